// Unpacks the G-buffer, and direct light at all its surfaces (eq. 6): each piece of a light by its outline, times what its
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
// Normal and depth of each pixel; depth 0 where there is nothing.
@group(0) @binding(7) var<storage, read_write> geometry: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> reflectance: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> direct: array<vec4f>;
// What taps read: the surface, and the radiosity by direct light.
@group(0) @binding(10) var<storage, read_write> outgoing: array<vec2u>;

@compute @workgroup_size(64)
fn light(@builtin(global_invocation_id) id: vec3u) {
    let index = screen.first + id.x;
    if index >= screen.end {
        return;
    }
    let is_around = index >= layer_entries();
    let pixel = select(pixel_of(index), pixel_around(index), is_around);
    let layer_around = 2u + (index - layer_entries()) / max(pixel_count_around(), 1u);
    let layer = select(index / pixel_count(), layer_around, is_around);
    let stored = textureLoad(depths, pixel, layer, 0).x;
    if stored <= 0.0 {
        geometry[index] = vec4f(0.0);
        reflectance[index] = vec4f(0.0);
        direct[index] = vec4f(0.0);
        outgoing[index] = vec2u(0u);
        return;
    }
    let in_view = normalize(textureLoad(normals, pixel, layer, 0).xyz);
    let normal = in_view.x * screen.right + in_view.y * screen.up + in_view.z * screen.forward;
    let z = screen.near / stored;
    let ray = view_ray(place_of(index));
    let position = screen.eye + z * (ray.x * screen.right + ray.y * screen.up + screen.forward);
    var arriving = vec3f(0.0);
    var slot = settings.first_slot;
    while slot < settings.end_slot {
        let pieces = lamps[slot].pieces;
        arriving += from_light(slot, pieces, position, normal);
        slot += pieces;
    }
    geometry[index] = vec4f(in_view, z);
    let reflected = textureLoad(reflectances, pixel, layer, 0).xyz;
    reflectance[index] = vec4f(reflected, 0.0);
    let mean = mean_with(direct[index], vec4f(arriving, 0.0));
    direct[index] = mean;
    outgoing[index] = vec2u(pack_surface(in_view, z), pack_light(reflected * mean.xyz));
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
    for (var slot = first; slot < first + pieces; slot++) {
        let offset = position - lamps[slot].origin;
        let squared = dot(offset, offset);
        // A little of what lies below the horizon, so that the last sliver of a light has a weight.
        let cosine = max(-dot(offset, normal) * inverseSqrt(squared), 1e-3);
        let weight = cosine * dot(offset, light_normal) / (squared * sqrt(squared));
        seen += weight * visibility(offset, normal, light_normal, tangent, slot);
        all += weight;
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
