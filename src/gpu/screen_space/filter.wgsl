// A separable Gaussian over the pixels around that lie in the same plane and face the same way. It reads the pixels on the
// grid alone, and writes all. Comes after screen.wgsl.

// What is filtered, of the pixels on the grid, with their surfaces.
@group(0) @binding(1) var<storage, read> unfiltered: array<vec2u>;
// What the first pass leaves, of the grid's rows, and what the second one does.
@group(0) @binding(2) var<storage, read_write> half_filtered: array<vec2u>;
@group(0) @binding(3) var<storage, read_write> filtered: array<vec4f>;
// Surfaces of all pixels.
@group(0) @binding(4) var<storage, read> surfaces: array<vec2u>;

// The least weight: so that pixels that are like none on the grid take the light of what is near.
const LEAST = 1e-6;

// The weight of a neighbour that lies `offset` pixels away: a Gaussian whose radius is three standard deviations, times
// nearness to the pixel's plane, times likeness of the normals.
fn weight(offset: f32, normal: vec3f, position: vec3f, there_normal: vec3f, there: vec3f) -> f32 {
    let deviations = 3.0 * offset / max(screen.filter_radius, 1e-3);
    let height = abs(dot(normal, there - position)) / (screen.filter_depth * position.z);
    // Normals 30 degrees apart are different surfaces.
    let likeness = saturate((dot(normal, there_normal) - 0.866) / 0.134);
    return exp(-0.5 * deviations * deviations) * max(max(1.0 - height, 0.0) * likeness, LEAST);
}

// The mean over the neighbours along one side, which lie on the grid.
fn blur(pixel: vec2i, step: vec2i) -> vec3f {
    let surface = surfaces[u32(pixel.y) * screen.size.x + u32(pixel.x)].x;
    let depth = unpack_depth(surface);
    if depth <= 0.0 {
        return vec3f(0.0);
    }
    let position = depth * view_ray(vec2f(pixel));
    let normal = unpack_normal(surface);
    let reach = i32(screen.filter_radius);
    let every = i32(screen.every);
    let here = dot(pixel, step);
    let end = min(here + reach, dot(vec2i(screen.size), step) - 1);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var there = (max(here - reach, 0) + every - 1) / every * every; there <= end; there += every) {
        let place = pixel + (there - here) * step;
        let words = unfiltered[u32(place.y) * screen.size.x + u32(place.x)];
        let there_depth = unpack_depth(words.x);
        if there_depth > 0.0 {
            // The pixel itself counts whole, whatever the rounding of its normal.
            var of_it = 1.0;
            if there != here {
                let there_position = there_depth * view_ray(vec2f(place));
                of_it = weight(f32(there - here), normal, position, unpack_normal(words.x), there_position);
            }
            sum += of_it * unpack_light(words.y);
            weights += of_it;
        }
    }
    return sum / max(weights, 1e-30);
}

@compute @workgroup_size(64)
fn across(@builtin(global_invocation_id) id: vec3u) {
    let number = screen.first + id.x;
    if number < screen.end {
        let pixel = vec2u(number % screen.size.x, number / screen.size.x * screen.every);
        let index = pixel.y * screen.size.x + pixel.x;
        half_filtered[index] = vec2u(surfaces[index].x, pack_light(blur(vec2i(pixel), vec2i(1, 0))));
    }
}

@compute @workgroup_size(64)
fn down(@builtin(global_invocation_id) id: vec3u) {
    let index = screen.first + id.x;
    if index < screen.end {
        filtered[index] = vec4f(blur(vec2i(pixel_of(index)), vec2i(0, 1)), 0.0);
    }
}
