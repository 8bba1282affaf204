//! The pass that draws the deep G-buffer: a layer at a time, through the pipelines of the views.

use std::ops::Range;

use bytemuck::Zeroable as _;
use glam::{Mat4, Vec2, Vec3};

use super::{targets::Targets, uniforms::rays};
use crate::{
    gpu::{
        frame::FrameUniforms,
        material_buffer::MaterialBuffer,
        mesh_buffers::MeshBuffers,
        mesh_view::{Layouts, MeshInputs, MeshView},
        projection::{NEAR, view_projection},
        variant::Variant,
    },
    scene::{Camera, Scene},
};

/// What of a camera's picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The nearest surfaces.
    First,
    /// What lies behind this frame's first layer.
    BehindFirst,
    /// What lies behind the last frame's first layer.
    BehindLast,
    /// The nearest surfaces of the picture around.
    Around,
    /// What lies behind them.
    BehindAround,
}

impl Layer {
    /// Which of the pipelines draws it.
    fn variant(self) -> Variant {
        Variant::of_layer(match self {
            Self::First | Self::Around => 0,
            Self::BehindFirst | Self::BehindAround => 1,
            Self::BehindLast => 2,
        })
    }

    /// Its image.
    fn place(self) -> usize {
        match self {
            Self::First => 0,
            Self::BehindFirst | Self::BehindLast => 1,
            Self::Around => 2,
            Self::BehindAround => 3,
        }
    }
}

/// Laid out as `Layer` in `g_buffer.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct LayerUniforms {
    /// Local units to clip space, for the camera that the reference depth was drawn with.
    pub reference: Mat4,
    /// The camera's right.
    pub right: Vec3,
    /// Distance of the near plane.
    pub near: f32,
    /// The camera's up.
    pub up: Vec3,
    /// The least distance between the layers, along the camera's axis.
    pub separation: f32,
    /// The camera's axis.
    pub forward: Vec3,
    /// Not used.
    pub spare: f32,
    /// See [`super::uniforms::ScreenUniforms`].
    pub ray_origin: Vec2,
    /// See [`super::uniforms::ScreenUniforms`].
    pub ray_step: Vec2,
}

/// Pipelines and uniforms.
pub(super) struct GBuffer {
    mesh_view: MeshView,
    layouts: Layouts,
    extra_layout: wgpu::BindGroupLayout,
    /// Of the picture, and of the one around.
    frames: [(wgpu::Buffer, wgpu::BindGroup); 2],
    layer: wgpu::Buffer,
    pub(super) materials: MaterialBuffer,
}

/// What tells the layers of a picture: each is found behind the depth that is bound.
pub(super) struct LayerGroups {
    behind_first: wgpu::BindGroup,
    behind_last: wgpu::BindGroup,
    behind_around: wgpu::BindGroup,
}

impl GBuffer {
    pub(super) fn new(device: &wgpu::Device, material_count: usize) -> Self {
        let layouts = Layouts::new(device);
        let visibility = wgpu::ShaderStages::FRAGMENT;
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let uniforms = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let depth = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let extra_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("layer"),
            entries: &[entry(0, uniforms), entry(1, depth)],
        });
        let buffer = |label, size: usize| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let frames = ["G-buffer frame", "frame around"].map(|label| {
            let frame = buffer(label, size_of::<FrameUniforms>());
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout: &layouts.frame,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }],
            });
            (frame, group)
        });
        let mut mesh_view = MeshView::new(device, &layouts);
        mesh_view.add_layers(device, &layouts, &extra_layout);
        Self {
            mesh_view,
            materials: MaterialBuffer::new(device, &layouts.material, material_count),
            layouts,
            extra_layout,
            frames,
            layer: buffer("G-buffer layer", size_of::<LayerUniforms>()),
        }
    }

    /// Another scene's materials.
    pub(super) fn set_material_count(&mut self, device: &wgpu::Device, count: usize) {
        self.materials = MaterialBuffer::new(device, &self.layouts.material, count);
    }

    /// Bindings of a picture's textures.
    pub(super) fn bind(&self, device: &wgpu::Device, targets: &Targets) -> LayerGroups {
        let group = |depth: &wgpu::TextureView| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("layer"),
                layout: &self.extra_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: self.layer.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(depth) },
                ],
            })
        };
        let last = targets.last_depth.create_view(&wgpu::TextureViewDescriptor::default());
        let [first, _, around, _] = &targets.depths.each;
        LayerGroups { behind_first: group(first), behind_last: group(&last), behind_around: group(around) }
    }

    /// Takes the camera of the next frame and that of the picture around, each with its columns and rows, and the one of the
    /// frame that `BehindLast` looks behind.
    pub(super) fn prepare(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        scene: &Scene,
        cameras: [(&Camera, [u32; 2]); 2],
        reference: Mat4,
        separation: f32,
    ) {
        for ((camera, size), (buffer, _)) in cameras.into_iter().zip(&self.frames) {
            let matrix = view_projection(camera, size[0].max(1) as f32 / size[1].max(1) as f32);
            let frame = FrameUniforms { view_projection: matrix, eye: camera.position, ..FrameUniforms::zeroed() };
            queue.write_buffer(buffer, 0, bytemuck::bytes_of(&frame));
        }
        let (camera, size) = cameras[0];
        let (ray_origin, ray_step) = rays(camera, size);
        let layer = LayerUniforms {
            reference,
            right: camera.right,
            near: NEAR,
            up: camera.up,
            separation,
            forward: camera.forward,
            spare: 0.0,
            ray_origin,
            ray_step,
        };
        queue.write_buffer(&self.layer, 0, bytemuck::bytes_of(&layer));
        for layer in [Layer::First, Layer::BehindFirst, Layer::BehindLast] {
            self.mesh_view.prepare(device, layer.variant(), scene, self.materials.materials());
        }
    }

    /// Draws a range of the triangles into a layer; clears it first if `clears`.
    pub(super) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (scene, mesh): (&Scene, &MeshBuffers),
        (targets, groups): (&Targets, &LayerGroups),
        (layer, triangles, clears): (Layer, Range<u32>, bool),
    ) {
        let place = layer.place();
        let color = |view| {
            let load = if clears { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
            let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        // Reversed depth: 0 is infinitely far.
        let load = if clears { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("G-buffer"),
            color_attachments: &[color(&targets.normals.each[place]), color(&targets.reflectances.each[place])],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depths.each[place],
                depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        let is_around = matches!(layer, Layer::Around | Layer::BehindAround);
        if is_around {
            let [width, height] = targets.surround.map(|pixels| pixels as f32);
            pass.set_viewport(0.0, 0.0, width, height, 0.0, 1.0);
        }
        let inputs = MeshInputs {
            scene,
            variant: layer.variant(),
            frame: &self.frames[usize::from(is_around)].1,
            // No fragment reads these two streams.
            irradiance: &mesh.positions,
            buried: &mesh.positions,
            materials: self.materials.materials(),
            material_group: &self.materials.group,
            // The first layer is drawn into the depth that the second is found behind.
            extra: Some(match layer {
                Layer::BehindFirst => &groups.behind_first,
                Layer::BehindAround => &groups.behind_around,
                _ => &groups.behind_last,
            }),
        };
        self.mesh_view.record(&mut pass, mesh, &inputs, (&mesh.triangles, triangles));
    }
}
