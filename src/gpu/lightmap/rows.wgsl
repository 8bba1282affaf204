// From item buffers to rows of form factors: the weight of every pixel is added to the triangle that it shows.
// Group 0: settings, weights of a hemicube's pixels, rows [slot][triangle], items.

@group(0) @binding(0) var<uniform> settings: Settings;
@group(0) @binding(1) var<storage, read> weights: array<f32>;
@group(0) @binding(2) var<storage, read_write> rows: array<atomic<u32>>;
@group(0) @binding(3) var items: texture_2d<u32>;

// Sums are whole numbers of 2^-30: the same in any order, and a row of 1 still fits.
const ONE: f32 = 1073741824.0;

@compute @workgroup_size(64)
fn add_pixels(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.x;
    let slot = id.y;
    if pixel >= 3u * settings.resolution * settings.resolution {
        return;
    }
    let place = tile_corner(slot, settings) + vec2u(pixel % settings.resolution, pixel / settings.resolution);
    let item = textureLoad(items, place, 0).x;
    if item > 0u {
        // The receivers are the triangles here.
        atomicAdd(&rows[slot * settings.receiver_count + item - 1u], u32(weights[pixel] * ONE + 0.5));
    }
}
