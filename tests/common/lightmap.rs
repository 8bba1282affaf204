//! What tests of the lightmap share.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use glam::Vec3;
use radiosity::{
    check::closed_form::polygon_irradiance,
    gpu::{device, lightmap::GpuSolver},
    lightmap::{Atlas, GpuSettings, LightmapSettings, Texel},
    scene::{AreaLight, LoadOptions, Scene, load},
    trace::{Ray, RayTracer as _, Tracer},
};

pub(crate) fn card() -> (wgpu::Device, wgpu::Queue) {
    device::headless().unwrap()
}

pub(crate) fn solver(scene: &Arc<Scene>, atlas: &Atlas, light: Option<AreaLight>, settings: &GpuSettings) -> GpuSolver {
    let (device, queue) = card();
    GpuSolver::new((&device, &queue), scene, atlas, light.as_ref(), settings).unwrap()
}

/// Steps until the stop rule holds.
pub(crate) fn solved(mut solver: GpuSolver) -> GpuSolver {
    while !solver.is_done() {
        solver.step().unwrap();
    }
    solver
}

pub(crate) fn atlas_of(scene: &Arc<Scene>, settings: &LightmapSettings) -> Atlas {
    Atlas::new(scene, &Tracer::new(Arc::clone(scene)), settings, &|_, _| true).unwrap().unwrap()
}

pub(crate) fn from_obj(obj: &str, mtl: &str) -> Arc<Scene> {
    Arc::new(load::load_from_memory("test", obj, mtl, &LoadOptions::default()).unwrap())
}

pub(crate) fn texels(count: u32) -> LightmapSettings {
    LightmapSettings { texels: count, ..LightmapSettings::default() }
}

/// Mean over all texels by open area.
pub(crate) fn mean(atlas: &Atlas, field: &[Vec3]) -> Vec3 {
    let area: f32 = atlas.texels.iter().map(|texel| texel.open_area()).sum();
    atlas.texels.iter().zip(field).map(|(texel, value)| texel.open_area() * *value).sum::<Vec3>() / area
}

/// How direct light on texels compares with one ray from each to the light's centre.
pub(crate) struct AgainstRays {
    /// Of the light that rays say arrives, the part that was placed elsewhere.
    pub(crate) misplaced: f32,
    /// Texels that rays say lie in shadow.
    pub(crate) shaded: usize,
}

/// Compares direct light on the texels that are `chosen` with rays.
pub(crate) fn against_rays(
    scene: &Arc<Scene>,
    atlas: &Atlas,
    light: &AreaLight,
    direct: &[Vec3],
    chosen: impl Fn(&Texel) -> bool,
) -> AgainstRays {
    let tracer = Tracer::new(Arc::clone(scene));
    let (mut arrives, mut wrong, mut shaded) = (0.0, 0.0, 0);
    for (texel, value) in atlas.texels.iter().zip(direct).filter(|(texel, _)| chosen(texel)) {
        let way = light.centre - texel.position;
        let ray = Ray {
            origin: texel.position,
            direction: way.normalize(),
            max_distance: way.length(),
            origin_triangle: texel.triangle,
        };
        let whole = polygon_irradiance(texel.position, texel.shading_normal, &light.corners(), light.radiance).x;
        let is_occluded = tracer.occluded(&ray);
        shaded += usize::from(is_occluded);
        let expected = if is_occluded { 0.0 } else { whole };
        arrives += texel.open_area() * expected;
        wrong += texel.open_area() * (value.x - expected).abs();
    }
    assert!(arrives > 0.0, "no texel is lit");
    AgainstRays { misplaced: wrong / arrives, shaded }
}
