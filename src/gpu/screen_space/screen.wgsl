// What all passes over the picture's pixels share: the camera, the settings, and where a pixel lies. View space: x to the
// right, y up, z the depth along the camera's axis. A buffer of all layers holds the first layer's pixels row by row, then
// the second's, then those of the coarse picture around; a texture of all layers has an image for each of these.

// The same fields as ScreenUniforms in uniforms.rs.
struct Screen {
    // Pixels.
    size: vec2u,
    // Layers of the G-buffer.
    layers: u32,
    // Frames since anything moved.
    still: u32,
    // The view ray through the middle of pixel p is (ray_origin + p * ray_step, 1).
    ray_origin: vec2f,
    ray_step: vec2f,
    // The camera, in local units.
    right: vec3f,
    // Distance of the near plane.
    near: f32,
    up: vec3f,
    // Area of a pixel at depth 1.
    pixel_area: f32,
    forward: vec3f,
    // Taps of the spiral.
    taps: u32,
    eye: vec3f,
    // The spiral's radius in pixels.
    radius: f32,
    // The filter's radius in pixels, and the distance from a plane, as a part of the depth, that it stops at.
    filter_radius: f32,
    filter_depth: f32,
    // Obscurance: radius in local units, its taps, magnitude, and the least slope that obscures.
    obscurance_radius: f32,
    obscurance_taps: u32,
    obscurance_strength: f32,
    obscurance_slope: f32,
    // How much of the light from where taps meet nothing is filled in by the mean of what they meet.
    unseen: f32,
    // 1: what the first bounce's taps count for is kept for the others.
    keeps: u32,
    // The pixels of this submission, of all layers (or those on the grid): first, and after the last.
    first: u32,
    end: u32,
    // Bounces are gathered at every so many pixels along each side: the grid.
    every: u32,
    // How far behind its front a surface hides, in local units.
    thickness: f32,
    // The coarse picture around: its rays, as for the picture, its columns and rows (0 if there is none), and how many times
    // as wide it is.
    surround_origin: vec2f,
    surround_step: vec2f,
    surround_size: vec2u,
    surround: f32,
    spare: f32,
    // Columns and rows of the grid.
    grid: vec2u,
    spare_too: vec2u,
}

@group(0) @binding(0) var<uniform> screen: Screen;

fn pixel_count() -> u32 {
    return screen.size.x * screen.size.y;
}

// Quotient and rest. Software drivers divide whole numbers one at a time.
fn divided(number: u32, by: u32) -> vec2u {
    var quotient = u32(f32(number) / f32(by));
    var rest = i32(number - quotient * by);
    // Rounding may have missed by one.
    if rest < 0 {
        quotient -= 1u;
        rest += i32(by);
    }
    if rest >= i32(by) {
        quotient += 1u;
        rest -= i32(by);
    }
    return vec2u(quotient, u32(rest));
}

// The place in rows of so many columns.
fn place_in_rows(number: u32, columns: u32) -> vec2u {
    return divided(number, columns).yx;
}

// Entries of the layers; those of the picture around follow.
fn layer_entries() -> u32 {
    return screen.layers * pixel_count();
}

fn pixel_count_around() -> u32 {
    return screen.surround_size.x * screen.surround_size.y;
}

// The first image of the picture around, in a texture of all layers.
const AROUND = 2u;

// An entry of buffers of all layers, and where it lies in textures of all layers: its pixel, and its image.
struct Entry {
    index: u32,
    image: u32,
    pixel: vec2u,
}

fn entry_of(index: u32) -> Entry {
    let is_around = index >= layer_entries();
    let of_kind = select(index, index - layer_entries(), is_around);
    let pixels = select(pixel_count(), max(pixel_count_around(), 1u), is_around);
    let columns = select(screen.size.x, max(screen.surround_size.x, 1u), is_around);
    // There are no more than two layers.
    let is_second = of_kind >= pixels;
    let image = select(0u, AROUND, is_around) + u32(is_second);
    return Entry(index, image, place_in_rows(of_kind - select(0u, pixels, is_second), columns));
}

// Where an entry lies, in the picture's pixels; those of the picture around mostly lie outside.
fn place_of(entry: Entry) -> vec2f {
    if entry.image < AROUND {
        return vec2f(entry.pixel);
    }
    let ray = screen.surround_origin + vec2f(entry.pixel) * screen.surround_step;
    return (ray - screen.ray_origin) / screen.ray_step;
}

// The entry of what bounces are gathered at, by its number: the first layer's pixels on the grid, all of the picture around,
// layer by layer, then the second layer's on the grid.
fn entry_on_grid(in_order: u32) -> Entry {
    let on_grid = screen.grid.x * screen.grid.y;
    let around = screen.layers * pixel_count_around();
    if in_order >= on_grid && in_order < on_grid + around {
        return entry_of(layer_entries() + in_order - on_grid);
    }
    let layer = u32(in_order >= on_grid);
    let number = in_order - layer * (on_grid + around);
    let pixel = screen.every * place_in_rows(number, screen.grid.x);
    return Entry(layer * pixel_count() + pixel.y * screen.size.x + pixel.x, layer, pixel);
}

