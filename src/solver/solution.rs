//! A solution: irradiance at the vertices, bounce by bounce.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::settings::SolveSettings;
use crate::scene::{LoadOptions, area_light::AreaLightState};

/// What a solution was computed from. Saved with it, and compared before it is used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolutionInfo {
    /// Name of the scene.
    pub scene_name: String,
    /// [`crate::scene::Scene::hash`] of the scene.
    pub scene_hash: String,
    /// Hash of the tessellation's positions and triangles.
    pub tessellation_hash: String,
    /// How the scene was read.
    pub load: LoadOptions,
    /// The settings.
    pub settings: SolveSettings,
    /// The placed area light, if there was one.
    pub light: Option<AreaLightState>,
    /// The program's version.
    pub program_version: String,
    /// False if the solve was cancelled: the last bounce may then be missing at some vertices.
    pub complete: bool,
}

/// Irradiance at the vertices of a tessellation.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// What it was computed from.
    pub info: SolutionInfo,
    /// Irradiance [W/m²] of each bounce alone at each vertex; bounce 0 is direct light. At least one bounce.
    pub bounces: Vec<Vec<Vec3>>,
    /// Vertices whose hemisphere mostly sees back faces.
    pub buried: Vec<bool>,
    /// How elements that follow the light were cut ([`crate::scene::Tessellation::with_cuts`]); else empty.
    pub cuts: Vec<u32>,
}

impl Solution {
    /// The sum of all bounces at each vertex [W/m²].
    pub fn total(&self) -> Vec<Vec3> {
        self.sum_of(0)
    }

    /// The sum of the indirect bounces at each vertex [W/m²].
    pub fn indirect(&self) -> Vec<Vec3> {
        self.sum_of(1)
    }

    /// Bounce 0 at each vertex [W/m²].
    pub fn direct(&self) -> &[Vec3] {
        &self.bounces[0]
    }

    fn sum_of(&self, first: usize) -> Vec<Vec3> {
        let mut sum = vec![Vec3::ZERO; self.buried.len()];
        for bounce in self.bounces.iter().skip(first) {
            for (total, value) in sum.iter_mut().zip(bounce) {
                *total += *value;
            }
        }
        sum
    }
}
