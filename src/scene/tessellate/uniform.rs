//! Regular subdivision: every edge is cut in two, every triangle in four, n times.

use glam::{Vec2, Vec3};

use super::{Element, Vertices, check_count};
use crate::scene::Mesh;

/// The scene's triangles, cut in 4^levels each. Part `p` of triangle `t` is element `t · 4^levels + p`.
pub(super) fn subdivide(mesh: &Mesh, vertices: &mut Vertices, levels: u32) -> Result<Vec<Element>, String> {
    let count = 4_u64.checked_pow(levels).and_then(|parts| parts.checked_mul(mesh.triangles.len() as u64));
    check_count(count.unwrap_or(u64::MAX)).map_err(|problem| format!("subdivide {levels} {problem}"))?;
    let mut elements = whole(mesh);
    for _ in 0..levels {
        vertices.midpoints.clear();
        elements = elements.iter().flat_map(|element| in_four(element, vertices)).collect();
    }
    vertices.midpoints.clear();
    Ok(elements)
}

/// The scene's triangles themselves.
pub(super) fn whole(mesh: &Mesh) -> Vec<Element> {
    let element = |(index, &vertices): (usize, &[u32; 3])| Element {
        vertices,
        scene_triangle: index as u32,
        barycentrics: [Vec2::ZERO, Vec2::X, Vec2::Y],
    };
    mesh.triangles.iter().enumerate().map(element).collect()
}

/// A part at each corner, then the middle one, turned by half a turn: its corner k lies opposite to corner k.
fn in_four(element: &Element, vertices: &mut Vertices) -> [Element; 4] {
    let [a, b, c] = element.vertices;
    let [bc, ca, ab] = [vertices.midpoint(b, c), vertices.midpoint(c, a), vertices.midpoint(a, b)];
    let [p, q, r] = element.barycentrics;
    let [qr, rp, pq] = [0.5 * (q + r), 0.5 * (r + p), 0.5 * (p + q)];
    let part = |vertices, barycentrics| Element { vertices, barycentrics, ..*element };
    [
        part([a, ab, ca], [p, pq, rp]),
        part([ab, b, bc], [pq, q, qr]),
        part([ca, bc, c], [rp, qr, r]),
        part([bc, ca, ab], [qr, rp, pq]),
    ]
}

/// The part of a scene triangle that holds a point, and the point's barycentric coordinates in it.
pub(super) fn descend(levels: u32, scene_triangle: u32, barycentric: Vec2) -> (u32, Vec2) {
    if levels == 0 {
        return (scene_triangle, barycentric);
    }
    let mut part = scene_triangle;
    let mut weights = Vec3::new(1.0 - barycentric.x - barycentric.y, barycentric.x, barycentric.y);
    for _ in 0..levels {
        // A corner's part holds the points where that corner weighs at least one half.
        let corner = (0..3).find(|&corner| weights[corner] >= 0.5);
        weights = match corner {
            Some(corner) => 2.0 * weights - Vec3::AXES[corner],
            None => 1.0 - 2.0 * weights,
        };
        part = 4 * part + corner.unwrap_or(3) as u32;
    }
    (part, Vec2::new(weights.y, weights.z))
}
