//! The scene in the window, with all that can be edited.

use std::sync::Arc;

use glam::DVec3;

use super::{
    loader::OpenedScene,
    solving::{Elements, SolveInput},
};
use crate::{
    files::loaded_scene::LoadedScene,
    math::color::ToneMap,
    scene::{Material, area_light::AreaLightState, inspect::SceneReport},
    solver::{SolveSettings, State},
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

/// A scene, as it was read and as it was edited.
pub struct Document {
    /// As it was read.
    pub loaded: LoadedScene,
    /// Its elements by the state's settings, shown until there is a solution.
    pub elements: Elements,
    /// The scene in numbers.
    pub report: SceneReport,
    /// As it is edited.
    pub edit: Edit,
    /// As it was at first, for the reset buttons.
    pub original: Edit,
}

impl Document {
    /// A scene that was just opened.
    pub fn new(opened: OpenedScene) -> Self {
        let OpenedScene { loaded, elements, report, .. } = opened;
        let edit = Edit {
            light: loaded.state.light,
            settings: loaded.state.settings.clone().unwrap_or_default(),
            materials: Arc::new(loaded.scene.materials.clone()),
            tone_map: loaded.tone_map,
        };
        Self { loaded, elements, report, original: edit.clone(), edit }
    }

    /// Length of the scene's longest side, in metres.
    pub fn size(&self) -> f64 {
        let [low, high] = [self.report.minimum, self.report.maximum].map(DVec3::from_array);
        (high - low).max_element().max(1e-9)
    }

    /// A light to begin with: under the middle of the scene's top, a fifth of its width, shining down.
    pub fn ceiling_light(&self) -> AreaLightState {
        let [low, high] = [self.report.minimum, self.report.maximum].map(DVec3::from_array);
        let half = 0.1 * (high - low);
        let middle = 0.5 * (low + high);
        AreaLightState {
            centre: [middle.x, high.y - 0.02 * (high.y - low.y), middle.z],
            u: [half.x.max(1e-3 * self.size()), 0.0, 0.0],
            v: [0.0, 0.0, half.z.max(1e-3 * self.size())],
            radiance: [20.0; 3],
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
