//! The parts of a view that depend on its geometry: its own copy of the field, and its materials.

use std::{borrow::Cow, sync::Arc};

use glam::Vec3;

use super::{
    ViewFrame, ViewGeometry,
    material_buffer::MaterialBuffer,
    mesh_buffers::MeshBuffers,
    mesh_view::{Layouts, MeshInputs},
    variant::Variant,
};

/// The parts of a view that depend on its geometry.
pub(super) struct Contents {
    pub(super) geometry: Arc<ViewGeometry>,
    pub(super) mesh: Arc<MeshBuffers>,
    pub(super) irradiance: wgpu::Buffer,
    /// Of the field that is shown.
    field_version: Option<u64>,
    /// Of the field in `irradiance`.
    streamed_version: Option<u64>,
    buried: wgpu::Buffer,
    buried_source: Option<Arc<Vec<bool>>>,
    pub(super) materials: MaterialBuffer,
    /// The pages of a lightmap, bound.
    pub(super) pages: Option<(wgpu::Buffer, wgpu::BindGroup)>,
}

/// What of a frame is not what was shown.
pub(super) struct Changes {
    /// The field.
    pub(super) field: bool,
    /// Anything else.
    pub(super) more: bool,
}

impl Contents {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, mesh: Arc<MeshBuffers>, frame: &ViewFrame) -> Self {
        let buffer = |label, size: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let vertices = frame.geometry.vertex_count();
        Self {
            geometry: Arc::clone(&frame.geometry),
            mesh,
            irradiance: buffer("irradiance", vertices * size_of::<Vec3>(), wgpu::BufferUsages::VERTEX),
            field_version: None,
            streamed_version: None,
            buried: buffer("buried", vertices * size_of::<f32>(), wgpu::BufferUsages::VERTEX),
            buried_source: None,
            materials: MaterialBuffer::new(device, &layouts.material, frame.materials.len()),
            pages: None,
        }
    }

    /// What the passes over the elements are given.
    pub(super) fn inputs<'a>(
        &'a self,
        frame: &'a wgpu::BindGroup,
        (variant, has_map): (Variant, bool),
    ) -> MeshInputs<'a> {
        MeshInputs {
            scene: &self.geometry.scene,
            variant,
            frame,
            irradiance: &self.irradiance,
            buried: &self.buried,
            materials: self.materials.materials(),
            material_group: &self.materials.group,
            extra: self.pages.as_ref().map(|(_, group)| group).filter(|_| has_map),
        }
    }

    /// True if the frame's field is not the one that is shown.
    pub(super) fn take_field(&mut self, frame: &ViewFrame) -> bool {
        self.field_version.replace(frame.field_version) != Some(frame.field_version)
    }

    /// Uploads the frame's field for passes that draw triangles, unless it is there.
    pub(super) fn stream_field(&mut self, queue: &wgpu::Queue, frame: &ViewFrame) {
        if self.streamed_version.replace(frame.field_version) != Some(frame.field_version) {
            queue.write_buffer(&self.irradiance, 0, bytemuck::cast_slice(&self.field(frame)));
        }
    }

    /// The frame's field at the vertices on the card.
    pub(super) fn field<'a>(&self, frame: &'a ViewFrame) -> Cow<'a, [Vec3]> {
        if self.geometry.copies.is_empty() && frame.field.len() == self.geometry.field_len {
            Cow::Borrowed(&frame.field)
        } else {
            Cow::Owned(self.geometry.expand(&frame.field))
        }
    }

    /// A new buffer holds zeros: nothing is buried.
    pub(super) fn upload_buried(&mut self, queue: &wgpu::Queue, frame: &ViewFrame) -> bool {
        let same = match (&self.buried_source, &frame.buried) {
            (None, None) => true,
            (Some(known), Some(wanted)) => Arc::ptr_eq(known, wanted),
            _ => false,
        };
        if same {
            return false;
        }
        self.buried_source = frame.buried.clone();
        let flags = self.buried_source.as_deref().map_or(&[][..], Vec::as_slice);
        let flags: Vec<f32> =
            self.geometry.expand(flags).into_iter().map(|buried| f32::from(u8::from(buried))).collect();
        queue.write_buffer(&self.buried, 0, bytemuck::cast_slice(&flags));
        true
    }

    pub(super) fn upload_materials(&mut self, queue: &wgpu::Queue, frame: &ViewFrame) -> bool {
        self.materials.upload(queue, &self.geometry.scene, &frame.materials)
    }
}
