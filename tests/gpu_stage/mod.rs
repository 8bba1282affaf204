//! A card without a window, and things to show on it; each test program uses a part.
#![allow(dead_code)]

use std::sync::Arc;

use glam::Vec3;
use image::RgbaImage;
use radiosity::{
    gpu::{Shading, ViewFrame, ViewGeometry, Viewer, device},
    math::color::{ToneCurve, ToneMap},
    render::{RenderSettings, Subject, View, render},
    scene::{AreaLight, Camera, LoadOptions, Scene, Tessellation, builtin, tessellate::TessellationOptions},
    solver::State,
    trace::Tracer,
};

/// A card and the views on it.
pub(crate) struct Stage {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) viewer: Viewer,
}

impl Stage {
    pub(crate) fn new() -> Option<Self> {
        match device::headless() {
            Ok((device, queue)) => {
                let viewer = Viewer::new(&device, wgpu::TextureFormat::Rgba8Unorm);
                Some(Self { device, queue, viewer })
            }
            Err(reason) => {
                println!("skipped: {reason}");
                None
            }
        }
    }

    /// True if the view was drawn again.
    pub(crate) fn draw(&mut self, frame: &ViewFrame) -> bool {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let drawn = self.viewer.draw(&self.device, &self.queue, &mut encoder, frame);
        self.queue.submit([encoder.finish()]);
        drawn
    }

    pub(crate) fn picture(&mut self, frame: &ViewFrame) -> RgbaImage {
        self.draw(frame);
        device::read_picture(&self.device, &self.queue, self.viewer.picture(frame.view).unwrap()).unwrap()
    }
}

/// A scene cut into elements, with a camera and a field made up from positions and normals.
pub(crate) struct Subjects {
    pub(crate) scene: Arc<Scene>,
    pub(crate) tessellation: Tessellation,
    pub(crate) geometry: Arc<ViewGeometry>,
    pub(crate) field: Arc<Vec<Vec3>>,
    pub(crate) camera: Camera,
    pub(crate) light: Option<AreaLight>,
}

impl Subjects {
    pub(crate) fn new(scene: Scene, subdivide: u32, camera: Camera, field: impl Fn(Vec3, Vec3) -> Vec3) -> Self {
        let scene = Arc::new(scene);
        let tessellation = Tessellation::new(&scene, &TessellationOptions { subdivide, max_edge: None }).unwrap();
        let geometry = Arc::new(ViewGeometry::new(&scene, &tessellation).unwrap());
        let mesh = &tessellation.mesh;
        let field = mesh.positions.iter().zip(&mesh.normals).map(|(position, normal)| field(*position, *normal));
        Self { field: Arc::new(field.collect()), scene, tessellation, geometry, camera, light: None }
    }

    pub(crate) fn cornell(subdivide: u32) -> Self {
        let scene = builtin::cornell(&LoadOptions::default()).unwrap();
        let (state, _) = State::from_toml(builtin::CORNELL_STATE).unwrap();
        let camera = state.camera.unwrap().to_local(&scene.frame);
        let light = state.light.unwrap().to_local(&scene.frame);
        Self { light: Some(light), ..Self::new(scene, subdivide, camera, varied) }
    }

    pub(crate) fn frame(&self, size: [u32; 2], shading: Shading) -> ViewFrame {
        ViewFrame {
            view: 1,
            geometry: Arc::clone(&self.geometry),
            materials: Arc::new(self.scene.materials.clone()),
            field: Arc::clone(&self.field),
            field_version: 1,
            map: None,
            buried: None,
            camera: self.camera,
            size,
            shading,
            tone_map: PLAIN,
            wireframe: false,
            ambient: Vec3::ZERO,
            light: self.light,
            light_outline: None,
            antialias: false,
            saves_time: false,
            gradual: false,
        }
    }

    /// The same picture by the CPU, one ray through the middle of each pixel.
    pub(crate) fn rendered(&self, frame: &ViewFrame, view: View) -> RgbaImage {
        let tracer = Tracer::new(Arc::clone(&self.scene));
        let light = frame.light;
        let (scene, tessellation, field) = (&*self.scene, &self.tessellation, &**self.field);
        let subject = Subject { scene, tracer: &tracer, tessellation, charts: None, field, direct: None, light };
        let [width, height] = frame.size;
        let samples = if frame.antialias { 16 } else { 1 };
        let settings = RenderSettings { width, height, view, samples, tone_map: frame.tone_map };
        render(&subject, &frame.camera, &settings)
    }
}

/// Exposure alone.
pub(crate) const PLAIN: ToneMap = ToneMap { exposure: 0.0, white: 1.0, gamma: 1.0, curve: ToneCurve::Plain };

/// A smooth field of different colours everywhere, between 0 and 6 W/m².
pub(crate) fn varied(position: Vec3, normal: Vec3) -> Vec3 {
    let waves = (3.0 * position + normal).map(f32::sin);
    1.5 * (waves + 1.0) + Vec3::splat(1.5 * (1.0 + normal.y))
}
