//! Hemispheres instead of hemicubes: one drawing of triangles' numbers a shooter, with edges that are not bent as they should
//! be (Coombe and Harris 2005, "Global Illumination Using Progressive Refinement Radiosity", GPU Gems 2).

use glam::Vec3;
use wgpu::util::DeviceExt as _;

use super::{
    hemicube::{FACE_COUNT, SceneBuffers, TileLayout},
    item_buffer::ITEM_FORMAT,
    pipelines::{FaceDraw, POSITIONS, face_pipeline, module},
    shaders::Shaders,
};
use crate::scene::Scene;

/// What each pixel of a tile counts: of the pixels in the circle one as much as another (Nusselt's analogue); they sum to 1.
pub fn pixel_weights(resolution: u32) -> Vec<f32> {
    let place = |index: u32| (index as f32 + 0.5) / resolution as f32 * 2.0 - 1.0;
    let is_inside = |pixel: u32| {
        let (column, row) = (pixel % resolution, pixel / resolution);
        row < resolution && place(column).hypot(place(row)) < 1.0
    };
    let pixels = 0..3 * resolution * resolution;
    let count = pixels.clone().filter(|pixel| is_inside(*pixel)).count();
    pixels.map(|pixel| if is_inside(pixel) { 1.0 / count as f32 } else { 0.0 }).collect()
}

/// The scene's triangles, three corners of its own for each.
pub(super) fn corners(device: &wgpu::Device, scene: &Scene) -> wgpu::Buffer {
    let triangles = 0..scene.mesh.triangles.len() as u32;
    let corners: Vec<[Vec3; 3]> = triangles.map(|triangle| scene.mesh.corners(triangle)).collect();
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("corners"),
        contents: bytemuck::cast_slice(&corners),
        usage: wgpu::BufferUsages::VERTEX,
    })
}

/// The pipeline.
pub(super) struct HemispherePass {
    corners: wgpu::Buffer,
    pipeline: wgpu::RenderPipeline,
}

impl HemispherePass {
    /// For the corners of a scene.
    pub(super) fn new(device: &wgpu::Device, shaders: &Shaders, corners: &wgpu::Buffer) -> Self {
        Self { corners: corners.clone(), pipeline: pipeline(device, shaders) }
    }

    /// Draws one hemisphere for the five faces of each hemicube.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        layout: TileLayout,
        (scene, faces): (&SceneBuffers, &wgpu::Buffer),
        drawn: std::ops::Range<u32>,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_vertex_buffer(0, self.corners.slice(..));
        pass.set_vertex_buffer(1, faces.slice(..));
        let corner_count = (self.corners.size() / size_of::<Vec3>() as u64) as u32;
        for draw in drawn.filter(|draw| (draw / scene.parts).is_multiple_of(FACE_COUNT)) {
            let (instance, part) = (draw / scene.parts, draw % scene.parts);
            layout.aim(pass, instance);
            pass.draw(scene.corners_of_part(corner_count, part), instance..instance + 1);
        }
    }
}

fn pipeline(device: &wgpu::Device, shaders: &Shaders) -> wgpu::RenderPipeline {
    face_pipeline(
        device,
        &FaceDraw {
            label: "hemispheres",
            module: &module(device, "hemisphere.wgsl", &shaders.hemisphere),
            vertex: POSITIONS,
            fragment: Some(("write_item", Some(ITEM_FORMAT))),
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_of_a_circle_are_those_whose_middles_lie_in_it_and_sum_to_one() {
        for resolution in [16, 64, 256] {
            let weights = pixel_weights(resolution);
            let inside = weights.iter().filter(|weight| **weight > 0.0).count();
            // Twice the distances of the pixels' middles from the circle's, in whole numbers.
            let middles = || (0..resolution).map(|pixel| (2 * pixel + 1).abs_diff(resolution).pow(2));
            let is_inside = |square: &u32| *square < resolution * resolution;
            let expected = middles().flat_map(|x| middles().map(move |y| x + y)).filter(is_inside).count();
            assert_eq!(inside, expected, "{resolution}");
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-3);
        }
    }
}
