// Which triangle each pixel of a hemisphere shows, seen from above (Coombe and Harris 2005): its number + 1, or 0 for back
// faces. Only corners are projected, so that edges are straight.

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) item: u32,
}

// Three vertices of its own for every triangle. The face is a hemicube's top.
@vertex
fn to_face(@builtin(vertex_index) vertex: u32, @location(0) position: vec3f, face: Instance) -> Varyings {
    let point = vec4f(position, 1.0);
    let local = vec3f(dot(face.x, point), dot(face.y, point), dot(face.w, point));
    let distance = max(length(local), near);
    let direction = local / distance;
    // Nearer is greater, and what lies below the horizon is cut off.
    return Varyings(vec4f(direction.xy, direction.z * near / distance, 1.0), vertex / 3u + 1u);
}

@fragment
fn write_item(varyings: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) u32 {
    return select(0u, varyings.item, is_front);
}
