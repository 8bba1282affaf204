//! Triangles that no solver can use: dropped and counted.

use std::collections::HashSet;

use glam::DVec3;

use super::obj::{Soup, Triangle};
use super::{counted, weld};
use crate::scene::LoadOptions;

/// Welds if asked to, then drops the triangles without area.
pub(super) fn mend(soup: &mut Soup, options: &LoadOptions, warnings: &mut Vec<String>) {
    if soup.left_out_corners > 0 {
        let corners = counted(soup.left_out_corners, "polygon corner");
        let line = soup.left_out_line;
        warnings.push(format!(
            "left out {corners} (repeated, on a straight edge, or where edges cross), first in line {line}"
        ));
    }
    if let Some(fraction) = options.weld {
        weld::weld(soup, f64::from(fraction), warnings);
    }
    let positions = &soup.positions;
    let points = |triangle: &Triangle| triangle.position_ids().map(|position| positions[position as usize]);
    keep(&mut soup.triangles, ["without area"; 2], warnings, |triangle| has_area(points(triangle)));
}

/// Keeps the triangles for which `is_kept` says so. One warning for the others, with the line of the first: `which` they
/// are, for one and for several.
pub(super) fn keep(
    triangles: &mut Vec<Triangle>,
    which: [&str; 2],
    warnings: &mut Vec<String>,
    mut is_kept: impl FnMut(&Triangle) -> bool,
) {
    let (mut count, mut first) = (0, 0);
    triangles.retain(|triangle| {
        let is_kept = is_kept(triangle);
        if !is_kept {
            first = if count == 0 { triangle.line } else { first };
            count += 1;
        }
        is_kept
    });
    match count {
        0 => {}
        1 => warnings.push(format!("dropped 1 triangle {}, in line {first}", which[0])),
        _ => warnings.push(format!("dropped {count} triangles {}, first in line {first}", which[1])),
    }
}

/// False if the corners lie on one line, up to the rounding of their coordinates.
fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let longest = (b - a).abs().max((c - a).abs()).max((c - b).abs()).max_element();
    if longest <= 0.0 {
        return false;
    }
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    let height = ((b - a) / longest).cross((c - a) / longest).length();
    height > 8.0 * f64::EPSILON * (largest / longest)
}

/// Drops each triangle whose three positions and material some earlier one has, in the same winding (in any winding
/// if every triangle is to get two sides). Positions are equal if their indices are.
pub(super) fn drop_duplicates(triangles: &mut Vec<Triangle>, any_winding: bool, warnings: &mut Vec<String>) {
    let mut seen = HashSet::with_capacity(triangles.len());
    let which = ["that repeats an earlier one exactly", "that repeat earlier ones exactly"];
    keep(triangles, which, warnings, |triangle| {
        let [a, b, c] = triangle.position_ids();
        let mut key = if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        };
        if any_winding {
            key.sort_unstable();
        }
        seen.insert((key, triangle.material))
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::obj::Corner;

    #[test]
    fn only_corners_on_one_line_lack_area() {
        let point = DVec3::new;
        assert!(!has_area([point(0.0, 0.0, 0.0), point(0.1, 0.2, 0.3), point(0.3, 0.6, 0.9)]));
        assert!(!has_area([point(1e5, 0.0, 0.0), point(1e5 + 0.1, 0.2, 0.0), point(1e5 + 0.3, 0.6, 0.0)]));
        assert!(!has_area([DVec3::ONE; 3]));
        assert!(has_area([point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0), point(0.5, 1e-12, 0.0)]));
        assert!(has_area([DVec3::ZERO, point(1e-200, 0.0, 0.0), point(0.0, 1e-200, 0.0)]));
    }

    #[test]
    fn copies_are_found_whatever_corner_they_start_at() {
        let triangle = |ids: [u32; 3], material| {
            let corners = ids.map(|position| Corner { position, ..Default::default() });
            Triangle { corners, material, line: 1 }
        };
        let all = [([4, 2, 3], 0), ([2, 3, 4], 0), ([3, 4, 2], 0), ([4, 3, 2], 0), ([4, 2, 3], 1), ([4, 2, 5], 0)];
        for (any_winding, kept) in [(false, 4), (true, 3)] {
            let mut triangles = all.map(|(ids, material)| triangle(ids, material)).to_vec();
            drop_duplicates(&mut triangles, any_winding, &mut Vec::new());
            assert_eq!(triangles.len(), kept);
        }
    }
}
