//! The watertight ray-triangle test of Woop, Benthin and Wald (JCGT 2(1), 2013).
//!
//! Two triangles that share an edge compute the same edge function with opposite signs, so no ray passes between them.
//! Where an edge function is exactly 0 in f32 it is computed again in f64, as the paper asks (section 3.2).

use glam::Vec3;

/// What the test needs of a ray, computed once a ray (table 1 of the paper).
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    origin: Vec3,
    /// Axis order x, y, z, with z along the direction's largest component, winding kept.
    axes: [usize; 3],
    shear: Vec3,
}

/// Where a ray meets a triangle's plane inside its edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleHit {
    pub(super) distance: f32,
    pub(super) barycentric: glam::Vec2,
    pub(super) front: bool,
}

impl ShearedRay {
    /// `direction` must not be 0.
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        let z = direction.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let shear = Vec3::new(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
        Self { origin, axes: [x, y, z], shear }
    }

    /// The hit with 0 < distance < `max_distance`, from either side.
    #[inline]
    pub(super) fn intersect(&self, corners: &[Vec3; 3], max_distance: f32) -> Option<TriangleHit> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|corner| corner - self.origin);
        let (ax, ay) = (a[x] - self.shear.x * a[z], a[y] - self.shear.y * a[z]);
        let (bx, by) = (b[x] - self.shear.x * b[z], b[y] - self.shear.y * b[z]);
        let (cx, cy) = (c[x] - self.shear.x * c[z], c[y] - self.shear.y * c[z]);
        let mut edges = Vec3::new(cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        if edges.x == 0.0 || edges.y == 0.0 || edges.z == 0.0 {
            edges = Vec3::new(edge_in_f64(cx, by, cy, bx), edge_in_f64(ax, cy, ay, cx), edge_in_f64(bx, ay, by, ax));
        }
        if edges.min_element() < 0.0 && edges.max_element() > 0.0 {
            return None;
        }
        let determinant = edges.x + edges.y + edges.z;
        if determinant == 0.0 {
            return None;
        }
        let scaled_distance = self.shear.z * (edges.x * a[z] + edges.y * b[z] + edges.z * c[z]);
        let inverse = 1.0 / determinant;
        let distance = scaled_distance * inverse;
        if !(distance > 0.0 && distance < max_distance) {
            return None;
        }
        let barycentric = glam::Vec2::new(edges.y * inverse, edges.z * inverse);
        Some(TriangleHit { distance, barycentric, front: determinant > 0.0 })
    }
}

fn edge_in_f64(p: f32, q: f32, r: f32, s: f32) -> f32 {
    (f64::from(p) * f64::from(q) - f64::from(r) * f64::from(s)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn hit_gives_distance_barycentrics_and_the_side_for_every_main_axis() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y]; // its front looks to +z
        for (turn, unturn) in [(0, 0), (1, 2), (2, 1)] {
            let rotate = |v: Vec3, times| (0..times).fold(v, |v: Vec3, _| Vec3::new(v.z, v.x, v.y));
            let turned = corners.map(|corner| rotate(corner, turn));
            for sign in [1.0, -1.0] {
                let origin = rotate(Vec3::new(0.2, 0.3, 2.0 * sign), turn);
                let direction = rotate(Vec3::new(0.0, 0.0, -sign), turn);
                assert_eq!(rotate(direction, unturn).z, -sign);
                let hit = ShearedRay::new(origin, direction).intersect(&turned, f32::INFINITY);
                let hit = hit.unwrap_or_else(|| panic!("turn {turn}, sign {sign}: missed"));
                assert!((hit.distance - 2.0).abs() < 1e-6);
                assert!(hit.barycentric.abs_diff_eq(Vec2::new(0.2, 0.3), 1e-6));
                assert_eq!(hit.front, sign > 0.0);
            }
        }
    }

    #[test]
    fn a_hit_behind_beyond_or_beside_does_not_count() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let down = |origin: Vec3, max| ShearedRay::new(origin, Vec3::NEG_Z).intersect(&corners, max).is_some();
        assert!(down(Vec3::new(0.2, 0.2, 1.0), 1.5));
        assert!(!down(Vec3::new(0.2, 0.2, 1.0), 1.0));
        assert!(!down(Vec3::new(0.2, 0.2, -1.0), 9.0));
        assert!(!down(Vec3::new(0.8, 0.8, 1.0), 9.0));
    }

    #[test]
    fn a_triangle_without_area_is_never_hit() {
        let needle = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        assert!(ShearedRay::new(Vec3::new(0.5, 0.0, 1.0), Vec3::NEG_Z).intersect(&needle, 9.0).is_none());
    }
}
