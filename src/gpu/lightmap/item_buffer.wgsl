// Which triangle each pixel of a hemicube shows: its number + 1, or 0 for nothing and for back faces.

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) item: u32,
}

// Three vertices of its own for every triangle.
@vertex
fn to_face(@builtin(vertex_index) vertex: u32, @location(0) position: vec3f, face: Instance) -> Varyings {
    return Varyings(on_face(position, face), vertex / 3u + 1u);
}

@fragment
fn write_item(varyings: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) u32 {
    return select(0u, varyings.item, is_front);
}
