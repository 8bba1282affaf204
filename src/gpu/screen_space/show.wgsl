// Writes one buffer where views read it: a page of a lightmap that is as large as the picture. Comes after screen.wgsl.

// As `Pages` in lightmap/pages.wgsl.
struct Pages {
    size: vec2u,
    count: u32,
    spare: u32,
    texels: array<vec4f>,
}

// The same fields as ShowUniforms in show.rs.
struct Show {
    // A number of `ShownBuffer`.
    buffer: u32,
    // Its layer: 0 or 1.
    layer: u32,
    // The depth that is shown as black.
    farthest: f32,
    spare: f32,
}

@group(0) @binding(1) var<uniform> show: Show;
@group(0) @binding(2) var<storage, read> geometry: array<vec4f>;
@group(0) @binding(3) var<storage, read> reflectance: array<vec4f>;
@group(0) @binding(4) var<storage, read> direct: array<vec4f>;
@group(0) @binding(5) var<storage, read> indirect: array<vec4f>;
// Of the first layer.
@group(0) @binding(6) var<storage, read> obscurance: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> pages: Pages;

fn coded(linear: vec3f) -> vec3f {
    let clipped = clamp(linear, vec3f(0.0), vec3f(1.0));
    let curved = 1.055 * pow(max(clipped, vec3f(1e-10)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curved, clipped * 12.92, clipped <= vec3f(0.0031308));
}

@compute @workgroup_size(64)
fn write_page(@builtin(global_invocation_id) id: vec3u) {
    let place = screen.first + id.x;
    if place == 0u {
        pages.size = screen.size;
        pages.count = 1u;
    }
    if place >= min(screen.end, pixel_count()) {
        return;
    }
    let index = place + show.layer * pixel_count();
    let surface = geometry[index];
    // Only the first layer's bounces are filtered, which fills in what lies off the grid.
    let pixel = vec2f(pixel_of(place));
    let nearest = on_grid(pixel);
    let step = u32(pixel.y - nearest.y) * screen.size.x + u32(pixel.x - nearest.x);
    let gathered = index - select(0u, step, show.layer > 0u);
    var value = vec3f(0.0);
    switch show.buffer {
        case 0u: { value = direct[index].xyz + indirect[gathered].xyz; }
        case 1u: { value = direct[index].xyz; }
        case 2u: { value = indirect[gathered].xyz; }
        // Normals as in the views: (n + 1) / 2.
        case 3u: { value = select(vec3f(0.0), 0.5 * vec3f(surface.xy, -surface.z) + 0.5, surface.w > 0.0); }
        case 4u: { value = coded(reflectance[index].xyz); }
        case 5u: { value = vec3f(select(0.0, clamp(1.0 - surface.w / show.farthest, 0.05, 1.0), surface.w > 0.0)); }
        default: { value = obscurance[place].xyz; }
    }
    pages.texels[place] = vec4f(value, 1.0);
}
