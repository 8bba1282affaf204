//! The pass that shows a page of a lightmap, or the hemicubes of the last batch, as a picture in the window.

use glam::Vec4;

use super::blit::window_pipeline;
use crate::math::color::ToneMap;

/// The shader.
pub const WGSL: &str = include_str!("map_picture.wgsl");

/// Uniforms, laid out as `PictureUniforms` in `map_picture.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PictureUniforms {
    /// Top left pixel in the window, and 1 / size there.
    pub place: Vec4,
    /// 2^exposure / white.
    pub exposure_scale: f32,
    /// 1 / gamma.
    pub inverse_gamma: f32,
    /// The page.
    pub page: u32,
    /// 0 for irradiance through the tone map (its curve left out), 1 for colours as they are.
    pub mode: u32,
    /// 1 for the charts' outlines.
    pub outlines: u32,
    /// 1 if the window codes linear values by itself.
    pub codes_itself: u32,
    /// Columns and rows that are shown of hemicubes and hemispheres.
    pub part: [u32; 2],
}

/// What a picture shows.
#[derive(Clone, Debug)]
pub enum Pictured {
    /// A page ([`super::lightmap::GpuSolver::pages`]).
    Page {
        /// All pages.
        pages: wgpu::Buffer,
        /// Which one.
        page: u32,
        /// It is light, for the tone map; else colours as they are.
        is_light: bool,
        /// The charts' outlines over it.
        outlines: bool,
    },
    /// Depth of hemicubes ([`super::lightmap::GpuSolver::hemicube_depth`]), and the columns and rows that are shown.
    Hemicubes(wgpu::TextureView, [u32; 2]),
    /// Items of hemispheres ([`super::lightmap::GpuSolver::item_buffer`]), likewise.
    Items(wgpu::TextureView, [u32; 2]),
}

/// A picture on its way to the window.
#[derive(Clone, Debug)]
pub struct MapPictureFrame {
    /// What it shows.
    pub pictured: Pictured,
    /// From radiance to colour.
    pub tone_map: ToneMap,
    /// Top left pixel in the window.
    pub origin: [i32; 2],
    /// Size there, in pixels.
    pub size: [u32; 2],
}

/// The pipelines, and one picture at a time.
pub struct MapPicture {
    page: wgpu::RenderPipeline,
    depth: wgpu::RenderPipeline,
    items: wgpu::RenderPipeline,
    codes_itself: bool,
    uniforms: wgpu::Buffer,
    /// What is shown, and the pipeline for it.
    shown: Option<(wgpu::BindGroup, wgpu::RenderPipeline)>,
}

impl MapPicture {
    /// For windows of this format.
    pub fn new(device: &wgpu::Device, target_format: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("map picture"),
            source: wgpu::ShaderSource::Wgsl(WGSL.into()),
        });
        let pipeline = |entry| window_pipeline(device, "map picture", (None, &module), entry, target_format);
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("map picture"),
            size: size_of::<PictureUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let codes_itself = target_format.is_srgb();
        let [page, depth, items] = ["page", "depth", "items"].map(pipeline);
        Self { page, depth, items, codes_itself, uniforms, shown: None }
    }

    /// Takes the picture that the next pass shows.
    pub fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, frame: &MapPictureFrame) {
        let ([x, y], [across, down]) = (frame.origin, frame.size.map(|pixels| 1.0 / pixels.max(1) as f32));
        let mut uniforms = PictureUniforms {
            place: Vec4::new(x as f32, y as f32, across, down),
            exposure_scale: frame.tone_map.scale(),
            inverse_gamma: frame.tone_map.inverse_gamma(),
            codes_itself: u32::from(self.codes_itself),
            ..PictureUniforms::default()
        };
        let (pipeline, binding, resource) = match &frame.pictured {
            Pictured::Page { pages, page, is_light, outlines } => {
                uniforms.page = *page;
                (uniforms.mode, uniforms.outlines) = (u32::from(!is_light), u32::from(*outlines));
                (&self.page, 1, pages.as_entire_binding())
            }
            Pictured::Hemicubes(depth, part) => {
                uniforms.part = *part;
                (&self.depth, 2, wgpu::BindingResource::TextureView(depth))
            }
            Pictured::Items(items, part) => {
                uniforms.part = *part;
                (&self.items, 3, wgpu::BindingResource::TextureView(items))
            }
        };
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("map picture"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.uniforms.as_entire_binding() },
                wgpu::BindGroupEntry { binding, resource },
            ],
        });
        self.shown = Some((group, pipeline.clone()));
    }

    /// Draws it over the viewport.
    pub fn record(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Some((group, pipeline)) = &self.shown else { return };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3, 0..1);
    }
}
