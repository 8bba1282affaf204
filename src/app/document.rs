//! The scene in the window, with all that can be edited.

use std::sync::Arc;

use glam::DVec3;

use super::{elements::Elements, loader::OpenedScene, solving::SolveInput};
use crate::{
    files::loaded_scene::LoadedScene,
    math::color::ToneMap,
    scene::{Material, area_light::AreaLightState, inspect::SceneReport},
    solver::{SolveSettings, State},
    transport::facing::Facing,
};

/// What undo takes back.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// The placed area light.
    pub light: Option<AreaLightState>,
    /// How to solve.
    pub settings: SolveSettings,
    /// The materials; a new `Arc` with each change.
    pub materials: Arc<Vec<Material>>,
    /// From radiance to colour.
    pub tone_map: ToneMap,
}

impl Edit {
    /// What ENTER would solve.
    pub fn solve_input(&self) -> SolveInput {
        SolveInput { light: self.light, settings: self.settings.clone(), materials: Arc::clone(&self.materials) }
    }
}

/// A light to begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPreset {
    /// Under the middle of the top.
    Ceiling,
    /// Small and bright, under the middle of the top.
    Spot,
    /// As wide as the top.
    Sky,
    /// Large, at one side.
    Window,
}

impl LightPreset {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Ceiling, Self::Spot, Self::Sky, Self::Window];

    /// Its name in the panel.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ceiling => "ceiling",
            Self::Spot => "spot",
            Self::Sky => "sky",
            Self::Window => "window",
        }
    }

    /// What it is, for the tooltip.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Ceiling => "A fifth of the scene's width, under the middle of its top, shining down: soft shadows",
            Self::Spot => "A fiftieth of the scene's width, under the middle of its top: hard shadows",
            Self::Sky => "As wide as the scene, at its top, bluish: hardly any shadows",
            Self::Window => "Upright at the scene's left side, shining to the right: long shadows",
        }
    }
}

/// A scene, as it was read and as it was edited.
pub struct Document {
    /// As it was read.
    pub loaded: LoadedScene,
    /// Its elements by the state's settings, shown until there is a solution.
    pub elements: Elements,
    /// The scene in numbers.
    pub report: SceneReport,
    /// What is to be said of the sides that light meets.
    pub facing: Option<Facing>,
    /// As it is edited.
    pub edit: Edit,
    /// As it was at first, for the reset buttons.
    pub original: Edit,
}

impl Document {
    /// A scene that was just opened.
    pub fn new(opened: OpenedScene) -> Self {
        let OpenedScene { loaded, elements, report, facing, .. } = opened;
        let edit = Edit {
            light: loaded.state.light,
            settings: loaded.state.settings.clone().unwrap_or_default(),
            materials: Arc::new(loaded.scene.materials.clone()),
            tone_map: loaded.tone_map,
        };
        Self { loaded, elements, report, facing, original: edit.clone(), edit }
    }

    /// Length of the scene's longest side, in metres.
    pub fn size(&self) -> f64 {
        let [low, high] = [self.report.minimum, self.report.maximum].map(DVec3::from_array);
        (high - low).max_element().max(1e-9)
    }

    /// A light to begin with, inside the scene's bounds.
    pub fn preset_light(&self, preset: LightPreset) -> AreaLightState {
        let [low, high] = [self.report.minimum, self.report.maximum].map(DVec3::from_array);
        let middle = 0.5 * (low + high);
        let half = (0.5 * (high - low)).max(DVec3::splat(5e-3 * self.size()));
        let below_top = |part: f64, radiance: [f32; 3]| AreaLightState {
            centre: [middle.x, high.y - 0.02 * (high.y - low.y), middle.z],
            u: [part * half.x, 0.0, 0.0],
            v: [0.0, 0.0, part * half.z],
            radiance,
        };
        match preset {
            LightPreset::Ceiling => below_top(0.2, [20.0; 3]),
            LightPreset::Spot => below_top(0.02, [2000.0; 3]),
            LightPreset::Sky => below_top(0.98, [0.8, 1.0, 1.3]),
            LightPreset::Window => AreaLightState {
                centre: [low.x + 0.02 * (high.x - low.x), middle.y + 0.2 * half.y, middle.z],
                u: [0.0, 0.4 * half.y, 0.0],
                v: [0.0, 0.0, 0.5 * half.z],
                radiance: [10.0; 3],
            },
        }
    }

    /// True if anything shines: a light or a material.
    pub fn shines(&self) -> bool {
        self.edit.light.is_some()
            || self.edit.materials.iter().any(|material| material.emitted_radiance.max_element() > 0.0)
    }

    /// Takes over what a state says.
    pub fn apply(&mut self, state: &State) {
        self.edit.light = state.light.or(self.edit.light);
        if let Some(settings) = &state.settings {
            self.edit.settings.clone_from(settings);
        }
        self.edit.tone_map = state.tone_map.unwrap_or(self.edit.tone_map);
    }
}
