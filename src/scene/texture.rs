//! Textures, decoded once to linear values.

use clap::ValueEnum;
use glam::{IVec2, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use crate::math::color::srgb_to_linear;

/// How a texture is read between its texel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TextureFilter {
    /// The nearest texel.
    #[default]
    Nearest,
    /// The four texels around, weighted bilinearly.
    Bilinear,
}

/// A texture that repeats. The first texel is the top left one of the file; texture coordinate v points up.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The file it came from, for reports.
    pub name: String,
    /// How it is read.
    pub filter: TextureFilter,
    size: IVec2,
    /// 8-bit texels as in the file: sRGB colour and linear alpha.
    texels: Vec<[u8; 4]>,
    /// Linear value of each sRGB byte.
    linear: Box<[f32; 256]>,
}

impl Texture {
    /// A texture of 8-bit sRGB texels with linear alpha, row by row from the top; `texels` must hold `width · height`
    /// of them, and at least one.
    pub fn new(name: String, width: u32, height: u32, texels: Vec<[u8; 4]>, filter: TextureFilter) -> Self {
        assert!(width > 0 && height > 0 && texels.len() == width as usize * height as usize, "texels fill the size");
        let linear = Box::new(std::array::from_fn(|byte| srgb_to_linear(byte as f32 / 255.0)));
        Self { name, filter, size: IVec2::new(width as i32, height as i32), texels, linear }
    }

    /// Width and height in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.size.x as u32, self.size.y as u32)
    }

    /// The texels as in the file, row by row from the top: sRGB colour and linear alpha.
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// The largest linear colour value that a texel can have: 1, or the limit of [`Texture::limit_values`].
    pub fn largest_value(&self) -> f32 {
        self.linear[255]
    }

    /// True if any texel is less than half opaque.
    pub fn has_cut_outs(&self) -> bool {
        self.texels.iter().any(|texel| texel[3] < 128)
    }

    /// Linear RGB at texture coordinates (repeating).
    pub fn sample(&self, texcoord: Vec2) -> Vec3 {
        self.filtered(texcoord, |[r, g, b, _]| {
            Vec4::new(self.linear[r as usize], self.linear[g as usize], self.linear[b as usize], 0.0)
        })
        .truncate()
    }

    /// Alpha in [0, 1] at texture coordinates; for a texture without alpha see [`Texture::with_opacity_from_grey`].
    pub fn sample_opacity(&self, texcoord: Vec2) -> f32 {
        self.filtered(texcoord, |texel| Vec4::splat(f32::from(texel[3]) / 255.0)).x
    }

    /// A `map_d` picture stores opacity as grey: this moves its red channel into alpha.
    pub fn with_opacity_from_grey(mut self) -> Self {
        for texel in &mut self.texels {
            texel[3] = texel[0];
        }
        self
    }

    /// Brings all linear colour values down to `limit`; true if any texel is above it.
    pub fn limit_values(&mut self, limit: f32) -> bool {
        let exceeds = |texel: &[u8; 4]| texel[..3].iter().any(|&byte| self.linear[byte as usize] > limit);
        let any = self.texels.iter().any(exceeds);
        self.linear.iter_mut().for_each(|value| *value = value.min(limit));
        any
    }

    /// Adds all that a result depends on to a hash.
    pub fn hash_into(&self, hasher: &mut blake3::Hasher) {
        hasher.update(bytemuck::cast_slice(&self.size.to_array()));
        hasher.update(&[self.filter as u8]);
        hasher.update(bytemuck::cast_slice(&self.texels));
        hasher.update(bytemuck::cast_slice(self.linear.as_slice()));
    }

    fn filtered(&self, texcoord: Vec2, value: impl Fn([u8; 4]) -> Vec4) -> Vec4 {
        // The fraction first, so that coordinates far from 0 keep their digits where f32 still has any.
        let wrapped = if texcoord.is_finite() { texcoord - texcoord.floor() } else { Vec2::ZERO };
        if self.filter == TextureFilter::Nearest {
            // Counted from below, so that v = 0 is the bottom row: models put whole surfaces at (0, 0).
            let place = (wrapped * self.size.as_vec2()).floor().as_ivec2();
            return value(self.texel(IVec2::new(place.x, self.size.y - 1 - place.y)));
        }
        let place = Vec2::new(wrapped.x, 1.0 - wrapped.y) * self.size.as_vec2();
        let corner = (place - 0.5).floor();
        let fraction = place - 0.5 - corner;
        let corner = corner.as_ivec2();
        let at = |x, y| value(self.texel(corner + IVec2::new(x, y)));
        let top = at(0, 0).lerp(at(1, 0), fraction.x);
        let bottom = at(0, 1).lerp(at(1, 1), fraction.x);
        top.lerp(bottom, fraction.y)
    }

    fn texel(&self, place: IVec2) -> [u8; 4] {
        let wrapped = IVec2::new(place.x.rem_euclid(self.size.x), place.y.rem_euclid(self.size.y));
        self.texels[(wrapped.y * self.size.x + wrapped.x) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red and green over blue and white.
    fn four(filter: TextureFilter) -> Texture {
        let texels = vec![[255, 0, 0, 255], [0, 255, 0, 0], [0, 0, 255, 255], [255, 255, 255, 255]];
        Texture::new(String::from("four"), 2, 2, texels, filter)
    }

    #[test]
    fn nearest_reads_v_upwards_and_wraps() {
        let texture = four(TextureFilter::Nearest);
        assert_eq!(texture.sample(Vec2::new(0.25, 0.75)), Vec3::X);
        assert_eq!(texture.sample(Vec2::new(0.75, 0.25)), Vec3::ONE);
        assert_eq!(texture.sample(Vec2::new(-6.75, 3.25)), Vec3::Z);
        // The corner (0, 0) belongs to the bottom left texel, 1/2 to the texel above it.
        assert_eq!(texture.sample(Vec2::ZERO), Vec3::Z);
        assert_eq!(texture.sample(Vec2::new(0.0, 0.5)), Vec3::X);
        assert_eq!(texture.sample(Vec2::new(f32::NAN, 0.0)), texture.sample(Vec2::ZERO));
    }

    #[test]
    fn bilinear_meets_the_texels_at_their_centres_and_the_mean_between() {
        let texture = four(TextureFilter::Bilinear);
        assert_eq!(texture.sample(Vec2::new(0.25, 0.75)), Vec3::X);
        assert!(texture.sample(Vec2::new(0.5, 0.75)).abs_diff_eq(Vec3::new(0.5, 0.5, 0.0), 1e-6));
        assert!(texture.sample(Vec2::new(0.5, 0.5)).abs_diff_eq(Vec3::splat(0.5), 1e-6));
        assert!((texture.sample_opacity(Vec2::new(0.5, 0.75)) - 0.5).abs() < 1e-6);
    }
}
