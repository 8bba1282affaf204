//! Joining positions that lie close together.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use super::obj::Soup;
use super::{counted, repair};

/// Joins positions nearer than `fraction` of the scene's largest side: each position takes the place of the first
/// earlier one in reach, if there is one. Triangles that lose a corner by it are dropped.
pub(super) fn weld(soup: &mut Soup, fraction: f64, warnings: &mut Vec<String>) {
    let (minimum, maximum) = bounds(soup);
    let reach = fraction * (maximum - minimum).max_element();
    if reach <= 0.0 {
        return;
    }
    let cell_of = |point: DVec3| ((point - minimum) / reach).floor().as_i64vec3();
    let mut kept: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
    let mut target = vec![u32::MAX; soup.positions.len()];
    let mut moved = 0;
    for place in soup.triangles.iter().flat_map(|triangle| triangle.position_ids()) {
        if target[place as usize] != u32::MAX {
            continue;
        }
        let point = soup.positions[place as usize];
        let near = neighbours(cell_of(point)).filter_map(|cell| kept.get(&cell)).flatten();
        let joined = near.copied().filter(|&other| soup.positions[other as usize].distance(point) < reach).min();
        let joined = joined.unwrap_or(place);
        if joined == place {
            kept.entry(cell_of(point)).or_default().push(place);
        } else if soup.positions[joined as usize] != point {
            moved += 1;
        }
        target[place as usize] = joined;
    }
    for corner in soup.triangles.iter_mut().flat_map(|triangle| &mut triangle.corners) {
        corner.position = target[corner.position as usize];
    }
    if moved > 0 {
        warnings.push(format!("welded {} to another within {reach:.3e} m", counted(moved, "vertex")));
    }
    repair::keep(&mut soup.triangles, ["that had two corners in one place"; 2], warnings, |triangle| {
        let [a, b, c] = triangle.position_ids();
        a != b && b != c && c != a
    });
}

fn neighbours(cell: I64Vec3) -> impl Iterator<Item = I64Vec3> {
    let steps = || -1_i64..=1;
    let offsets = steps().flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| I64Vec3::new(x, y, z))));
    offsets.map(move |offset| cell.saturating_add(offset))
}

/// The bounding box of the positions that triangles use in m.
pub(super) fn bounds(soup: &Soup) -> (DVec3, DVec3) {
    let points = soup.triangles.iter().flat_map(|triangle| soup.points(triangle));
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}
