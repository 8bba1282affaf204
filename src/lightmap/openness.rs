//! How much of a texel is open: not under an object, nor inside of one, nor in the hole of a cut-out.

use glam::{DVec2, Vec2};

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
    /// Distance of the nearest other surface [local units]; infinite if there is none.
    pub(super) clearance: f32,
}

/// Points looked at first, along each side of a texel.
const COARSE: u32 = 2;
/// And where those disagree.
const FINE: u32 = 6;

/// Looks at some points of a piece; more where they disagree. `see` is told the triangles that are seen from there.
pub(super) fn openness(
    scene: &Scene,
    tracer: &dyn RayTracer,
    triangle: u32,
    flat: &TexelTriangle,
    piece: &Piece,
    mut see: impl FnMut(u32),
) -> Openness {
    let mut clearance = f32::INFINITY;
    let mut test = |point: Vec2| {
        let found = clearance_of(scene, tracer, triangle, point, &mut see);
        clearance = clearance.min(found.unwrap_or(f32::INFINITY));
        found.is_some()
    };
    let mut points = points_in(flat, piece, COARSE);
    points.push(piece.centroid);
    let open = points.iter().filter(|point| test(**point)).count();
    if open == points.len() {
        return Openness { share: 1.0, centroid: piece.centroid, clearance };
    }
    let fine = points_in(flat, piece, FINE);
    let points = if fine.is_empty() { points } else { fine };
    let found: Vec<Vec2> = points.iter().copied().filter(|point| test(*point)).collect();
    if found.is_empty() {
        return Openness { share: 0.0, centroid: piece.centroid, clearance };
    }
    let centroid = found.iter().sum::<Vec2>() / found.len() as f32;
    // The middle of a bent part may be buried itself: then the point next to it.
    let nearest = |a: &&Vec2, b: &&Vec2| a.distance_squared(centroid).total_cmp(&b.distance_squared(centroid));
    let centroid = if test(centroid) { centroid } else { found.iter().min_by(nearest).copied().unwrap_or(centroid) };
    Openness { share: found.len() as f32 / points.len() as f32, centroid, clearance }
}

/// The points of a grid in the texel that lie in the piece, in barycentric coordinates.
pub(super) fn points_in(flat: &TexelTriangle, piece: &Piece, side: u32) -> Vec<Vec2> {
    let corner = DVec2::new(f64::from(piece.texel[0]), f64::from(piece.texel[1]));
    let place = |index: u32| (DVec2::new(f64::from(index % side), f64::from(index / side)) + 0.5) / f64::from(side);
    let points = (0..side * side).map(|index| corner + place(index));
    points.filter(|point| flat.contains(*point)).map(|point| flat.barycentric(point)).collect()
}

/// How far the next surface is; none in a cut-out's hole and where the point is buried.
fn clearance_of(
    scene: &Scene,
    tracer: &dyn RayTracer,
    triangle: u32,
    point: Vec2,
    see: impl FnMut(u32),
) -> Option<f32> {
    if scene.may_be_cut_out(triangle) && scene.is_cut_out(triangle, point) {
        return None;
    }
    let around = SurfacePoint::new(scene, triangle, point).surroundings(tracer, see);
    (!around.is_buried).then_some(around.clearance)
}
