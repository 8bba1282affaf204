// What each pixel sees: a triangle's vertices, the place between them, and all of the colour that the field does not decide.
// Comes after mesh_view.wgsl and vertex_field.wgsl. Three vertices in turn are the corners of a triangle.

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    @location(2) texcoord: vec2f,
    // All three of the triangle.
    @location(3) vertices: vec3u,
}

struct Seen {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
    @location(1) texcoord: vec2f,
    // Barycentric (u, v).
    @location(2) place: vec2f,
    @location(3) @interpolate(flat) vertices: vec3u,
}

struct Kept {
    // The triangle's vertices, the first plus 1 as 0 is nothing; and its barycentric (u, v) as 16-bit fractions.
    @location(0) vertices_and_place: vec4u,
    // Radiance that leaves for each unit of irradiance.
    @location(1) reflected: vec4f,
    // Radiance that leaves without the field, times the exposure: any camera's white is 1.
    @location(2) own: vec4f,
}

@vertex
fn seen_vertex(@builtin(vertex_index) index: u32, corner: Corner) -> Seen {
    var out: Seen;
    out.clip = frame.view_projection * vec4f(corner.position, 1.0);
    if AMBIENT {
        out.normal = corner.normal.xyz;
    }
    if REFLECTANCE_FILTER != NO_TEXTURE || OPACITY_FILTER != NO_TEXTURE {
        out.texcoord = corner.texcoord;
    }
    let number = index % 3u;
    out.place = vec2f(f32(number == 1u), f32(number == 2u));
    out.vertices = corner.vertices;
    return out;
}

@fragment
fn keep(in: Seen) -> Kept {
    if is_hole(in.texcoord) {
        discard;
    }
    var reflected = vec3f(1.0 / PI);
    var own = vec3f(0.0);
    if SHADING == RADIOSITY {
        reflected = reflectance(in.texcoord) / PI;
        own = material.emitted_radiance;
    }
    if AMBIENT {
        own += reflected * ambient_irradiance(in.normal);
    }
    // The largest number of 16 bits is 65504.
    let exposed = min(own * frame.exposure_scale, vec3f(6e4));
    let vertices_and_place = vec4u(in.vertices + vec3u(1u, 0u, 0u), pack2x16unorm(in.place));
    return Kept(vertices_and_place, vec4f(reflected, 1.0), vec4f(exposed, 1.0));
}
