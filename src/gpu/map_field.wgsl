// The field of a view that lies on the pages of a lightmap, read for every pixel. Comes after mesh_view.wgsl.

const HAS_MAP = true;

// As `Pages` in lightmap/pages.wgsl.
struct Pages {
    size: vec2u,
    count: u32,
    spare: u32,
    texels: array<vec4f>,
}

@group(3) @binding(0) var<storage, read> pages: Pages;

// The difference to the field at the vertices is shown.
override DIFFERENCE: bool;
// The nearest texel, and not the four around.
override NEAREST_TEXEL: bool;
// The page is a picture of the view itself.
override ON_SCREEN: bool;

fn texel(page: u32, place: vec2f) -> vec3f {
    let inside = vec2u(clamp(place, vec2f(0.0), vec2f(pages.size) - 1.0));
    return pages.texels[(page * pages.size.y + inside.y) * pages.size.x + inside.x].xyz;
}

// Charts::interpolate.
fn at_map(place: vec3f) -> vec3f {
    let page = u32(place.z + 0.5);
    if NEAREST_TEXEL {
        return texel(page, floor(place.xy));
    }
    let shifted = place.xy - 0.5;
    let corner = floor(shifted);
    let fraction = shifted - corner;
    let upper = mix(texel(page, corner), texel(page, corner + vec2f(1.0, 0.0)), fraction.x);
    let lower = mix(texel(page, corner + vec2f(0.0, 1.0)), texel(page, corner + vec2f(1.0, 1.0)), fraction.x);
    return mix(upper, lower, fraction.y);
}

fn field(in: Fragment) -> vec3f {
    var place = in.map_place.xyz / in.map_place.w;
    if ON_SCREEN {
        place = vec3f(in.clip.xy * frame.range.zw, 0.0);
    }
    let value = at_map(place);
    if DIFFERENCE {
        return abs(in.irradiance - value);
    }
    return value;
}
