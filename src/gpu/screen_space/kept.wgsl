// What the taps of a pixel count for is the same in all bounces of a frame: the first one keeps it, for the others to look
// up. Comes after slices.wgsl.

// The word of a tap: how many sectors it lights, and its part in the mean of all; 0 if it counts for nothing.
fn pack_counts(sectors: u32, part: f32) -> u32 {
    return (bitcast<u32>(part) & ~63u) | sectors;
}

// Where the words of what is gathered at are kept: tap by tap, layer by layer. Behind those of all taps, the weight of a
// sector, and that of the mean.
fn kept_place(entry_number: u32, tap: u32, layer: u32) -> u32 {
    let entries = screen.layers * (screen.grid.x * screen.grid.y + pixel_count_around());
    return (tap * LAYERS + layer) * entries + entry_number;
}

// Irradiance as by `from_slices`, of what leaves the taps by the bounce before.
fn from_kept(pixel: vec2f, noise: vec2f, entry_number: u32) -> vec3f {
    let line = line_of(pixel, noise);
    var light = vec3f(0.0);
    var mean_light = vec4f(0.0);
    var half = 0u;
    loop {
        let side = side_of(line, half);
        var number = 0u;
        loop {
            let tap = tap_of(line, side, number);
            if !tap.is_there {
                break;
            }
            for (var layer = 0u; layer < LAYERS; layer++) {
                let counts = kept[kept_place(entry_number, side.first + number, layer)];
                if counts != 0u {
                    let leaves = unpack_light(outgoing[tap.entry + layer * tap.to_second]);
                    light += f32(counts & 63u) * leaves;
                    mean_light += bitcast<f32>(counts & ~63u) * vec4f(leaves, 1.0);
                }
            }
            continuing {
                number++;
                break if number >= side.steps;
            }
        }
        continuing {
            half++;
            break if half >= sides();
        }
    }
    let weight = bitcast<f32>(kept[kept_place(entry_number, screen.taps, 0u)]);
    let guess = bitcast<f32>(kept[kept_place(entry_number, screen.taps, 1u)]);
    return weight * light + guess * mean_light.xyz / max(mean_light.w, 1e-30);
}
