// Triangles that a texture cuts holes into, on a hemicube's face: their depth, or their items. Group 0: the masks, and their opacities, four
// bytes a word.

struct Mask {
    // Number of its first opacity, columns, rows.
    first: u32,
    width: u32,
    height: u32,
    // 1: the four opacities around are weighed bilinearly; 0: the nearest decides.
    filtered: u32,
    // What the texture's opacity is multiplied by.
    opacity: f32,
}

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) texcoord: vec2f,
    @location(1) @interpolate(flat) mask: u32,
    @location(2) @interpolate(flat) item: u32,
}

@group(0) @binding(0) var<storage, read> masks: array<Mask>;
@group(0) @binding(1) var<storage, read> opacities: array<u32>;

@vertex
fn to_face(
    @location(0) position: vec3f,
    @location(4) mask: u32,
    @location(5) texcoord: vec2f,
    @location(6) item: u32,
    face: Instance,
) -> Varyings {
    return Varyings(on_face(position, face), texcoord, mask, item);
}

// The opacity of a texel; the texture repeats.
fn texel(mask: Mask, place: vec2i) -> f32 {
    let size = vec2i(i32(mask.width), i32(mask.height));
    let wrapped = vec2u((place % size + size) % size);
    let index = mask.first + wrapped.y * mask.width + wrapped.x;
    return f32(opacities[index / 4u] >> (8u * (index % 4u)) & 255u) / 255.0;
}

// As `Texture::sample_opacity` reads it.
fn sampled(mask: Mask, texcoord: vec2f) -> f32 {
    let size = vec2f(f32(mask.width), f32(mask.height));
    let wrapped = fract(texcoord);
    if mask.filtered == 0u {
        let place = vec2i(floor(wrapped * size));
        return texel(mask, vec2i(place.x, i32(mask.height) - 1 - place.y));
    }
    let place = vec2f(wrapped.x, 1.0 - wrapped.y) * size - 0.5;
    let corner = vec2i(floor(place));
    let fraction = fract(place);
    let top = mix(texel(mask, corner), texel(mask, corner + vec2i(1, 0)), fraction.x);
    let bottom = mix(texel(mask, corner + vec2i(0, 1)), texel(mask, corner + vec2i(1, 1)), fraction.x);
    return mix(top, bottom, fraction.y);
}

fn is_hole(varyings: Varyings) -> bool {
    let mask = masks[varyings.mask];
    return mask.opacity * sampled(mask, varyings.texcoord) < 0.5;
}

@fragment
fn cut_out(varyings: Varyings) {
    if is_hole(varyings) {
        discard;
    }
}

// As `hemicube.wgsl` writes it.
@fragment
fn cut_out_side(varyings: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) u32 {
    if is_hole(varyings) {
        discard;
    }
    return select(0u, 1u, is_front);
}

// As `item_buffer.wgsl` writes it.
@fragment
fn cut_out_item(varyings: Varyings, @builtin(front_facing) is_front: bool) -> @location(0) u32 {
    if is_hole(varyings) {
        discard;
    }
    return select(0u, varyings.item + 1u, is_front);
}
