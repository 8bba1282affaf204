// Depth of the scene on one face of a hemicube: 0 where nothing is seen; and 1 where it is the front of a surface.

@vertex
fn to_face(@location(0) position: vec3f, face: Instance) -> @builtin(position) vec4f {
    return on_face(position, face);
}

@fragment
fn write_side(@builtin(front_facing) is_front: bool) -> @location(0) u32 {
    return select(0u, 1u, is_front);
}
