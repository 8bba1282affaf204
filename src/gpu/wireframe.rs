//! The pass that draws the elements' edges over them: lines a pixel wide, hidden where the surface is hidden, and
//! fainter where the elements are only a few pixels large.

use std::ops::Range;

use super::{frame::FRAME_WGSL, mesh_buffers::MeshBuffers, mesh_view::Layouts, targets::Targets};

/// The shader.
pub const WGSL: &str = include_str!("wireframe.wgsl");

/// The pipeline.
pub(super) struct Wireframe {
    pipeline: wgpu::RenderPipeline,
}

impl Wireframe {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, samples: u32) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("wireframe"),
            source: wgpu::ShaderSource::Wgsl(format!("{FRAME_WGSL}{WGSL}").into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("wireframe"),
            bind_group_layouts: &[Some(&layouts.frame)],
            immediate_size: 0,
        });
        let positions = wgpu::vertex_attr_array![0 => Float32x3];
        let normals = wgpu::vertex_attr_array![1 => Snorm16x4];
        let stream = |array_stride, attributes| {
            Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("wireframe"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[stream(12, &positions), stream(8, &normals)],
            },
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::LineList,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                depth_write_enabled: Some(false),
                ..Targets::depth_state(wgpu::CompareFunction::GreaterEqual)
            }),
            multisample: Targets::multisample(samples),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: Targets::COLOR_FORMAT,
                    blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline }
    }

    /// Draws a range of the edges.
    pub(super) fn record(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        frame: &wgpu::BindGroup,
        mesh: &MeshBuffers,
        edges: Range<u32>,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_vertex_buffer(0, mesh.positions.slice(..));
        pass.set_vertex_buffer(1, mesh.normals.slice(..));
        pass.set_index_buffer(mesh.edges.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(2 * edges.start..2 * edges.end, 0, 0..1);
    }
}
