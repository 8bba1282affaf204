//! The uniforms that all passes over the picture's pixels share.

use glam::{Vec2, Vec3};

use super::{settings::ScreenSettings, targets::kept_words};
use crate::{gpu::projection::NEAR, scene::Camera};

/// What all shaders of this folder but `g_buffer.wgsl` begin with.
pub const SCREEN_WGSL: &str = include_str!("screen.wgsl");

/// A rise, as a part of the depth, that obscures nothing: the G-buffer's own rounding.
const OBSCURANCE_SLOPE: f32 = 1e-3;

/// Laid out as `Screen` in `screen.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ScreenUniforms {
    /// Pixels.
    pub size: [u32; 2],
    /// Layers of the G-buffer.
    pub layers: u32,
    /// Frames since anything moved.
    pub still: u32,
    /// The view ray through the middle of pixel p is (`ray_origin` + p `ray_step`, 1): x to the right, y up, z the depth.
    pub ray_origin: Vec2,
    /// Its change from pixel to pixel.
    pub ray_step: Vec2,
    /// The camera's right.
    pub right: Vec3,
    /// Distance of the near plane.
    pub near: f32,
    /// The camera's up.
    pub up: Vec3,
    /// Area of a pixel at depth 1.
    pub pixel_area: f32,
    /// The camera's axis.
    pub forward: Vec3,
    /// Taps of the spiral.
    pub taps: u32,
    /// Eye point.
    pub eye: Vec3,
    /// The spiral's radius in pixels.
    pub radius: f32,
    /// The filter's radius in pixels.
    pub filter_radius: f32,
    /// The distance from a plane, as a part of the depth, that the filter stops at.
    pub filter_depth: f32,
    /// Radius of the obscurance, in local units.
    pub obscurance_radius: f32,
    /// Taps of the obscurance.
    pub obscurance_taps: u32,
    /// Magnitude of the obscurance.
    pub obscurance_strength: f32,
    /// The least rise that obscures, as a part of the depth.
    pub obscurance_slope: f32,
    /// See [`ScreenSettings::unseen`].
    pub unseen: f32,
    /// 1: what the first bounce's taps count for is kept for the others.
    pub keeps: u32,
    /// First pixel of this submission, of all layers, or of those on the grid.
    pub first: u32,
    /// Pixel after the last one.
    pub end: u32,
    /// See [`ScreenSettings::every`].
    pub every: u32,
    /// See [`ScreenSettings::thickness`]; in local units.
    pub thickness: f32,
    /// The picture around: its rays, as for the picture.
    pub surround_origin: Vec2,
    /// Their change from pixel to pixel.
    pub surround_step: Vec2,
    /// Its columns and rows; 0 if there is none.
    pub surround_size: [u32; 2],
    /// See [`ScreenSettings::surround`]; 1 if there is none.
    pub surround: f32,
    /// Not used.
    pub spare: f32,
    /// Columns and rows of the grid.
    pub grid: [u32; 2],
    /// Not used.
    pub spare_too: [u32; 2],
}

impl ScreenUniforms {
    /// For one camera; `scene_size` is the scene's largest extent in local units.
    pub fn new(camera: &Camera, size: [u32; 2], settings: &ScreenSettings, still: u32, scene_size: f32) -> Self {
        let pixels = Vec2::new(size[0] as f32, size[1] as f32);
        let (ray_origin, ray_step) = rays(camera, size);
        let surround_size = settings.surround_size(size);
        let surround = if surround_size == [0; 2] { 1.0 } else { settings.surround };
        let (surround_origin, surround_step) =
            rays(&wider(camera, surround), surround_size.map(|pixels| pixels.max(1)));
        Self {
            size,
            layers: settings.layers(),
            still,
            ray_origin,
            ray_step,
            right: camera.right,
            near: NEAR,
            up: camera.up,
            pixel_area: (ray_step.x * ray_step.y).abs(),
            forward: camera.forward,
            taps: settings.taps,
            eye: camera.position,
            radius: settings.radius * pixels.length(),
            filter_radius: settings.filter_radius(still) as f32,
            filter_depth: settings.filter_depth,
            obscurance_radius: settings.obscurance_radius * scene_size,
            obscurance_taps: settings.obscurance,
            obscurance_strength: settings.obscurance_strength,
            obscurance_slope: OBSCURANCE_SLOPE,
            unseen: settings.unseen,
            keeps: u32::from(kept_words(settings, size) > 0),
            every: settings.every,
            thickness: settings.thickness * scene_size,
            surround_origin,
            surround_step,
            surround_size,
            surround,
            grid: settings.grid(size),
            ..Self::default()
        }
    }
}

/// A camera that sees so many times as wide and high.
pub fn wider(camera: &Camera, times: f32) -> Camera {
    Camera { tan_half_fov: times * camera.tan_half_fov, ..*camera }
}

/// The view ray through the middle of the first pixel at depth 1, and its change from pixel to pixel.
pub fn rays(camera: &Camera, [width, height]: [u32; 2]) -> (Vec2, Vec2) {
    let (width, height) = (width as f32, height as f32);
    let half = camera.tan_half_fov * Vec2::new(width / height, 1.0);
    let origin = Vec2::new(1.0 / width - 1.0, 1.0 - 1.0 / height) * half;
    (origin, Vec2::new(2.0 / width, -2.0 / height) * half)
}
