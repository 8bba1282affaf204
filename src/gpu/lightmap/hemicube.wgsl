// Depth of the scene on one face of a hemicube: 0 where nothing is seen.

@vertex
fn to_face(@location(0) position: vec3f, face: Instance) -> @builtin(position) vec4f {
    return on_face(position, face);
}
