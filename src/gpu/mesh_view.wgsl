// The elements. Comes after frame.wgsl and shading.wgsl; vertex_field.wgsl or map_field.wgsl, which say where the field
// is, come after it.

// The same fields as MaterialUniforms in mesh_view.rs.
struct MaterialUniforms {
    reflectance: vec3f,
    opacity: f32,
    emitted_radiance: vec3f,
    largest_texel: f32,
}

@group(1) @binding(0) var<uniform> material: MaterialUniforms;
@group(2) @binding(0) var reflectance_texture: texture_2d<f32>;
@group(2) @binding(1) var opacity_texture: texture_2d<f32>;

// What a pipeline is made for: software drivers run both sides of every branch that is decided later.
override AMBIENT: bool;
override BURIED: bool;
override REFLECTANCE_FILTER: u32;
override OPACITY_FILTER: u32;
override SEVERAL_SAMPLES: bool;

const NO_TEXTURE = 0u;
const BILINEAR = 2u;
// sRGB-coded colour of the hatching over buried vertices.
const BURIED_COLOR = vec3f(0.95, 0.6, 0.15);

// The side that ambient light is brightest from: from no axis, so that the sides of a box differ.
const AMBIENT_SIDE = vec3f(0.65, 0.6, 0.4664762);

struct VertexIn {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    @location(2) texcoord: vec2f,
    @location(3) irradiance: vec3f,
    @location(4) buried: f32,
    // Column, row and page on the lightmap, if there is one.
    @location(5) map_place: vec3f,
}

struct Fragment {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
    @location(1) texcoord: vec2f,
    @location(2) irradiance: vec3f,
    @location(3) buried: f32,
    // Not outside of the triangle, where the map has another chart. The last number is 1: some drivers divide what they
    // interpolate at the centroid by the depth at the pixel's middle, and it by so much.
    @location(4) @interpolate(perspective, centroid) map_place: vec4f,
}

@vertex
fn vertex(in: VertexIn) -> Fragment {
    // What the fragments will not use is left at 0, so that it need not be fetched.
    var out: Fragment;
    out.clip = frame.view_projection * vec4f(in.position, 1.0);
    if AMBIENT || SHADING == NORMALS {
        out.normal = in.normal.xyz;
    }
    if REFLECTANCE_FILTER != NO_TEXTURE || OPACITY_FILTER != NO_TEXTURE {
        out.texcoord = in.texcoord;
    }
    if SHADING != ALBEDO && SHADING != NORMALS {
        out.irradiance = in.irradiance;
    }
    if BURIED {
        out.buried = in.buried;
    }
    if HAS_MAP {
        out.map_place = vec4f(in.map_place, 1.0);
    }
    return out;
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    if is_hole(in.texcoord) {
        discard;
    }
    let color = surface_color(in);
    if BURIED {
        // Stripes across half of what lies nearer to a buried vertex than to one that is not.
        let stripe = fract((in.clip.x + in.clip.y) / 8.0) < 0.5;
        return vec4f(select(color, BURIED_COLOR, in.buried > 0.5 && stripe), 1.0);
    }
    return vec4f(color, 1.0);
}

// True where the opacity texture leaves nothing.
fn is_hole(texcoord: vec2f) -> bool {
    if OPACITY_FILTER == NO_TEXTURE {
        return false;
    }
    return material.opacity * read_texture(opacity_texture, texcoord, OPACITY_FILTER, 1.0).a < 0.5;
}

// sRGB-coded colour of a point.
fn surface_color(in: Fragment) -> vec3f {
    if SHADING == PLAIN {
        return field(in);
    }
    if SHADING == RADIOSITY {
        return tone_map(material.emitted_radiance + reflectance(in.texcoord) * irradiance(in) / PI);
    }
    if SHADING == IRRADIANCE {
        return tone_map(irradiance(in) / PI);
    }
    if SHADING == ALBEDO {
        return linear_to_srgb(reflectance(in.texcoord));
    }
    if SHADING == NORMALS {
        return 0.5 * normalize(in.normal) + 0.5;
    }
    return false_color(luminance(field(in)));
}

fn irradiance(in: Fragment) -> vec3f {
    if AMBIENT {
        return field(in) + ambient_irradiance(in.normal);
    }
    return field(in);
}

fn ambient_irradiance(normal: vec3f) -> vec3f {
    return frame.ambient.rgb * (0.55 + 0.45 * dot(normalize(normal), AMBIENT_SIDE));
}

fn reflectance(texcoord: vec2f) -> vec3f {
    if REFLECTANCE_FILTER == NO_TEXTURE {
        return material.reflectance;
    }
    if !SEVERAL_SAMPLES {
        return material.reflectance * texel_color(texcoord);
    }
    // Where four samples a pixel see edges, the texture is also read at four places, as they lie in the pixel.
    let right = dpdx(texcoord) / 8.0;
    let down = dpdy(texcoord) / 8.0;
    let upper = texel_color(texcoord - right - 3.0 * down) + texel_color(texcoord + 3.0 * right - down);
    let lower = texel_color(texcoord - 3.0 * right + down) + texel_color(texcoord + right + 3.0 * down);
    return material.reflectance * 0.25 * (upper + lower);
}

fn texel_color(texcoord: vec2f) -> vec3f {
    return read_texture(reflectance_texture, texcoord, REFLECTANCE_FILTER, material.largest_texel).rgb;
}

// Texture::sample: repeating; rows from the top, v from the bottom; texels brought down to `largest`.
fn read_texture(picture: texture_2d<f32>, texcoord: vec2f, texture_filter: u32, largest: f32) -> vec4f {
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

// The texel at whole numbers from -1 to the size, repeating. OpenGL leaves the remainder of a negative number open.
fn texel_at(picture: texture_2d<f32>, place: vec2f, largest: f32) -> vec4f {
    let size = vec2i(textureDimensions(picture));
    let wrapped = (vec2i(place) + size) % size;
    return min(textureLoad(picture, wrapped, 0), vec4f(largest));
}
