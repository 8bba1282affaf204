//! What tests of the lightmap share.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use glam::Vec3;
use radiosity::{
    gpu::{device, lightmap::GpuSolver},
    lightmap::{Atlas, GpuSettings, LightmapSettings},
    scene::{AreaLight, LoadOptions, Scene, load},
    trace::Tracer,
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
