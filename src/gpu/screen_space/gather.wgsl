// One bounce: what arrives at the surfaces of the pixels on the grid from those that taps of the picture show. Comes after
// screen.wgsl, and before slices.wgsl and spiral.wgsl, which hold the two ways to weigh taps.

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

@group(0) @binding(1) var<storage, read> geometry: array<vec4f>;
// Each pixel's surface, and its radiosity by the bounce before [W/m²].
@group(0) @binding(2) var<storage, read> outgoing: array<vec2u>;
// Of this bounce: mean irradiance over the still frames.
@group(0) @binding(3) var<storage, read_write> gathered: array<vec4f>;
// Cosine and sine of each tap's angle on the spiral.
@group(0) @binding(4) var<uniform> spiral: array<vec4f, 128>;
@group(0) @binding(5) var<uniform> bounce: Bounce;
@group(0) @binding(6) var<storage, read> reflectance: array<vec4f>;
// Radiosity by this bounce; after the last one, all indirect irradiance.
@group(0) @binding(7) var<storage, read_write> next: array<vec2u>;
@group(0) @binding(8) var<storage, read_write> indirect: array<vec4f>;
// `gathered` of the last bounce; of that itself, anything.
@group(0) @binding(9) var<storage, read> gathered_last: array<vec4f>;
// Obscurance, if there is any.
@group(0) @binding(10) var<storage, read> obscurance: array<vec4f>;

const PI = 3.14159265358979;

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3u) {
    let number = screen.first + id.x;
    if number >= screen.end {
        return;
    }
    let index = entry_on_grid(number);
    let here = geometry[index];
    var arriving = vec4f(0.0);
    if here.w > 0.0 {
        let pixel = place_of(index);
        if screen.source_weights == 1u {
            arriving = vec4f(from_spiral(pixel, here), 0.0);
        } else {
            // Of the second layer, obscurance is not known.
            let is_dimmed = screen.obscurance_taps > 0u && index < pixel_count();
            let openness = select(1.0, obscurance[min(index, pixel_count() - 1u)].x, is_dimmed);
            var noise_pixel = pixel;
            if index >= layer_entries() {
                noise_pixel = vec2f(pixel_around(index) * screen.every);
            }
            arriving = vec4f(from_slices(pixel, here, jitter(noise_pixel), openness), 0.0);
        }
        if screen.still > 0u {
            // What is fed grows from frame to frame: later ones count more.
            let weight = select(1.0 / f32(screen.still + 1u), 2.0 / f32(screen.still + 2u), bounce.is_fed == 1u);
            arriving = mix(gathered[index], arriving, weight);
        }
    }
    gathered[index] = arriving;
    var sum = arriving.xyz;
    if bounce.is_first == 0u {
        sum += indirect[index].xyz;
    }
    indirect[index] = vec4f(sum, 0.0);
    var leaves = sum;
    if bounce.is_last == 0u {
        var irradiance = arriving.xyz;
        if bounce.feeds_last == 1u && screen.still > 0u {
            irradiance += gathered_last[index].xyz;
        }
        leaves = reflectance[index].xyz * irradiance;
    }
    next[index] = vec2u(outgoing[index].x, pack_light(leaves));
}
