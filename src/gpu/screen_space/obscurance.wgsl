// Ambient obscurance of the first layer (Alchemy: McGuire, Osman, Bukowski and Hennessy 2011, eq. 10), lengths in units of
// the obscurance's radius, so that its numbers suit scenes of any size. Comes after screen.wgsl.

@group(0) @binding(1) var normals: texture_2d_array<f32>;
@group(0) @binding(2) var depths: texture_2d_array<f32>;
@group(0) @binding(3) var<uniform> spiral: array<vec4f, 128>;
// The mean over the still frames, 1 where nothing obscures, down to 0; and the same to be filtered, and to be shown.
@group(0) @binding(4) var<storage, read_write> obscured: array<f32>;
@group(0) @binding(5) var<storage, read_write> next: array<u32>;
@group(0) @binding(6) var<storage, read_write> obscurance: array<vec3f>;

// Layers of the G-buffer.
override LAYERS: u32;

const PI = 3.14159265358979;
// Keeps near taps from outweighing all others, in squares of the radius.
const LEAST_SQUARE = 0.01;
// The radius in pixels is no larger than this part of the picture's height.
const LARGEST_PART = 0.25;

@compute @workgroup_size(64)
fn obscure(@builtin(global_invocation_id) id: vec3u) {
    let number = screen.first + id.x;
    if number >= screen.end {
        return;
    }
    let entry = entry_on_grid(number);
    let stored = textureLoad(depths, entry.pixel, 0, 0).x;
    var open = 1.0;
    if stored > 0.0 {
        let normal = normalize(textureLoad(normals, entry.pixel, 0, 0).xyz);
        open = openness(vec2f(entry.pixel), vec4f(normal, screen.near / stored));
    }
    let mean = mean_with(vec3f(obscured[entry.index]), vec3f(open));
    obscured[entry.index] = mean.x;
    next[entry.index] = pack_light(mean);
    obscurance[entry.index] = mean;
}

fn openness(pixel: vec2f, here: vec4f) -> f32 {
    let position = here.w * view_ray(pixel);
    let noise = jitter(pixel + 5.0 * f32(screen.every));
    let turn = vec2f(cos(2.0 * PI * noise.x), sin(2.0 * PI * noise.x));
    let size = f32(screen.size.y);
    let radius = min(screen.obscurance_radius / (here.w * sqrt(screen.pixel_area)), LARGEST_PART * size);
    let step = radius / f32(screen.obscurance_taps);
    var sum = 0.0;
    for (var tap = 0u; tap < screen.obscurance_taps; tap++) {
        let along = spiral[tap].xy;
        let offset = (f32(tap) + noise.y) * step
            * vec2f(along.x * turn.x - along.y * turn.y, along.x * turn.y + along.y * turn.x);
        let place = vec2i(floor(pixel + 0.5 + offset));
        if all(place >= vec2i(0)) && all(place < vec2i(screen.size)) {
            for (var layer = 0u; layer < LAYERS; layer++) {
                let stored = textureLoad(depths, place, layer, 0).x;
                let depth = screen.near / max(stored, 1e-30);
                let to = (depth * view_ray(vec2f(place)) - position) / screen.obscurance_radius;
                let squared = dot(to, to);
                if stored > 0.0 && squared < 1.0 {
                    let rise = dot(to, here.xyz) - screen.obscurance_slope * here.w / screen.obscurance_radius;
                    sum += max(rise, 0.0) / (squared + LEAST_SQUARE);
                }
            }
        }
    }
    return max(1.0 - 2.0 * screen.obscurance_strength * sum / f32(screen.obscurance_taps), 0.0);
}
