//! Numbers: colour, sample sequences, statistics. Knows nothing of scenes.

pub mod color;
pub mod sequence;
pub mod sets;
pub mod statistics;

use glam::Vec3;

/// `a / b`, and 0 where that is not a finite number (0/0, x/0): for ratios that are only reported.
pub fn ratio_or_zero(numerator: f64, denominator: f64) -> f64 {
    let ratio = numerator / denominator;
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// True where every component is finite and not negative: what a radiometric quantity must be.
pub fn is_radiometric(value: Vec3) -> bool {
    value.is_finite() && value.min_element() >= 0.0
}
