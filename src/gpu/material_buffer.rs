//! The uniforms of a scene's materials on the card, uploaded again when they are edited.

use std::sync::Arc;

use super::mesh_view::MaterialUniforms;
use crate::scene::{Material, Scene};

/// Bytes between the uniforms of two materials: WebGPU's largest `min_uniform_buffer_offset_alignment`.
pub(super) const MATERIAL_STRIDE: usize = 256;

/// One slice of a buffer for each material.
pub(super) struct MaterialBuffer {
    buffer: wgpu::Buffer,
    /// A slice, by its offset.
    pub(super) group: wgpu::BindGroup,
    /// The materials that were uploaded; none in a new buffer.
    source: Option<Arc<Vec<Material>>>,
    count: usize,
}

impl MaterialBuffer {
    /// For so many materials.
    pub(super) fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, count: usize) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("materials"),
            size: (MATERIAL_STRIDE * count.max(1)) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let one_material = wgpu::BufferBinding {
            buffer: &buffer,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<MaterialUniforms>() as u64),
        };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("materials"),
            layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::Buffer(one_material) }],
        });
        Self { buffer, group, source: None, count }
    }

    /// True if it has room for just so many materials.
    pub(super) fn is_for(&self, materials: &[Material]) -> bool {
        self.count == materials.len()
    }

    /// The materials that were uploaded.
    pub(super) fn materials(&self) -> &[Material] {
        self.source.as_deref().map_or(&[], Vec::as_slice)
    }

    /// Uploads materials of `scene`, as many as it is for, unless they are there: true if it did.
    pub(super) fn upload(&mut self, queue: &wgpu::Queue, scene: &Scene, materials: &Arc<Vec<Material>>) -> bool {
        if self.source.as_ref().is_some_and(|known| Arc::ptr_eq(known, materials)) {
            return false;
        }
        let mut bytes = vec![0; MATERIAL_STRIDE * self.count];
        for (place, material) in bytes.chunks_exact_mut(MATERIAL_STRIDE).zip(materials.iter()) {
            let uniforms = MaterialUniforms::new(scene, material);
            place[..size_of::<MaterialUniforms>()].copy_from_slice(bytemuck::bytes_of(&uniforms));
        }
        queue.write_buffer(&self.buffer, 0, &bytes);
        self.source = Some(Arc::clone(materials));
        true
    }
}
