//! The pass that draws the elements: Gouraud-interpolated irradiance, textures per pixel, back faces culled.
//!
//! Inputs: the frame's uniforms (group 0), a material's uniforms (group 1, one slice of a buffer for each material), its
//! textures (group 2), and the streams position, normal, texture coordinates, irradiance and buried flag.

use std::{collections::BTreeMap, ops::Range};

use glam::Vec3;

use super::{
    frame::{FRAME_WGSL, SAMPLE_COUNTS, Shading, ViewFrame},
    geometry::MaterialDraw,
    mesh_buffers::{MeshBuffers, Triangles},
    resolve::SHADING_WGSL,
    targets::Targets,
};
use crate::{
    math::color::ToneCurve,
    scene::{Material, Scene, Texture, texture::TextureFilter},
};

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

/// What a pipeline is made for. The shader has no branches but these, because a software driver runs both sides of a
/// branch that is decided while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Variant {
    samples: u32,
    tone: ToneVariant,
    ambient: bool,
    buried: bool,
    map: Option<MapVariant>,
    /// A layer of a G-buffer, and not a picture: `LAYER` of `g_buffer.wgsl`.
    layer: Option<u32>,
    reflectance_filter: u32,
    opacity_filter: u32,
}

/// How a pipeline makes colours: the constants of `shading.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ToneVariant {
    shading: u32,
    filmic: bool,
    gamma: bool,
    logarithmic: bool,
}

impl ToneVariant {
    fn new(frame: &ViewFrame) -> Self {
        let (shading, logarithmic) = match frame.shading {
            Shading::Radiosity => (0, false),
            Shading::Irradiance => (1, false),
            Shading::Albedo => (2, false),
            Shading::Normals => (3, false),
            Shading::FalseColor(range) => (4, range.logarithmic),
            Shading::Plain => (5, false),
        };
        let tone_mapped = shading < 2;
        Self {
            shading,
            filmic: tone_mapped && frame.tone_map.curve == ToneCurve::Filmic,
            gamma: tone_mapped && frame.tone_map.gamma != 1.0,
            logarithmic,
        }
    }

    /// The shader's constants.
    pub(super) fn constants(self) -> Vec<(&'static str, f64)> {
        let flag = |set| f64::from(u8::from(set));
        vec![
            ("SHADING", f64::from(self.shading)),
            ("FILMIC", flag(self.filmic)),
            ("GAMMA", flag(self.gamma)),
            ("LOGARITHMIC", flag(self.logarithmic)),
        ]
    }
}

/// What a pipeline for a lightmap is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MapVariant {
    difference: bool,
    nearest: bool,
    on_screen: bool,
}

impl Variant {
    /// For a frame, and a material without textures.
    pub(super) fn new(frame: &ViewFrame) -> Self {
        let tone = ToneVariant::new(frame);
        Self {
            samples: frame.samples(),
            tone,
            ambient: tone.shading < 2 && frame.ambient != Vec3::ZERO,
            buried: frame.buried.is_some(),
            map: frame.map.as_ref().map(|map| MapVariant {
                difference: map.difference,
                nearest: map.nearest,
                on_screen: map.on_screen.is_some(),
            }),
            layer: None,
            reflectance_filter: 0,
            opacity_filter: 0,
        }
    }

    /// For a layer of a G-buffer: reflectance as albedo is shown, and normals as ambient light needs them.
    pub(super) fn of_layer(layer: u32) -> Self {
        Self {
            samples: 1,
            tone: ToneVariant { shading: 2, filmic: false, gamma: false, logarithmic: false },
            ambient: true,
            buried: false,
            map: None,
            layer: Some(layer),
            reflectance_filter: 0,
            opacity_filter: 0,
        }
    }

    /// The same without smooth edges.
    pub(super) fn with_one_sample(self) -> Self {
        Self { samples: 1, ..self }
    }

    /// How colours are made, if all that changes with the field is what a visibility buffer knows.
    pub(super) fn resolved(self) -> Option<ToneVariant> {
        let shows_field = !matches!(self.tone.shading, 2 | 3);
        (shows_field && self.samples == 1 && !self.buried && self.map.is_none()).then_some(self.tone)
    }

    /// The same for a material of `scene`.
    pub(super) fn with_textures(self, scene: &Scene, material: &Material) -> Self {
        let filter = |index: Option<u32>| match index.and_then(|index| scene.textures.get(index as usize)) {
            None => 0,
            Some(texture) if texture.filter == TextureFilter::Nearest => 1,
            Some(_) => 2,
        };
        let shows_reflectance = matches!(self.tone.shading, 0 | 2);
        Self {
            reflectance_filter: if shows_reflectance { filter(material.reflectance_texture) } else { 0 },
            opacity_filter: filter(material.opacity_texture),
            ..self
        }
    }

