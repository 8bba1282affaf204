//! Fewer triangles for drivers that draw on the processor: all vertices in one cell of a grid become one of them
//! (Rossignac and Borrel 1993, "Multi-resolution 3D approximations for rendering complex scenes").

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use super::geometry::MaterialDraw;

/// About so many triangles are left.
const TARGET: usize = 60_000;
/// Geometries of no more triangles are always drawn whole.
pub(super) const SMALL: usize = 250_000;

/// Triangles that take the place of many more, over the same vertices.
pub struct Coarse {
    /// The triangles.
    pub indices: Vec<[u32; 3]>,
    /// The vertex that each vertex becomes: the first in its cell, so none of the copies at the end.
    pub representatives: Vec<u32>,
    /// As [`super::ViewGeometry::draws`], in [`Coarse::indices`].
    pub(crate) draws: Vec<MaterialDraw>,
}

/// The coarse form of triangles that are sorted by material; none for few triangles. Surfaces stay closed; what is
/// smaller than a cell vanishes. `typical_edge` in local units.
pub(super) fn coarse(
    positions: &[Vec3],
    indices: &[[u32; 3]],
    draws: &[MaterialDraw],
    typical_edge: f32,
) -> Option<Coarse> {
    if indices.len() <= SMALL || typical_edge <= 0.0 {
        return None;
    }
    let cell = typical_edge * (indices.len() as f32 / TARGET as f32).sqrt();
    let representatives = representatives(positions, cell);
    let (mut coarse_indices, mut coarse_draws) = (Vec::new(), Vec::new());
    for draw in draws {
        let start = coarse_indices.len() as u32;
        let triangles = &indices[draw.triangles.start as usize..draw.triangles.end as usize];
        let merged = triangles.iter().map(|triangle| triangle.map(|vertex| representatives[vertex as usize]));
        coarse_indices.extend(merged.filter(|[a, b, c]| a != b && b != c && c != a));
        let triangles = start..coarse_indices.len() as u32;
        coarse_draws.push(MaterialDraw { material: draw.material, triangles });
    }
    Some(Coarse { indices: coarse_indices, representatives, draws: coarse_draws })
}

/// For each vertex, the first one in its cell.
fn representatives(positions: &[Vec3], cell: f32) -> Vec<u32> {
    let mut first: HashMap<IVec3, u32> = HashMap::new();
    let place = |position: Vec3| (position / cell).floor().as_ivec3();
    positions.iter().zip(0..).map(|(position, vertex)| *first.entry(place(*position)).or_insert(vertex)).collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    /// A square of so many cells a side, cut into two triangles each.
    fn sheet(cells: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let side = cells + 1;
        let place = |number: u32| number as f32 / cells as f32 - 0.5;
        let positions = (0..side * side).map(|vertex| Vec3::new(place(vertex % side), place(vertex / side), 0.1));
        let corners = (0..cells * cells).map(|cell| cell / cells * side + cell % cells);
        let triangles = corners
            .flat_map(|corner| [[corner, corner + 1, corner + side], [corner + 1, corner + side + 1, corner + side]]);
        (positions.collect(), triangles.collect())
    }

    fn area(positions: &[Vec3], triangles: &[[u32; 3]]) -> f32 {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            0.5 * (b - a).cross(c - a).z
        };
        triangles.iter().map(area).sum()
    }

    #[test]
    fn a_sheet_of_half_a_million_triangles_keeps_its_area_its_side_and_its_materials_with_a_tenth_of_them() {
        let (positions, triangles) = sheet(500);
        let half = triangles.len() as u32 / 2;
        let draws = [0..half, half..2 * half].into_iter().zip(0..);
        let draws: Vec<_> = draws.map(|(triangles, material)| MaterialDraw { material, triangles }).collect();
        let coarse = coarse(&positions, &triangles, &draws, 1.0 / 500.0).unwrap();
        let count = coarse.indices.len();
        assert!((TARGET / 2..2 * TARGET).contains(&count), "{count} triangles");
        // What is lost lies along the edge: half a cell at most on each side.
        let area = area(&positions, &coarse.indices);
        assert!((0.97..=1.0001).contains(&area), "an area of {area}, 1 was given");
        let [first, second] = [&coarse.draws[0], &coarse.draws[1]];
        assert_eq!(
            (first.triangles.start, first.triangles.end, second.triangles.end),
            (0, second.triangles.start, count as u32)
        );
        assert!(first.triangles.len().abs_diff(second.triangles.len()) < count / 20);
        assert!(coarse.representatives.iter().zip(0..).all(|(representative, vertex)| *representative <= vertex));
    }

    #[test]
    fn few_triangles_stay_as_they_are() {
        let (positions, triangles) = sheet(20);
        let draws = [MaterialDraw { material: 0, triangles: 0..triangles.len() as u32 }];
        assert!(coarse(&positions, &triangles, &draws, 0.05).is_none());
    }
}
