//! The samplers of the program's own engine, apart from those that a student writes (`student`): the two are
//! independent, so that each tells of a mistake in the other.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};

use glam::{Mat3, Vec2, Vec3};

use crate::scene::{AreaLight, mesh::interpolate};

/// A frame around a unit normal, for directions with z up: columns tangent, bitangent, normal.
pub fn frame(normal: Vec3) -> Mat3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    Mat3::from_cols(tangent, bitangent, normal)
}

/// A direction about +z with density cosθ/π (eq. 4), from a point of the unit square: the hemisphere above the
/// concentric disk of Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
pub fn cosine_direction(point: Vec2) -> Vec3 {
    let Vec2 { x, y } = 2.0 * point - 1.0;
    let (radius, angle) = if x * x > y * y {
        (x, FRAC_PI_4 * (y / x))
    } else if y != 0.0 {
        (y, FRAC_PI_2 - FRAC_PI_4 * (x / y))
    } else {
        return Vec3::Z;
    };
    let (sine, cosine) = angle.sin_cos();
    Vec3::new(radius * cosine, radius * sine, (1.0 - radius * radius).max(0.0).sqrt())
}

/// The density of [`cosine_direction`] [1/sr], from the cosine to the normal: 0 below the horizon.
pub fn cosine_pdf_solid_angle(cosine: f32) -> f32 {
    cosine.max(0.0) * FRAC_1_PI
}

/// The point of an area light at a point of the unit square: uniform, with density one over the area.
pub fn area_light_point(light: &AreaLight, point: Vec2) -> Vec3 {
    let Vec2 { x, y } = 2.0 * point - 1.0;
    light.centre + x * light.half_extent_u + y * light.half_extent_v
}

/// A uniform point of a triangle, from a point of the unit square: folds the square's diagonal onto the triangle and
/// shears the two halves, so that a stratified set stays well spread (Heitz 2019, "A Low-Distortion Map Between
/// Triangle and Square"). Returns its barycentric coordinates and its position.
pub fn triangle_point(corners: [Vec3; 3], point: Vec2) -> (Vec2, Vec3) {
    let half = 0.5 * point.min_element();
    let barycentric = if point.x < point.y { Vec2::new(half, point.y - half) } else { Vec2::new(point.x - half, half) };
    (barycentric, interpolate(corners, barycentric))
}

/// A point of a triangle with density proportional to the weight b of one corner (0, 1 or 2), from a point of the unit
/// square; its barycentric coordinates. The weight's distribution is 3b² - 2b³ (a layer of weight b is as wide as 1 - b),
/// whose inverse is a third of an angle (Cardano); along a layer the density is even.
pub fn hat_point(point: Vec2, corner: usize) -> Vec2 {
    let weight = (0.5 - ((1.0 - 2.0 * point.x).clamp(-1.0, 1.0).asin() / 3.0).sin()).clamp(0.0, 1.0);
    let next = (1.0 - weight) * point.y;
    match corner {
        0 => Vec2::new(next, 1.0 - weight - next),
        1 => Vec2::new(weight, next),
        _ => Vec2::new(1.0 - weight - next, weight),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hat_points_are_as_dense_as_a_corner_weighs() {
        // ∫ b_i b_j dA / ∫ b_i dA is 1/2 for j = i, else 1/4; ∫ b_i³ dA / ∫ b_i dA is 3/10 (A/3, A/6, A/12 and A/10).
        for corner in 0..3 {
            let (mut means, mut square) = (Vec3::ZERO, 0.0);
            for cell in 0..4096 {
                let point = (Vec2::new((cell % 64) as f32, (cell / 64) as f32) + 0.5) / 64.0;
                let Vec2 { x, y } = hat_point(point, corner);
                let weights = Vec3::new(1.0 - x - y, x, y);
                assert!(weights.min_element() >= -1e-6, "{weights}");
                means += weights / 4096.0;
                square += weights[corner] * weights[corner] / 4096.0;
            }
            let mut expected = Vec3::splat(0.25);
            expected[corner] = 0.5;
            assert!(means.abs_diff_eq(expected, 1e-3) && (square - 0.3).abs() < 1e-3, "{corner}: {means}, {square}");
        }
    }
}
