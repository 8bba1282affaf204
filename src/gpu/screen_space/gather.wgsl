// One bounce: what arrives at each pixel's surface from the surfaces that taps of the picture show. Comes after screen.wgsl.

// The same fields as BounceUniforms in gather.rs.
struct Bounce {
    // 1: the sum over the bounces begins.
    is_first: u32,
    // 1: nothing follows, and the filter takes the sum.
    is_last: u32,
    // 1: the last bounce comes next, and gathers from what it gathered in the frames before, too: so it grows to be the sum
    // of all that follow.
    feeds_last: u32,
    // 1: the last bounce, fed in this way.
    is_fed: u32,
}

@group(0) @binding(1) var<storage, read> geometry: array<vec4f>;
// Each pixel's surface, and its radiosity by the bounce before [W/m²].
@group(0) @binding(2) var<storage, read> outgoing: array<vec2u>;
// Of this bounce, means over the still frames: irradiance from the taps, and the part of the hemisphere that they fill (for
// the source's weights, 1).
@group(0) @binding(3) var<storage, read_write> gathered: array<vec4f>;
// Cosine and sine of each tap's angle on the spiral.
@group(0) @binding(4) var<uniform> spiral: array<vec4f, 128>;
@group(0) @binding(5) var<uniform> bounce: Bounce;
@group(0) @binding(6) var<storage, read> reflectance: array<vec4f>;
// Radiosity by this bounce; after the last one, all indirect irradiance.
@group(0) @binding(7) var<storage, read_write> next: array<vec2u>;
@group(0) @binding(8) var<storage, read_write> indirect: array<vec4f>;
// `gathered` of the last bounce; of that itself, anything.
@group(0) @binding(9) var<storage, read> gathered_last: array<vec4f>;

const PI = 3.14159265358979;

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3u) {
    let index = screen.first + id.x;
    if index >= screen.end {
        return;
    }
    let here = geometry[index];
    var filled = vec4f(0.0);
    if here.w > 0.0 {
        filled = from_taps(vec2f(pixel_of(index)), here);
        if screen.still > 0u {
            // What is fed grows from frame to frame: later ones count more.
            let weight = select(1.0 / f32(screen.still + 1u), 2.0 / f32(screen.still + 2u), bounce.is_fed == 1u);
            filled = mix(gathered[index], filled, weight);
        }
    }
    gathered[index] = filled;
    // A hemisphere is not filled more than once: taps do not know what hides what.
    let mean = filled.xyz / max(filled.w, 1.0);
    var sum = mean;
    if bounce.is_first == 0u {
        sum += indirect[index].xyz;
    }
    indirect[index] = vec4f(sum, 0.0);
    var leaves = sum;
    if bounce.is_last == 0u {
        var irradiance = mean;
        if bounce.feeds_last == 1u && screen.still > 0u {
            irradiance += gathered_last[index].xyz / max(gathered_last[index].w, 1.0);
        }
        leaves = reflectance[index].xyz * irradiance;
    }
    next[index] = vec2u(outgoing[index].x, pack_light(leaves));
}

// Irradiance of a pixel's surface by the light of its taps, and the part of its hemisphere that they fill.
fn from_taps(pixel: vec2f, here: vec4f) -> vec4f {
    let position = here.w * view_ray(pixel);
    let noise = jitter(pixel);
    let turn = vec2f(cos(2.0 * PI * noise.x), sin(2.0 * PI * noise.x));
    let size = vec2f(screen.size);
    let pixels = pixel_count();
    var light = vec3f(0.0);
    var mean_light = vec4f(0.0);
    var seen = 0.0;
    for (var tap = 0u; tap < screen.taps; tap++) {
        let place_along = (f32(tap) + noise.y) / f32(screen.taps);
        // The source spreads taps evenly over the radius. What lies near fills more of the hemisphere: so more taps lie near.
        let curve = select(place_along, 1.0, screen.source_weights == 1u);
        let radius = screen.radius * place_along * curve;
        let along = spiral[tap].xy;
        let offset = radius * vec2f(along.x * turn.x - along.y * turn.y, along.x * turn.y + along.y * turn.x);
        let place = floor(pixel + 0.5 + offset);
        if all(place >= vec2f(0.0)) && all(place < size) {
            let there_ray = view_ray(place);
            var other = u32(place.y) * screen.size.x + u32(place.x);
            for (var layer = 0u; layer < screen.layers; layer++) {
                let there = outgoing[other];
                let depth = unpack_depth(there.x);
                let to = depth * there_ray - position;
                let squared = dot(to, to);
                let cosine = dot(here.xyz, to);
                if depth > 0.0 && cosine > 0.0 {
                    let leaves = unpack_light(there.y);
                    var factor = 0.0;
                    if screen.source_weights == 1u {
                        // Twice the mean of radiosity times cosine over the taps above the horizon.
                        factor = 2.0 * cosine * inverseSqrt(squared);
                        seen += 1.0;
                    } else {
                        // Eq. 2 over the area of the surface that the tap stands for; none fills more than the hemisphere.
                        let normal = unpack_normal(there.x);
                        let slant = max(-dot(normal, there_ray), 1e-3);
                        // So many pixels: the ring from this tap to the next.
                        let ring = 4.0 * PI * max(radius, 0.5) * screen.radius * place_along / f32(screen.taps);
                        let area = ring * screen.pixel_area * depth * depth / slant;
                        factor = min(max(-dot(normal, to), 0.0) * cosine * area / (PI * squared * squared), 1.0);
                        seen += factor;
                        mean_light += area * vec4f(leaves, 1.0);
                    }
                    light += factor * leaves;
                }
                other += pixels;
            }
        }
    }
    if screen.source_weights == 1u {
        return vec4f(light / max(seen, 1.0), 1.0);
    }
    if screen.unseen > 0.0 {
        light += screen.unseen * max(1.0 - seen, 0.0) * mean_light.xyz / max(mean_light.w, 1e-20);
    }
    return vec4f(light, seen);
}
