//! The watertight ray-triangle test of Woop, Benthin and Wald (JCGT 2(1), 2013).
//!
//! Two triangles that share an edge compute the same edge function with opposite signs, so no ray passes between them.
//! Where an edge function is exactly 0 in f32 it is computed again in f64, as the paper asks (section 3.2).

use fearless_simd::{f32x4, f32x8, prelude::*, u8x16};
use glam::{Vec2, Vec3};

use super::{
    Hit, Ray,
    wide_tree::{Block, LANES},
};

/// A ray's axes, by twice the main one (along which its direction is longest), plus 1 where the direction is negative
/// along that: x, y, z with z the main one, winding kept.
const AXES: [[usize; 3]; 6] = [[1, 2, 0], [2, 1, 0], [2, 0, 1], [0, 2, 1], [0, 1, 2], [1, 0, 2]];

/// The bytes that bring a vector of four to the axes of [`AXES`]. Without an entry: main axis 3, which no ray has.
const SWIZZLES: [[u8; 16]; 8] = {
    let (mut swizzles, mut row) = ([[0; 16]; 8], 0);
    while row < AXES.len() {
        let mut byte = 0;
        while byte < 12 {
            swizzles[row][byte] = (4 * AXES[row][byte / 4] + byte % 4) as u8;
            byte += 1;
        }
        row += 1;
    }
    swizzles
};

/// What the test needs of a ray, computed once a ray (table 1 of the paper).
#[derive(Clone, Copy, Debug)]
struct ShearedRay {
    origin: Vec3,
    /// Of [`AXES`].
    axes: [usize; 3],
    shear: Vec3,
}

/// Where a ray meets a triangle's plane inside its edges.
#[derive(Clone, Copy, Debug)]
struct TriangleHit {
    distance: f32,
    barycentric: Vec2,
    front: bool,
}

impl ShearedRay {
    /// `direction` must not be 0.
    fn new(origin: Vec3, direction: Vec3) -> Self {
        let main = direction.abs().max_position();
        let components = direction.to_array();
        let axes = AXES[2 * main + usize::from(components[main] < 0.0)];
        let [x, y, z] = axes.map(|axis| components[axis]);
        Self { origin, axes, shear: Vec3::new(x / z, y / z, 1.0 / z) }
    }

    /// The hit with 0 < distance < `max_distance`, from either side.
    fn intersect(&self, corners: &[Vec3; 3], max_distance: f32) -> Option<TriangleHit> {
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
        let barycentric = Vec2::new(edges.y * inverse, edges.z * inverse);
        Some(TriangleHit { distance, barycentric, front: determinant > 0.0 })
    }
}

/// A ray for testing a block of triangles at once.
pub(super) struct ShearedLanes<S: Simd> {
    /// Of [`AXES`].
    axes: [usize; 3],
    /// In the ray's axis order, in all lanes.
    origin: [f32x8<S>; 3],
    shear: [f32x8<S>; 3],
}

/// What a ray meets in a block of triangles.
pub(super) struct BlockHits<S: Simd> {
    /// A bit for each triangle that is met, or on whose edge or corner the ray may lie.
    pub(super) lanes: u64,
    /// A bit for each triangle that the ray meets neither on an edge nor on a corner.
    off_edge: u64,
    distance: f32x8<S>,
    barycentric: [f32x8<S>; 2],
    inverse: f32x8<S>,
}

impl<S: Simd> ShearedLanes<S> {
    /// From origin and direction, with fourth lanes of 0: to the same bits as [`ShearedRay::new`], but without a branch,
    /// as rays of all directions would mispredict it.
    #[inline(always)]
    pub(super) fn new(simd: S, [origin, direction]: [f32x4<S>; 2]) -> Self {
        let length = direction.abs();
        let [x, y, z, _] = length.to_array();
        let longest = length.simd_ge(f32x4::splat(simd, x.max(y).max(z))).to_bitmask();
        let main = longest.trailing_zeros() as usize % 4;
        let is_negative = direction.simd_lt(f32x4::splat(simd, 0.0)).to_bitmask() as usize >> main & 1;
        let row = 2 * main + is_negative;
        let swizzle = u8x16::load_array_ref(simd, &SWIZZLES[row]);
        let [origin, direction] = [origin, direction].map(
            #[inline(always)]
            |vector| simd.swizzle_dyn_f32x4(vector, swizzle),
        );
        let [x, y, z, _] = direction.to_array();
        let shear = f32x4::load_array(simd, [x, y, 1.0, 0.0]) / z;
        Self { axes: AXES[row % AXES.len()], origin: splat(simd, origin), shear: splat(simd, shear) }
    }

