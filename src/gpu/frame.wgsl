// Uniforms of a frame; the same fields as FrameUniforms in frame.rs.
struct FrameUniforms {
    view_projection: mat4x4f,
    eye: vec3f,
    shading: u32,
    viewport: vec2f,
    exposure_scale: f32,
    inverse_gamma: f32,
    ambient: vec3f,
    filmic: u32,
    range: vec2f,
    logarithmic: u32,
    edge_pixels: f32,
    light_centre: vec3f,
    outline_width: f32,
    light_u: vec4f,
    light_v: vec4f,
    light_radiance: vec4f,
    outline_color: vec4f,
    false_colors: array<vec4f, 10>,
}

@group(0) @binding(0) var<uniform> frame: FrameUniforms;

const PI = 3.14159265358979;

const RADIOSITY = 0u;
const IRRADIANCE = 1u;
const ALBEDO = 2u;
const NORMALS = 3u;
const FALSE_COLOR = 4u;

// Linear to sRGB-coded values in [0, 1] (IEC 61966-2-1).
fn linear_to_srgb(linear: vec3f) -> vec3f {
    let clipped = clamp(linear, vec3f(0.0), vec3f(1.0));
    let curved = 1.055 * pow(max(clipped, vec3f(1e-10)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curved, clipped * 12.92, clipped <= vec3f(0.0031308));
}

// Narkowicz's rational fit of the ACES filmic curve, as math::color has it.
fn filmic(x: vec3f) -> vec3f {
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

// ToneMap::apply: radiance to sRGB-coded values in [0, 1].
fn tone_map(radiance: vec3f) -> vec3f {
    // Far above any white; keeps the curve's squares finite.
    let scaled = min(radiance * frame.exposure_scale, vec3f(1e6));
    let curved = select(scaled, filmic(scaled) / filmic(vec3f(1.0)), frame.filmic == 1u);
    let clipped = clamp(curved, vec3f(0.0), vec3f(1.0));
    let powered = pow(max(clipped, vec3f(1e-10)), vec3f(frame.inverse_gamma));
    return linear_to_srgb(select(powered, vec3f(0.0), clipped <= vec3f(1e-10)));
}

// false_color::color at FalseColorRange::place: the sRGB-coded colour of a value of the field.
fn false_color(value: f32) -> vec3f {
    let ends = vec3f(frame.range, value);
    let scaled = select(ends, log2(max(ends, vec3f(1e-30))), frame.logarithmic == 1u);
    let fraction = clamp((scaled.z - scaled.x) / max(scaled.y - scaled.x, 1e-30), 0.0, 1.0);
    let place = fraction * 9.0;
    let lower = min(u32(place), 8u);
    return mix(frame.false_colors[lower].rgb, frame.false_colors[lower + 1u].rgb, place - f32(lower));
}
