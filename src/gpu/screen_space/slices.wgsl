// Bounces by slices: planes through the eye and a pixel's surface cut the hemisphere into half discs, and lie on the picture
// as lines, so that taps along a line meet what a ray of the slice meets, in the ray's order. Each tap covers the sectors of
// the half disc between the ends of its piece of surface; a sector takes the light of the tap that covers it first. So what
// hides what is known. After Therrien, Levesque and Gilet 2023, "Screen space indirect lighting with visibility bitmask"; here
// sectors are of equal weight (eq. 2), and a tap's piece of surface reaches to the next tap's, along its own plane. Comes
// after gather.wgsl and line.wgsl, and before kept.wgsl.

const SECTORS = 32.0;

// A half disc about the direction to the eye: angles to one side are negative.
struct Slice {
    // The normal's part in it, a unit vector: to the side, and to the eye.
    normal: vec2f,
    // The weight of what lies below the half disc's lower end, and one over the weight of all of it.
    lowest: f32,
    scale: f32,
}

// The angle whose cosine this is, to 7e-5 (Abramowitz and Stegun, 4.4.45).
fn angle_of(cosine: f32) -> f32 {
    let x = abs(cosine);
    let angle = sqrt(max(1.0 - x, 0.0)) * (((-0.0187293 * x + 0.0742610) * x - 0.2121144) * x + 1.5707288);
    return select(angle, PI - angle, cosine < 0.0);
}

// Cosine to the normal times area on the sphere, from the direction to the eye to the angle whose cosine and sine are given
// (Jimenez, Wu, Pesce and Jarabo 2016, eq. 7), for a normal that is a unit vector in the slice.
fn weight_to(normal: vec2f, angle: f32, cosine: f32, sine: f32) -> f32 {
    let of_normal = vec2f(select(-normal.x, normal.x, sine >= 0.0), normal.y);
    let double = vec2f(2.0 * abs(sine) * cosine, 1.0 - 2.0 * sine * sine);
    let weight = 0.25 * (of_normal.y - dot(double, of_normal) + 2.0 * angle * of_normal.x);
    return select(-weight, weight, sine >= 0.0);
}

// Where a direction (to the side, and to the eye) lies between the ends of a slice, by weight: 0 to 1. What lies below the
// surface is put at the end of its side.
fn place_on(slice: Slice, direction: vec2f, end: f32) -> f32 {
    let unit = direction * inverseSqrt(max(dot(direction, direction), 1e-30));
    if dot(unit, slice.normal) <= 0.0 {
        return end;
    }
    return saturate((weight_to(slice.normal, angle_of(unit.y), unit.y, unit.x) - slice.lowest) * slice.scale);
}

// Irradiance of a pixel's surface by the light of its taps, and by a guess for the rest.
fn from_slices(pixel: vec2f, here: vec4f, noise: vec2f, openness: f32, entry_number: u32) -> vec3f {
    let line = line_of(pixel, noise);
    let ray = line.ray;
    let tangent = line.tangent;
    let ray_length = length(ray);
    let eye_distance = here.w * ray_length;
    let to_eye = -ray / ray_length;
    let normal_within = vec2f(dot(here.xyz, tangent), dot(here.xyz, to_eye));
    let normal_length = max(length(normal_within), 1e-6);
    let normal = normal_within / normal_length;
    // The ends are a right angle from the normal: their cosines and sines are its own, turned.
    let ends = vec2f(
        weight_to(normal, angle_of(normal.x), normal.x, -normal.y),
        weight_to(normal, angle_of(-normal.x), -normal.x, normal.y),
    );
    let slice = Slice(normal, ends.x, 1.0 / (ends.y - ends.x));
    // The view ray at a place s pixels along the line is the pixel's own, changed by s times this.
    let change = line.along * screen.ray_step;
    let rates = vec2f(dot(change, tangent.xy), dot(change, to_eye.xy));
    let rounding = fract(noise.x * 7.0 + noise.y);
    var covered = 0u;
    var light = vec3f(0.0);
    var known = 0u;
    var mean_light = vec4f(0.0);
    // The sectors nearest to the eye that taps of either side cover.
    var rims = vec2u(u32(SECTORS), 0u);
    var half = 0u;
    loop {
        let side = side_of(line, half);
        let end = select(1.0, 0.0, half == 1u);
        var number = 0u;
        loop {
            let tap = tap_of(line, side, number);
            let places = tap.places;
            let there_ray = tap.ray;
            if !tap.is_there {
                break;
            }
            for (var layer = 0u; layer < LAYERS; layer++) {
                let surface = surfaces[tap.entry + layer * tap.to_second];
                let depth = unpack_depth(surface);
                // The surface's plane, met by the rays of both ends.
                let there_normal = unpack_direction(surface);
                let height = depth * dot(there_normal, there_ray);
                let own = dot(there_normal, ray);
                let turn = dot(there_normal.xy, change);
                let slants = min(own + places.xz * turn, vec2f(-1e-4));
                let depths = clamp(height / slants, vec2f(0.5 * depth), vec2f(2.0 * depth)) + vec2f(screen.thickness, 0.0);
                let first = depths.x * vec2f(places.x * rates.x, places.x * rates.y - ray_length);
                let last = depths.y * vec2f(places.z * rates.x, places.z * rates.y - ray_length);
                let to_eye_plane = vec2f(0.0, eye_distance);
                let lower = place_on(slice, first + to_eye_plane, end);
                let upper = place_on(slice, last + to_eye_plane, end);
                let low = u32(min(lower, upper) * SECTORS + rounding);
                let end_sector = u32(max(lower, upper) * SECTORS + rounding);
                let count = select(0u, end_sector - low, depth > 0.0);
                let sectors = select((1u << count) - 1u, 0xffffffffu, count >= 32u) << low;
                // Of what turns its back, the light is not known.
                let fresh = select(0u, countOneBits(sectors & ~covered), height < here.w * own);
                covered |= sectors;
                known += fresh;
                var counts = 0u;
                if count > 0u {
                    let leaves = unpack_light(outgoing[tap.entry + layer * tap.to_second]);
                    light += f32(fresh) * leaves;
                    rims = select(vec2u(rims.x, max(rims.y, low + count)), vec2u(min(rims.x, low), rims.y), half == 0u);
                    // By the area that the tap stands for.
                    let area = places.y * (places.z - places.x) * depth * depth * depth / max(-height, 0.02 * depth);
                    mean_light += area * vec4f(leaves, 1.0);
                    counts = pack_counts(fresh, area);
                }
                if screen.keeps == 1u {
                    kept[kept_place(entry_number, side.first + number, layer)] = counts;
                }
            }
            continuing {
                number++;
                break if number >= side.steps;
            }
        }
        continuing {
            half++;
            break if half >= sides();
        }
    }
    // All slices together weigh 1.
    let weight = normal_length / (slice.scale * SECTORS);
    // Behind what is shown something is, taken to be as bright as what taps meet; where nothing may be, darker.
    let open = weight * f32(max(rims.x, rims.y) - rims.y);
    let hidden = max(1.0 - open - weight * f32(known), 0.0);
    let guess = saturate(4.0 * screen.unseen) * hidden + screen.unseen * openness * open;
    if screen.keeps == 1u {
        kept[kept_place(entry_number, screen.taps, 0u)] = bitcast<u32>(weight);
        kept[kept_place(entry_number, screen.taps, 1u)] = bitcast<u32>(guess);
    }
    return weight * light + guess * mean_light.xyz / max(mean_light.w, 1e-30);
}
