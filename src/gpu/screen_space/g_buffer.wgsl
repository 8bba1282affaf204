// What of the surfaces the passes over the picture read: normals in view space, reflectance, and depth. Comes after
// mesh_view.wgsl and vertex_field.wgsl.

// The same fields as LayerUniforms in g_buffer.rs.
struct Layer {
    // The camera that the reference depth was drawn with: local units to clip space.
    reference: mat4x4f,
    right: vec3f,
    near: f32,
    up: vec3f,
    // The second layer lies so far behind the first, or farther.
    separation: f32,
    forward: vec3f,
    spare: f32,
    // As in screen.wgsl.
    ray_origin: vec2f,
    ray_step: vec2f,
}

@group(3) @binding(0) var<uniform> layer: Layer;
// Depth of the first layer, as a texture of numbers: OpenGL loads no single texels of depth textures.
@group(3) @binding(1) var reference_depth: texture_2d<f32>;

// 0: all surfaces. 1: what lies behind this frame's first layer. 2: what lies behind the last frame's.
override LAYER: u32;

struct Surface {
    @location(0) normal: vec4f,
    @location(1) reflectance: vec4f,
}

@fragment
fn surface(in: Fragment) -> Surface {
    if is_hole(in.texcoord) || (LAYER > 0u && !is_behind(in.clip)) {
        discard;
    }
    let normal = normalize(in.normal);
    let in_view = vec3f(dot(normal, layer.right), dot(normal, layer.up), dot(normal, layer.forward));
    return Surface(vec4f(in_view, 0.0), vec4f(reflectance(in.texcoord), 1.0));
}

// True if a point lies far enough behind the reference's surface. In another frame's depth, it is looked up where it was.
fn is_behind(clip: vec4f) -> bool {
    let depth = layer.near / clip.z;
    var pixel = vec2i(clip.xy);
    var depth_there = depth;
    if LAYER == 2u {
        let ray = layer.ray_origin + floor(clip.xy) * layer.ray_step;
        let position = frame.eye + depth * (ray.x * layer.right + ray.y * layer.up + layer.forward);
        let there = layer.reference * vec4f(position, 1.0);
        if there.w < layer.near {
            return false;
        }
        let size = vec2f(textureDimensions(reference_depth));
        pixel = vec2i(floor((vec2f(0.5, -0.5) * there.xy / there.w + 0.5) * size));
        if any(pixel < vec2i(0)) || any(pixel >= vec2i(size)) {
            return false;
        }
        depth_there = there.w;
    }
    let nearest = textureLoad(reference_depth, pixel, 0).x;
    return nearest > 0.0 && depth_there >= layer.near / nearest + layer.separation;
}
