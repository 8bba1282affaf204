// The pages of a lightmap, for whoever draws them: what is asked for of every open texel, then buried texels and the gutter,
// ring by ring. Group 0: settings, receivers, irradiance, direct irradiance, unshot radiosity, shots, the pixel of each
// receiver, pages, pixels of a ring, irradiance at a remembered moment.

struct PageSettings {
    // What is added for light that has still to be shot: irradiance everywhere, and so many times what came since a
    // remembered moment.
    even: vec3f,
    // A number of `Stage`.
    stage: u32,
    trend: vec3f,
    spare: f32,
    receiver_count: u32,
    // So far.
    shooter_count: u32,
    // Area of the largest texel.
    largest_area: f32,
    spare_too: f32,
}

struct Pages {
    // Columns and rows of a page.
    size: vec2u,
    count: u32,
    spare: u32,
    // Page by page, row by row; w is the number of the chart + 1, 0 in the gutter and under objects.
    texels: array<vec4f>,
}

struct Fill {
    pixel: u32,
    neighbours: u32,
}

@group(0) @binding(0) var<uniform> settings: PageSettings;
@group(0) @binding(1) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(2) var<storage, read> irradiance: array<vec4f>;
@group(0) @binding(3) var<storage, read> direct: array<vec4f>;
@group(0) @binding(4) var<storage, read> unshot: array<vec4f>;
@group(0) @binding(5) var<storage, read> shots: array<vec2u>;
// Pixel, and number of the chart + 1.
@group(0) @binding(6) var<storage, read> places: array<vec2u>;
@group(0) @binding(7) var<storage, read_write> pages: Pages;
@group(0) @binding(8) var<storage, read> ring: array<Fill>;
@group(0) @binding(9) var<storage, read> older: array<vec4f>;

// From early to late; never at all is grey.
fn order_color(index: u32) -> vec3f {
    let first = shots[index].x;
    if first == 0u {
        return vec3f(0.15);
    }
    let place = log2(f32(first)) / max(log2(f32(settings.shooter_count)), 1.0);
    if place < 0.5 {
        return mix(vec3f(1.0, 0.95, 0.4), vec3f(0.85, 0.25, 0.3), 2.0 * place);
    }
    return mix(vec3f(0.85, 0.25, 0.3), vec3f(0.1, 0.15, 0.5), 2.0 * place - 1.0);
}

// With what is added for the light that has still to be shot.
fn all_irradiance(index: u32) -> vec3f {
    let known = irradiance[index].xyz;
    return known + settings.even + settings.trend * (known - older[index].xyz);
}

fn stage_value(index: u32) -> vec3f {
    switch settings.stage {
        case 0u: { return all_irradiance(index); }
        case 1u: { return direct[index].xyz; }
        case 2u: { return all_irradiance(index) - direct[index].xyz; }
        case 3u: { return unshot[index].xyz; }
        case 4u: { return order_color(index); }
        case 5u: { return vec3f(min(f32(shots[index].y) / 8.0, 1.0)); }
        case 6u: { return receivers[index].reflectance; }
        case 7u: { return 0.5 * receivers[index].shading_normal + 0.5; }
        case 8u: { return 0.5 * receivers[index].position + 0.5; }
        default: { return vec3f(receivers[index].area / settings.largest_area); }
    }
}

@compute @workgroup_size(64)
fn place(@builtin(global_invocation_id) id: vec3u) {
    if id.x < settings.receiver_count {
        let place = places[id.x];
        pages.texels[place.x] = vec4f(stage_value(id.x), f32(place.y));
    }
}

@compute @workgroup_size(64)
fn fill(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&ring) {
        return;
    }
    let mine = ring[id.x];
    if mine.neighbours == 0u {
        return;
    }
    let width = i32(pages.size.x);
    // The neighbours of `AROUND` in dilate.rs: four at the sides, then four at the corners for half.
    var steps = array<i32, 8>(-1, 1, -width, width, -width - 1, -width + 1, width - 1, width + 1);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var index = 0u; index < 8u; index++) {
        if (mine.neighbours >> index & 1u) == 1u {
            let weight = select(0.5, 1.0, index < 4u);
            sum += weight * pages.texels[u32(i32(mine.pixel) + steps[index])].xyz;
            weights += weight;
        }
    }
    pages.texels[mine.pixel] = vec4f(sum / weights, 0.0);
}
