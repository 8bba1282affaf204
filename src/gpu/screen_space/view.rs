//! What a frame in screen space shows, and what is read back of it.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::uniforms::rays;
use crate::scene::{AreaLight, Camera, Material};

/// What is seen. A frame after one of the same view adds to it.
#[derive(Clone, Debug)]
pub struct ScreenView {
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels, at least 1.
    pub size: [u32; 2],
    /// The placed area light.
    pub light: Option<AreaLight>,
    /// The scene's materials, possibly edited.
    pub materials: Arc<Vec<Material>>,
}

impl ScreenView {
    pub(super) fn is_lit_as(&self, other: &Self) -> bool {
        self.light == other.light && Arc::ptr_eq(&self.materials, &other.materials)
    }

    /// True if a frame of one adds to a frame of the other.
    pub fn is_same(&self, other: &Self) -> bool {
        self.camera == other.camera && self.size == other.size && self.is_lit_as(other)
    }
}

/// The finished picture, pixel by pixel, row by row from the top: irradiance [W/m²].
#[derive(Clone, Debug, PartialEq)]
pub struct ScreenFields {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Depth along the camera's axis, in local units; 0 where there is nothing.
    pub depth: Vec<f32>,
    /// Depth of the second layer; empty without one.
    pub second_depth: Vec<f32>,
    /// Irradiance of the lights alone.
    pub direct: Vec<Vec3>,
    /// All irradiance.
    pub total: Vec<Vec3>,
    /// Ambient obscurance: 1 where nothing obscures, 0 where it is off.
    pub obscurance: Vec<f32>,
}

impl ScreenFields {
    /// The point that a pixel shows, rebuilt from its depth; none where there is nothing.
    pub fn position(&self, camera: &Camera, pixel: u32) -> Option<Vec3> {
        let depth = self.depth.get(pixel as usize).copied().filter(|depth| *depth > 0.0)?;
        let (origin, step) = rays(camera, self.size);
        let ray = origin + step * Vec2::new((pixel % self.size[0]) as f32, (pixel / self.size[0]) as f32);
        Some(camera.position + depth * (ray.x * camera.right + ray.y * camera.up + camera.forward))
    }
}

/// The least and the largest depth of a box's corners, not behind the camera.
pub(super) fn depths_of_box([low, high]: [Vec3; 2], camera: &Camera) -> [f32; 2] {
    let middle = (0.5 * (low + high) - camera.position).dot(camera.forward);
    let half = (0.5 * (high - low)).dot(camera.forward.abs());
    let nearest = (middle - half).max(0.0);
    [nearest, (middle + half).max(nearest + 1e-3 * half.max(1e-6))]
}
