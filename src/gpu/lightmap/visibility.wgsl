// How much of a light arrives, seen from a point: the form factor of its outline, and what its hemicube shows before the
// point. Whoever uses it declares `settings` and `depth`, and begins with patches.wgsl.

const PI: f32 = 3.14159265;

// One edge of Lambert's formula (eq. 6), without its factor 1/2π.
fn edge_term(from_corner: vec3f, to_corner: vec3f, normal: vec3f) -> f32 {
    let across = cross(from_corner, to_corner);
    let sine = length(across);
    if sine <= 0.0 {
        return 0.0;
    }
    return atan2(sine, dot(from_corner, to_corner)) * dot(across, normal) / sine;
}

// The form factor from the origin to a quadrangle, the part below the horizon cut off (eq. 6 divided by π L). A triangle
// has its last corner twice.
fn polygon_form_factor(quadrangle: array<vec3f, 4>, normal: vec3f) -> f32 {
    var corners = quadrangle;
    var sum = 0.0;
    // Where the outline goes below the horizon, and where it comes up again; along it the polygon is closed.
    var leaves = vec3f(0.0);
    var returns = vec3f(0.0);
    for (var index = 0u; index < 4u; index++) {
        let here = corners[index];
        let there = corners[(index + 1u) % 4u];
        let height = dot(here, normal);
        let next_height = dot(there, normal);
        if height < 0.0 && next_height < 0.0 {
            continue;
        }
        var start = here;
        var end = there;
        if (height < 0.0) != (next_height < 0.0) {
            let crossing = mix(here, there, height / (height - next_height));
            if height < 0.0 {
                start = crossing;
                returns = crossing;
            } else {
                end = crossing;
                leaves = crossing;
            }
        }
        sum += edge_term(start, end, normal);
    }
    sum += edge_term(leaves, returns, normal);
    return abs(sum) / (2.0 * PI);
}

// True if what a pixel shows does not hide the receiver: the depth is compared where the pixel's ray meets the
// receiver's plane, so that a plane seen at a slant does not shade itself.
fn pixel_sees(pixel: vec2u, direction: vec3f, offset: vec3f, along: f32, normal: vec3f, slack: f32) -> bool {
    let stored = textureLoad(depth, pixel, 0).x;
    let slope = dot(normal, direction);
    var plane = along;
    if slope < 0.0 {
        plane = min(along, dot(normal, offset) / slope);
    }
    return stored * plane * slack <= settings.near;
}

// The part of a hemicube's origin that a point sees: `offset` from it, on a plane of this unit normal. `normal` and
// `tangent` are the hemicube's.
fn visibility(offset: vec3f, geometric_normal: vec3f, normal: vec3f, tangent: vec3f, slot: u32) -> f32 {
    let local = vec3f(dot(offset, tangent), dot(offset, cross(normal, tangent)), dot(offset, normal));
    if local.z <= 0.0 {
        return 0.0;
    }
    var face = 0u;
    if abs(local.x) > local.z || abs(local.y) > local.z {
        face = select(select(4u, 3u, local.y > 0.0), select(2u, 1u, local.x > 0.0), abs(local.x) > abs(local.y));
    }
    let axes = face_axes(face, tangent, normal);
    let along = dot(offset, axes.forward);
    let across = vec2f(dot(offset, axes.right), dot(offset, axes.up)) / along;
    let size = f32(settings.resolution);
    let rows = select(size / 2.0, size, face == 0u);
    // In pixels of the face; the first row is the highest.
    let lowest = select(0.0, -1.0, face == 0u);
    let place = vec2f((across.x + 1.0) * 0.5 * size, (1.0 - across.y) / (1.0 - lowest) * rows);
    let corner = tile_corner(slot, settings) + vec2u(0u, face_row(face, settings.resolution));
    let slack = 1.0 - settings.bias * 2.0 / size;
    if settings.filtered == 0u {
        let pixel = clamp(floor(place), vec2f(0.0), vec2f(size, rows) - 1.0);
        let on_face = pixel_place(pixel, size, rows, lowest);
        let direction = axes.forward + on_face.x * axes.right + on_face.y * axes.up;
        return f32(pixel_sees(corner + vec2u(pixel), direction, offset, along, geometric_normal, slack));
    }
    let first = floor(place - 0.5);
    let fraction = place - 0.5 - first;
    var seen = 0.0;
    for (var index = 0u; index < 4u; index++) {
        let step = vec2f(f32(index % 2u), f32(index / 2u));
        let pixel = clamp(first + step, vec2f(0.0), vec2f(size, rows) - 1.0);
        let weights = mix(1.0 - fraction, fraction, step);
        let on_face = pixel_place(pixel, size, rows, lowest);
        let direction = axes.forward + on_face.x * axes.right + on_face.y * axes.up;
        if pixel_sees(corner + vec2u(pixel), direction, offset, along, geometric_normal, slack) {
            seen += weights.x * weights.y;
        }
    }
    return seen;
}

// The middle of a pixel on its face at distance 1: along it from -1 to 1, and up from `lowest` to 1.
fn pixel_place(pixel: vec2f, size: f32, rows: f32, lowest: f32) -> vec2f {
    return vec2f((pixel.x + 0.5) / size * 2.0 - 1.0, 1.0 - (pixel.y + 0.5) / rows * (1.0 - lowest));
}
