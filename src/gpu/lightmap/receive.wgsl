// What shooters give to texels (eq. 2 over pairs of patches). Group 0: settings, shooters, receivers,
// irradiance, unshot radiosity, sums of power by workgroup, depth of the hemicubes.

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> shooters: array<Shooter>;
@group(0) @binding(2) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(3) var<storage, read_write> irradiance: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> unshot: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> sums: array<PowerSums>;
// Depth, as a texture of numbers: OpenGL loads no single texels of depth textures.
@group(0) @binding(6) var depth: texture_2d<f32>;

const PI: f32 = 3.14159265;

// A shooter nearer than this many times the root of its area is integrated as a polygon.
override near_ratio: f32 = 5.0;

// Heights over a shooter's plane below this part of its side are rounding.
const LEAST_HEIGHT: f32 = 1e-3;

var<workgroup> shared_sums: array<PowerSums, 64>;

// One edge of Lambert's formula (eq. 6), without its factor 1/2π.
fn edge_term(from_corner: vec3f, to_corner: vec3f, normal: vec3f) -> f32 {
    let across = cross(from_corner, to_corner);
    let sine = length(across);
    if sine <= 0.0 {
        return 0.0;
    }
    return atan2(sine, dot(from_corner, to_corner)) * dot(across, normal) / sine;
}

// The form factor from a point to a parallelogram, the part below the point's horizon cut off (eq. 6 divided by π L).
fn polygon_form_factor(centre: vec3f, half_u: vec3f, half_v: vec3f, normal: vec3f) -> f32 {
    var corners = array<vec3f, 4>(
        centre - half_u - half_v,
        centre + half_u - half_v,
        centre + half_u + half_v,
        centre - half_u + half_v,
    );
    var sum = 0.0;
    var first = vec3f(0.0);
    var last = vec3f(0.0);
    var count = 0u;
    for (var index = 0u; index < 4u; index++) {
        let here = corners[index];
        let there = corners[(index + 1u) % 4u];
        let height = dot(here, normal);
        let next_height = dot(there, normal);
        if height >= 0.0 {
            if count > 0u { sum += edge_term(last, here, normal); } else { first = here; }
            last = here;
            count++;
        }
        if (height > 0.0 && next_height < 0.0) || (height < 0.0 && next_height > 0.0) {
            let crossing = mix(here, there, height / (height - next_height));
            if count > 0u { sum += edge_term(last, crossing, normal); } else { first = crossing; }
            last = crossing;
            count++;
        }
    }
    if count > 2u {
        sum += edge_term(last, first, normal);
    }
    return abs(sum) / (2.0 * PI);
}

// The form factor from a receiver to a shooter in full view of it. Of the shooter, only what is needed is read: that is
// what a software driver spends its time on.
fn form_factor(receiver: Receiver, slot: u32) -> f32 {
    let area = shooters[slot].area;
    let offset = shooters[slot].centre - receiver.position;
    let shooter_cosine = -dot(offset, shooters[slot].normal);
    // What lies in the shooter's plane, but for rounding, gets nothing.
    if area <= 0.0 || shooter_cosine <= LEAST_HEIGHT * sqrt(area) {
        return 0.0;
    }
    let distance_squared = dot(offset, offset);
    if settings.attenuation == 0u && distance_squared < near_ratio * near_ratio * area {
        return polygon_form_factor(offset, shooters[slot].half_u, shooters[slot].half_v, receiver.shading_normal);
    }
    let cosine = dot(offset, receiver.shading_normal);
    if cosine <= 0.0 || dot(offset, receiver.geometric_normal) <= 0.0 {
        return 0.0;
    }
    let physical = area * cosine * shooter_cosine / (PI * distance_squared * distance_squared);
    switch settings.attenuation {
        case 1u: { return physical * settings.patch_area / area * sqrt(distance_squared); }
        case 2u: { return physical * settings.patch_area / area; }
        default: { return physical; }
    }
}

// True if what a pixel shows does not hide the receiver: the depth is compared where the pixel's ray meets the
// receiver's plane, so that a plane seen at a slant does not shade itself.
fn pixel_sees(pixel: vec2u, direction: vec3f, offset: vec3f, along: f32, normal: vec3f, slack: f32) -> bool {
    let stored = textureLoad(depth, pixel, 0).x;
    let slope = dot(normal, direction);
    var plane = along;
    if slope < 0.0 {
        plane = min(along, dot(normal, offset) / slope);
    }
    return stored * plane * slack <= settings.near;
}

