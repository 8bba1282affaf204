//! The assignment: the functions of light transport that a student writes.
//!
//! Plain functions from values to values: no threads, no shared state, nothing to set up. Every sampler stands beside
//! its density and its inverse, so that each can be tested against the others:
//!
//! | file | functions | equation |
//! | --- | --- | --- |
//! | [`basis`] | a frame around a normal | turns the directions of eq. 4 |
//! | [`warp`] | square to disk to hemisphere | eq. 4 |
//! | [`hemicube`] | weights of a hemicube's pixels | eq. 8 |
//! | [`light`] | points on the area light | eq. 3 |
//! | [`barycentric`] | values between the corners of a triangle | eq. 4 |
//! | [`texture`] | the colour of a texel | eq. 4 |
//! | [`irradiance`] | direct and indirect irradiance at a point | eq. 3 and 4 |
//! | [`points`] | extra: stratified points, points of low discrepancy | |
//! | [`tracer`] | for pleasure: a ray tracer | |
//!
//! [`world`] is given: the scene as [`irradiance`] sees it. `radiosity check` tests the functions and names the mistake;
//! `radiosity solve --engine student`, and the window's switch, compute with them. Both take them as a table,
//! [`Functions`], so that other versions can be tested as well. Before a function is written it returns what
//! [`PLACEHOLDERS`] returns (or calls `todo!()`).
//!
//! A density says in its name what it is a density over: `pdf_area` per square of the scene's local unit,
//! `pdf_solid_angle` per steradian.

pub mod barycentric;
pub mod basis;
pub mod hemicube;
pub mod irradiance;
pub mod light;
pub mod placeholder;
pub mod points;
pub mod texture;
pub mod tracer;
pub mod warp;
pub mod world;

use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use crate::{
    scene::{AreaLight, Scene},
    trace::RayTracer,
};

pub use barycentric::interpolate_barycentric;
pub use basis::form_basis;
pub use hemicube::{HemicubeFace, delta_form_factor};
pub use irradiance::{direct_irradiance, indirect_irradiance, surface_reflectance};
pub use light::{LightSample, area_light_inverse, sample_area_light};
pub use placeholder::PLACEHOLDERS;
pub use points::{low_discrepancy_point, stratified_point};
pub use texture::sample_texture;
pub use tracer::ray_tracer;
pub use warp::{
    cosine_hemisphere_pdf_solid_angle, cosine_hemisphere_to_square, disk_pdf_area, disk_to_square_concentric,
    disk_to_square_polar, square_to_cosine_hemisphere, square_to_disk_concentric, square_to_disk_polar,
};
pub use world::{Receiver, SurfaceHit, World};

/// From a texture's size, its texels and texture coordinates to a colour.
pub type SampleTexture = fn((u32, u32), &[[u8; 4]], Vec2) -> Vec3;

/// One version of every function of the assignment. What each must do is written at the function of the same name in
/// this module.
#[derive(Clone, Copy, Debug)]
pub struct Functions {
    /// See [`form_basis`].
    pub form_basis: fn(Vec3) -> Mat3,
    /// See [`square_to_disk_polar`].
    pub square_to_disk_polar: fn(Vec2) -> Vec2,
    /// See [`disk_to_square_polar`].
    pub disk_to_square_polar: fn(Vec2) -> Vec2,
    /// See [`square_to_disk_concentric`].
    pub square_to_disk_concentric: fn(Vec2) -> Vec2,
    /// See [`disk_to_square_concentric`].
    pub disk_to_square_concentric: fn(Vec2) -> Vec2,
    /// See [`disk_pdf_area`].
    pub disk_pdf_area: fn(Vec2) -> f32,
    /// See [`square_to_cosine_hemisphere`].
    pub square_to_cosine_hemisphere: fn(Vec2) -> Vec3,
    /// See [`cosine_hemisphere_pdf_solid_angle`].
    pub cosine_hemisphere_pdf_solid_angle: fn(Vec3) -> f32,
    /// See [`cosine_hemisphere_to_square`].
    pub cosine_hemisphere_to_square: fn(Vec3) -> Vec2,
    /// See [`sample_area_light`].
    pub sample_area_light: fn(&AreaLight, Vec2) -> LightSample,
    /// See [`area_light_inverse`].
    pub area_light_inverse: fn(&AreaLight, Vec3) -> Vec2,
    /// See [`interpolate_barycentric`].
    pub interpolate_barycentric: fn([Vec3; 3], Vec2) -> Vec3,
    /// See [`sample_texture`].
    pub sample_texture: SampleTexture,
    /// See [`surface_reflectance`].
    pub surface_reflectance: fn(&World, &SurfaceHit) -> Vec3,
    /// See [`direct_irradiance`].
    pub direct_irradiance: fn(&World, &Receiver) -> Vec3,
    /// See [`indirect_irradiance`].
    pub indirect_irradiance: fn(&World, &Receiver, &[&[Vec3]]) -> Vec3,
    /// See [`stratified_point`].
    pub stratified_point: fn(u32, u32, Vec2) -> Vec2,
    /// See [`low_discrepancy_point`].
    pub low_discrepancy_point: fn(u32) -> Vec2,
    /// See [`ray_tracer`](fn@ray_tracer).
    pub ray_tracer: fn(&Arc<Scene>) -> Option<Box<dyn RayTracer>>,
}

/// The functions of this module.
pub const FUNCTIONS: Functions = Functions {
    form_basis,
    square_to_disk_polar,
    disk_to_square_polar,
    square_to_disk_concentric,
    disk_to_square_concentric,
    disk_pdf_area,
    square_to_cosine_hemisphere,
    cosine_hemisphere_pdf_solid_angle,
    cosine_hemisphere_to_square,
    sample_area_light,
    area_light_inverse,
    interpolate_barycentric,
    sample_texture,
    surface_reflectance,
    direct_irradiance,
    indirect_irradiance,
    stratified_point,
    low_discrepancy_point,
    ray_tracer,
};
