//! What shines: the placed area light, and the emissive triangles, chosen by power.

use clap::ValueEnum;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::lamps::{Lamp, lamps_of};
use crate::{
    math::color::luminance,
    scene::{AreaLight, Scene},
};

/// How direct light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DirectMethod {
    /// By Lambert's formula (eq. 6) over the part of the light that is seen; samples where too much lies between.
    Analytic,
    /// By Lambert's formula for the whole light, times the part of it that samples see (Heitz, Hill and McGuire 2018).
    Ratio,
    /// By samples on the lights (eq. 3).
    Sampled,
}

/// All sources of direct light.
#[derive(Clone, Debug)]
pub struct Lights {
    /// The placed light, if it has an area and a radiance.
    pub area_light: Option<AreaLight>,
    /// The same as a lamp.
    pub(super) area_lamp: Option<Lamp>,
    /// Emissive triangles.
    pub emitters: Emitters,
}

/// More lamps than this are left to samples, and so are more triangles of lamps.
const MOST_LAMPS: usize = 512;
const MOST_LAMP_TRIANGLES: usize = 1 << 16;

/// The emissive triangles with the distribution that chooses one by its power.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    triangles: Vec<u32>,
    /// Running sums of the probabilities; the last is 1.
    cumulative: Vec<f32>,
    /// Sum over the triangles of luminance times area.
    total: f64,
    /// The lamps that the triangles are.
    lamps: Option<Vec<Lamp>>,
}

impl Lights {
    /// The lights of a scene; a light without area or radiance is left out.
    pub fn new(scene: &Scene, area_light: Option<AreaLight>) -> Self {
        let shines = |light: &AreaLight| light.area() > 0.0 && light.radiance.max_element() > 0.0;
        let area_light = area_light.filter(shines);
        let area_lamp = area_light.as_ref().map(Lamp::of_area_light);
        Self { area_light, area_lamp, emitters: Emitters::new(scene) }
    }

    /// The area light alone.
    pub fn without_emitters(&self) -> Self {
        Self { area_light: self.area_light, area_lamp: self.area_lamp.clone(), emitters: Emitters::default() }
    }

    /// True if nothing shines, so that every solution is black.
    pub fn is_empty(&self) -> bool {
        self.area_light.is_none() && self.emitters.is_empty()
    }

    /// Power Φ = π L A that all lights emit [W per local unit²·m⁻²], summed over each band.
    pub fn emitted_power(&self, scene: &Scene) -> Vec3 {
        let placed = self.area_light.map_or(Vec3::ZERO, |light| light.radiance * light.area());
        let emissive = self
            .emitters
            .triangles
            .iter()
            .map(|&triangle| scene.material(triangle).emitted_radiance * scene.mesh.area(triangle));
        std::f32::consts::PI * (placed + emissive.sum::<Vec3>())
    }
}

impl Emitters {
    fn new(scene: &Scene) -> Self {
        let power = |triangle: u32| {
            f64::from(luminance(scene.material(triangle).emitted_radiance)) * f64::from(scene.mesh.area(triangle))
        };
        let triangles: Vec<u32> = scene.emissive_triangles().filter(|&triangle| power(triangle) > 0.0).collect();
        let total: f64 = triangles.iter().map(|&triangle| power(triangle)).sum();
        let mut sum = 0.0;
        let cumulative = triangles
            .iter()
            .map(|&triangle| {
                sum += power(triangle);
                (sum / total) as f32
            })
            .collect();
        let is_whole = triangles.iter().all(|&triangle| !scene.may_be_cut_out(triangle));
        let lamps = (is_whole && triangles.len() <= MOST_LAMP_TRIANGLES)
            .then(|| lamps_of(scene, &triangles, MOST_LAMPS))
            .flatten();
        Self { triangles, cumulative, total, lamps }
    }

    /// The density [1/local unit²] with which [`Emitters::choose`] and a uniform point on the chosen triangle meet a
    /// point that emits `radiance`: the area of the triangle cancels.
    pub fn pdf_area(&self, radiance: Vec3) -> f32 {
        (f64::from(luminance(radiance)) / self.total) as f32
    }

    /// The lamps that the emissive triangles are, if they are so few, and whole, that direct light of each can be found
    /// by itself.
    pub fn lamps(&self) -> Option<&[Lamp]> {
        self.lamps.as_deref()
    }

    /// True if no triangle emits.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Chooses a triangle by `choice` in [0, 1): its number, and `choice` stretched back to [0, 1) so that it can be
    /// used again. `None` if no triangle emits.
    pub fn choose(&self, choice: f32) -> Option<(u32, f32)> {
        let last = self.triangles.len().checked_sub(1)?;
        let index = self.cumulative.partition_point(|&sum| sum <= choice).min(last);
        let before = if index == 0 { 0.0 } else { self.cumulative[index - 1] };
        let pmf = self.cumulative[index] - before;
        if pmf <= 0.0 {
            return None;
        }
        Some((self.triangles[index], ((choice - before) / pmf).clamp(0.0, 1.0 - f32::EPSILON)))
    }
}

/// Splits light from emissive triangles between its two finders, gather rays and samples on the triangles, so that
/// each does what it is good at (balance heuristic, Veach and Guibas 1995, eq. 14): no spike beside an emitter, no
/// noise from a small one.
#[derive(Clone, Copy, Debug)]
pub struct FinderCounts {
    /// Gather rays a vertex.
    pub gather: u32,
    /// Samples on the triangles a vertex.
    pub light: u32,
}

impl FinderCounts {
    /// The gather rays' share of the light found along one direction; the rest is the samples'. The densities are per
    /// solid angle.
    pub fn gather_share(&self, gather_pdf_solid_angle: f32, light_pdf_solid_angle: f32) -> f32 {
        let gather = self.gather as f32 * gather_pdf_solid_angle;
        let light = self.light as f32 * light_pdf_solid_angle;
        if self.light == 0 || light_pdf_solid_angle <= 0.0 {
            1.0
        } else if light_pdf_solid_angle.is_infinite() {
            0.0
        } else {
            gather / (gather + light)
        }
    }
}

/// A density over area as one over solid angle, seen from `distance` away: pdf_area r² / cosθ_l.
pub fn area_to_solid_angle(pdf_area: f32, distance: f32, cosine_light: f32) -> f32 {
    pdf_area * distance * distance / cosine_light
}
