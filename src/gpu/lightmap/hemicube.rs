//! The pass that draws depth on the faces of many hemicubes into one atlas.
//!
//! A hemicube of n pixels is a tile of n columns and 3 n rows: the top, then the upper halves of the four sides. Which
//! shooter a tile belongs to is decided on the card: the vertex shader reads the face's matrix by instance.

use std::ops::Range;

use glam::Vec2;

use super::{
    cutouts::{CutoutBuffers, CutoutPass},
    hemisphere::{self, HemispherePass},
    item_buffer::ITEM_FORMAT,
    pipelines::{FaceDraw, POSITIONS, face_pipeline, module},
    shaders::Shaders,
};
use crate::{
    gpu::targets::drawn_texture,
    lightmap::Visibility,
    scene::Scene,
    student::hemicube::{HemicubeFace, delta_form_factor},
};

/// Faces of a hemicube.
pub const FACE_COUNT: u32 = 5;

/// Distance of the near plane [local units]: nearer surfaces are not seen.
pub const NEAR: f32 = 1e-4;

/// The delta form factor (eq. 8) of each pixel of a tile, row by row, as the student's function has it.
pub fn delta_form_factors(resolution: u32) -> Vec<f32> {
    let pixel_side = 2.0 / resolution as f32;
    let pixel = |index: u32| {
        let (column, row) = (index % resolution, index / resolution);
        let across = (column as f32 + 0.5) * pixel_side - 1.0;
        if row < resolution {
            let up = 1.0 - (row as f32 + 0.5) * pixel_side;
            delta_form_factor(HemicubeFace::Top, Vec2::new(across, up), pixel_side * pixel_side)
        } else {
            let height = 1.0 - ((row - resolution) % (resolution / 2)) as f32 * pixel_side - 0.5 * pixel_side;
            delta_form_factor(HemicubeFace::Side, Vec2::new(across, height), pixel_side * pixel_side)
        }
    };
    (0..3 * resolution * resolution).map(pixel).collect()
}

/// Where tiles lie in the atlas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileLayout {
    /// Pixels along a hemicube's top: even.
    pub resolution: u32,
    /// Tiles side by side.
    pub tiles_per_row: u32,
    /// Tiles.
    pub slots: u32,
}

impl TileLayout {
    /// At most `slots` tiles, as many as fit a texture of `most` pixels a side.
    pub fn new(resolution: u32, slots: u32, most: u32) -> Self {
        let tiles_per_row = (most / resolution).min(slots.isqrt() * 2).max(1);
        let rows = slots.div_ceil(tiles_per_row).min(most / (3 * resolution)).max(1);
        Self { resolution, tiles_per_row, slots: slots.min(rows * tiles_per_row) }
    }

    /// Pixels of the atlas.
    pub fn size(&self) -> [u32; 2] {
        let rows = self.slots.div_ceil(self.tiles_per_row);
        [self.tiles_per_row * self.resolution, 3 * rows * self.resolution]
    }

    /// First column and row, width and height of a face.
    pub fn viewport(&self, slot: u32, face: u32) -> [u32; 4] {
        let (column, row) = (slot % self.tiles_per_row, slot / self.tiles_per_row);
        let corner = [column * self.resolution, 3 * row * self.resolution];
        let half = self.resolution / 2;
        match face {
            0 => [corner[0], corner[1], self.resolution, self.resolution],
            _ => [corner[0], corner[1] + self.resolution + (face - 1) * half, self.resolution, half],
        }
    }

    /// Makes a pass draw into the place of one instance: face `instance` % 5 of slot `instance` / 5.
    pub(super) fn aim(&self, pass: &mut wgpu::RenderPass<'_>, instance: u32) {
        let [x, y, width, height] = self.viewport(instance / FACE_COUNT, instance % FACE_COUNT);
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, width, height);
    }
}

/// Triangles of a part of a scene, at most: a software driver takes some 3 ms for them.
const MOST_TRIANGLES: u32 = 32_768;

/// The scene's triangles as the pass draws them.
pub struct SceneBuffers {
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    pub(in crate::gpu) index_count: u32,
    /// It is drawn in so many parts, so that no submission has to hold more than one of them.
    pub(super) parts: u32,
    cutouts: Option<CutoutBuffers>,
    /// What hemispheres show; none if there are to be none.
    corners: Option<wgpu::Buffer>,
}

impl SceneBuffers {
    /// Bytes of a scene's triangles on the card.
    pub(super) fn bytes(scene: &Scene) -> u64 {
        12 * (scene.mesh.positions.len() + scene.mesh.triangles.len()) as u64 + CutoutBuffers::bytes(scene)
    }

    /// Uploads the triangles that hide what lies behind them.
    pub fn new(device: &wgpu::Device, scene: &Scene, visibility: Visibility) -> Self {
        let triangles = (0..scene.mesh.triangles.len() as u32).filter(|triangle| !scene.may_be_cut_out(*triangle));
        let indices: Vec<u32> = triangles.flat_map(|triangle| scene.mesh.triangles[triangle as usize]).collect();
        let buffer = |label, bytes: &[u8], usage| {
            wgpu::util::DeviceExt::create_buffer_init(
                device,
                &wgpu::util::BufferInitDescriptor { label: Some(label), contents: bytes, usage },
            )
        };
        Self {
            positions: buffer("positions", bytemuck::cast_slice(&scene.mesh.positions), wgpu::BufferUsages::VERTEX),
            index_count: indices.len() as u32,
            parts: (scene.mesh.triangles.len() as u32).div_ceil(MOST_TRIANGLES).max(1),
            indices: buffer("indices", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            cutouts: CutoutBuffers::new(device, scene),
            corners: (visibility == Visibility::Hemisphere).then(|| hemisphere::corners(device, scene)),
        }
    }
}

impl SceneBuffers {
    /// Draws of so many faces: each part of the scene on each.
    pub(in crate::gpu) fn draws(&self, faces: u32) -> u32 {
        faces * self.parts
    }

