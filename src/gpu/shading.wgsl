// From radiance, or the value of a field, to the colour of a pixel. Comes after frame.wgsl.

// What a pipeline is made for: software drivers run both sides of every branch that is decided later.
override SHADING: u32;
override FILMIC: bool;
override GAMMA: bool;
override LOGARITHMIC: bool;

const RADIOSITY = 0u;
const IRRADIANCE = 1u;
const ALBEDO = 2u;
const NORMALS = 3u;
const PLAIN = 5u;

const PI = 3.14159265358979;

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
    return tone_curve(radiance * frame.exposure_scale);
}

// The same for a radiance that was multiplied by the exposure: 1 is white.
fn tone_curve(exposed: vec3f) -> vec3f {
    // Far above any white; keeps the curve's squares finite.
    let scaled = min(exposed, vec3f(1e6));
    var toned = scaled;
    if FILMIC {
        toned = filmic(scaled) / filmic(vec3f(1.0));
    }
    var clipped = clamp(toned, vec3f(0.0), vec3f(1.0));
    if GAMMA {
        let powered = pow(max(clipped, vec3f(1e-10)), vec3f(frame.inverse_gamma));
        clipped = select(powered, vec3f(0.0), clipped <= vec3f(1e-10));
    }
    return linear_to_srgb(clipped);
}

fn luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

// false_color::color at FalseColorRange::place: the sRGB-coded colour of a value of the field.
fn false_color(value: f32) -> vec3f {
    var scaled = vec3f(frame.range.xy, value);
    if LOGARITHMIC {
        scaled = log2(max(scaled, vec3f(1e-30)));
    }
    let fraction = clamp((scaled.z - scaled.x) / max(scaled.y - scaled.x, 1e-30), 0.0, 1.0);
    let place = fraction * 9.0;
    let lower = min(u32(place), 8u);
    return mix(frame.false_colors[lower].rgb, frame.false_colors[lower + 1u].rgb, place - f32(lower));
}
