//! False colours: from dark violet over green to yellow, even in lightness.

use glam::Vec3;

/// sRGB-coded colours at equal steps of [`color`]: ten points of matplotlib's "viridis" (van der Walt and Smith 2015).
pub const STOPS: [[u8; 3]; 10] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x28, 0x78],
    [0x3e, 0x49, 0x89],
    [0x31, 0x68, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x1f, 0x9e, 0x89],
    [0x35, 0xb7, 0x79],
    [0x6e, 0xce, 0x58],
    [0xb5, 0xde, 0x2b],
    [0xfd, 0xe7, 0x25],
];

/// The sRGB-coded colour, in [0, 1], of a value in [0, 1]; values outside get the end colours. Legends and shader use
/// the same stops, so they show the same colours.
pub fn color(value: f32) -> Vec3 {
    let inside = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
    let place = inside * (STOPS.len() - 1) as f32;
    let lower = (place as usize).min(STOPS.len() - 2);
    stop(lower).lerp(stop(lower + 1), place - lower as f32)
}

/// One of [`STOPS`], in [0, 1].
pub fn stop(index: usize) -> Vec3 {
    Vec3::from_array(STOPS[index].map(f32::from)) / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::color::{luminance, srgb_to_linear};

    #[test]
    fn brighter_colours_mean_larger_values() {
        let lightness = |step: usize| luminance(color(step as f32 / 100.0).map(srgb_to_linear));
        assert!((1..=100).all(|step| lightness(step) > lightness(step - 1)));
    }

    #[test]
    fn values_outside_get_the_end_colours() {
        assert_eq!(color(-3.0), stop(0));
        assert_eq!(color(f32::NAN), stop(0));
        assert_eq!(color(7.0), stop(9));
        assert_eq!(color(f32::INFINITY), stop(9));
    }
}
