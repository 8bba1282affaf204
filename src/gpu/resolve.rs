//! The pass that colours pixels whose triangles are known ([`super::visibility`]) from the field: it costs by the pixel,
//! however many triangles there are.
//!
//! Inputs: the frame's uniforms (group 0); what pixels see, and the field as a texture (group 1).

use std::collections::BTreeMap;

use glam::{Vec3, Vec4};

use super::{
    frame::FRAME_WGSL,
    mesh_view::Layouts,
    targets::Targets,
    variant::{SHADING_WGSL, ToneVariant},
    visibility::SeenTargets,
};

/// The shader.
pub const WGSL: &str = include_str!("resolve.wgsl");

/// Vertices in a row of the field's texture: `FIELD_WIDTH` in `resolve.wgsl`.
const FIELD_WIDTH: u32 = 1024;

/// A field at the vertices on the card, as a texture.
pub(super) struct FieldTexture(wgpu::Texture);

impl FieldTexture {
    /// The most vertices that a texture of this device can hold.
    pub(super) fn capacity(device: &wgpu::Device) -> usize {
        FIELD_WIDTH as usize * device.limits().max_texture_dimension_2d as usize
    }

    /// For so many vertices, at most [`FieldTexture::capacity`].
    pub(super) fn new(device: &wgpu::Device, vertices: usize) -> Self {
        let height = vertices.div_ceil(FIELD_WIDTH as usize).max(1) as u32;
        Self(device.create_texture(&wgpu::TextureDescriptor {
            label: Some("field"),
            size: wgpu::Extent3d { width: FIELD_WIDTH, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        }))
    }

    /// Takes a field [W/m²] of as many vertices as it was made for.
    pub(super) fn write(&self, queue: &wgpu::Queue, field: &[Vec3]) {
        let mut texels: Vec<Vec4> = field.iter().map(|value| value.extend(0.0)).collect();
        texels.resize((FIELD_WIDTH * self.0.height()) as usize, Vec4::ZERO);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(FIELD_WIDTH * size_of::<Vec4>() as u32),
            rows_per_image: None,
        };
        queue.write_texture(self.0.as_image_copy(), bytemuck::cast_slice(&texels), layout, self.0.size());
    }
}

/// The pipelines, made when they are first needed.
pub(super) struct Resolve {
    module: wgpu::ShaderModule,
    inputs: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    pipelines: BTreeMap<ToneVariant, wgpu::RenderPipeline>,
}

impl Resolve {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("resolve"),
            source: wgpu::ShaderSource::Wgsl(format!("{FRAME_WGSL}{SHADING_WGSL}{WGSL}").into()),
        });
        let inputs = bindings(device);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("resolve"),
            bind_group_layouts: &[Some(&layouts.frame), Some(&inputs)],
            immediate_size: 0,
        });
        Self { module, inputs, layout, pipelines: BTreeMap::new() }
    }

    /// Bindings of what pixels see, and of the field.
    pub(super) fn bind(&self, device: &wgpu::Device, seen: &SeenTargets, field: &FieldTexture) -> wgpu::BindGroup {
        let field = field.0.create_view(&wgpu::TextureViewDescriptor::default());
        let entry =
            |(binding, view)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
        let entries: Vec<_> = (0..).zip(seen.views.iter().chain([&field])).map(entry).collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("resolve"),
            layout: &self.inputs,
            entries: &entries,
        })
    }

    /// Makes the pipeline if it is not there yet.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, variant: ToneVariant) {
        if !self.pipelines.contains_key(&variant) {
            self.pipelines.insert(variant, self.pipeline(device, variant));
        }
    }

    fn pipeline(&self, device: &wgpu::Device, variant: ToneVariant) -> wgpu::RenderPipeline {
        let constants = variant.constants();
        let options = || wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("resolve"),
            layout: Some(&self.layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("vertex"),
                compilation_options: options(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            // Depth is reversed, and 0 where nothing is seen: this pass lies there, so that it colours only what is nearer.
            // The triangles' depth stays for what is drawn after them.
            depth_stencil: Some(wgpu::DepthStencilState {
                depth_write_enabled: Some(false),
                ..Targets::depth_state(wgpu::CompareFunction::Less)
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("fragment"),
                compilation_options: options(),
                targets: &[Some(Targets::COLOR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Colours all pixels.
    pub(super) fn record(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        variant: ToneVariant,
        [frame, inputs]: [&wgpu::BindGroup; 2],
    ) {
        let Some(pipeline) = self.pipelines.get(&variant) else { return };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, inputs, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn bindings(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::FRAGMENT, ty, count: None };
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let float = || texture(wgpu::TextureSampleType::Float { filterable: false });
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("resolve"),
        entries: &[
            entry(0, texture(wgpu::TextureSampleType::Uint)),
            entry(1, float()),
            entry(2, float()),
            entry(3, float()),
        ],
    })
}
