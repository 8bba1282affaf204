// What a shooter sees by the depth on its hemicube. Comes after visibility.wgsl and before receive.wgsl. Group 0: settings,
// shooters, depth of the hemicubes.

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> shooters: array<Shooter>;
// Depth, as a texture of numbers: OpenGL loads no single texels of depth textures.
@group(0) @binding(6) var depth: texture_2d<f32>;

// The part of a shooter that a receiver sees.
fn seen(receiver: Receiver, slot: u32) -> f32 {
    let offset = receiver.position - shooters[slot].origin;
    return visibility(offset, receiver.geometric_normal, shooters[slot].normal, shooters[slot].tangent, slot);
}
