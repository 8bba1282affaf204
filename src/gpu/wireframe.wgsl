// Edges of the elements. Comes after frame.wgsl.

// sRGB-coded, as render::wireframe has it.
const LINE_COLOR = vec3f(0.25, 0.85, 0.95);
// Elements smaller than this, in pixels, get fainter lines, so that a fine mesh does not become one flat colour.
const FULL_STRENGTH_PIXELS = 6.0;
// Lines lie nearer than their surface by this part of their distance, and by as much again as the surface's distance
// changes over so many pixels: the surface beside a line must not hide half of it.
const LIFT = 4e-4;
const LIFT_PIXELS = 1.5;
const STEEPEST = 30.0;

struct Fragment {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) depth: f32,
}

@vertex
fn vertex(@location(0) position: vec3f, @location(1) normal: vec4f) -> Fragment {
    var clip = frame.view_projection * vec4f(position, 1.0);
    let depth = clip.w;
    let facing = abs(dot(normal.xyz, normalize(frame.eye - position)));
    let slope = sqrt(max(1.0 - facing * facing, 0.0)) / max(facing, 1.0 / STEEPEST);
    clip.z *= 1.0 + LIFT + LIFT_PIXELS * frame.pixel_size * slope;
    return Fragment(clip, position, normal.xyz, depth);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    // Edges of faces that are seen from behind are not drawn, like the faces.
    if dot(in.normal, frame.eye - in.position) <= 0.0 {
        discard;
    }
    let pixels = frame.typical_edge / (frame.pixel_size * max(in.depth, 1e-6));
    return vec4f(LINE_COLOR, min(pixels / FULL_STRENGTH_PIXELS, 1.0));
}
