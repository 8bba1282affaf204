// Copies a picture of sRGB-coded values, pixel by pixel or magnified: then in squares, as a mean of texels would take a
// software driver twice as long.

@group(0) @binding(0) var picture: texture_2d<f32>;
// xy: its top left pixel in the window. zw: 1 / its size in pixels of the window.
@group(0) @binding(1) var<uniform> place: vec4f;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // A triangle that covers the viewport.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn pixel(position: vec4f) -> vec4f {
    let size = vec2f(textureDimensions(picture));
    let texel = clamp((position.xy - place.xy) * place.zw * size, vec2f(0.0), size - 1.0);
    return textureLoad(picture, vec2u(texel), 0);
}

// For a window that takes sRGB-coded values.
@fragment
fn coded(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return pixel(position);
}

// For a window that codes linear values by itself.
@fragment
fn linear(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let value = pixel(position);
    let curved = pow((value.rgb + 0.055) / 1.055, vec3f(2.4));
    return vec4f(select(curved, value.rgb / 12.92, value.rgb <= vec3f(0.04045)), value.a);
}
