//! How much of a texel is open: not under an object, nor inside of one, nor in the hole of a cut-out.

use glam::{DVec2, Vec2, Vec3};

use super::coverage::{Piece, TexelTriangle};
use crate::{
    scene::Scene,
    trace::{RayTracer, SurfacePoint},
};

/// The open part of a piece.
pub(super) struct Openness {
    /// Its share of the piece, in [0, 1].
    pub(super) share: f32,
    /// Barycentric coordinates of its middle; of the piece's where nothing is open.
    pub(super) centroid: Vec2,
}

/// Points looked at first, along each side of a texel.
const COARSE: u32 = 2;
/// And where those disagree.
const FINE: u32 = 6;

/// Directions about +z that tell whether a point is buried: two rings, 30 and 60 degrees from the normal.
const DIRECTIONS: [Vec3; 8] = [
    Vec3::new(0.5, 0.0, 0.866),
    Vec3::new(-0.5, 0.0, 0.866),
    Vec3::new(0.0, 0.5, 0.866),
    Vec3::new(0.0, -0.5, 0.866),
    Vec3::new(0.612, 0.612, 0.5),
    Vec3::new(-0.612, 0.612, 0.5),
    Vec3::new(0.612, -0.612, 0.5),
    Vec3::new(-0.612, -0.612, 0.5),
];

/// Looks at some points of a piece; more where they disagree.
pub(super) fn openness(
    scene: &Scene,
    tracer: &dyn RayTracer,
    triangle: u32,
    flat: &TexelTriangle,
    piece: &Piece,
) -> Openness {
    let test = |point: Vec2| is_open(scene, tracer, triangle, point);
    let mut points = points_in(flat, piece, COARSE);
    points.push(piece.centroid);
    let open = points.iter().filter(|point| test(**point)).count();
    if open == points.len() {
        return Openness { share: 1.0, centroid: piece.centroid };
    }
    let fine = points_in(flat, piece, FINE);
    let points = if fine.is_empty() { points } else { fine };
    let found: Vec<Vec2> = points.iter().copied().filter(|point| test(*point)).collect();
    if found.is_empty() {
        return Openness { share: 0.0, centroid: piece.centroid };
    }
    let centroid = found.iter().sum::<Vec2>() / found.len() as f32;
    // The middle of a bent part may be buried itself: then the point next to it.
    let nearest = |a: &&Vec2, b: &&Vec2| a.distance_squared(centroid).total_cmp(&b.distance_squared(centroid));
    let centroid = if test(centroid) { centroid } else { found.iter().min_by(nearest).copied().unwrap_or(centroid) };
    Openness { share: found.len() as f32 / points.len() as f32, centroid }
}

/// The points of a grid in the texel that lie in the piece, in barycentric coordinates.
pub(super) fn points_in(flat: &TexelTriangle, piece: &Piece, side: u32) -> Vec<Vec2> {
    let corner = DVec2::new(f64::from(piece.texel[0]), f64::from(piece.texel[1]));
    let place = |index: u32| (DVec2::new(f64::from(index % side), f64::from(index / side)) + 0.5) / f64::from(side);
    let points = (0..side * side).map(|index| corner + place(index));
    points.filter(|point| flat.contains(*point)).map(|point| flat.barycentric(point)).collect()
}

/// False in a cut-out's hole, and where most rays meet back faces.
fn is_open(scene: &Scene, tracer: &dyn RayTracer, triangle: u32, point: Vec2) -> bool {
    if scene.may_be_cut_out(triangle) && scene.is_cut_out(triangle, point) {
        return false;
    }
    let from = SurfacePoint::new(scene, triangle, point);
    let (tangent, bitangent) = from.geometric_normal.any_orthonormal_pair();
    let back_hits = DIRECTIONS.iter().filter(|direction| {
        let direction = direction.x * tangent + direction.y * bitangent + direction.z * from.geometric_normal;
        let ray = from.ray(direction.normalize_or_zero());
        ray.and_then(|ray| tracer.closest_hit(&ray)).is_some_and(|hit| !hit.front)
    });
    2 * back_hits.count() <= DIRECTIONS.len()
}
