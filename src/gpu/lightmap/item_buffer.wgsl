// Which triangle each pixel of a hemicube shows: its number + 1, or 0 for nothing and for back faces.

struct Instance {
    @location(1) x: vec4f,
    @location(2) y: vec4f,
    @location(3) w: vec4f,
}

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) item: u32,
}

override near: f32 = 1e-4;

// Three vertices of its own for every triangle.
@vertex
fn to_face(@builtin(vertex_index) vertex: u32, @location(0) position: vec3f, face: Instance) -> Varyings {
    let point = vec4f(position, 1.0);
    let place = vec4f(dot(face.x, point), dot(face.y, point), near, dot(face.w, point));
    return Varyings(place, vertex / 3u + 1u);
}

@fragment
fn write_item(varyings: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) u32 {
    return select(0u, varyings.item, is_front);
}
