// The colours of pixels whose triangles are known. Comes after shading.wgsl.

// As Kept in visibility.wgsl has them.
@group(1) @binding(0) var vertices_and_places: texture_2d<u32>;
@group(1) @binding(1) var reflected: texture_2d<f32>;
@group(1) @binding(2) var own: texture_2d<f32>;
// Irradiance at the vertices, in rows: software drivers read textures faster than buffers.
@group(1) @binding(3) var irradiance: texture_2d<f32>;

// Vertices a row: FIELD_WIDTH in resolve.rs.
const FIELD_WIDTH = 1024u;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // A triangle that covers the viewport.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let seen = textureLoad(vertices_and_places, pixel, 0);
    // The light's rectangle, which is drawn later, may be all there is.
    if seen.x == 0u {
        discard;
    }
    let place = unpack2x16unorm(seen.w);
    let field = (1.0 - place.x - place.y) * at_vertex(seen.x - 1u)
        + place.x * at_vertex(seen.y)
        + place.y * at_vertex(seen.z);
    return vec4f(color(field, pixel), 1.0);
}

fn at_vertex(vertex: u32) -> vec3f {
    return textureLoad(irradiance, vec2u(vertex % FIELD_WIDTH, vertex / FIELD_WIDTH), 0).rgb;
}

fn color(field: vec3f, pixel: vec2u) -> vec3f {
    if SHADING == PLAIN {
        return field;
    }
    if SHADING == RADIOSITY || SHADING == IRRADIANCE {
        let exposed = field * frame.exposure_scale;
        return tone_curve(textureLoad(own, pixel, 0).rgb + textureLoad(reflected, pixel, 0).rgb * exposed);
    }
    return false_color(luminance(field));
}
