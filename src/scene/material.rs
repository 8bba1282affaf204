//! Diffuse materials.

use glam::Vec3;

/// A Lambertian material. Specular terms of the file are ignored (said once at load).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the MTL.
    pub name: String,
    /// Reflectance ρ in [0, 1) per band (`Kd`, linear).
    pub reflectance: Vec3,
    /// Texture that multiplies the reflectance (`map_Kd`).
    pub reflectance_texture: Option<u32>,
    /// Emitted radiance (`Ke`) [W/(m² sr)], from the front side.
    pub emitted_radiance: Vec3,
    /// Opacity (`d`, or 1 - `Tr`); below 1/2 rays pass.
    pub opacity: f32,
    /// Texture that multiplies the opacity (`map_d`, or the alpha of `map_Kd`).
    pub opacity_texture: Option<u32>,
}

impl Default for Material {
    /// What a face without a usable material gets: grey, no emission, opaque.
    fn default() -> Self {
        Self {
            name: String::from("default"),
            reflectance: Vec3::splat(0.6),
            reflectance_texture: None,
            emitted_radiance: Vec3::ZERO,
            opacity: 1.0,
            opacity_texture: None,
        }
    }
}
