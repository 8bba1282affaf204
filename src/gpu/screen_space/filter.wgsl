// A separable Gaussian over the pixels around that lie in the same plane and face the same way. Comes after screen.wgsl.

// Each pixel's surface, and what is filtered.
@group(0) @binding(1) var<storage, read> unfiltered: array<vec2u>;
// What the first pass leaves, and what the second one does.
@group(0) @binding(2) var<storage, read_write> half_filtered: array<vec2u>;
@group(0) @binding(3) var<storage, read_write> filtered: array<vec4f>;

// The weight of a neighbour that lies `offset` pixels away: a Gaussian whose radius is three standard deviations, times
// nearness to the pixel's plane, times likeness of the normals.
fn weight(offset: f32, normal: vec3f, position: vec3f, there_normal: vec3f, there: vec3f) -> f32 {
    let deviations = 3.0 * offset / max(screen.filter_radius, 1e-3);
    let height = abs(dot(normal, there - position)) / (screen.filter_depth * position.z);
    // Normals 30 degrees apart are different surfaces.
    let likeness = saturate((dot(normal, there_normal) - 0.866) / 0.134);
    return exp(-0.5 * deviations * deviations) * max(1.0 - height, 0.0) * likeness;
}

fn blur(index: u32, step: vec2i) -> vec3f {
    let here = unfiltered[index];
    let depth = unpack_depth(here.x);
    var sum = unpack_light(here.y);
    if depth <= 0.0 {
        return sum;
    }
    let pixel = vec2i(pixel_of(index));
    let layer_start = index - index % pixel_count();
    let position = depth * view_ray(vec2f(pixel));
    let normal = unpack_normal(here.x);
    let reach = i32(screen.filter_radius);
    // The pixel itself counts whole, whatever the rounding of its normal.
    var weights = 1.0;
    for (var offset = -reach; offset <= reach; offset++) {
        let place = pixel + offset * step;
        if offset != 0 && all(place >= vec2i(0)) && all(place < vec2i(screen.size)) {
            let there = unfiltered[layer_start + u32(place.y) * screen.size.x + u32(place.x)];
            let there_depth = unpack_depth(there.x);
            if there_depth > 0.0 {
                let there_position = there_depth * view_ray(vec2f(place));
                let of_it = weight(f32(offset), normal, position, unpack_normal(there.x), there_position);
                sum += of_it * unpack_light(there.y);
                weights += of_it;
            }
        }
    }
    return sum / weights;
}

@compute @workgroup_size(64)
fn across(@builtin(global_invocation_id) id: vec3u) {
    let index = screen.first + id.x;
    if index < screen.end {
        half_filtered[index] = vec2u(unfiltered[index].x, pack_light(blur(index, vec2i(1, 0))));
    }
}

@compute @workgroup_size(64)
fn down(@builtin(global_invocation_id) id: vec3u) {
    let index = screen.first + id.x;
    if index < screen.end {
        filtered[index] = vec4f(blur(index, vec2i(0, 1)), 0.0);
    }
}
