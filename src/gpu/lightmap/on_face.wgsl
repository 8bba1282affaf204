// Where a point lies on one face of a hemicube; every face is an instance. Depth is near / distance along the face's axis.
// What draws on faces begins with this.

struct Instance {
    @location(1) x: vec4f,
    @location(2) y: vec4f,
    @location(3) w: vec4f,
}

override near: f32 = 1e-4;

fn on_face(position: vec3f, face: Instance) -> vec4f {
    let point = vec4f(position, 1.0);
    return vec4f(dot(face.x, point), dot(face.y, point), near, dot(face.w, point));
}
