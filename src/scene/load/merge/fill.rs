//! Triangles inside an outline.

use earcut::{Earcut, Refiner};
use glam::{DVec2, DVec3, Vec3};

use super::{FLAT, Faces, regions::Region};

/// A triangle with less height over its longest edge than this is none.
const THINNEST: f64 = 1e-4;

/// A vertex that stays on a straight edge is moved inwards by this part of the shorter edge at it while ears are clipped,
/// or it would get a triangle without area, or none.
const INWARDS: f64 = 1e-5;

/// Fills outlines; keeps its buffers between calls.
pub(super) struct Filler {
    earcut: Earcut<f64>,
    refiner: Refiner,
    flat: Vec<DVec2>,
    moved: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl Default for Filler {
    fn default() -> Self {
        let (earcut, refiner) = (Earcut::new(), Refiner::new());
        Self { earcut, refiner, flat: Vec::new(), moved: Vec::new(), triangles: Vec::new() }
    }
}

impl Filler {
    /// Triangles with corners from `loops` that cover a region; `None` if none are found that do.
    pub(super) fn fill(
        &mut self,
        region: &Region,
        loops: &[Vec<u32>],
        faces: &Faces,
        positions: &[Vec3],
    ) -> Option<Vec<[u32; 3]>> {
        let (x, y) = region.normal.any_orthonormal_pair();
        let point = |corner: u32| positions[faces.id(corner) as usize].as_dvec3();
        let origin = point(*loops.first()?.first()?);
        let flattened = |position: DVec3| DVec2::new((position - origin).dot(x), (position - origin).dot(y));
        // Around the surface comes first, its holes after that; each is as the surface lies to its left.
        let doubled_area = |outline: &Vec<u32>| -> f64 {
            let next = outline.iter().cycle().skip(1);
            outline.iter().zip(next).map(|(&a, &b)| flattened(point(a)).perp_dot(flattened(point(b)))).sum()
        };
        let (around, holes): (Vec<_>, Vec<_>) = loops.iter().partition(|outline| doubled_area(outline) > 0.0);
        let [around] = around[..] else { return None };
        let mut corners = around.clone();
        let mut hole_starts = Vec::new();
        for hole in holes {
            hole_starts.push(corners.len() as u32);
            corners.extend(hole);
        }
        self.flat.clear();
        self.flat.extend(corners.iter().map(|&corner| flattened(point(corner))));
        self.move_straight_ones(&hole_starts);
        self.earcut.earcut_slice(&self.moved, &hole_starts, &mut self.triangles);
        self.wind();
        self.refiner.refine(&mut self.triangles, &self.moved);
        let before = |&triangle: &u32| {
            let [a, b, c] = faces.points(triangle, positions);
            (b - a).cross(c - a).length()
        };
        let is_whole = self.covers(region.triangles.iter().map(before).sum());
        let triangles = self.triangles.chunks_exact(3);
        is_whole.then(|| triangles.map(|t| [t[0], t[1], t[2]].map(|place| corners[place as usize])).collect())
    }

    fn move_straight_ones(&mut self, hole_starts: &[u32]) {
        self.moved.clear();
        let mut start = 0;
        for end in hole_starts.iter().map(|&start| start as usize).chain([self.flat.len()]) {
            let outline = &self.flat[start..end];
            for (place, &here) in outline.iter().enumerate() {
                let (before, after) =
                    (outline[(place + outline.len() - 1) % outline.len()], outline[(place + 1) % outline.len()]);
                let along = (after - before).normalize_or_zero();
                let is_straight = along.perp_dot(here - before).abs() <= 2.0 * FLAT;
                let shift = if is_straight { INWARDS * here.distance(before).min(here.distance(after)) } else { 0.0 };
                self.moved.push((here + shift * along.perp()).to_array());
            }
            start = end;
        }
    }

    fn doubled_area(&self, triangle: &[u32]) -> f64 {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|place| self.flat[place as usize]);
        (b - a).perp_dot(c - a)
    }

    fn wind(&mut self) {
        let mut triangles = std::mem::take(&mut self.triangles);
        for triangle in triangles.chunks_exact_mut(3) {
            if self.doubled_area(triangle) < 0.0 {
                triangle.swap(1, 2);
            }
        }
        self.triangles = triangles;
    }

    /// True if the triangles have this area (doubled), none is folded or thin, and all vertices are in use.
    fn covers(&self, expected: f64) -> bool {
        let mut is_used = vec![false; self.flat.len()];
        let mut sum = 0.0;
        for triangle in self.triangles.chunks_exact(3) {
            let area = self.doubled_area(triangle);
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|place| self.flat[place as usize]);
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            if area < THINNEST * longest {
                return false;
            }
            sum += area;
            triangle.iter().for_each(|&place| is_used[place as usize] = true);
        }
        is_used.iter().all(|&used| used) && (sum - expected).abs() <= FLAT.max(1e-5 * expected)
    }
}
