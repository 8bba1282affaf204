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
    frame: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    layer: wgpu::Buffer,
    pub(super) materials: MaterialBuffer,
}

/// What tells the layers of a picture: each is found behind the depth that is bound.
pub(super) struct LayerGroups {
    behind_first: wgpu::BindGroup,
    behind_last: wgpu::BindGroup,
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
        let frame = buffer("G-buffer frame", size_of::<FrameUniforms>());
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("G-buffer frame"),
            layout: &layouts.frame,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }],
        });
        let mut mesh_view = MeshView::new(device, &layouts);
        mesh_view.add_layers(device, &layouts, &extra_layout);
        Self {
            mesh_view,
            materials: MaterialBuffer::new(device, &layouts.material, material_count),
            layouts,
            extra_layout,
            frame,
            frame_group,
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
        LayerGroups { behind_first: group(&targets.depths.each[0]), behind_last: group(&last) }
    }

    /// Takes the camera of the next frame, and the one of the frame that `BehindLast` looks behind.
    pub(super) fn prepare(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        scene: &Scene,
        (camera, size): (&Camera, [u32; 2]),
        reference: Mat4,
        separation: f32,
    ) {
        let matrix = view_projection(camera, size[0] as f32 / size[1] as f32);
        let frame = FrameUniforms { view_projection: matrix, eye: camera.position, ..FrameUniforms::zeroed() };
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
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
            self.mesh_view.prepare(device, Variant::of_layer(layer as u32), scene, self.materials.materials());
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
        let place = usize::from(layer != Layer::First);
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
        let inputs = MeshInputs {
            scene,
            variant: Variant::of_layer(layer as u32),
            frame: &self.frame_group,
            // No fragment reads these two streams.
            irradiance: &mesh.positions,
            buried: &mesh.positions,
            materials: self.materials.materials(),
            material_group: &self.materials.group,
            // The first layer is drawn into the depth that the second is found behind.
            extra: Some(if layer == Layer::BehindFirst { &groups.behind_first } else { &groups.behind_last }),
        };
        self.mesh_view.record(&mut pass, mesh, &inputs, (&mesh.triangles, triangles));
    }
}
