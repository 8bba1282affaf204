//! What each function returns before it is written: harmless (finite, no panic) and plainly wrong.

use std::f32::consts::PI;

use glam::{Mat3, Vec2, Vec3};

use super::{Functions, LightSample};

/// The functions with nothing done. A function that answers like its neighbour in this table counts as not done.
pub const PLACEHOLDERS: Functions = Functions {
    // Every frame is the scene's own: all directions are taken about +z.
    form_basis: |_| Mat3::IDENTITY,
    // Every point is the middle of the disk.
    square_to_disk_polar: |_| Vec2::ZERO,
    disk_to_square_polar: |_| MIDDLE,
    square_to_disk_concentric: |_| Vec2::ZERO,
    disk_to_square_concentric: |_| MIDDLE,
    // Nothing in the program divides by this one; 1 is what a forgotten π gives.
    disk_pdf_area: |_| 0.0,
    // Every ray goes straight up.
    square_to_cosine_hemisphere: |_| Vec3::Z,
    // A division by 1 does no harm, and no density here is 1 everywhere.
    cosine_hemisphere_pdf_solid_angle: |_| 1.0,
    cosine_hemisphere_to_square: |_| MIDDLE,
    // A light that gives no light.
    sample_area_light: |light, _| LightSample { position: light.centre, normal: Vec3::ZERO, pdf_area: 0.0 },
    area_light_inverse: |_, _| MIDDLE,
    // Nothing is read from the triangle.
    interpolate_barycentric: |_, _| Vec3::ZERO,
    sample_texture: |_, _, _| Vec3::ZERO,
    surface_reflectance: |_, hit| hit.material.reflectance,
    // The normal as a colour: what a new student sees when the solver runs for the first time.
    direct_irradiance: |_, receiver| PI * (0.5 + 0.5 * receiver.normal()),
    indirect_irradiance: |_, _, _| Vec3::ZERO,
    stratified_point: |_, _, jitter| jitter,
    low_discrepancy_point: |_| MIDDLE,
    ray_tracer: |_| None,
};

const MIDDLE: Vec2 = Vec2::splat(0.5);