    /// The corners of one part, out of so many.
    pub(super) fn corners_of_part(&self, corners: u32, part: u32) -> Range<u32> {
        let first = |part: u32| (u64::from(corners / 3) * u64::from(part) / u64::from(self.parts)) as u32 * 3;
        first(part)..first(part + 1)
    }
}

/// The numbers of a scene's sides, or items.
fn side_format(scene: &SceneBuffers) -> wgpu::TextureFormat {
    if scene.corners.is_some() { ITEM_FORMAT } else { wgpu::TextureFormat::R8Uint }
}

/// The pipeline and the atlas that it draws into.
pub struct HemicubePass {
    /// Where tiles lie.
    pub layout: TileLayout,
    /// The atlas's depth.
    pub depth: wgpu::TextureView,
    /// What its pixels show: 1 for a front, or on hemispheres the item of a triangle; 0 for a back face and for nothing.
    pub(super) sides: Option<wgpu::TextureView>,
    /// Drawn instead of hemicubes.
    pub(super) hemispheres: Option<HemispherePass>,
    pipeline: wgpu::RenderPipeline,
    cutouts: Option<CutoutPass>,
}

impl HemicubePass {
    /// Makes an atlas of depth, for one scene.
    pub(in crate::gpu) fn new(
        device: &wgpu::Device,
        shaders: &Shaders,
        scene: &SceneBuffers,
        layout: TileLayout,
    ) -> Self {
        let depth = drawn_texture(device, "hemicubes", layout.size(), wgpu::TextureFormat::Depth32Float);
        Self::of(device, shaders, scene, (layout, depth, None))
    }

    /// Makes an atlas of depth and sides.
    pub(super) fn with_sides(
        device: &wgpu::Device,
        shaders: &Shaders,
        scene: &SceneBuffers,
        layout: TileLayout,
    ) -> Self {
        let depth = drawn_texture(device, "hemicubes", layout.size(), wgpu::TextureFormat::Depth32Float);
        let sides = drawn_texture(device, "sides", layout.size(), side_format(scene));
        Self::of(device, shaders, scene, (layout, depth, Some(sides)))
    }

    /// The same with other shaders.
    pub(super) fn reloaded(&self, device: &wgpu::Device, shaders: &Shaders, scene: &SceneBuffers) -> Self {
        Self::of(device, shaders, scene, (self.layout, self.depth.clone(), self.sides.clone()))
    }

    fn of(
        device: &wgpu::Device,
        shaders: &Shaders,
        scene: &SceneBuffers,
        (layout, depth, sides): (TileLayout, wgpu::TextureView, Option<wgpu::TextureView>),
    ) -> Self {
        let format = sides.as_ref().map(|_| side_format(scene));
        let draw = FaceDraw {
            label: "hemicubes",
            module: &module(device, "hemicube.wgsl", &shaders.hemicube),
            vertex: POSITIONS,
            fragment: format.map(|format| ("write_side", Some(format))),
        };
        let cut_out = if format.is_some() { "cut_out_side" } else { "cut_out" };
        let cutouts =
            scene.cutouts.as_ref().map(|buffers| CutoutPass::new(device, &shaders.cutouts, buffers, (cut_out, format)));
        let hemispheres = scene.corners.as_ref().map(|corners| HemispherePass::new(device, shaders, corners));
        Self { layout, depth, sides, hemispheres, pipeline: face_pipeline(device, &draw), cutouts }
    }

    /// Draws parts of the scene on faces, by their number (5 faces a hemicube, [`SceneBuffers::draws`]), with the matrices
    /// in `faces`; first clears all faces if `clears`.
    pub(in crate::gpu) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        faces: &wgpu::Buffer,
        (drawn, clears): (Range<u32>, bool),
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let load = if clears { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        let load_sides = if clears { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
        let sides = self.sides.as_ref().map(|view| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: load_sides, store: wgpu::StoreOp::Store },
        });
        let sides: Vec<_> = sides.into_iter().map(Some).collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("hemicubes"),
            color_attachments: &sides,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        if let Some(hemispheres) = &self.hemispheres {
            hemispheres.draw(&mut pass, self.layout, (scene, faces), drawn);
            return;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_vertex_buffer(0, scene.positions.slice(..));
        pass.set_vertex_buffer(1, faces.slice(..));
        pass.set_index_buffer(scene.indices.slice(..), wgpu::IndexFormat::Uint32);
        for draw in drawn.clone() {
            let (instance, part) = (draw / scene.parts, draw % scene.parts);
            self.layout.aim(&mut pass, instance);
            pass.draw_indexed(scene.corners_of_part(scene.index_count, part), 0, instance..instance + 1);
        }
        if let (Some(cutouts), Some(buffers)) = (&self.cutouts, &scene.cutouts) {
            let corners = cutouts.begin(&mut pass, buffers);
            for draw in drawn {
                let (instance, part) = (draw / scene.parts, draw % scene.parts);
                self.layout.aim(&mut pass, instance);
                pass.draw(scene.corners_of_part(corners, part), instance..instance + 1);
            }
        }
    }
}
