//! The field of a solution between its vertices.

use clap::ValueEnum;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::solution::Solution;
use crate::{
    scene::{Scene, Tessellation, mesh::interpolate},
    trace::{RayTracer, SurfacePoint},
    transport::visible_light::Scratch,
};
#[cfg(feature = "reference")]
use crate::{
    solver::settings::SolveSettings,
    transport::{
        Lights,
        direct::{DirectContext, ShadowRays},
        lights::FinderCounts,
    },
};

/// How the field is rebuilt at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reconstruction {
    /// Direct and indirect light by interpolation between the vertices.
    #[default]
    Vertex,
    /// Direct light computed at the point itself; indirect light by interpolation.
    #[cfg(feature = "reference")]
    PointDirect,
}

/// Irradiance [W/m²] at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointIrradiance {
    /// Of bounce 0.
    pub direct: Vec3,
    /// Of all bounces.
    pub total: Vec3,
}

/// How many times as many samples a point gets as a vertex: no neighbours smooth out what errs there.
#[cfg(feature = "reference")]
const MORE_AT_A_POINT: u32 = 4;

/// Rebuilds the field of a solution at points of the scene.
pub struct Reconstructor<'a> {
    scene: &'a Scene,
    tracer: &'a dyn RayTracer,
    tessellation: &'a Tessellation,
    solution: &'a Solution,
    indirect: Vec<Vec3>,
    #[cfg(feature = "reference")]
    lights: Lights,
    reconstruction: Reconstruction,
}

impl<'a> Reconstructor<'a> {
    /// For a solution with the scene and the elements that it belongs to.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a dyn RayTracer,
        tessellation: &'a Tessellation,
        solution: &'a Solution,
        reconstruction: Reconstruction,
    ) -> Self {
        Self {
            scene,
            tracer,
            tessellation,
            solution,
            indirect: solution.indirect(),
            #[cfg(feature = "reference")]
            lights: Lights::new(scene, solution.info.light.map(|light| light.to_local(&scene.frame))),
            reconstruction,
        }
    }

    /// Irradiance at a point of a scene triangle. Nothing reaches a point that is buried in an element that is so only
    /// in part, whatever its free corners see.
    pub fn irradiance(&self, scene_triangle: u32, barycentric: Vec2, scratch: &mut Scratch) -> PointIrradiance {
        #[cfg(not(feature = "reference"))]
        let _ = scratch;
        let (element, local) = self.tessellation.locate(scene_triangle, barycentric);
        let corners = self.tessellation.mesh.triangles[element as usize].map(|vertex| vertex as usize);
        let point =
            SurfacePoint::new(self.scene, scene_triangle, barycentric).on_curve(self.scene, barycentric, self.tracer);
        if corners.iter().any(|&corner| self.solution.buried[corner]) && point.is_buried(self.tracer) {
            return PointIrradiance::default();
        }
        // Weights that rounding leaves a hair below 0 must not make light negative.
        let at = |field: &[Vec3]| interpolate(corners.map(|corner| field[corner]), local).max(Vec3::ZERO);
        let direct = match self.reconstruction {
            Reconstruction::Vertex => at(self.solution.direct()),
            #[cfg(feature = "reference")]
            Reconstruction::PointDirect => self.direct_at(&point, scratch),
        };
        PointIrradiance { direct, total: direct + at(&self.indirect) }
    }

    /// Irradiance of the lights alone, and all irradiance [W/m²], as [`Reconstructor::irradiance`] has them.
    pub fn direct_and_total(&self, scene_triangle: u32, barycentric: Vec2) -> (Vec3, Vec3) {
        let found = self.irradiance(scene_triangle, barycentric, &mut Scratch::default());
        (found.direct, found.total)
    }

    /// Direct irradiance [W/m²] computed at a point.
    #[cfg(feature = "reference")]
    pub fn direct_at(&self, point: &SurfacePoint, scratch: &mut Scratch) -> Vec3 {
        let settings = &self.solution.info.settings;
        let light_rays = settings.light_rays.saturating_mul(MORE_AT_A_POINT);
        let context = point_context(self.scene, self.tracer, &self.lights, settings);
        let context = DirectContext { light_rays, finders: FinderCounts { gather: 0, light: light_rays }, ..context };
        context.at_point(point, scratch, &mut ShadowRays::default()).irradiance()
    }
}

/// Direct light at points, as a solve with these settings would find it.
#[cfg(feature = "reference")]
pub fn point_context<'a>(
    scene: &'a Scene,
    tracer: &'a dyn RayTracer,
    lights: &'a Lights,
    settings: &SolveSettings,
) -> DirectContext<'a> {
    DirectContext {
        scene,
        tracer,
        lights,
        method: settings.direct,
        sampler: settings.sampler,
        seed: settings.seed,
        light_rays: settings.light_rays,
        finders: FinderCounts { gather: 0, light: settings.light_rays },
        is_cancelled: &|| false,
    }
}
