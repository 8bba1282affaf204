// The placed area light. Comes after frame.wgsl.

// sRGB-coded colour of the side that does not shine.
const BACK_COLOR = vec3f(0.05);
// The light lies before a surface in the same place by this part of its distance.
const LIFT = 1e-4;

struct Fragment {
    @builtin(position) clip: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Fragment {
    // Two triangles over the corners (-1,-1), (1,-1), (1,1), (-1,1), counter-clockwise seen from the front.
    let corner = (index - index / 3u) % 4u;
    let right = corner == 1u || corner == 2u;
    let place = vec2f(select(-1.0, 1.0, right), select(-1.0, 1.0, corner >= 2u));
    let position = frame.light_centre.xyz + place.x * frame.light_u.xyz + place.y * frame.light_v.xyz;
    var clip = frame.view_projection * vec4f(position, 1.0);
    clip.z *= 1.0 + LIFT;
    return Fragment(clip, place);
}

@fragment
fn fragment(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let from_border = (1.0 - abs(in.place)) / max(fwidth(in.place), vec2f(1e-9));
    let color = select(BACK_COLOR, frame.light_color.rgb, front);
    let outlined = min(from_border.x, from_border.y) < frame.outline_width;
    return vec4f(select(color, frame.outline_color.rgb, outlined), 1.0);
}
