//! The pass that draws the elements: Gouraud-interpolated irradiance, textures per pixel, back faces culled.
//!
//! Inputs: the frame's uniforms (group 0), a material's uniforms (group 1, one slice of a buffer for each material), its
//! textures (group 2), and the streams position, normal, texture coordinates, irradiance and buried flag.

use std::ops::Range;

use glam::Vec3;

use super::{
    frame::{FRAME_WGSL, SAMPLE_COUNTS},
    mesh_buffers::{MeshBuffers, Triangles},
    surface_pipelines::{SurfacePass, SurfacePipelines, surface_pipeline},
    targets::Targets,
    variant::{SHADING_WGSL, Variant},
};
use crate::scene::{Material, Scene, Texture};

/// The shader.
pub const WGSL: &str = include_str!("mesh_view.wgsl");
/// Its part for a field at the vertices.
pub const VERTEX_FIELD_WGSL: &str = include_str!("vertex_field.wgsl");
/// Its part for a lightmap.
pub const MAP_FIELD_WGSL: &str = include_str!("map_field.wgsl");
/// What draws a G-buffer instead of colours, over a field at the vertices.
pub const G_BUFFER_WGSL: &str = include_str!("screen_space/g_buffer.wgsl");

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
}

impl MaterialUniforms {
    /// The uniforms of a material of `scene`, possibly edited.
    pub(super) fn new(scene: &Scene, material: &Material) -> Self {
        let texture = material.reflectance_texture.and_then(|index| scene.textures.get(index as usize));
        Self {
            reflectance: material.reflectance,
            opacity: material.opacity,
            emitted_radiance: material.emitted_radiance,
            largest_texel: texture.map_or(1.0, Texture::largest_value),
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
    pub(super) scene: &'a Scene,
    pub(super) variant: Variant,
    pub(super) frame: &'a wgpu::BindGroup,
    pub(super) irradiance: &'a wgpu::Buffer,
    pub(super) buried: &'a wgpu::Buffer,
    pub(super) materials: &'a [Material],
    pub(super) material_group: &'a wgpu::BindGroup,
    /// The pages, for a lightmap; what a layer of a G-buffer is told by.
    pub(super) extra: Option<&'a wgpu::BindGroup>,
}

/// The streams of vertices: bytes a vertex, and format. Without a lightmap the last one is the irradiance once more.
const STREAMS: [(u64, wgpu::VertexFormat); 6] = [
    (12, wgpu::VertexFormat::Float32x3),
    (8, wgpu::VertexFormat::Snorm16x4),
    (8, wgpu::VertexFormat::Float32x2),
    (12, wgpu::VertexFormat::Float32x3),
    (4, wgpu::VertexFormat::Float32),
    (12, wgpu::VertexFormat::Float32x3),
];

/// Formats of a G-buffer's layer: normals and reflectance.
pub(super) const LAYER_FORMATS: [wgpu::TextureFormat; 2] = [wgpu::TextureFormat::Rgba16Float; 2];

/// The pass.
pub(super) struct MeshView {
    shaders: Shaders,
    pipelines: SurfacePipelines,
}

struct Shaders {
    at_vertices: Shader,
    /// Made with the first lightmap: its layout asks for what old devices do not have.
    on_map: Option<(Shader, wgpu::BindGroupLayout)>,
    /// Made with the first G-buffer.
    layer: Option<Shader>,
}

struct Shader {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
}

impl Shader {
    fn new(device: &wgpu::Device, layouts: &Layouts, field: &str, pages: Option<&wgpu::BindGroupLayout>) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("mesh view"),
            source: wgpu::ShaderSource::Wgsl(format!("{FRAME_WGSL}{SHADING_WGSL}{WGSL}{field}").into()),
        });
        let mut groups = vec![Some(&layouts.frame), Some(&layouts.material), Some(&layouts.textures)];
        groups.extend(pages.map(Some));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("mesh view"),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        Self { module, layout }
    }
}

impl Shaders {
    fn pipeline(&self, device: &wgpu::Device, variant: Variant) -> wgpu::RenderPipeline {
        let at_vertices = &self.at_vertices;
        let shader = self.on_map.as_ref().filter(|_| variant.map.is_some()).map_or(at_vertices, |(shader, _)| shader);
        let shader = self.layer.as_ref().filter(|_| variant.layer.is_some()).unwrap_or(shader);
        let (fragment, targets) = match variant.layer {
            Some(_) => ("surface", &LAYER_FORMATS[..]),
            None => ("fragment", &[Targets::COLOR_FORMAT][..]),
        };
        let Shader { module, layout } = shader;
        let entries = ["vertex", fragment];
        let pass = SurfacePass { label: "mesh view", module, layout, entries, streams: &STREAMS, targets };
        surface_pipeline(device, variant, &pass)
    }
}

impl MeshView {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let at_vertices = Shader::new(device, layouts, VERTEX_FIELD_WGSL, None);
        Self { shaders: Shaders { at_vertices, on_map: None, layer: None }, pipelines: SurfacePipelines::default() }
    }

    /// Binds the pages of a lightmap.
    pub(super) fn bind_pages(
        &mut self,
        device: &wgpu::Device,
        layouts: &Layouts,
        pages: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let (_, layout) = self.shaders.on_map.get_or_insert_with(|| {
            let entry = wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            };
            let layout = device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("pages"), entries: &[entry] });
            (Shader::new(device, layouts, MAP_FIELD_WGSL, Some(&layout)), layout)
        });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pages"),
            layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: pages.as_entire_binding() }],
        })
    }

    /// Makes it able to draw a G-buffer, whose group 3 has this layout.
    pub(super) fn add_layers(&mut self, device: &wgpu::Device, layouts: &Layouts, extra: &wgpu::BindGroupLayout) {
        let source = format!("{VERTEX_FIELD_WGSL}{G_BUFFER_WGSL}");
        self.shaders.layer = Some(Shader::new(device, layouts, &source, Some(extra)));
    }

    /// Makes the pipelines that these materials need, for any number of samples: else the first frame of a solve, which
    /// takes another number, would wait for them.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, variant: Variant, scene: &Scene, materials: &[Material]) {
        let counts = if variant.layer.is_some() { &SAMPLE_COUNTS[..1] } else { &SAMPLE_COUNTS[..] };
        for &samples in counts {
            let make = |variant| self.shaders.pipeline(device, variant);
            self.pipelines.prepare(variant.with_samples(samples), (scene, materials), make);
        }
    }

    /// Draws a range of the triangles, material by material; those that are invisible altogether are left out.
    pub(super) fn record(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        mesh: &MeshBuffers,
        inputs: &MeshInputs<'_>,
        (triangles, range): (&Triangles, Range<u32>),
    ) {
        let map_places = mesh.map_places.as_ref().unwrap_or(inputs.irradiance);
        let streams = [&mesh.positions, &mesh.normals, &mesh.texcoords, inputs.irradiance, inputs.buried, map_places];
        if let Some(extra) = inputs.extra {
            pass.set_bind_group(3, extra, &[]);
        }
        for (slot, stream) in (0..).zip(streams) {
            pass.set_vertex_buffer(slot, stream.slice(..));
        }
        pass.set_index_buffer(triangles.indices.slice(..), wgpu::IndexFormat::Uint32);
        self.pipelines.draw_materials(pass, mesh, (inputs, triangles), |pass, of_material| {
            let start = of_material.start.max(range.start);
            let end = of_material.end.min(range.end);
            if start < end {
                pass.draw_indexed(3 * start..3 * end, 0, 0..1);
            }
        });
    }
}
