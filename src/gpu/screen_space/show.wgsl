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
    // The depths that are shown as white, and as black, or almost.
    nearest: f32,
    farthest: f32,
}

@group(0) @binding(1) var<uniform> show: Show;
@group(0) @binding(2) var normals: texture_2d_array<f32>;
@group(0) @binding(3) var reflectances: texture_2d_array<f32>;
@group(0) @binding(4) var depths: texture_2d_array<f32>;
@group(0) @binding(5) var<storage, read> direct: array<vec3f>;
@group(0) @binding(6) var<storage, read> indirect: array<vec3f>;
// Of the first layer.
@group(0) @binding(7) var<storage, read> obscurance: array<vec3f>;
@group(0) @binding(8) var<storage, read_write> pages: Pages;

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
    let pixel = place_in_rows(place, screen.size.x);
    // Only the first layer's bounces are filtered, which fills in what lies off the grid.
    let nearest = vec2u(on_grid(vec2f(pixel)));
    let step = (pixel.y - nearest.y) * screen.size.x + pixel.x - nearest.x;
    let gathered = index - select(0u, step, show.layer > 0u);
    var value = vec3f(0.0);
    switch show.buffer {
        case 0u: { value = direct[index] + indirect[gathered]; }
        case 1u: { value = direct[index]; }
        case 2u: { value = indirect[gathered]; }
        case 3u: { value = surface(pixel); }
        case 4u: { value = coded(textureLoad(reflectances, pixel, show.layer, 0).xyz); }
        case 5u: { value = depth(pixel); }
        default: { value = obscurance[place]; }
    }
    pages.texels[place] = vec4f(value, 1.0);
}

// Normals as in the views: (n + 1) / 2.
fn surface(pixel: vec2u) -> vec3f {
    let normal = normalize(textureLoad(normals, pixel, show.layer, 0).xyz);
    return select(vec3f(0.0), 0.5 * vec3f(normal.xy, -normal.z) + 0.5, depth(pixel) > vec3f(0.0));
}

// White is near, black is nothing.
fn depth(pixel: vec2u) -> vec3f {
    let stored = textureLoad(depths, pixel, show.layer, 0).x;
    let part = (screen.near / max(stored, 1e-30) - show.nearest) / (show.farthest - show.nearest);
    let shade = clamp(1.0 - part, 0.05, 1.0);
    return vec3f(select(0.0, shade, stored > 0.0));
}
