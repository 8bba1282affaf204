// A page of a lightmap, or the hemicubes of a batch, as a picture in the window.

struct PictureUniforms {
    // xy: its top left pixel in the window. zw: 1 / its size in pixels of the window.
    place: vec4f,
    exposure_scale: f32,
    inverse_gamma: f32,
    page: u32,
    // 0: irradiance through the tone map, 1: colours as they are.
    mode: u32,
    // 1: the outlines of the charts over it.
    outlines: u32,
    // 1: the window codes linear values by itself.
    codes_itself: u32,
    // Columns and rows that are shown of hemicubes and hemispheres.
    part: vec2u,
}

// As `Pages` in lightmap/pages.wgsl.
struct Pages {
    size: vec2u,
    count: u32,
    spare: u32,
    texels: array<vec4f>,
}

@group(0) @binding(0) var<uniform> picture: PictureUniforms;
@group(0) @binding(1) var<storage, read> pages: Pages;
@group(0) @binding(2) var hemicubes: texture_2d<f32>;
@group(0) @binding(3) var item_numbers: texture_2d<u32>;

const PI = 3.14159265358979;
const OUTLINE = vec3f(1.0, 0.55, 0.1);
// hemicube::NEAR.
const NEAR = 1e-4;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // A triangle that covers the viewport.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// From the upper left (0, 0) to the lower right (1, 1).
fn point(position: vec4f) -> vec2f {
    return clamp((position.xy - picture.place.xy) * picture.place.zw, vec2f(0.0), vec2f(0.999999));
}

fn linear_to_srgb(linear: vec3f) -> vec3f {
    let clipped = clamp(linear, vec3f(0.0), vec3f(1.0));
    let curved = 1.055 * pow(max(clipped, vec3f(1e-10)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curved, clipped * 12.92, clipped <= vec3f(0.0031308));
}

fn shown(coded: vec3f) -> vec4f {
    if picture.codes_itself == 0u {
        return vec4f(coded, 1.0);
    }
    let curved = pow((coded + 0.055) / 1.055, vec3f(2.4));
    return vec4f(select(curved, coded / 12.92, coded <= vec3f(0.04045)), 1.0);
}

fn texel(place: vec2i) -> vec4f {
    let inside = vec2u(clamp(place, vec2i(0), vec2i(pages.size) - 1));
    return pages.texels[(picture.page * pages.size.y + inside.y) * pages.size.x + inside.x];
}

@fragment
fn page(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2i(floor(point(position) * vec2f(pages.size)));
    let here = texel(place);
    if picture.outlines == 1u && (here.w != texel(place + vec2i(1, 0)).w || here.w != texel(place + vec2i(0, 1)).w) {
        return shown(OUTLINE);
    }
    if picture.mode == 1u {
        return shown(here.xyz);
    }
    let toned = pow(max(here.xyz * picture.exposure_scale / PI, vec3f(1e-10)), vec3f(picture.inverse_gamma));
    return shown(linear_to_srgb(toned));
}

@fragment
fn depth(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2u(point(position) * vec2f(picture.part));
    let stored = textureLoad(hemicubes, place, 0).x;
    if stored <= 0.0 {
        return shown(vec3f(0.1, 0.1, 0.25));
    }
    // White is near; an eighth darker with each doubling of the distance.
    return shown(vec3f(clamp(1.0 + 0.125 * log2(0.02 * stored / NEAR), 0.05, 1.0)));
}

// A colour for every triangle; neighbours in the list differ.
@fragment
fn items(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2u(point(position) * vec2f(picture.part));
    let item = textureLoad(item_numbers, place, 0).x;
    if item == 0u {
        return shown(vec3f(0.1, 0.1, 0.25));
    }
    let mixed = (item * 2654435761u) ^ ((item * 2654435761u) >> 15u);
    return shown(vec3f(vec3u(mixed, mixed >> 8u, mixed >> 16u) & vec3u(255u)) / 255.0 * 0.8 + 0.2);
}
