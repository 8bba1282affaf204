//! The energy ledger: where the emitted power went, bounce by bounce; or of other iterations, what each sweep changed.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::settings::Iteration;
use crate::scene::{Scene, Tessellation, reflectance::triangle_mean_reflectance};

/// Power, in watts of one bounce, per band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BouncePower {
    /// Arriving on front sides.
    pub arriving: DVec3,
    /// Of that, absorbed.
    pub absorbed: DVec3,
    /// Of that, reflected: what the next bounce has to spend.
    pub reflected: DVec3,
    /// What left the lights or the bounce before and arrived on no front side: through openings, into back faces.
    pub escaped: DVec3,
}

/// Emitted power and the power of each bounce.
///
/// Other iterations than Neumann's enter what each sweep changed. Their last sweep is a plain bounce of all light, so
/// that the sums over all sweeps are exact: what left the surfaces is the light before it, what arrived that after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Power of all lights, in watts.
    pub emitted: DVec3,
    /// Bounce 0 (direct) and on.
    pub bounces: Vec<BouncePower>,
    /// What the bounces are: bounces, or sweeps.
    #[serde(default)]
    pub iteration: Iteration,
}

/// Area [m²] of each vertex's share of the surface, and that times its mean reflectance.
pub(super) struct VertexWeights {
    area: Vec<f64>,
    reflecting_area: Vec<DVec3>,
}

impl VertexWeights {
    /// Area [m²] of each vertex's share times its mean reflectance.
    #[cfg(feature = "reference")]
    pub(super) fn reflecting_area(&self) -> &[DVec3] {
        &self.reflecting_area
    }

    pub(super) fn new(scene: &Scene, tessellation: &Tessellation) -> Self {
        let mesh = &tessellation.mesh;
        let square_metres = scene.frame.square_metres_per_unit();
        let reflectance: Vec<Vec3> =
            (0..scene.mesh.triangles.len() as u32).map(|triangle| triangle_mean_reflectance(scene, triangle)).collect();
        let area = tessellation.vertex_areas().into_iter().map(|area| f64::from(area) * square_metres).collect();
        let mut weights = Self { area, reflecting_area: vec![DVec3::ZERO; mesh.positions.len()] };
        for element in 0..mesh.triangles.len() {
            let share = f64::from(mesh.area(element as u32)) * square_metres / 3.0;
            let reflectance = reflectance[tessellation.scene_triangle[element] as usize].as_dvec3();
            for vertex in mesh.triangles[element].map(|vertex| vertex as usize) {
                weights.reflecting_area[vertex] += share * reflectance;
            }
        }
        weights
    }
}

impl Ledger {
    pub(super) fn new(emitted: DVec3, iteration: Iteration) -> Self {
        Self { emitted, bounces: Vec::new(), iteration }
    }

    /// Enters the next bounce. The sums run in vertex order, in f64, so they are the same on any number of threads.
    pub(super) fn enter(&mut self, irradiance: &[Vec3], weights: &VertexWeights) {
        let (mut arriving, mut reflected) = (DVec3::ZERO, DVec3::ZERO);
        for (vertex, value) in irradiance.iter().enumerate() {
            arriving += value.as_dvec3() * weights.area[vertex];
            reflected += value.as_dvec3() * weights.reflecting_area[vertex];
        }
        let source = self.bounces.last().map_or(self.emitted, |bounce| bounce.reflected);
        self.bounces.push(BouncePower {
            arriving,
            absorbed: arriving - reflected,
            reflected,
            escaped: source - arriving,
        });
    }

    /// The fraction of the emitted power that is still to be absorbed: the last bounce's reflected power with the
    /// geometric tail 1/(1-q) of all bounces after it, q being the ratio of the last two bounces (of direct light: to
    /// the emitted power); of sweeps, the reflected part of all light that leaves surfaces. At most 1.
    pub fn unabsorbed(&self) -> f64 {
        let power = |bounce: &BouncePower| bounce.reflected.element_sum().abs();
        let emitted = self.emitted.element_sum();
        let Some(last) = self.bounces.last().map(power) else {
            return 1.0;
        };
        if emitted <= 0.0 || last <= 0.0 {
            return 0.0;
        }
        if self.iteration != Iteration::Neumann {
            let reflected: f64 = self.bounces.iter().map(|bounce| bounce.reflected.element_sum()).sum();
            return (last / emitted * (1.0 + reflected.max(0.0) / emitted)).min(1.0);
        }
        let before = self.bounces.len().checked_sub(2).map_or(emitted, |index| power(&self.bounces[index]));
        let ratio = (last / before).clamp(0.0, 0.999);
        (last / emitted / (1.0 - ratio)).min(1.0)
    }
}
