//! How the pipelines of this folder are made.

use glam::Vec3;

use super::{hemicube::NEAR, patches::Face};
use crate::gpu::targets::Targets;

/// A shader from its source.
pub(super) fn module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

/// A compute pass: one function of a shader, with the bindings that it uses.
pub(super) fn compute_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry: &str,
) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: None,
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}

/// Draws triangles on hemicubes' faces: vertices of positions, instances of [`Face`]s; both sides of a surface hide.
/// `items` names the function that writes a fragment, and the format that it writes; without it, there is depth alone.
pub(super) fn face_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    label: &str,
    items: Option<(&str, wgpu::TextureFormat)>,
) -> wgpu::RenderPipeline {
    let position = wgpu::vertex_attr_array![0 => Float32x3];
    let rows = wgpu::vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32x4];
    let stream = |array_stride: usize, step_mode, attributes| {
        Some(wgpu::VertexBufferLayout { array_stride: array_stride as u64, step_mode, attributes })
    };
    let targets = [items.map(|(_, format)| format.into())];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("to_face"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("near", f64::from(NEAR))],
                ..wgpu::PipelineCompilationOptions::default()
            },
            buffers: &[
                stream(size_of::<Vec3>(), wgpu::VertexStepMode::Vertex, &position),
                stream(size_of::<Face>(), wgpu::VertexStepMode::Instance, &rows),
            ],
        },
        // A hemicube's faces are mirrored: right × up looks outwards.
        primitive: wgpu::PrimitiveState { front_face: wgpu::FrontFace::Cw, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(Targets::depth_state(wgpu::CompareFunction::Greater)),
        multisample: wgpu::MultisampleState::default(),
        fragment: items.map(|(entry, _)| wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
