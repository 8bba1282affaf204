//! The assignment: the functions of light transport that a student writes.
//!
//! Plain functions from values to values: no threads, no shared state, nothing to set up. Every sampler stands beside
//! its density and its inverse, so that each can be tested against the others (`tests/samplers.rs`):
//!
//! | file | functions | equation |
//! | --- | --- | --- |
//! | [`basis`] | a frame around a normal | turns the directions of eq. 4 |
//! | [`warp`] | square to disk to hemisphere | eq. 4 |
//! | [`light`] | points on the area light and on triangles | eq. 3 |
//!
//! The fourth function of this kind, barycentric interpolation, is [`crate::scene::mesh::interpolate`].
//!
//! A density says in its name what it is a density over: `pdf_area` per square of the scene's local unit,
//! `pdf_solid_angle` per steradian.

pub mod basis;
pub mod light;
pub mod warp;

pub use basis::form_basis;
pub use light::{
    LightSample, TriangleSample, area_light_inverse, sample_area_light, sample_triangle, triangle_inverse,
};
pub use warp::{
    cosine_hemisphere_pdf_solid_angle, cosine_hemisphere_to_square, disk_to_square_concentric,
    square_to_cosine_hemisphere, square_to_disk_concentric,
};
