//! The pass that draws the placed area light: a rectangle, bright on the side that shines, dark on the other, with an
//! outline if it is picked.

use super::{frame::FRAME_WGSL, mesh_view::Layouts, targets::Targets};

/// The shader.
pub const WGSL: &str = include_str!("light_view.wgsl");

/// The pipeline.
pub(super) struct LightView {
    pipeline: wgpu::RenderPipeline,
}

impl LightView {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, samples: u32) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("light view"),
            source: wgpu::ShaderSource::Wgsl(format!("{FRAME_WGSL}{WGSL}").into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("light view"),
            bind_group_layouts: &[Some(&layouts.frame)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("light view"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(Targets::depth_state(wgpu::CompareFunction::GreaterEqual)),
            multisample: Targets::multisample(samples),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(Targets::COLOR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline }
    }

    /// Draws the light of the frame's uniforms.
    pub(super) fn record(&self, pass: &mut wgpu::RenderPass<'_>, frame: &wgpu::BindGroup) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.draw(0..6, 0..1);
    }
}
