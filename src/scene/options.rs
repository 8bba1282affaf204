//! How a scene is read: one struct for the flags, the state file and the window.

use clap::Args;
use serde::{Deserialize, Serialize};

use super::texture::TextureFilter;

/// Choices made while a scene is read.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(default)]
pub struct LoadOptions {
    /// Swap the front and back of every triangle, and its normals with it.
    #[arg(long)]
    pub flip: bool,
    /// Throw the file's normals away and compute new ones: smooth across edges that bend by less than this angle
    /// (in degrees), creased elsewhere. 0 gives flat shading.
    #[arg(long, value_name = "DEGREES")]
    pub crease_angle: Option<f32>,
    /// Join positions nearer than this fraction of the scene's size.
    #[arg(long, value_name = "FRACTION")]
    pub weld: Option<f32>,
    /// Take flat neighbours of one material, whose texture goes straight on, as one surface, so that a finely cut wall
    /// costs no more than a whole one; `false` keeps all faces as they come. Without it, flat neighbours are merged where
    /// elements follow the light.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true")]
    pub merge_flat: Option<bool>,
    /// Leave faces that lie on one another, touch or cross as they come. Otherwise one stays in each place, what is
    /// enclosed in solids is left out, and faces are cut where others stand on them, so that no light leaks across.
    #[arg(long)]
    pub faces_as_read: bool,
    /// Scale the scene so that its largest side is 1 m.
    #[arg(long)]
    pub unit_size: bool,
    /// Give every surface two sides, each lit on its own.
    #[arg(long)]
    pub two_sided: bool,
    /// Take triangles as flat although their normals tell of a curved surface: at the edge of a shadow on a rounded body
    /// whole triangles then go dark. Otherwise light reaches as far round as the normals say.
    #[arg(long)]
    pub faceted: bool,
    /// The highest reflectance that a material keeps, in any band; up to 0.999. Higher ones are clamped, and counted.
    #[arg(long, value_name = "REFLECTANCE", default_value_t = LoadOptions::default().reflectance_limit)]
    pub reflectance_limit: f32,
    /// Treat every surface as opaque: `d` and `map_d` are ignored. Otherwise light passes where opacity is below one half.
    #[arg(long)]
    pub opaque: bool,
    /// How textures are read between their texel centres.
    #[arg(long, value_enum, default_value_t = LoadOptions::default().texture_filter)]
    pub texture_filter: TextureFilter,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            flip: false,
            crease_angle: None,
            weld: None,
            merge_flat: None,
            faces_as_read: false,
            unit_size: false,
            two_sided: false,
            faceted: false,
            reflectance_limit: 0.95,
            opaque: false,
            texture_filter: TextureFilter::Nearest,
        }
    }
}

impl LoadOptions {
    /// The options for a solve, if they do not say themselves whether flat neighbours are merged: `by_default`.
    #[must_use]
    pub fn merging_flat(self, by_default: bool) -> Self {
        Self { merge_flat: Some(self.merge_flat.unwrap_or(by_default)), ..self }
    }

    /// What is wrong with the options, if anything: a value out of its range.
    pub fn problem(&self) -> Option<String> {
        let outside = |value: f32, low: f32, high: f32| !(low..=high).contains(&value);
        if let Some(angle) = self.crease_angle.filter(|angle| outside(*angle, 0.0, 180.0)) {
            return Some(format!("the crease angle {angle} is not between 0 and 180 degrees"));
        }
        if let Some(fraction) = self.weld.filter(|fraction| outside(*fraction, 0.0, 0.5)) {
            return Some(format!("the weld distance {fraction} is not between 0 and 0.5 of the scene's size"));
        }
        if outside(self.reflectance_limit, 0.0, 1.0) {
            return Some(format!("the reflectance limit {} is not between 0 and 1", self.reflectance_limit));
        }
        None
    }
}
