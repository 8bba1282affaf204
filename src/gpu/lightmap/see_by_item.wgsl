// What a shooter sees by the triangles on its hemisphere. Comes after visibility.wgsl and before receive.wgsl. Group 0:
// settings, shooters, depth (not used), items.

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> shooters: array<Shooter>;
// Depth, as a texture of numbers: OpenGL loads no single texels of depth textures.
@group(0) @binding(6) var depth: texture_2d<f32>;
// Number of the triangle + 1, 0 for nothing.
@group(0) @binding(7) var items: texture_2d<u32>;

// 1 if the pixel that a receiver lies in shows its triangle.
fn seen(receiver: Receiver, slot: u32) -> f32 {
    let offset = receiver.position - shooters[slot].origin;
    let normal = shooters[slot].normal;
    let tangent = shooters[slot].tangent;
    let local = vec3f(dot(offset, tangent), dot(offset, cross(normal, tangent)), dot(offset, normal));
    if local.z <= 0.0 {
        return 0.0;
    }
    let size = f32(settings.resolution);
    let place = (normalize(local).xy * vec2f(0.5, -0.5) + 0.5) * size;
    let pixel = vec2u(clamp(floor(place), vec2f(0.0), vec2f(size - 1.0)));
    let item = textureLoad(items, tile_corner(slot, settings) + pixel, 0).x;
    return select(0.0, 1.0, item == receiver.triangle + 1u);
}
