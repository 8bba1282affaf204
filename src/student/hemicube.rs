//! The hemicube: what each of its pixels counts.

use std::f32::consts::FRAC_1_PI;

use glam::Vec2;

/// A face of the hemicube, the upper half of a cube of side 2 around the patch (Cohen and Greenberg 1985).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HemicubeFace {
    /// The square above the patch, at height 1.
    Top,
    /// One of the four half squares around it, at distance 1.
    Side,
}

/// The delta form factor of a small pixel of the hemicube (eq. 8): the part of what the patch emits, or receives, that
/// passes through the pixel. All pixels together have 1.
///
/// `place` is the middle of the pixel: (x, y) in [-1, 1]² on the top; on a side its way along the side in [-1, 1], and
/// its height z above the patch in [0, 1]. `pixel_area` is the pixel's area on the cube, whose faces lie at distance 1.
///
/// Method: Cohen and Greenberg 1985, "The Hemi-Cube: A Radiosity Solution for Complex Environments".
///
/// Placeholder while not done: 0. Tests: `tests/gpu_lightmap.rs`.
///
/// Hint: cosθ cosθ' / (π r²) with r² = x² + y² + 1 on the top. There both cosines are 1/r; on a side the patch's own is
/// z/r.
pub fn delta_form_factor(face: HemicubeFace, place: Vec2, pixel_area: f32) -> f32 {
    let distance_squared = place.length_squared() + 1.0;
    let cosines = match face {
        HemicubeFace::Top => 1.0,
        HemicubeFace::Side => place.y,
    };
    cosines * pixel_area * FRAC_1_PI / (distance_squared * distance_squared)
}
