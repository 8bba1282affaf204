// The elements. Comes after frame.wgsl.

// The same fields as MaterialUniforms in mesh_view.rs.
struct MaterialUniforms {
    reflectance: vec3f,
    opacity: f32,
    emitted_radiance: vec3f,
    largest_texel: f32,
    reflectance_filter: u32,
    opacity_filter: u32,
    unused: vec2u,
}

@group(1) @binding(0) var<uniform> material: MaterialUniforms;
@group(2) @binding(0) var reflectance_texture: texture_2d<f32>;
@group(2) @binding(1) var opacity_texture: texture_2d<f32>;

const BILINEAR = 2u;
// sRGB-coded colour of the hatching over buried vertices.
const BURIED_COLOR = vec3f(0.95, 0.6, 0.15);

struct VertexIn {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    @location(2) texcoord: vec2f,
    @location(3) irradiance: vec3f,
    @location(4) buried: f32,
}

struct Fragment {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) texcoord: vec2f,
    @location(3) irradiance: vec3f,
    @location(4) buried: f32,
}

@vertex
fn vertex(in: VertexIn) -> Fragment {
    let clip = frame.view_projection * vec4f(in.position, 1.0);
    return Fragment(clip, in.position, in.normal.xyz, in.texcoord, in.irradiance, in.buried);
}

@fragment
fn opaque(in: Fragment) -> @location(0) vec4f {
    return vec4f(surface_color(in), 1.0);
}

@fragment
fn cut_out(in: Fragment) -> @location(0) vec4f {
    let texel = read(opacity_texture, in.texcoord, material.opacity_filter, 1.0);
    if material.opacity * texel.a < 0.5 {
        discard;
    }
    return vec4f(surface_color(in), 1.0);
}

// sRGB-coded colour of a point.
fn surface_color(in: Fragment) -> vec3f {
    var color: vec3f;
    switch frame.shading {
        case RADIOSITY: {
            let radiance = material.emitted_radiance + reflectance(in.texcoord) * irradiance(in) / PI;
            color = tone_map(radiance);
        }
        case IRRADIANCE: {
            color = tone_map(irradiance(in) / PI);
        }
        case ALBEDO: {
            color = linear_to_srgb(reflectance(in.texcoord));
        }
        case NORMALS: {
            color = 0.5 * normalize(in.normal) + 0.5;
        }
        default: {
            color = false_color(dot(in.irradiance, vec3f(0.2126, 0.7152, 0.0722)));
        }
    }
    // Stripes across half of what lies nearer to a buried vertex than to one that is not.
    let stripe = fract((in.clip.x + in.clip.y) / 8.0) < 0.5;
    return select(color, BURIED_COLOR, in.buried > 0.5 && stripe);
}

fn irradiance(in: Fragment) -> vec3f {
    let facing = abs(dot(normalize(in.normal), normalize(frame.eye - in.position)));
    return in.irradiance + frame.ambient * (0.5 + 0.5 * facing);
}

fn reflectance(texcoord: vec2f) -> vec3f {
    if material.reflectance_filter == 0u {
        return material.reflectance;
    }
    let texel = read(reflectance_texture, texcoord, material.reflectance_filter, material.largest_texel);
    return material.reflectance * texel.rgb;
}

// Texture::sample: repeating; rows from the top, v from the bottom; texels brought down to `largest`.
fn read(picture: texture_2d<f32>, texcoord: vec2f, texture_filter: u32, largest: f32) -> vec4f {
    let size = vec2f(textureDimensions(picture));
    let wrapped = texcoord - floor(texcoord);
    if texture_filter != BILINEAR {
        let place = floor(wrapped * size);
        return texel_at(picture, vec2f(place.x, size.y - 1.0 - place.y), largest);
    }
    let place = vec2f(wrapped.x, 1.0 - wrapped.y) * size - 0.5;
    let corner = floor(place);
    let fraction = place - corner;
    let right = vec2f(1.0, 0.0);
    let down = vec2f(0.0, 1.0);
    let top_left = texel_at(picture, corner, largest);
    let top_right = texel_at(picture, corner + right, largest);
    let bottom_left = texel_at(picture, corner + down, largest);
    let bottom_right = texel_at(picture, corner + down + right, largest);
    return mix(mix(top_left, top_right, fraction.x), mix(bottom_left, bottom_right, fraction.x), fraction.y);
}

// The texel at whole numbers, repeating.
fn texel_at(picture: texture_2d<f32>, place: vec2f, largest: f32) -> vec4f {
    let size = vec2i(textureDimensions(picture));
    let wrapped = ((vec2i(place) % size) + size) % size;
    return min(textureLoad(picture, wrapped, 0), vec4f(largest));
}
