//! Triangles that a texture cuts holes into, as hemicubes draw them: a pixel is hidden where the ray tracer's ray is
//! ([`Scene::is_cut_out`]).

use glam::{Vec2, Vec3};
use wgpu::util::DeviceExt as _;

use super::pipelines::{FaceDraw, face_pipeline, module};
use crate::scene::{Scene, texture::TextureFilter};

/// A corner of such a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct CutoutVertex {
    position: Vec3,
    /// Number of the [`Mask`].
    mask: u32,
    texcoord: Vec2,
    /// What item buffers show of its triangle.
    item: u32,
}

/// A triangle of a surface that a texture cuts holes into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CutTriangle {
    /// Its number in item buffers.
    pub(super) item: u32,
    /// The scene's triangle that it is a part of.
    pub(super) scene_triangle: u32,
    /// Its corners.
    pub(super) corners: [Vec3; 3],
    /// And where they lie in the scene's triangle, in barycentric coordinates.
    pub(super) places: [Vec2; 3],
}

/// All triangles of a scene that have a mask.
fn of_scene(scene: &Scene) -> impl Iterator<Item = CutTriangle> + '_ {
    let masked = (0..scene.mesh.triangles.len() as u32).filter(|triangle| has_mask(scene, *triangle));
    masked.map(|triangle| CutTriangle {
        item: triangle,
        scene_triangle: triangle,
        corners: scene.mesh.corners(triangle),
        places: [Vec2::ZERO, Vec2::X, Vec2::Y],
    })
}

/// The opacity of a material, laid out as `Mask` in `cutouts.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Mask {
    /// Number of its first opacity.
    pub first: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 1 if the four opacities around a point are weighed bilinearly, 0 if the nearest decides.
    pub filtered: u32,
    /// What the texture's opacity is multiplied by.
    pub opacity: f32,
}

/// What a scene has of them: corners, a mask for every material (most of them empty), and the textures' opacities.
#[derive(Default)]
struct Cutouts {
    vertices: Vec<CutoutVertex>,
    masks: Vec<Mask>,
    opacities: Vec<u8>,
}

impl Cutouts {
    fn of(scene: &Scene, triangles: impl Iterator<Item = CutTriangle>) -> Self {
        let mut found = Self { masks: vec![Mask::default(); scene.materials.len()], ..Self::default() };
        for (material, mask) in scene.materials.iter().zip(&mut found.masks) {
            let Some(texture) = material.opacity_texture.map(|index| &scene.textures[index as usize]) else { continue };
            let (width, height) = texture.size();
            let filtered = u32::from(texture.filter == TextureFilter::Bilinear);
            let first = found.opacities.len() as u32;
            *mask = Mask { first, width, height, filtered, opacity: material.opacity };
            found.opacities.extend(texture.texels().iter().map(|texel| texel[3]));
        }
        for CutTriangle { item, scene_triangle, corners, places } in triangles {
            let mask = scene.mesh.material_indices[scene_triangle as usize];
            let places = places.map(|place| scene.mesh.texcoord(scene_triangle, place));
            let vertex = |(position, texcoord)| CutoutVertex { position, mask, texcoord, item };
            found.vertices.extend(corners.into_iter().zip(places).map(vertex));
        }
        found.opacities.resize(found.opacities.len().next_multiple_of(4), 0);
        found
    }
}

/// True for triangles that are drawn here, and not among those that hide all behind them.
pub(super) fn has_mask(scene: &Scene, triangle: u32) -> bool {
    scene.material(triangle).opacity_texture.is_some()
}

/// They, on the card.
pub(super) struct CutoutBuffers {
    vertices: wgpu::Buffer,
    vertex_count: u32,
    masks: wgpu::Buffer,
    opacities: wgpu::Buffer,
}

impl CutoutBuffers {
    /// Uploads what a scene has of them; none if it has none.
    pub(super) fn new(device: &wgpu::Device, scene: &Scene) -> Option<Self> {
        Self::of(device, scene, of_scene(scene))
    }

    /// Uploads some triangles, of materials with holes; none if there are none.
    pub(super) fn of(
        device: &wgpu::Device,
        scene: &Scene,
        triangles: impl Iterator<Item = CutTriangle>,
    ) -> Option<Self> {
        let found = Cutouts::of(scene, triangles);
        if found.vertices.is_empty() {
            return None;
        }
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("cut-outs"), contents, usage })
        };
        Some(Self {
            vertices: buffer(bytemuck::cast_slice(&found.vertices), wgpu::BufferUsages::VERTEX),
            vertex_count: found.vertices.len() as u32,
            masks: buffer(bytemuck::cast_slice(&found.masks), wgpu::BufferUsages::STORAGE),
            opacities: buffer(&found.opacities, wgpu::BufferUsages::STORAGE),
        })
    }

    /// Bytes on the card.
    pub(super) fn bytes(scene: &Scene) -> u64 {
        let opacities = scene.materials.iter().filter_map(|material| material.opacity_texture);
        let texels: usize = opacities.map(|texture| scene.textures[texture as usize].texels().len()).sum();
        let triangles = (0..scene.mesh.triangles.len() as u32).filter(|triangle| has_mask(scene, *triangle)).count();
        (texels + triangles * 3 * size_of::<CutoutVertex>()) as u64
    }
}

/// What draws them.
pub(super) struct CutoutPass {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

impl CutoutPass {
    /// `shader` is `cutouts.wgsl`, or another in its place; `fragment` as in [`FaceDraw`].
    pub(super) fn new(
        device: &wgpu::Device,
        shader: &str,
        buffers: &CutoutBuffers,
        fragment: (&str, Option<wgpu::TextureFormat>),
    ) -> Self {
        let attributes = [
            wgpu::VertexAttribute { format: wgpu::VertexFormat::Float32x3, offset: 0, shader_location: 0 },
            wgpu::VertexAttribute { format: wgpu::VertexFormat::Uint32, offset: 12, shader_location: 4 },
            wgpu::VertexAttribute { format: wgpu::VertexFormat::Float32x2, offset: 16, shader_location: 5 },
            wgpu::VertexAttribute { format: wgpu::VertexFormat::Uint32, offset: 24, shader_location: 6 },
        ];
        let draw = FaceDraw {
            label: "cut-outs",
            module: &module(device, "cutouts.wgsl", shader),
            vertex: (size_of::<CutoutVertex>(), &attributes),
            fragment: Some(fragment),
        };
        let pipeline = face_pipeline(device, &draw);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("cut-outs"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: buffers.masks.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: buffers.opacities.as_entire_binding() },
            ],
        });
        Self { pipeline, group }
    }

    /// Makes a pass draw them next, and says how many corners there are.
    pub(super) fn begin(&self, pass: &mut wgpu::RenderPass<'_>, buffers: &CutoutBuffers) -> u32 {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_vertex_buffer(0, buffers.vertices.slice(..));
        buffers.vertex_count
    }
}
