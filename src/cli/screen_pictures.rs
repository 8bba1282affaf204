//! Pictures of what is drawn in screen space, through the window's own view.

use std::{path::Path, sync::Arc};

use anyhow::anyhow;
use glam::Vec3;

use super::{files, scene_args::LoadedScene};
use crate::{
    check::picture_errors::PictureTruth,
    gpu::{
        FalseColorRange, MapFrame, Shading, ViewFrame, ViewGeometry, Viewer, device,
        mesh_buffers::MeshBuffers,
        screen_space::{ScreenRenderer, ScreenSettings, ScreenView, ShownBuffer, show::page_of},
    },
    math::color::ToneMap,
    scene::{Tessellation, area_light::AreaLightState},
};

/// Draws pages as views.
pub(super) struct Pictures {
    device: wgpu::Device,
    queue: wgpu::Queue,
    viewer: Viewer,
    frame: ViewFrame,
    pub(super) geometry: Arc<ViewGeometry>,
    version: u64,
}

impl Pictures {
    pub(super) fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        loaded: &LoadedScene,
        tessellation: &Tessellation,
        light: Option<AreaLightState>,
        tone_map: ToneMap,
    ) -> anyhow::Result<Self> {
        let scene = &loaded.scene;
        let geometry = Arc::new(ViewGeometry::new(scene, tessellation).map_err(anyhow::Error::msg)?);
        let frame = ViewFrame {
            view: 0,
            geometry: Arc::clone(&geometry),
            materials: Arc::new(scene.materials.clone()),
            field: Arc::default(),
            field_version: 0,
            map: None,
            buried: None,
            camera: loaded.camera.to_local(&scene.frame),
            size: [1; 2],
            shading: Shading::Radiosity,
            tone_map,
            wireframe: false,
            ambient: Vec3::ZERO,
            light: light.map(|light| light.to_local(&scene.frame)),
            light_outline: None,
            antialias: false,
            saves_time: false,
            gradual: false,
        };
        let viewer = Viewer::new(device, wgpu::TextureFormat::Rgba8Unorm);
        Ok(Self { device: device.clone(), queue: queue.clone(), viewer, frame, geometry, version: 0 })
    }

    /// The geometry's buffers.
    pub(super) fn mesh(&mut self) -> Arc<MeshBuffers> {
        self.viewer.mesh(&self.device, &self.queue, &self.geometry)
    }

    /// Writes the picture of the mean of all frames, which was drawn last; and each buffer, the solution and the difference
    /// to it into the folder, if there is one.
    pub(super) fn write(
        &mut self,
        renderer: &mut ScreenRenderer,
        view: &ScreenView,
        (settings, frames): (&ScreenSettings, u32),
        truth: &PictureTruth,
        (output, folder): (&Path, Option<&Path>),
    ) -> anyhow::Result<()> {
        let page = |renderer: &ScreenRenderer| renderer.page().ok_or_else(|| anyhow!("nothing was drawn"));
        self.write_page(page(renderer)?.0, truth.size, Shading::Radiosity, output)?;
        let Some(folder) = folder else { return Ok(()) };
        let fields = renderer.fields().map_err(anyhow::Error::msg)?;
        let known = truth.total();
        let page_of = |values: &[Vec3]| page_of(&self.device, truth.size, values);
        let (solution, difference) = (page_of(&known), page_of(&apart(&fields.total, &known)));
        let mean = known.iter().map(|value| value.element_sum() / 3.0).sum::<f32>() / known.len() as f32;
        let range = FalseColorRange { minimum: 0.0, maximum: mean.max(1e-9), logarithmic: false };
        self.write_page(solution, truth.size, Shading::Radiosity, &folder.join("solution.png"))?;
        self.write_page(difference, truth.size, Shading::FalseColor(range), &folder.join("difference.png"))?;
        for buffer in ShownBuffer::ALL {
            let both = settings.layers() == 2 && buffer.has_layers();
            for layer in 0..1 + u32::from(both) {
                renderer.show(buffer, layer);
                // The mean anew: a buffer is written when a frame ends.
                renderer.forget();
                for _ in 0..frames {
                    renderer.draw(view, settings).map_err(anyhow::Error::msg)?;
                }
                let path = folder.join(format!("{}-{}.png", buffer.name(), layer + 1));
                let shading = if buffer.is_light() { Shading::Irradiance } else { Shading::Plain };
                self.write_page(page(renderer)?.0, truth.size, shading, &path)?;
            }
        }
        renderer.show(ShownBuffer::Total, 0);
        Ok(())
    }

    fn write_page(&mut self, pages: wgpu::Buffer, size: [u32; 2], shading: Shading, path: &Path) -> anyhow::Result<()> {
        self.version += 1;
        let map = MapFrame { pages, version: self.version, difference: false, nearest: true, on_screen: Some(size) };
        self.frame = ViewFrame { map: Some(map), size, shading, ..self.frame.clone() };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.viewer.draw(&self.device, &self.queue, &mut encoder, &self.frame);
        self.queue.submit([encoder.finish()]);
        let picture = self.viewer.picture(self.frame.view).ok_or_else(|| anyhow!("nothing was drawn"))?;
        let picture = device::read_picture(&self.device, &self.queue, picture).map_err(anyhow::Error::msg)?;
        files::write_picture(path, &picture)
    }
}

/// The absolute difference, as a grey of the root of the mean square of the bands.
fn apart(values: &[Vec3], known: &[Vec3]) -> Vec<Vec3> {
    let grey = |(a, b): (&Vec3, &Vec3)| Vec3::splat(((*a - *b).length_squared() / 3.0).sqrt());
    values.iter().zip(known).map(grey).collect()
}
