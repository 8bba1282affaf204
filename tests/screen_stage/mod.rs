//! Pictures in screen space without a window; each test program uses a part.
#![allow(dead_code)]

use std::sync::Arc;

use glam::Vec3;
use radiosity::{
    gpu::{
        ViewGeometry, device,
        mesh_buffers::MeshBuffers,
        screen_space::{ScreenFields, ScreenRenderer, ScreenSettings, ScreenView},
    },
    scene::{
        AreaLight, Camera, LoadOptions, Scene, Tessellation, builtin, camera::CameraState, load,
        tessellate::TessellationOptions,
    },
    solver::State,
};

/// A scene with a camera, and what draws it.
pub(crate) struct ScreenStage {
    pub(crate) scene: Arc<Scene>,
    pub(crate) view: ScreenView,
    pub(crate) renderer: ScreenRenderer,
}

impl ScreenStage {
    /// None, with the reason printed, without a graphics driver.
    pub(crate) fn new(scene: Scene, camera: Camera, light: Option<AreaLight>, size: [u32; 2]) -> Option<Self> {
        let (device, queue) = match device::headless() {
            Ok(opened) => opened,
            Err(reason) => {
                println!("skipped: {reason}");
                return None;
            }
        };
        let scene = Arc::new(scene);
        let options = TessellationOptions { subdivide: 1, max_edge: None };
        let tessellation = Tessellation::new(&scene, &options).unwrap();
        let geometry = Arc::new(ViewGeometry::new(&scene, &tessellation).unwrap());
        let mesh = MeshBuffers::upload(&device, &queue, &geometry);
        let renderer = ScreenRenderer::new((&device, &queue), &geometry, mesh);
        let view = ScreenView { camera, size, light, materials: Arc::new(scene.materials.clone()) };
        Some(Self { scene, view, renderer })
    }

    pub(crate) fn cornell(size: [u32; 2]) -> Option<Self> {
        let scene = builtin::cornell(&LoadOptions::default()).unwrap();
        let (state, _) = State::from_toml(builtin::CORNELL_STATE).unwrap();
        let camera = state.camera.unwrap().to_local(&scene.frame);
        let light = state.light.unwrap().to_local(&scene.frame);
        Self::new(scene, camera, Some(light), size)
    }

    /// A scene from the text of an OBJ file, its camera in metres.
    pub(crate) fn of_text(obj: &str, mtl: &str, camera: &CameraState, size: [u32; 2]) -> Option<Self> {
        let scene = load::load_from_memory("test", obj, mtl, &LoadOptions::default()).unwrap();
        let camera = camera.to_local(&scene.frame);
        Self::new(scene, camera, None, size)
    }

    pub(crate) fn drawn(&mut self, settings: &ScreenSettings) -> ScreenFields {
        assert_eq!(settings.problem(), None);
        self.renderer.draw(&self.view, settings).unwrap();
        self.renderer.fields().unwrap()
    }

    /// A mean of so many frames.
    pub(crate) fn drawn_still(&mut self, settings: &ScreenSettings, frames: u32) -> ScreenFields {
        (1..frames).for_each(|_| self.renderer.draw(&self.view, settings).unwrap());
        self.drawn(settings)
    }
}

/// The light of what is shown and no more, unfiltered.
pub(crate) fn plain() -> ScreenSettings {
    ScreenSettings { filter: 0, every: 1, unseen: 0.0, ..ScreenSettings::default() }
}

/// Relative L2 difference, as in `check::metrics`.
pub(crate) fn relative_l2(estimate: &[Vec3], truth: &[Vec3]) -> f64 {
    let double = |values: &[Vec3]| values.iter().map(|value| value.as_dvec3()).collect::<Vec<_>>();
    radiosity::check::metrics::relative_l2(&double(estimate), &double(truth))
}
