//! Linear RGB with the Rec. 709 primaries, its sRGB coding, and the tone map.

use clap::ValueEnum;
use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Luminance of linear RGB with Rec. 709 primaries (ITU-R BT.709-6, item 3.2).
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Decodes one sRGB value in [0, 1] to linear (IEC 61966-2-1).
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Codes one linear value in [0, 1] as sRGB (IEC 61966-2-1).
pub fn linear_to_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The curve of a tone map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ToneCurve {
    /// Exposure, then clipped at white.
    Plain,
    /// Exposure, then a shoulder that rolls off towards white (Narkowicz 2015, fit of the ACES curve).
    Filmic,
}

/// How linear radiance becomes a displayed colour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ToneMap {
    /// Exposure in stops: radiance is multiplied by 2^exposure.
    pub exposure: f32,
    /// The radiance, after exposure, that is shown as white. Above 0.
    pub white: f32,
    /// Extra gamma on top of sRGB's own coding; 1 leaves it alone.
    pub gamma: f32,
    /// Plain or filmic.
    pub curve: ToneCurve,
}

impl Default for ToneMap {
    fn default() -> Self {
        Self { exposure: 0.0, white: 1.0, gamma: 1.0, curve: ToneCurve::Filmic }
    }
}

impl ToneMap {
    /// What radiance is multiplied by before the curve: 2^exposure / white.
    pub fn scale(&self) -> f32 {
        self.exposure.exp2() / self.white.max(1e-6)
    }

    /// 1 / gamma.
    pub fn inverse_gamma(&self) -> f32 {
        1.0 / self.gamma.max(1e-3)
    }

    /// Linear radiance [W/(m² sr)] to sRGB-coded values in [0, 1].
    pub fn apply(&self, radiance: Vec3) -> Vec3 {
        let scaled = radiance * self.scale();
        let curved = match self.curve {
            ToneCurve::Plain => scaled,
            ToneCurve::Filmic => filmic(scaled) / filmic(Vec3::ONE),
        };
        let clipped = curved.clamp(Vec3::ZERO, Vec3::ONE);
        clipped.powf(self.inverse_gamma()).map(linear_to_srgb)
    }

    /// [`ToneMap::apply`] as opaque 8-bit RGBA.
    pub fn apply_to_bytes(&self, radiance: Vec3) -> [u8; 4] {
        let coded = self.apply(radiance);
        let bytes = (coded.extend(1.0) * 255.0).round().clamp(Vec4::ZERO, Vec4::splat(255.0));
        bytes.to_array().map(|value| value as u8)
    }
}

/// Narkowicz's rational fit of the ACES filmic curve.
fn filmic(x: Vec3) -> Vec3 {
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips_every_byte() {
        for byte in 0..=255_u8 {
            let encoded = f32::from(byte) / 255.0;
            assert!((linear_to_srgb(srgb_to_linear(encoded)) - encoded).abs() < 1e-5, "byte {byte}");
        }
    }

    #[test]
    fn both_curves_take_black_to_black_and_the_white_point_to_white() {
        for curve in [ToneCurve::Plain, ToneCurve::Filmic] {
            let map = ToneMap { exposure: 1.0, white: 8.0, gamma: 1.0, curve };
            assert_eq!(map.apply_to_bytes(Vec3::ZERO), [0, 0, 0, 255]);
            assert_eq!(map.apply_to_bytes(Vec3::splat(4.0)), [255; 4]); // 4 · 2^1 = white
            assert!(map.apply(Vec3::splat(1.0)).cmplt(Vec3::ONE).all());
        }
    }

    #[test]
    fn plain_curve_at_half_of_white_is_srgb_of_one_half() {
        let map = ToneMap { exposure: 0.0, white: 2.0, gamma: 1.0, curve: ToneCurve::Plain };
        assert_eq!(map.apply_to_bytes(Vec3::ONE)[0], 188); // IEC 61966-2-1: 0.5 linear is 0.7354 coded
    }
}
