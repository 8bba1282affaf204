//! Cutting polygons into triangles.

use earcut::Earcut;
use glam::DVec3;

/// Polygons up to this size are first tried as a fan around each corner.
const LARGEST_FAN: usize = 16;

/// Cuts polygons; keeps its buffers between calls.
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    relative: Vec<DVec3>,
    projected: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { earcut: Earcut::new(), relative: Vec::new(), projected: Vec::new(), triangles: Vec::new() }
    }
}

impl Triangulator {
    /// Corner numbers of the triangles that make up a polygon of three or more corners, wound as it is.
    ///
    /// A fan if one exists that does not fold, the best shaped one (quads: the better diagonal); otherwise ears are
    /// clipped in the plane of the polygon's normal. A polygon without area gives a fan without area.
    pub(super) fn triangulate(&mut self, corners: &[DVec3]) -> &[u32] {
        self.triangles.clear();
        let origin = corners[0];
        self.relative.clear();
        self.relative.extend(corners.iter().map(|corner| corner - origin));
        let normal = newell_normal(&self.relative);
        let count = corners.len() as u32;
        if count == 3 || normal == DVec3::ZERO {
            fan(count, 0, &mut self.triangles);
        } else if let Some(start) = best_fan(&self.relative, normal) {
            fan(count, start, &mut self.triangles);
        } else {
            self.clip_ears(normal);
        }
        &self.triangles
    }

    fn clip_ears(&mut self, normal: DVec3) {
        // Leaving out the normal's largest component keeps the coordinates' own digits.
        let [x, y, z] = normal.abs().to_array();
        let (first, second, dropped) = if z >= x && z >= y {
            (0, 1, 2)
        } else if y >= x {
            (2, 0, 1)
        } else {
            (1, 2, 0)
        };
        let (first, second) = if normal[dropped] > 0.0 { (first, second) } else { (second, first) };
        self.projected.clear();
        self.projected.extend(self.relative.iter().map(|point| [point[first], point[second]]));
        self.earcut.earcut_slice(&self.projected, &[], &mut self.triangles);
        let projected = &self.projected;
        for triangle in self.triangles.chunks_exact_mut(3) {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|corner| projected[corner as usize]);
            if (b[0] - a[0]) * (c[1] - a[1]) < (b[1] - a[1]) * (c[0] - a[0]) {
                triangle.swap(1, 2);
            }
        }
        if self.triangles.is_empty() {
            fan(self.relative.len() as u32, 0, &mut self.triangles);
        }
    }
}

fn fan(count: u32, start: u32, triangles: &mut Vec<u32>) {
    for step in 1..count - 1 {
        triangles.extend([start, (start + step) % count, (start + step + 1) % count]);
    }
}

/// The corner whose fan has no folded or empty triangle and whose worst triangle is the best shaped; the earliest of
/// equals. None if every fan folds: then the polygon is concave, or its edges cross.
fn best_fan(points: &[DVec3], normal: DVec3) -> Option<u32> {
    let count = points.len();
    if count > LARGEST_FAN {
        return None;
    }
    let mut best = None;
    let mut best_shape = 0.0;
    for start in 0..if count == 4 { 2 } else { count } {
        let shape = (1..count - 1)
            .map(|step| {
                shape(points[start], points[(start + step) % count], points[(start + step + 1) % count], normal)
            })
            .fold(f64::INFINITY, f64::min);
        // The margin keeps rounding from choosing between the two diagonals of a rectangle.
        if shape > best_shape * (1.0 + 1e-6) {
            best = Some(start as u32);
            best_shape = shape;
        }
    }
    best
}

/// Twice the signed area over the square of the longest edge; not above rounding noise: 0.
fn shape(a: DVec3, b: DVec3, c: DVec3, normal: DVec3) -> f64 {
    let longest_squared = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    let ratio = (b - a).cross(c - a).dot(normal) / (normal.length() * longest_squared);
    if ratio > 1e-12 { ratio } else { 0.0 }
}

/// Twice the vector area (Newell's method; Sutherland, Sproull and Schumacker 1974).
fn newell_normal(points: &[DVec3]) -> DVec3 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles, and their area and vector area.
    fn cut(points: &[DVec3]) -> (Vec<u32>, f64, DVec3) {
        let mut triangulator = Triangulator::default();
        let triangles = triangulator.triangulate(points).to_vec();
        let scaled = |t: &[u32]| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|corner| points[corner as usize]);
            0.5 * (b - a).cross(c - a)
        };
        let area = triangles.chunks_exact(3).map(|t| scaled(t).length()).sum();
        let vector_area = triangles.chunks_exact(3).map(scaled).sum();
        (triangles, area, vector_area)
    }

    /// A comb of `teeth` unit squares standing on a base of height 1: area 3 teeth - 1.
    fn comb(teeth: i32, place: impl Fn(f64, f64) -> DVec3) -> Vec<DVec3> {
        let width = f64::from(2 * teeth - 1);
        let mut points = vec![place(0.0, 0.0), place(width, 0.0)];
        for tooth in (0..teeth).rev() {
            let left = f64::from(2 * tooth);
            points.extend([place(left + 1.0, 2.0), place(left, 2.0)]);
            if tooth > 0 {
                points.extend([place(left, 1.0), place(left - 1.0, 1.0)]);
            }
        }
        points
    }

    #[test]
    fn concave_polygons_keep_their_area_and_side_in_every_plane_and_far_away() {
        for (name, axes) in [("xy", [DVec3::X, DVec3::Y]), ("yz", [DVec3::Y, DVec3::Z]), ("zx", [DVec3::Z, DVec3::X])] {
            for (u, v) in [(axes[0], axes[1]), (axes[1], axes[0])] {
                for far in [0.0, 1e6] {
                    let points = comb(9, |x, y| DVec3::splat(far) + x * u + y * v);
                    let (triangles, area, vector_area) = cut(&points);
                    assert!((area - 26.0).abs() < 1e-9, "{name} {far}: {area}");
                    assert!(vector_area.abs_diff_eq(26.0 * u.cross(v), 1e-9), "{name} {far}");
                    assert!(triangles.len() <= 3 * (points.len() - 2));
                }
            }
        }
    }

    #[test]
    fn quads_are_cut_along_the_diagonal_that_lies_inside() {
        // A dart whose corner 1 is reflex: only the diagonal 1-3 lies inside.
        let dart = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.0], [1.0, 3.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let (triangles, area, _) = cut(&dart);
        assert_eq!(triangles, [1, 2, 3, 1, 3, 0]);
        assert!((area - 2.5).abs() < 1e-12); // triangle (0,0) (2,0) (1,3), less triangle (0,0) (2,0) (1,1/2)
        let square = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.3], [0.0, 0.3]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(cut(&square).0, [0, 1, 2, 0, 2, 3]);
    }

    #[test]
    fn corners_on_a_straight_edge_make_no_empty_triangle() {
        let points = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let (triangles, area, _) = cut(&points);
        assert_eq!((triangles.len(), area), (9, 4.0));
        assert_eq!(triangles[0], 1, "the fan starts in the middle of the straight edge");
    }

    #[test]
    fn a_polygon_without_area_gives_triangles_without_area() {
        let points = [0.0, 1.0, 2.0, 3.0].map(|x| DVec3::new(x, x, x));
        assert_eq!(cut(&points), (vec![0, 1, 2, 0, 2, 3], 0.0, DVec3::ZERO));
    }
}
