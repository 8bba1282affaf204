// Bounces by a spiral of taps, weighed as the source does (Nielsen 2015, section 2.3.3): twice the mean, over the taps above
// the horizon, of radiosity times cosine. That is an estimate of nothing in particular: neither distance nor what hides what
// has a part in it. Comes after gather.wgsl.

// "Irradiance" of a pixel's surface by the light of its taps.
fn from_spiral(pixel: vec2f, here: vec4f) -> vec3f {
    let position = here.w * view_ray(pixel);
    let noise = jitter(pixel);
    let turn = vec2f(cos(2.0 * PI * noise.x), sin(2.0 * PI * noise.x));
    let size = vec2f(screen.size);
    var light = vec3f(0.0);
    var seen = 0.0;
    for (var tap = 0u; tap < screen.taps; tap++) {
        let radius = screen.radius * (f32(tap) + noise.y) / f32(screen.taps);
        let along = spiral[tap].xy;
        let offset = radius * vec2f(along.x * turn.x - along.y * turn.y, along.x * turn.y + along.y * turn.x);
        let place = on_grid(pixel + 0.5 + offset);
        if all(place >= vec2f(0.0)) && all(place < size) {
            var other = u32(place.y) * screen.size.x + u32(place.x);
            for (var layer = 0u; layer < LAYERS; layer++) {
                let depth = unpack_depth(surfaces[other]);
                let to = depth * view_ray(place) - position;
                let cosine = dot(here.xyz, to);
                if depth > 0.0 && cosine > 0.0 {
                    light += 2.0 * cosine * inverseSqrt(dot(to, to)) * unpack_light(outgoing[other]);
                    seen += 1.0;
                }
                other += pixel_count();
            }
        }
    }
    return light / max(seen, 1.0);
}
