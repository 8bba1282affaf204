//! What the pipelines over elements and pixels are made for, and how their shaders make colours.

use glam::Vec3;

use super::frame::{Shading, ViewFrame};
use crate::{
    math::color::ToneCurve,
    scene::{Material, Scene, texture::TextureFilter},
};

/// From radiance or the field's value to colour: a part of several shaders.
pub const SHADING_WGSL: &str = include_str!("shading.wgsl");

/// What a pipeline is made for. The shader has no branches but these, because a software driver runs both sides of a
/// branch that is decided while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Variant {
    pub(super) samples: u32,
    tone: ToneVariant,
    ambient: bool,
    buried: bool,
    pub(super) map: Option<MapVariant>,
    /// A layer of a G-buffer, and not a picture: `LAYER` of `g_buffer.wgsl`.
    pub(super) layer: Option<u32>,
    reflectance_filter: u32,
    opacity_filter: u32,
}

/// How a pipeline makes colours: the constants of `shading.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ToneVariant {
    shading: u32,
    filmic: bool,
    gamma: bool,
    logarithmic: bool,
}

impl ToneVariant {
    fn new(frame: &ViewFrame) -> Self {
        let (shading, logarithmic) = match frame.shading {
            Shading::Radiosity => (0, false),
            Shading::Irradiance => (1, false),
            Shading::Albedo => (2, false),
            Shading::Normals => (3, false),
            Shading::FalseColor(range) => (4, range.logarithmic),
            Shading::Plain => (5, false),
        };
        let tone_mapped = shading < 2;
        Self {
            shading,
            filmic: tone_mapped && frame.tone_map.curve == ToneCurve::Filmic,
            gamma: tone_mapped && frame.tone_map.gamma != 1.0,
            logarithmic,
        }
    }

    /// The shader's constants.
    pub(super) fn constants(self) -> Vec<(&'static str, f64)> {
        let flag = |set| f64::from(u8::from(set));
        vec![
            ("SHADING", f64::from(self.shading)),
            ("FILMIC", flag(self.filmic)),
            ("GAMMA", flag(self.gamma)),
            ("LOGARITHMIC", flag(self.logarithmic)),
        ]
    }
}

/// What a pipeline for a lightmap is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct MapVariant {
    difference: bool,
    nearest: bool,
    on_screen: bool,
}

impl Variant {
    /// For a frame, and a material without textures.
    pub(super) fn new(frame: &ViewFrame) -> Self {
        let tone = ToneVariant::new(frame);
        Self {
            samples: frame.samples(),
            tone,
            ambient: tone.shading < 2 && frame.ambient != Vec3::ZERO,
            buried: frame.buried.is_some(),
            map: frame.map.as_ref().map(|map| MapVariant {
                difference: map.difference,
                nearest: map.nearest,
                on_screen: map.on_screen.is_some(),
            }),
            layer: None,
            reflectance_filter: 0,
            opacity_filter: 0,
        }
    }

    /// For a layer of a G-buffer: reflectance as albedo is shown, and normals as ambient light needs them.
    pub(super) fn of_layer(layer: u32) -> Self {
        Self {
            samples: 1,
            tone: ToneVariant { shading: 2, filmic: false, gamma: false, logarithmic: false },
            ambient: true,
            buried: false,
            map: None,
            layer: Some(layer),
            reflectance_filter: 0,
            opacity_filter: 0,
        }
    }

    /// The same with so many samples a pixel.
    pub(super) fn with_samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    /// How colours are made, if all that changes with the field is what a visibility buffer knows.
    pub(super) fn resolved(self) -> Option<ToneVariant> {
        let shows_field = !matches!(self.tone.shading, 2 | 3);
        (shows_field && self.samples == 1 && !self.buried && self.map.is_none()).then_some(self.tone)
    }

    /// The same for a material of `scene`.
    pub(super) fn with_textures(self, scene: &Scene, material: &Material) -> Self {
        let filter = |index: Option<u32>| match index.and_then(|index| scene.textures.get(index as usize)) {
            None => 0,
            Some(texture) if texture.filter == TextureFilter::Nearest => 1,
            Some(_) => 2,
        };
        let shows_reflectance = matches!(self.tone.shading, 0 | 2);
        Self {
            reflectance_filter: if shows_reflectance { filter(material.reflectance_texture) } else { 0 },
            opacity_filter: filter(material.opacity_texture),
            ..self
        }
    }

    /// The shader's constants.
    pub(super) fn constants(self) -> Vec<(&'static str, f64)> {
        let flag = |set| f64::from(u8::from(set));
        let mut constants = self.tone.constants();
        constants.extend([
            ("AMBIENT", flag(self.ambient)),
            ("BURIED", flag(self.buried)),
            ("REFLECTANCE_FILTER", f64::from(self.reflectance_filter)),
            ("OPACITY_FILTER", f64::from(self.opacity_filter)),
            ("SEVERAL_SAMPLES", flag(self.samples > 1)),
        ]);
        if let Some(map) = self.map {
            constants.extend([("DIFFERENCE", flag(map.difference)), ("NEAREST_TEXEL", flag(map.nearest))]);
            constants.push(("ON_SCREEN", flag(map.on_screen)));
        }
        constants.extend(self.layer.map(|layer| ("LAYER", f64::from(layer))));
        constants
    }
}