    /// The shader's constants.
    pub(super) fn constants(self) -> Vec<(&'static str, f64)> {
        let flag = |set| f64::from(u8::from(set));
        let mut constants = self.tone.constants();
        constants.extend([
            ("AMBIENT", flag(self.ambient)),
            ("BURIED", flag(self.buried)),
            ("REFLECTANCE_FILTER", f64::from(self.reflectance_filter)),
            ("OPACITY_FILTER", f64::from(self.opacity_filter)),
            ("SEVERAL_SAMPLES", flag(self.samples > 1)),
        ]);
        if let Some(map) = self.map {
            constants.extend([("DIFFERENCE", flag(map.difference)), ("NEAREST_TEXEL", flag(map.nearest))]);
            constants.push(("ON_SCREEN", flag(map.on_screen)));
        }
        constants.extend(self.layer.map(|layer| ("LAYER", f64::from(layer))));
        constants
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
    pub(super) material_stride: u32,
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

/// The pipelines, made when they are first needed.
pub(super) struct MeshView {
    at_vertices: Shader,
    /// Made with the first lightmap: its layout asks for what old devices do not have.
    on_map: Option<(Shader, wgpu::BindGroupLayout)>,
    /// Made with the first G-buffer.
    layer: Option<Shader>,
    pipelines: BTreeMap<Variant, wgpu::RenderPipeline>,
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

impl MeshView {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let at_vertices = Shader::new(device, layouts, VERTEX_FIELD_WGSL, None);
        Self { at_vertices, on_map: None, layer: None, pipelines: BTreeMap::new() }
    }

    /// Binds the pages of a lightmap.
    pub(super) fn bind_pages(
        &mut self,
        device: &wgpu::Device,
        layouts: &Layouts,
        pages: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let (_, layout) = self.on_map.get_or_insert_with(|| {
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
        self.layer = Some(Shader::new(device, layouts, &source, Some(extra)));
    }

    /// Makes the pipelines that these materials need, for any number of samples: else the first frame of a solve, which
    /// takes another number, would wait for them.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, variant: Variant, scene: &Scene, materials: &[Material]) {
        for material in materials {
            for samples in if variant.layer.is_some() { &SAMPLE_COUNTS[..1] } else { &SAMPLE_COUNTS[..] } {
                let samples = *samples;
                let variant = Variant { samples, ..variant.with_textures(scene, material) };
                if !self.pipelines.contains_key(&variant) {
                    self.pipelines.insert(variant, self.pipeline(device, variant));
                }
            }
        }
    }

    fn pipeline(&self, device: &wgpu::Device, variant: Variant) -> wgpu::RenderPipeline {
        let at_vertices = &self.at_vertices;
        let shader = self.on_map.as_ref().filter(|_| variant.map.is_some()).map_or(at_vertices, |(shader, _)| shader);
        let shader = self.layer.as_ref().filter(|_| variant.layer.is_some()).unwrap_or(shader);
        let layer_targets = LAYER_FORMATS.map(|format| Some(format.into()));
        let (entry, targets) = match variant.layer {
            Some(_) => ("surface", &layer_targets[..]),
            None => ("fragment", &[Some(Targets::COLOR_FORMAT.into())][..]),
        };
        let mut attributes = [[wgpu::VertexAttribute { format: STREAMS[0].1, offset: 0, shader_location: 0 }]; 6];
        for (location, (attribute, (_, format))) in (0..).zip(attributes.iter_mut().zip(STREAMS)) {
            attribute[0].format = format;
            attribute[0].shader_location = location;
        }
        let step_mode = wgpu::VertexStepMode::Vertex;
        let buffers: [_; 6] = std::array::from_fn(|slot| {
            Some(wgpu::VertexBufferLayout { array_stride: STREAMS[slot].0, step_mode, attributes: &attributes[slot] })
        });
        let constants = variant.constants();
        let options = || wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("mesh view"),
            layout: Some(&shader.layout),
            vertex: wgpu::VertexState {
                module: &shader.module,
                entry_point: Some("vertex"),
                compilation_options: options(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..wgpu::PrimitiveState::default() },
            depth_stencil: Some(Targets::depth_state(wgpu::CompareFunction::Greater)),
            multisample: Targets::multisample(variant.samples),
            fragment: Some(wgpu::FragmentState {
                module: &shader.module,
                entry_point: Some(entry),
                compilation_options: options(),
                targets,
            }),
            multiview_mask: None,
            cache: None,
        })
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
        draw_materials(pass, mesh, inputs, &self.pipelines, triangles, |pass, of_material| {
            let start = of_material.start.max(range.start);
            let end = of_material.end.min(range.end);
            if start < end {
                pass.draw_indexed(3 * start..3 * end, 0, 0..1);
            }
        });
    }
}

/// Lets `draw` draw the triangles of one material after the other; those that are invisible altogether are left out.
pub(super) fn draw_materials(
    pass: &mut wgpu::RenderPass<'_>,
    mesh: &MeshBuffers,
    inputs: &MeshInputs<'_>,
    pipelines: &BTreeMap<Variant, wgpu::RenderPipeline>,
    triangles: &Triangles,
    draw: impl Fn(&mut wgpu::RenderPass<'_>, Range<u32>),
) {
    pass.set_bind_group(0, inputs.frame, &[]);
    for MaterialDraw { material: index, triangles } in &triangles.draws {
        let material = inputs.materials.get(*index as usize).filter(|material| material.opacity >= 0.5);
        let Some(material) = material else { continue };
        let Some(pipeline) = pipelines.get(&inputs.variant.with_textures(inputs.scene, material)) else { continue };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, inputs.material_group, &[index * inputs.material_stride]);
        pass.set_bind_group(2, mesh.textures.of_material(*index), &[]);
        draw(pass, triangles.clone());
    }
}
