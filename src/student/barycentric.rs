//! Values between the corners of a triangle.

use glam::{Vec2, Vec3};

/// The value at barycentric coordinates (u, v) of a triangle with `values` a, b, c at its corners:
/// (1-u-v) a + u b + v c, in the unit of the values. A gather of eq. 4 reads the radiosity that a ray meets with it.
///
/// `barycentric` holds (u, v), both ≥ 0, u + v ≤ 1. Placeholder while not done: (0, 0, 0), no light.
///
/// Tests: `radiosity check`, task `barycentric`.
///
/// Hint: each weight is 1 at its own corner and 0 at the other two; the three sum to 1.
pub fn interpolate_barycentric(corners: [Vec3; 3], barycentric: Vec2) -> Vec3 {
    // <answer>
    let [a, b, c] = corners;
    (1.0 - barycentric.x - barycentric.y) * a + barycentric.x * b + barycentric.y * c
    // </answer> (super::PLACEHOLDERS.interpolate_barycentric)(corners, barycentric)
}
