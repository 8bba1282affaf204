// The taps of a pixel on the line of its slice, in the picture and in the one around. Comes after gather.wgsl.

// A slice's line on the picture.
struct Line {
    pixel: vec2f,
    // The view ray of its pixel at depth 1.
    ray: vec3f,
    // To the side, within the slice: at a right angle to the ray.
    tangent: vec3f,
    // One pixel along it on the picture.
    along: vec2f,
    // How far taps are apart, and how they are rounded.
    noise: vec2f,
}

// The line of a pixel's slice, turned about the direction to the eye, evenly.
fn line_of(pixel: vec2f, noise: vec2f) -> Line {
    let ray = view_ray(pixel);
    let to_eye = -normalize(ray);
    let aside = normalize(cross(to_eye, vec3f(0.0, 1.0, 0.0)));
    let tangent = cos(PI * noise.x) * aside + sin(PI * noise.x) * cross(to_eye, aside);
    return Line(pixel, ray, tangent, normalize((tangent.xy - ray.xy * tangent.z) / screen.ray_step), noise);
}

// One half of a line, from its pixel on.
struct Side {
    // 1, or -1 against the line.
    sign: f32,
    // Number of its first tap among those of the line, and of its taps.
    first: u32,
    steps: u32,
    within: f32,
    // Where it leaves the picture, as a part of the reach; and how much farther apart taps are from there on.
    exit: f32,
    growth: f32,
}

fn side_of(line: Line, side: u32) -> Side {
    let sign = select(1.0, -1.0, side == 1u);
    let along = sign * line.along;
    let borders = select(vec2f(0.0), vec2f(screen.size), along > vec2f(0.0));
    let leaves_at = max((borders - line.pixel - 0.5) / along, vec2f(0.0));
    let exit = sqrt(min(leaves_at.x, leaves_at.y) / screen.radius);
    let growth = (screen.surround - 1.0) / max(1.0 - exit, 1e-3);
    let first = side * ((screen.taps + 1u) / 2u);
    return Side(sign, first, (screen.taps + 1u - side) / 2u, fract(line.noise.y + 0.5 * f32(side)), exit, growth);
}

// Sides of a line: a single tap lies on one.
fn sides() -> u32 {
    return min(screen.taps, 2u);
}

// A tap of one side of a line.
struct Tap {
    // Where the part of the line that it stands for begins, where it lies, and where that part ends, in pixels.
    places: vec3f,
    // Its view ray.
    ray: vec3f,
    // Its first layer's entry, and how far behind it the second layer's is.
    entry: u32,
    to_second: u32,
    // Not outside the picture around.
    is_there: bool,
}

// More taps lie near, where a hemisphere is filled. Within the picture taps lie as they do without one around. Each stands for
// the line half way to its neighbours: so the ends of its part move with it from frame to frame, and leave no bands.
fn tap_of(line: Line, side: Side, number: u32) -> Tap {
    let middle = f32(number) + side.within;
    let begin = select(middle - 0.5, 0.0, number == 0u);
    let end = select(middle + 0.5, f32(side.steps), number + 1u == side.steps);
    let parts = vec3f(begin, middle, end) / f32(side.steps);
    let grown = 1.0 + max(parts - side.exit, vec3f(0.0)) * side.growth;
    let reach = screen.radius * parts * parts * grown;
    let places = side.sign * max(reach, vec3f(0.75, 1.0, 1.25));
    let place = on_grid(line.pixel + 0.5 + places.y * line.along);
    let ray = view_ray(place);
    if all(place >= vec2f(0.0)) && all(place < vec2f(screen.size)) {
        return Tap(places, ray, u32(place.y) * screen.size.x + u32(place.x), pixel_count(), true);
    }
    let around = floor((ray.xy - screen.surround_origin) / screen.surround_step + 0.5);
    let is_there = all(around >= vec2f(0.0)) && all(around < vec2f(screen.surround_size));
    let entry = layer_entries() + u32(around.y) * screen.surround_size.x + u32(around.x);
    return Tap(places, vec3f(screen.surround_origin + around * screen.surround_step, 1.0), entry, pixel_count_around(), is_there);
}
