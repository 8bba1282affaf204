//! The pipelines of passes over a view's surfaces, material by material, made when they are first needed.

use std::{collections::BTreeMap, ops::Range};

use super::{
    geometry::MaterialDraw,
    material_buffer::MATERIAL_STRIDE,
    mesh_buffers::{MeshBuffers, Triangles},
    mesh_view::MeshInputs,
    targets::Targets,
    variant::Variant,
};
use crate::scene::{Material, Scene};

/// By what each is made for.
#[derive(Default)]
pub(super) struct SurfacePipelines(BTreeMap<Variant, wgpu::RenderPipeline>);

impl SurfacePipelines {
    /// Makes by `make` what these materials need and is not there yet.
    pub(super) fn prepare(
        &mut self,
        variant: Variant,
        (scene, materials): (&Scene, &[Material]),
        make: impl Fn(Variant) -> wgpu::RenderPipeline,
    ) {
        for material in materials {
            let variant = variant.with_textures(scene, material);
            self.0.entry(variant).or_insert_with(|| make(variant));
        }
    }

    /// Lets `draw` draw the triangles of one material after the other; those that are invisible altogether are left out.
    pub(super) fn draw_materials(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        mesh: &MeshBuffers,
        (inputs, triangles): (&MeshInputs<'_>, &Triangles),
        draw: impl Fn(&mut wgpu::RenderPass<'_>, Range<u32>),
    ) {
        pass.set_bind_group(0, inputs.frame, &[]);
        for MaterialDraw { material: index, triangles } in &triangles.draws {
            let material = inputs.materials.get(*index as usize).filter(|material| material.opacity >= 0.5);
            let Some(material) = material else { continue };
            let Some(pipeline) = self.0.get(&inputs.variant.with_textures(inputs.scene, material)) else { continue };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, inputs.material_group, &[index * MATERIAL_STRIDE as u32]);
            pass.set_bind_group(2, mesh.textures.of_material(*index), &[]);
            draw(pass, triangles.clone());
        }
    }
}

/// What a pipeline over surfaces has of its own; all cull back faces, and the nearest surface wins.
pub(super) struct SurfacePass<'a> {
    pub(super) label: &'a str,
    pub(super) module: &'a wgpu::ShaderModule,
    pub(super) layout: &'a wgpu::PipelineLayout,
    /// Names of the vertex and the fragment shader.
    pub(super) entries: [&'a str; 2],
    /// The streams of vertices: bytes a vertex, and format.
    pub(super) streams: &'a [(u64, wgpu::VertexFormat)],
    pub(super) targets: &'a [wgpu::TextureFormat],
}

/// Makes a pipeline.
pub(super) fn surface_pipeline(
    device: &wgpu::Device,
    variant: Variant,
    pass: &SurfacePass<'_>,
) -> wgpu::RenderPipeline {
    let attribute = |(shader_location, (_, format)): (u32, &(u64, wgpu::VertexFormat))| {
        [wgpu::VertexAttribute { format: *format, offset: 0, shader_location }]
    };
    let attributes: Vec<_> = (0..).zip(pass.streams).map(attribute).collect();
    let buffers = pass.streams.iter().zip(&attributes).map(|((array_stride, _), attributes)| {
        let step_mode = wgpu::VertexStepMode::Vertex;
        Some(wgpu::VertexBufferLayout { array_stride: *array_stride, step_mode, attributes })
    });
    let buffers: Vec<_> = buffers.collect();
    let targets: Vec<_> = pass.targets.iter().map(|format| Some((*format).into())).collect();
    let constants = variant.constants();
    let options = || wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(pass.label),
        layout: Some(pass.layout),
        vertex: wgpu::VertexState {
            module: pass.module,
            entry_point: Some(pass.entries[0]),
            compilation_options: options(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(Targets::depth_state(wgpu::CompareFunction::Greater)),
        multisample: Targets::multisample(variant.samples),
        fragment: Some(wgpu::FragmentState {
            module: pass.module,
            entry_point: Some(pass.entries[1]),
            compilation_options: options(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
