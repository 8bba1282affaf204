//! A sampler's density against the area that it really spreads a small square over.

use glam::{Vec2, Vec3};

/// How far a density may be from the finite difference, relatively: rounding and curvature stay far below it.
pub const JACOBIAN_TOLERANCE: f32 = 0.01;

/// Half the side of the small square.
const STEP: f32 = 1e-3;

/// Where a density is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JacobianMismatch {
    /// The point of the unit square.
    pub point: Vec2,
    /// The density as the function gives it.
    pub pdf: f32,
    /// The density as the warp has it: one over the area that a unit of the square is spread over.
    pub measured: f32,
}

/// 100 points of the unit square, at least 0.02 from its sides and its diagonals: common maps are smooth in between,
/// and folded there.
pub fn fixed_points() -> impl Iterator<Item = Vec2> {
    (0..100).map(|index| Vec2::new((index % 10) as f32 + 0.2, (index / 10) as f32 + 0.5) / 10.0)
}

/// Compares `pdf` with one over the Jacobian of `warp` at each of `points`, by central differences; the first
/// mismatch above [`JACOBIAN_TOLERANCE`] is the error.
///
/// `warp` maps the unit square to a surface in space (a plane map leaves z at 0); `pdf` is per unit of its area.
pub fn check_jacobian(
    points: impl Iterator<Item = Vec2>,
    warp: impl Fn(Vec2) -> Vec3,
    pdf: impl Fn(Vec3) -> f32,
) -> Result<(), JacobianMismatch> {
    for point in points {
        let along = |step: Vec2| (warp(point + step) - warp(point - step)) / (2.0 * STEP);
        let area = along(STEP * Vec2::X).cross(along(STEP * Vec2::Y)).length();
        let (pdf, measured) = (pdf(warp(point)), 1.0 / area);
        let deviation = (pdf / measured - 1.0).abs();
        if deviation.is_nan() || deviation > JACOBIAN_TOLERANCE {
            return Err(JacobianMismatch { point, pdf, measured });
        }
    }
    Ok(())
}