    /// The hits with 0 < distance <= `reach`, from either side.
    #[inline(always)]
    pub(super) fn meet(&self, simd: S, block: &Block, reach: f32) -> BlockHits<S> {
        let zero = f32x8::splat(simd, 0.0);
        let [ax, ay, az] = self.corner(simd, &block.corners[0]);
        let [bx, by, bz] = self.corner(simd, &block.corners[1]);
        let [cx, cy, cz] = self.corner(simd, &block.corners[2]);
        // Not fused: both triangles of an edge must round alike.
        let edges = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
        let (least, most) = (edges[0].min(edges[1]).min(edges[2]), edges[0].max(edges[1]).max(edges[2]));
        let is_inside = least.simd_ge(zero) | most.simd_le(zero);
        let scaled_distance = self.shear[2] * (edges[0] * az + edges[1] * bz + edges[2] * cz);
        let inverse = f32x8::splat(simd, 1.0) / (edges[0] + edges[1] + edges[2]);
        let distance = scaled_distance * inverse;
        let is_outside = distance.simd_le(zero) | distance.simd_gt(f32x8::splat(simd, reach));
        let off_edge = least.simd_gt(zero) | most.simd_lt(zero);
        BlockHits {
            // On an edge the distance is computed anew, and may then be within reach.
            lanes: (is_inside & !(is_outside & off_edge)).to_bitmask(),
            off_edge: off_edge.to_bitmask(),
            distance,
            barycentric: [edges[1] * inverse, edges[2] * inverse],
            inverse,
        }
    }

    /// The hit with one of the triangles that [`Self::meet`] found, to the same bits as [`ShearedRay::intersect`].
    #[inline(always)]
    pub(super) fn hit(&self, ray: &Ray, hits: &BlockHits<S>, block: &Block, lane: usize, reach: f32) -> Option<Hit> {
        if hits.off_edge >> lane & 1 == 0 {
            return ShearedRay::hit(ray, block, lane, reach);
        }
        let lane = lane % LANES;
        Some(Hit {
            triangle: block.triangles[lane],
            barycentric: Vec2::from(hits.barycentric.map(
                #[inline(always)]
                |values| values.to_array()[lane],
            )),
            distance: hits.distance.to_array()[lane],
            front: hits.inverse.to_array()[lane] > 0.0,
        })
    }

    /// A corner of each triangle, seen from the origin and sheared; its depth last.
    #[inline(always)]
    fn corner(&self, simd: S, corner: &[[f32; LANES]; 3]) -> [f32x8<S>; 3] {
        let [x, y, z] = self.axes;
        let depth = f32x8::load_array_ref(simd, &corner[z]) - self.origin[2];
        let across = f32x8::load_array_ref(simd, &corner[x]) - self.origin[0];
        let along = f32x8::load_array_ref(simd, &corner[y]) - self.origin[1];
        [across - self.shear[0] * depth, along - self.shear[1] * depth, depth]
    }
}

impl ShearedRay {
    /// The hit with one triangle of a block: seldom asked for.
    #[cold]
    #[inline(never)]
    fn hit(ray: &Ray, block: &Block, lane: usize, reach: f32) -> Option<Hit> {
        let sheared = Self::new(ray.origin, ray.direction);
        let TriangleHit { distance, barycentric, front } = sheared.intersect(&block.corners(lane), reach.next_up())?;
        Some(Hit { triangle: block.triangles[lane], barycentric, distance, front })
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, vector: f32x4<S>) -> [f32x8<S>; 3] {
    let [x, y, z, _] = vector.to_array();
    [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)]
}

fn edge_in_f64(p: f32, q: f32, r: f32, s: f32) -> f32 {
    (f64::from(p) * f64::from(q) - f64::from(r) * f64::from(s)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

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
