//! A [`ViewGeometry`] on the card: streams that never change, shared by all views.

use std::sync::{Arc, OnceLock};

use wgpu::util::{BufferInitDescriptor, DeviceExt};

use super::{
    ViewGeometry, geometry::MaterialDraw, mesh_view::Layouts, textures::TextureGroups, visibility::CornerStreams,
};

/// Buffers and textures of a geometry.
pub struct MeshBuffers {
    pub(super) positions: wgpu::Buffer,
    pub(super) normals: wgpu::Buffer,
    pub(super) texcoords: wgpu::Buffer,
    pub(super) map_places: Option<wgpu::Buffer>,
    pub(super) triangles: Triangles,
    /// What takes the place of many triangles for a moment.
    pub(super) coarse: Option<Triangles>,
    pub(super) edges: wgpu::Buffer,
    pub(super) edge_count: u32,
    pub(super) textures: TextureGroups,
    /// Made when a view first needs them.
    pub(super) corners: OnceLock<CornerStreams>,
}

/// Triangles in the order of their materials.
pub(super) struct Triangles {
    pub(super) indices: wgpu::Buffer,
    pub(super) draws: Vec<MaterialDraw>,
}

impl Triangles {
    /// How many there are.
    pub(super) fn count(&self) -> u32 {
        self.draws.last().map_or(0, |draw| draw.triangles.end)
    }
}

impl MeshBuffers {
    /// Uploads a geometry, where there is no [`super::Viewer`] that has done so.
    pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, geometry: &Arc<ViewGeometry>) -> Arc<Self> {
        Arc::new(Self::new(device, queue, &Layouts::new(device).textures, geometry))
    }

    /// Uploads a geometry.
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        texture_layout: &wgpu::BindGroupLayout,
        geometry: &Arc<ViewGeometry>,
    ) -> Self {
        let buffer = |label, contents: &[u8], usage| {
            device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let vertex = wgpu::BufferUsages::VERTEX;
        let index = wgpu::BufferUsages::INDEX;
        let triangles = |indices: &[[u32; 3]], draws: &[MaterialDraw]| Triangles {
            indices: buffer("triangles", bytemuck::cast_slice(indices), index),
            draws: draws.to_vec(),
        };
        Self {
            positions: buffer("positions", bytemuck::cast_slice(&geometry.positions), vertex),
            normals: buffer("normals", bytemuck::cast_slice(&geometry.normals), vertex),
            texcoords: buffer("texture coordinates", bytemuck::cast_slice(&geometry.texcoords), vertex),
            map_places: (!geometry.map_places.is_empty())
                .then(|| buffer("map places", bytemuck::cast_slice(&geometry.map_places), vertex)),
            triangles: triangles(&geometry.indices, &geometry.draws),
            coarse: geometry.coarse.as_ref().map(|coarse| triangles(&coarse.indices, &coarse.draws)),
            edges: buffer("edges", bytemuck::cast_slice(&geometry.edges), index),
            edge_count: geometry.edges.len() as u32,
            textures: TextureGroups::new(device, queue, texture_layout, &geometry.scene),
            corners: OnceLock::new(),
        }
    }
}
