// One bounce: what arrives at the surfaces of the pixels on the grid from those that taps of the picture show. Comes after
// screen.wgsl, and before the ways to weigh taps: line.wgsl, slices.wgsl and kept.wgsl, and spiral.wgsl.

// The same fields as BounceUniforms in gather.rs.
struct Bounce {
    // 1: the sum over the bounces begins.
    is_first: u32,
    // 1: nothing follows, and the filter takes the sum.
    is_last: u32,
    // 1: the last bounce comes next, and gathers from what it gathered in the frames before, too: so it grows to be the sum
    // of all that follow.
    feeds_last: u32,
    // 1: the last bounce, fed in this way.
    is_fed: u32,
}

// The G-buffer.
@group(0) @binding(1) var normals: texture_2d_array<f32>;
@group(0) @binding(2) var depths: texture_2d_array<f32>;
@group(0) @binding(3) var reflectances: texture_2d_array<f32>;
// What taps read: surfaces, and their radiosity by the bounce before [W/m²].
@group(0) @binding(4) var<storage, read> surfaces: array<u32>;
@group(0) @binding(5) var<storage, read> outgoing: array<u32>;
// Radiosity by this bounce; after the last one, all indirect irradiance.
@group(0) @binding(6) var<storage, read_write> next: array<u32>;
// Of this bounce: mean irradiance over the still frames.
@group(0) @binding(7) var<storage, read_write> gathered: array<vec3f>;
@group(0) @binding(8) var<storage, read_write> indirect: array<vec3f>;
// `gathered` of the last bounce; of that itself, anything.
@group(0) @binding(9) var<storage, read> gathered_last: array<vec3f>;
// Obscurance, if there is any.
@group(0) @binding(10) var<storage, read> obscurance: array<vec3f>;
// Cosine and sine of each tap's angle on the spiral.
@group(0) @binding(11) var<uniform> spiral: array<vec4f, 128>;
@group(0) @binding(12) var<uniform> bounce: Bounce;
// What the taps of the first bounce count for, for the bounces after it: see kept.wgsl.
@group(0) @binding(13) var<storage, read_write> kept: array<u32>;

// Layers of the G-buffer.
override LAYERS: u32;
// How taps are weighed, by a number of `Way` in gather.rs.
override WAY: u32;
const KEPT = 1u;
const SPIRAL = 2u;

const PI = 3.14159265358979;

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3u) {
    let number = screen.first + id.x;
    if number >= screen.end {
        return;
    }
    let entry = entry_on_grid(number);
    let index = entry.index;
    let stored = textureLoad(depths, entry.pixel, entry.image, 0).x;
    var arriving = vec3f(0.0);
    if stored > 0.0 {
        let normal = normalize(textureLoad(normals, entry.pixel, entry.image, 0).xyz);
        let here = vec4f(normal, screen.near / stored);
        let pixel = place_of(entry);
        if WAY == SPIRAL {
            arriving = from_spiral(pixel, here);
        } else {
            // Of the second layer, obscurance is not known.
            let is_dimmed = screen.obscurance_taps > 0u && index < pixel_count();
            var openness = 1.0;
            if is_dimmed {
                openness = obscurance[index].x;
            }
            let noise_pixel = select(pixel, vec2f(entry.pixel * screen.every), entry.image >= AROUND);
            let noise = jitter(noise_pixel);
            if WAY == KEPT {
                arriving = from_kept(pixel, noise, number);
            } else {
                arriving = from_slices(pixel, here, noise, openness, number);
            }
        }
        if screen.still > 0u {
            // What is fed grows from frame to frame: later ones count more.
            let weight = select(1.0 / f32(screen.still + 1u), 2.0 / f32(screen.still + 2u), bounce.is_fed == 1u);
            arriving = mix(gathered[index], arriving, weight);
        }
    }
    gathered[index] = arriving;
    var sum = arriving;
    if bounce.is_first == 0u {
        sum += indirect[index];
    }
    indirect[index] = sum;
    var leaves = sum;
    if bounce.is_last == 0u {
        var irradiance = arriving;
        if bounce.feeds_last == 1u && screen.still > 0u {
            irradiance += gathered_last[index];
        }
        leaves = textureLoad(reflectances, entry.pixel, entry.image, 0).xyz * irradiance;
    }
    next[index] = pack_light(leaves);
}