// The part of a shooter that a receiver sees, by the shooter's hemicube.
fn visibility(receiver: Receiver, slot: u32) -> f32 {
    let offset = receiver.position - shooters[slot].origin;
    let normal = shooters[slot].normal;
    let tangent = shooters[slot].tangent;
    let local = vec3f(dot(offset, tangent), dot(offset, cross(normal, tangent)), dot(offset, normal));
    if local.z <= 0.0 {
        return 0.0;
    }
    var face = 0u;
    if abs(local.x) > local.z || abs(local.y) > local.z {
        face = select(select(4u, 3u, local.y > 0.0), select(2u, 1u, local.x > 0.0), abs(local.x) > abs(local.y));
    }
    let axes = face_axes(face, tangent, normal);
    let along = dot(offset, axes.forward);
    let across = vec2f(dot(offset, axes.right), dot(offset, axes.up)) / along;
    let size = f32(settings.resolution);
    let rows = select(size / 2.0, size, face == 0u);
    // In pixels of the face; the first row is the highest.
    let lowest = select(0.0, -1.0, face == 0u);
    let place = vec2f((across.x + 1.0) * 0.5 * size, (1.0 - across.y) / (1.0 - lowest) * rows);
    let corner = tile_corner(slot, settings) + vec2u(0u, face_row(face, settings.resolution));
    let slack = 1.0 - settings.bias * 2.0 / size;
    if settings.filtered == 0u {
        let pixel = clamp(floor(place), vec2f(0.0), vec2f(size, rows) - 1.0);
        let on_face = pixel_place(pixel, size, rows, lowest);
        let direction = axes.forward + on_face.x * axes.right + on_face.y * axes.up;
        return f32(pixel_sees(corner + vec2u(pixel), direction, offset, along, receiver.geometric_normal, slack));
    }
    let first = floor(place - 0.5);
    let fraction = place - 0.5 - first;
    var seen = 0.0;
    for (var index = 0u; index < 4u; index++) {
        let step = vec2f(f32(index % 2u), f32(index / 2u));
        let pixel = clamp(first + step, vec2f(0.0), vec2f(size, rows) - 1.0);
        let weights = mix(1.0 - fraction, fraction, step);
        let on_face = pixel_place(pixel, size, rows, lowest);
        let direction = axes.forward + on_face.x * axes.right + on_face.y * axes.up;
        if pixel_sees(corner + vec2u(pixel), direction, offset, along, receiver.geometric_normal, slack) {
            seen += weights.x * weights.y;
        }
    }
    return seen;
}

// The middle of a pixel on its face at distance 1: along it from -1 to 1, and up from `lowest` to 1.
fn pixel_place(pixel: vec2f, size: f32, rows: f32, lowest: f32) -> vec2f {
    return vec2f((pixel.x + 0.5) / size * 2.0 - 1.0, 1.0 - (pixel.y + 0.5) / rows * (1.0 - lowest));
}

@compute @workgroup_size(64)
fn receive(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) group: vec3u,
) {
    var mine: PowerSums;
    let index = settings.first_receiver + id.x;
    if index < settings.end_receiver {
        let receiver = receivers[index];
        // One shooter after the other, so that it does not matter which of them come in one submission.
        var total = irradiance[index].xyz;
        var still_unshot = unshot[index].xyz;
        for (var slot = settings.first_slot; slot < settings.end_slot; slot++) {
            // On a bent surface a group's own texels may lie before its plane.
            let is_own = index - shooters[slot].first < shooters[slot].count;
            let factor = select(form_factor(receiver, slot), 0.0, is_own);
            if factor > 0.0 {
                let added = factor * visibility(receiver, slot) * shooters[slot].radiosity;
                total += added;
                still_unshot += receiver.reflectance * added;
                mine.arrived += receiver.area * added;
            }
        }
        irradiance[index] = vec4f(total, 0.0);
        unshot[index] = vec4f(still_unshot, 0.0);
        mine.reflected = receiver.reflectance * mine.arrived;
        mine.unshot = receiver.area * still_unshot;
    }
    shared_sums[local] = mine;
    for (var half = 32u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if local < half {
            shared_sums[local].arrived += shared_sums[local + half].arrived;
            shared_sums[local].reflected += shared_sums[local + half].reflected;
            shared_sums[local].unshot += shared_sums[local + half].unshot;
        }
    }
    if local == 0u {
        sums[settings.first_receiver / 64u + group.x] = shared_sums[0];
    }
}
