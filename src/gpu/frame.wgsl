// Uniforms of a frame; the same fields as FrameUniforms in frame.rs.
struct FrameUniforms {
    view_projection: mat4x4f,
    eye: vec3f,
    outline_width: f32,
    typical_edge: f32,
    pixel_size: f32,
    exposure_scale: f32,
    inverse_gamma: f32,
    ambient: vec4f,
    range: vec4f,
    light_centre: vec4f,
    light_u: vec4f,
    light_v: vec4f,
    light_color: vec4f,
    outline_color: vec4f,
    false_colors: array<vec4f, 10>,
}

@group(0) @binding(0) var<uniform> frame: FrameUniforms;