// The pixel on the grid that lies nearest, towards the first one.
fn on_grid(place: vec2f) -> vec2f {
    let every = f32(screen.every);
    return floor(place / every) * every;
}

// The view ray through the middle of a pixel, at depth 1.
fn view_ray(pixel: vec2f) -> vec3f {
    return vec3f(screen.ray_origin + pixel * screen.ray_step, 1.0);
}

// The point that a place of the picture shows, in view space, rebuilt from what the depth texture stores there.
fn position_at(place: vec2f, stored: f32) -> vec3f {
    return screen.near / stored * view_ray(place);
}

// From view space to local units.
fn in_space(view: vec3f) -> vec3f {
    return view.x * screen.right + view.y * screen.up + view.z * screen.forward;
}

// A mean over the frames since anything moved.
fn mean_with(before: vec3f, now: vec3f) -> vec3f {
    if screen.still == 0u {
        return now;
    }
    return mix(before, now, 1.0 / f32(screen.still + 1u));
}

// Two numbers in [0, 1) for a pixel. Of sixteen that lie in a square, each has the first one in a sixteenth of its own, in the
// order of Bayer's matrix, so that the filter finds all directions near, and no stripes. Over frames it goes on by van der
// Corput's sequence, so that each pixel has all sixteenths after sixteen of them, and no pattern of the square is left; the
// second one by an additive sequence (Roberts).
fn jitter(entry: vec2f) -> vec2f {
    let pixel = vec2u(floor(entry / f32(screen.every)));
    let mixed = pixel.x ^ pixel.y;
    let order = ((mixed & 1u) << 3u) | ((pixel.y & 1u) << 2u) | (mixed & 2u) | ((pixel.y & 2u) >> 1u);
    var hash = (pixel.x * 0x9e3779b9u) ^ (pixel.y * 0x85ebca6bu);
    hash = (hash ^ (hash >> 15u)) * 0x2c1b3c6du;
    hash = (hash ^ (hash >> 12u)) * 0x297a2d39u;
    hash = hash ^ (hash >> 15u);
    let bits = ((order << 28u) | ((hash & 0xffffu) << 12u)) ^ reverseBits(screen.still);
    let radius = f32(hash >> 16u) / 65536.0 + f32(screen.still % 4096u) * 0.56984029;
    return vec2f(f32(bits >> 8u) / 16777216.0, fract(radius));
}

// What taps read of a surface, in one word: its normal by an octahedron in the lower half, its depth in the upper half; 0
// where there is nothing.
fn pack_surface(normal: vec3f, depth: f32) -> u32 {
    let flat = normal.xy / (abs(normal.x) + abs(normal.y) + abs(normal.z));
    let folded = (1.0 - abs(flat.yx)) * select(vec2f(-1.0), vec2f(1.0), flat >= vec2f(0.0));
    let place = select(flat, folded, normal.z < 0.0);
    // Eleven bits of mantissa and five of exponent, of powers of two from DEPTH_EXPONENT on.
    let rounded = (bitcast<u32>(clamp(depth, 2.5e-4, 5e5)) + 0x800u) >> 12u;
    return ((rounded - DEPTH_EXPONENT) << 16u) | (pack4x8snorm(vec4f(place, 0.0, 0.0)) & 0xffffu);
}

// The exponent of 2^-12 in a number of 32 bits, after a shift by 12.
const DEPTH_EXPONENT = 0x39800u;

fn unpack_depth(surface: u32) -> f32 {
    let depth = bitcast<f32>(((surface >> 16u) + DEPTH_EXPONENT) << 12u);
    return select(depth, 0.0, surface == 0u);
}

fn unpack_normal(surface: u32) -> vec3f {
    return normalize(unpack_direction(surface));
}

// The normal, but not of unit length.
fn unpack_direction(surface: u32) -> vec3f {
    let place = unpack4x8snorm(surface).xy;
    let height = 1.0 - abs(place.x) - abs(place.y);
    let fold = max(-height, 0.0);
    return vec3f(place - fold * sign(place), height);
}

// Light in one word: three mantissas and an exponent that they share (Ward 1991).
fn pack_light(light: vec3f) -> u32 {
    let largest = max(max(light.x, light.y), max(light.z, 1e-30));
    let exponent = min((bitcast<u32>(largest) >> 23u) + 1u, 254u);
    return (exponent << 24u) | (pack4x8unorm(vec4f(light / bitcast<f32>(exponent << 23u), 0.0)) & 0xffffffu);
}

fn unpack_light(word: u32) -> vec3f {
    return unpack4x8unorm(word).xyz * bitcast<f32>((word >> 24u) << 23u);
}
