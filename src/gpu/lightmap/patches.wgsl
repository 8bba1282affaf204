// What all passes of the lightmap share: the structs of `patches.rs`, and the faces of a hemicube.

struct Settings {
    receiver_count: u32,
    group_count: u32,
    // Shooters of this batch.
    slot_count: u32,
    // Pixels along a hemicube's top.
    resolution: u32,
    // Hemicubes side by side in the depth atlas.
    tiles_per_row: u32,
    // Distance of the near plane, in local units.
    near: f32,
    // How far behind what a pixel shows a receiver may lie and be seen, in pixels.
    bias: f32,
    // 1: the four pixels around are weighed bilinearly; 0: the nearest pixel decides.
    filtered: u32,
    // The shooters and the texels of this submission: first, and after the last.
    first_slot: u32,
    end_slot: u32,
    first_receiver: u32,
    end_receiver: u32,
    // Shooters before this batch.
    shooter_count: u32,
    // 0: as it is; 1: linear; 2: quadratic; 3: quadratic with the patch's size.
    attenuation: u32,
    patch_area: f32,
    spare: u32,
}

struct Receiver {
    position: vec3f,
    area: f32,
    geometric_normal: vec3f,
    triangle: u32,
    shading_normal: vec3f,
    // No light comes from another room.
    room: u32,
    reflectance: vec3f,
    spare_again: f32,
}

// Sums of power over a workgroup of `receive`.
struct PowerSums {
    arrived: vec3f,
    spare: f32,
    reflected: vec3f,
    spare_too: f32,
    unshot: vec3f,
    spare_three: f32,
}

// Texels that shoot as one.
struct Group {
    centre: vec3f,
    area: f32,
    origin: vec3f,
    first: u32,
    normal: vec3f,
    count: u32,
    half_u: vec3f,
    chart: u32,
    half_v: vec3f,
    // With more unshot power than this its parts shoot, and not it.
    most_power: f32,
    tangent: vec3f,
    // The group that it is a part of, or NO_GROUP.
    parent: u32,
}

struct Shooter {
    centre: vec3f,
    area: f32,
    origin: vec3f,
    // Its texels.
    first: u32,
    normal: vec3f,
    count: u32,
    half_u: vec3f,
    spare_three: f32,
    half_v: vec3f,
    spare_four: f32,
    tangent: vec3f,
    spare_five: f32,
    radiosity: vec3f,
    spare_six: f32,
}

// Rows of the matrix from a point (x, y, z, 1) to clip space; the depth is always the near distance.
struct Face {
    x: vec4f,
    y: vec4f,
    w: vec4f,
}

struct Axes {
    right: vec3f,
    up: vec3f,
    forward: vec3f,
}

// Faces of a hemicube: 0 the top, 1 to 4 the sides.
fn face_axes(face: u32, tangent: vec3f, normal: vec3f) -> Axes {
    let bitangent = cross(normal, tangent);
    switch face {
        case 0u: { return Axes(tangent, bitangent, normal); }
        case 1u: { return Axes(bitangent, normal, tangent); }
        case 2u: { return Axes(-bitangent, normal, -tangent); }
        case 3u: { return Axes(-tangent, normal, bitangent); }
        default: { return Axes(tangent, normal, -bitangent); }
    }
}

// First row of a face in its tile.
fn face_row(face: u32, resolution: u32) -> u32 {
    return select(resolution + (face - 1u) * (resolution / 2u), 0u, face == 0u);
}

// First pixel of a hemicube's tile in the depth atlas.
fn tile_corner(slot: u32, settings: Settings) -> vec2u {
    let place = vec2u(slot % settings.tiles_per_row, slot / settings.tiles_per_row);
    return place * vec2u(settings.resolution, 3u * settings.resolution);
}
