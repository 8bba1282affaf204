// A separable Gaussian over the pixels around that lie in the same plane and face the same way. It reads the pixels on the
// grid alone, and writes all. Comes after screen.wgsl.

// Surfaces of all pixels.
@group(0) @binding(1) var<storage, read> surfaces: array<u32>;
// What is filtered, of the pixels on the grid; or what the first pass leaves, of the grid's rows.
@group(0) @binding(2) var<storage, read> unfiltered: array<u32>;
// What the first pass leaves, and what the second one does.
@group(0) @binding(3) var<storage, read_write> half_filtered: array<u32>;
@group(0) @binding(4) var<storage, read_write> filtered: array<vec3f>;

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

// The mean over the neighbours along one side, which lie on the grid; they are so many entries apart.
fn blur(pixel: vec2u, step: vec2u, stride: u32) -> vec3f {
    let index = pixel.y * screen.size.x + pixel.x;
    let surface = surfaces[index];
    let depth = unpack_depth(surface);
    if depth <= 0.0 {
        return vec3f(0.0);
    }
    let position = depth * view_ray(vec2f(pixel));
    let normal = unpack_normal(surface);
    let every = i32(screen.every);
    let here = i32(dot(pixel, step));
    let reach = i32(screen.filter_radius);
    let end = min(here + reach, i32(dot(screen.size, step)) - 1);
    var there = i32(divided(u32(max(here - reach, 0) + every - 1), screen.every).x) * every;
    var sum = vec3f(0.0);
    var weights = 0.0;
    loop {
        let entry = index + u32(there - here) * stride;
        let there_surface = surfaces[entry];
        let there_depth = unpack_depth(there_surface);
        if there_depth > 0.0 {
            // The pixel itself counts whole, whatever the rounding of its normal.
            var of_it = 1.0;
            if there != here {
                let there_position = there_depth * view_ray(vec2f(vec2i(pixel) + (there - here) * vec2i(step)));
                of_it = weight(f32(there - here), normal, position, unpack_normal(there_surface), there_position);
            }
            sum += of_it * unpack_light(unfiltered[entry]);
            weights += of_it;
        }
        continuing {
            there += every;
            break if there > end;
        }
    }
    return sum / max(weights, 1e-30);
}

@compute @workgroup_size(64)
fn across(@builtin(global_invocation_id) id: vec3u) {
    let number = screen.first + id.x;
    if number < screen.end {
        let pixel = place_in_rows(number, screen.size.x) * vec2u(1u, screen.every);
        half_filtered[pixel.y * screen.size.x + pixel.x] = pack_light(blur(pixel, vec2u(1u, 0u), 1u));
    }
}

@compute @workgroup_size(64)
fn down(@builtin(global_invocation_id) id: vec3u) {
    let index = screen.first + id.x;
    if index < screen.end {
        filtered[index] = blur(place_in_rows(index, screen.size.x), vec2u(0u, 1u), screen.size.x);
    }
}
