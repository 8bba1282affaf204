//! Which surfaces the pixels of a picture show.

use glam::Vec2;
use rayon::prelude::*;

use super::picture::first_front_face;
use crate::{
    scene::Camera,
    trace::{Hit, RayTracer},
};

/// What a ray through the middle of each pixel meets first, front sides only; row by row from the top. Distances are from
/// the eye.
pub fn visible_points(tracer: &impl RayTracer, camera: &Camera, [width, height]: [u32; 2]) -> Vec<Option<Hit>> {
    let size = Vec2::new(width as f32, height as f32);
    let hit = |pixel: u32| {
        let middle = Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        let direction = camera.direction(middle / size, size.x / size.y).normalize_or(camera.forward);
        first_front_face(tracer, camera.position, direction)
    };
    (0..width * height).into_par_iter().map(hit).collect()
}
