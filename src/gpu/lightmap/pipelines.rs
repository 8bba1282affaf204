//! How the pipelines of this folder are made.

use glam::Vec3;

use super::{hemicube::NEAR, patches::Face};
use crate::gpu::targets::Targets;

/// A shader from its source.
pub(in crate::gpu) fn module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

/// A compute pass: one function of a shader, with the bindings that it uses.
pub(in crate::gpu) fn compute_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry: &str,
) -> wgpu::ComputePipeline {
    compute_pipeline_with(device, module, entry, &[])
}

/// The same with values for the shader's constants.
pub(in crate::gpu) fn compute_pipeline_with(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry: &str,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: None,
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            ..wgpu::PipelineCompilationOptions::default()
        },
        cache: None,
    })
}

/// How triangles are drawn on hemicubes' faces.
pub(super) struct FaceDraw<'a> {
    pub(super) label: &'a str,
    /// The shader, with a function `to_face`.
    pub(super) module: &'a wgpu::ShaderModule,
    /// Bytes of a vertex, and what is in it.
    pub(super) vertex: (usize, &'a [wgpu::VertexAttribute]),
    /// The function of a fragment, and the format that it writes; without a format, or a function, there is depth alone.
    pub(super) fragment: Option<(&'a str, Option<wgpu::TextureFormat>)>,
}

/// Vertices that are positions and no more.
pub(super) const POSITIONS: (usize, &[wgpu::VertexAttribute]) =
    (size_of::<Vec3>(), &wgpu::vertex_attr_array![0 => Float32x3]);

/// Draws triangles on hemicubes' faces, each an instance ([`Face`]); both sides of a surface hide.
pub(super) fn face_pipeline(device: &wgpu::Device, draw: &FaceDraw<'_>) -> wgpu::RenderPipeline {
    let rows = wgpu::vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32x4];
    let stream = |array_stride: usize, step_mode, attributes| {
        Some(wgpu::VertexBufferLayout { array_stride: array_stride as u64, step_mode, attributes })
    };
    let targets: Vec<_> =
        draw.fragment.and_then(|(_, format)| format).map(|format| Some(format.into())).into_iter().collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(draw.label),
        layout: None,
        vertex: wgpu::VertexState {
            module: draw.module,
            entry_point: Some("to_face"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("near", f64::from(NEAR))],
                ..wgpu::PipelineCompilationOptions::default()
            },
            buffers: &[
                stream(draw.vertex.0, wgpu::VertexStepMode::Vertex, draw.vertex.1),
                stream(size_of::<Face>(), wgpu::VertexStepMode::Instance, &rows),
            ],
        },
        // A hemicube's faces are mirrored: right × up looks outwards.
        primitive: wgpu::PrimitiveState { front_face: wgpu::FrontFace::Cw, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(Targets::depth_state(wgpu::CompareFunction::Greater)),
        multisample: wgpu::MultisampleState::default(),
        fragment: draw.fragment.map(|(entry, _)| wgpu::FragmentState {
            module: draw.module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
