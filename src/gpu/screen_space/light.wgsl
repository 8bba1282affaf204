// What taps read of the G-buffer, and direct light at all its surfaces (eq. 6): each piece of a light by its outline, times what its
// hemicube shows of it. Comes after patches.wgsl, visibility.wgsl and screen.wgsl.

// A piece of a light. The same fields as Lamp in lamps.rs.
struct Lamp {
    // The whole light, the same for all of its pieces: a quadrangle; a triangle has its last corner twice. The w of the first
    // three are its middle.
    corners: array<vec4f, 4>,
    // Where the piece's hemicube stands.
    origin: vec3f,
    // Points nearer to its plane than this get nothing.
    least_height: f32,
    normal: vec3f,
    // Pieces of the same light from this one on.
    pieces: u32,
    tangent: vec3f,
    // Of the whole light.
    area: f32,
    radiosity: vec3f,
    spare: f32,
}

@group(0) @binding(1) var<uniform> settings: Settings;
@group(0) @binding(2) var<uniform> lamps: array<Lamp, 64>;
// Depth of the lamps' hemicubes.
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var normals: texture_2d_array<f32>;
@group(0) @binding(5) var reflectances: texture_2d_array<f32>;
@group(0) @binding(6) var depths: texture_2d_array<f32>;
@group(0) @binding(7) var<storage, read_write> direct: array<vec3f>;
// What taps read: the surface, and the radiosity by direct light.
@group(0) @binding(8) var<storage, read_write> surfaces: array<u32>;
@group(0) @binding(9) var<storage, read_write> outgoing: array<u32>;

@compute @workgroup_size(64)
fn light(@builtin(global_invocation_id) id: vec3u) {
    let index = screen.first + id.x;
    if index >= screen.end {
        return;
    }
    let entry = entry_of(index);
    let stored = textureLoad(depths, entry.pixel, entry.image, 0).x;
    if stored <= 0.0 {
        direct[index] = vec3f(0.0);
        surfaces[index] = 0u;
        outgoing[index] = 0u;
        return;
    }
    let in_view = normalize(textureLoad(normals, entry.pixel, entry.image, 0).xyz);
    let normal = in_space(in_view);
    let position_in_view = position_at(place_of(entry), stored);
    let position = screen.eye + in_space(position_in_view);
    var arriving = vec3f(0.0);
    var slot = settings.first_slot;
    // Loops test at their end: software drivers run a body once more to find that nothing is left.
    if slot < settings.end_slot {
        loop {
            let pieces = lamps[slot].pieces;
            arriving += from_light(slot, pieces, position, normal);
            continuing {
                slot += pieces;
                break if slot >= settings.end_slot;
            }
        }
    }
    let mean = mean_with(direct[index], arriving);
    direct[index] = mean;
    let reflected = textureLoad(reflectances, entry.pixel, entry.image, 0).xyz;
    surfaces[index] = pack_surface(in_view, position_in_view.z);
    outgoing[index] = pack_light(reflected * mean);
}

// Irradiance from a light: in full view by its outline, times the part of its pieces that is seen, each weighed by what it
// would give (a ratio of two estimates; Heitz, Hill and McGuire 2018).
fn from_light(first: u32, pieces: u32, position: vec3f, normal: vec3f) -> vec3f {
    let light_normal = lamps[first].normal;
    let tangent = lamps[first].tangent;
    if dot(position - lamps[first].origin, light_normal) <= lamps[first].least_height {
        return vec3f(0.0);
    }
    let factor = open_form_factor(first, position, normal);
    if factor <= 0.0 {
        return vec3f(0.0);
    }
    var seen = 0.0;
    var all = 0.0;
    var slot = first;
    loop {
        let offset = position - lamps[slot].origin;
        let squared = dot(offset, offset);
        // A little of what lies below the horizon, so that the last sliver of a light has a weight.
        let cosine = max(-dot(offset, normal) * inverseSqrt(squared), 1e-3);
        let weight = cosine * dot(offset, light_normal) / (squared * sqrt(squared));
        seen += weight * visibility(offset, normal, light_normal, tangent, slot);
        all += weight;
        continuing {
            slot++;
            break if slot >= first + pieces;
        }
    }
    return factor * seen / all * lamps[first].radiosity;
}

// A light nearer than this many times the root of its area is a polygon; a farther one would be rounding.
const NEAR_RATIO = 5.0;

// The form factor from a point to a light in full view of it.
fn open_form_factor(slot: u32, position: vec3f, normal: vec3f) -> f32 {
    let area = lamps[slot].area;
    let middle = vec3f(lamps[slot].corners[0].w, lamps[slot].corners[1].w, lamps[slot].corners[2].w);
    let to_middle = middle - position;
    let squared = dot(to_middle, to_middle);
    if squared > NEAR_RATIO * NEAR_RATIO * area {
        let cosines = max(dot(to_middle, normal), 0.0) * max(-dot(to_middle, lamps[slot].normal), 0.0);
        return area * cosines / (PI * squared * squared);
    }
    let corners = array<vec3f, 4>(
        lamps[slot].corners[0].xyz - position,
        lamps[slot].corners[1].xyz - position,
        lamps[slot].corners[2].xyz - position,
        lamps[slot].corners[3].xyz - position,
    );
    return polygon_form_factor(corners, normal);
}
