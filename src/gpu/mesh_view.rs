//! The pass that draws the elements: Gouraud-interpolated irradiance, textures per pixel, back faces culled.
//!
//! Inputs: the frame's uniforms (group 0), a material's uniforms (group 1, one slice of a buffer for each material), its
//! textures (group 2), and the streams position, normal, texture coordinates, irradiance and buried flag.

use crate::scene::{Material, Scene, texture::TextureFilter};
use glam::Vec3;

use super::{frame::FRAME_WGSL, mesh_buffers::MeshBuffers, targets::Targets};

/// The shader.
pub const WGSL: &str = include_str!("mesh_view.wgsl");

/// Uniforms of a material, laid out as `MaterialUniforms` in `mesh_view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MaterialUniforms {
    /// Reflectance, which the texture multiplies.
    pub reflectance: Vec3,
    /// Opacity, which its texture multiplies.
    pub opacity: f32,
    /// Emitted radiance.
    pub emitted_radiance: Vec3,
    /// The texture's values are brought down to this.
    pub largest_texel: f32,
    /// 0 for no reflectance texture, 1 for one read at the nearest texel, 2 for bilinear.
    pub reflectance_filter: u32,
    /// The same for the opacity texture.
    pub opacity_filter: u32,
    /// Up to a multiple of 16 bytes.
    pub unused: [u32; 2],
}

impl MaterialUniforms {
    /// The uniforms of a material of `scene`, possibly edited.
    pub(super) fn new(scene: &Scene, material: &Material) -> Self {
        let texture = |index: Option<u32>| index.and_then(|index| scene.textures.get(index as usize));
        let filter = |index| {
            texture(index).map_or(0, |texture| match texture.filter {
                TextureFilter::Nearest => 1,
                TextureFilter::Bilinear => 2,
            })
        };
        Self {
            reflectance: material.reflectance,
            opacity: material.opacity,
            emitted_radiance: material.emitted_radiance,
            largest_texel: texture(material.reflectance_texture).map_or(1.0, |texture| texture.largest_value()),
            reflectance_filter: filter(material.reflectance_texture),
            opacity_filter: filter(material.opacity_texture),
            unused: [0; 2],
        }
    }
}

/// Layouts of the bindings, the same for any number of samples.
pub(super) struct Layouts {
    pub(super) frame: wgpu::BindGroupLayout,
    pub(super) material: wgpu::BindGroupLayout,
    pub(super) textures: wgpu::BindGroupLayout,
}

impl Layouts {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let uniforms = |visibility, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset,
                min_binding_size: None,
            },
            count: None,
        };
        let texture = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        Self {
            frame: layout("frame", &[uniforms(wgpu::ShaderStages::VERTEX_FRAGMENT, false)]),
            material: layout("material", &[uniforms(wgpu::ShaderStages::FRAGMENT, true)]),
            textures: layout("textures", &[texture(0), texture(1)]),
        }
    }
}

/// What a view adds to the shared mesh: fields and materials.
pub(super) struct MeshInputs<'a> {
    pub(super) frame: &'a wgpu::BindGroup,
    pub(super) irradiance: &'a wgpu::Buffer,
    pub(super) buried: &'a wgpu::Buffer,
    pub(super) materials: &'a [Material],
    pub(super) material_group: &'a wgpu::BindGroup,
    pub(super) material_stride: u32,
}

/// The pipelines.
pub(super) struct MeshView {
    opaque: wgpu::RenderPipeline,
    cut_out: wgpu::RenderPipeline,
}

impl MeshView {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, samples: u32) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("mesh view"),
            source: wgpu::ShaderSource::Wgsl(format!("{FRAME_WGSL}{WGSL}").into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("mesh view"),
            bind_group_layouts: &[Some(&layouts.frame), Some(&layouts.material), Some(&layouts.textures)],
            immediate_size: 0,
        });
        let pipeline = |entry_point| {
            let streams = [
                (12, wgpu::VertexFormat::Float32x3),
                (8, wgpu::VertexFormat::Snorm16x4),
                (8, wgpu::VertexFormat::Float32x2),
                (12, wgpu::VertexFormat::Float32x3),
                (4, wgpu::VertexFormat::Float32),
            ];
            let mut location = 0;
            let attributes = streams.map(|(_, format)| {
                location += 1;
                [wgpu::VertexAttribute { format, offset: 0, shader_location: location - 1 }]
            });
            let buffers: Vec<_> = streams
                .iter()
                .zip(&attributes)
                .map(|(&(array_stride, _), attributes)| {
                    Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
                })
                .collect();
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("mesh view"),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &buffers,
                },
                primitive: wgpu::PrimitiveState {
                    cull_mode: Some(wgpu::Face::Back),
                    ..wgpu::PrimitiveState::default()
                },
                depth_stencil: Some(Targets::depth_state(wgpu::CompareFunction::Greater)),
                multisample: Targets::multisample(samples),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(Targets::COLOR_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self { opaque: pipeline("opaque"), cut_out: pipeline("cut_out") }
    }

    /// Draws all elements, material by material; those that are invisible altogether are left out.
    pub(super) fn record(&self, pass: &mut wgpu::RenderPass<'_>, mesh: &MeshBuffers, inputs: &MeshInputs<'_>) {
        pass.set_bind_group(0, inputs.frame, &[]);
        let streams = [&mesh.positions, &mesh.normals, &mesh.texcoords, inputs.irradiance, inputs.buried];
        for (slot, stream) in (0..).zip(streams) {
            pass.set_vertex_buffer(slot, stream.slice(..));
        }
        pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        for draw in &mesh.draws {
            let Some(material) = inputs.materials.get(draw.material as usize) else { continue };
            if material.opacity < 0.5 {
                continue;
            }
            let cut_out = material.opacity_texture.is_some();
            pass.set_pipeline(if cut_out { &self.cut_out } else { &self.opaque });
            pass.set_bind_group(1, inputs.material_group, &[draw.material * inputs.material_stride]);
            pass.set_bind_group(2, mesh.textures.of_material(draw.material), &[]);
            pass.draw_indexed(3 * draw.triangles.start..3 * draw.triangles.end, 0, 0..1);
        }
    }
}
