//! The pass that finds what each pixel sees: a visibility buffer (Burns and Hunt 2013, "The Visibility Buffer: A
//! Cache-Friendly Approach to Deferred Shading"). While only the field changes, [`super::resolve`] colours the pixels from
//! it, and no triangle is drawn.
//!
//! Inputs as those of [`super::mesh_view`], but for the streams: each triangle has corners of its own, in turn.

use wgpu::util::{BufferInitDescriptor, DeviceExt};

use super::{
    ViewGeometry,
    frame::FRAME_WGSL,
    mesh_buffers::MeshBuffers,
    mesh_view::{self, Layouts, MeshInputs, VERTEX_FIELD_WGSL},
    surface_pipelines::{SurfacePass, SurfacePipelines, surface_pipeline},
    targets::drawn_texture,
    variant::{SHADING_WGSL, Variant},
};
use crate::scene::{Material, Scene};

/// The shader.
pub const WGSL: &str = include_str!("visibility.wgsl");

/// Position, normal and texture coordinates of each triangle's corners, and at each the triangle's vertices.
pub(super) struct CornerStreams([wgpu::Buffer; 4]);

impl CornerStreams {
    /// Uploads the corners of a geometry.
    pub(super) fn new(device: &wgpu::Device, geometry: &ViewGeometry) -> Self {
        let corners = || geometry.indices.iter().flatten().map(|&vertex| vertex as usize);
        let buffer = |label, contents: &[u8]| {
            device.create_buffer_init(&BufferInitDescriptor {
                label: Some(label),
                contents,
                usage: wgpu::BufferUsages::VERTEX,
            })
        };
        let positions: Vec<_> = corners().map(|vertex| geometry.positions[vertex]).collect();
        let normals: Vec<_> = corners().map(|vertex| geometry.normals[vertex]).collect();
        let texcoords: Vec<_> = corners().map(|vertex| geometry.texcoords[vertex]).collect();
        let triangles: Vec<_> = geometry.indices.iter().flat_map(|triangle| [*triangle; 3]).collect();
        Self([
            buffer("corner positions", bytemuck::cast_slice(&positions)),
            buffer("corner normals", bytemuck::cast_slice(&normals)),
            buffer("corner texture coordinates", bytemuck::cast_slice(&texcoords)),
            buffer("corner vertices", bytemuck::cast_slice(&triangles)),
        ])
    }
}

/// What the pixels of a view see, as `Kept` in `visibility.wgsl` has it.
pub(super) struct SeenTargets {
    pub(super) views: [wgpu::TextureView; 3],
}

impl SeenTargets {
    const FORMATS: [wgpu::TextureFormat; 3] =
        [wgpu::TextureFormat::Rgba32Uint, wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Rgba16Float];

    pub(super) fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        Self { views: Self::FORMATS.map(|format| drawn_texture(device, "what pixels see", size, format)) }
    }
}

/// The streams of corners: bytes a corner, and format.
const STREAMS: [(u64, wgpu::VertexFormat); 4] = [
    (12, wgpu::VertexFormat::Float32x3),
    (8, wgpu::VertexFormat::Snorm16x4),
    (8, wgpu::VertexFormat::Float32x2),
    (12, wgpu::VertexFormat::Uint32x3),
];

/// The pass.
pub(super) struct Visibility {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    pipelines: SurfacePipelines,
}

impl Visibility {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let before = [FRAME_WGSL, SHADING_WGSL, mesh_view::WGSL, VERTEX_FIELD_WGSL].concat();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("visibility"),
            source: wgpu::ShaderSource::Wgsl(format!("{before}{WGSL}").into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("visibility"),
            bind_group_layouts: &[Some(&layouts.frame), Some(&layouts.material), Some(&layouts.textures)],
            immediate_size: 0,
        });
        Self { module, layout, pipelines: SurfacePipelines::default() }
    }

    /// Makes the pipelines that these materials need.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, variant: Variant, scene: &Scene, materials: &[Material]) {
        let (module, layout) = (&self.module, &self.layout);
        let (entries, targets) = (["seen_vertex", "keep"], &SeenTargets::FORMATS[..]);
        let pass = SurfacePass { label: "visibility", module, layout, entries, streams: &STREAMS, targets };
        self.pipelines.prepare(variant, (scene, materials), |variant| surface_pipeline(device, variant, &pass));
    }

    /// Draws all triangles into what pixels see.
    pub(super) fn record(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        mesh: &MeshBuffers,
        (inputs, corners): (&MeshInputs<'_>, &CornerStreams),
    ) {
        for (slot, stream) in (0..).zip(&corners.0) {
            pass.set_vertex_buffer(slot, stream.slice(..));
        }
        self.pipelines.draw_materials(pass, mesh, (inputs, &mesh.triangles), |pass, triangles| {
            pass.draw(3 * triangles.start..3 * triangles.end, 0..1);
        });
    }
}
