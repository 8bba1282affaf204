// The matrices of all faces of a batch's hemicubes, one invocation a face. Group 0: settings, shooters, faces.

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> shooters: array<Shooter>;
@group(0) @binding(2) var<storage, read_write> faces: array<Face>;

@compute @workgroup_size(64)
fn find_faces(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x / 5u;
    if slot >= settings.slot_count {
        return;
    }
    let shooter = shooters[slot];
    let face = id.x % 5u;
    if shooter.area <= 0.0 {
        // Nothing shoots: every point lies behind.
        faces[id.x] = Face(vec4f(0.0), vec4f(0.0), vec4f(0.0, 0.0, 0.0, -1.0));
        return;
    }
    let axes = face_axes(face, shooter.tangent, shooter.normal);
    let x = vec4f(axes.right, -dot(axes.right, shooter.origin));
    let up = vec4f(axes.up, -dot(axes.up, shooter.origin));
    let w = vec4f(axes.forward, -dot(axes.forward, shooter.origin));
    // A side's upper half fills its rows: heights from 0 to 1 become -1 to 1.
    let y = select(2.0 * up - w, up, face == 0u);
    faces[id.x] = Face(x, y, w);
}
