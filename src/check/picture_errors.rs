//! How far a picture's irradiance is from a solution's, over the pixels that show something (7.1, with pixels for points).

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::metrics::{Field, field_errors, relative_l2};
use crate::{render::visible_points, scene::Camera, trace::RayTracer};

/// What a solution says arrives at the points that a picture shows.
#[derive(Clone, Debug)]
pub struct PictureTruth {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Pixels that show something.
    pixels: Vec<usize>,
    direct: Vec<DVec3>,
    total: Vec<DVec3>,
}

/// Errors of a picture over the pixels that show something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PictureErrors {
    /// So many pixels.
    pub pixels: usize,
    /// All light: `sqrt(mean |E - E_truth|²) / mean(E_truth)`.
    pub total: f64,
    /// Indirect light, relative to the mean of all true light.
    pub indirect: f64,
    /// Indirect light, relative to its own true mean.
    pub indirect_by_itself: f64,
    /// Ratio of the means of all light, minus 1.
    pub bias: f64,
    /// Difference of the means of indirect light over its own true mean.
    pub indirect_bias: f64,
}

impl PictureTruth {
    /// Reads a solution at what the middles of a picture's pixels show: `irradiance` gives direct and all irradiance
    /// [W/m²] at a point of a scene triangle.
    pub fn new(
        tracer: &impl RayTracer,
        camera: &Camera,
        size: [u32; 2],
        irradiance: impl Fn(u32, Vec2) -> (Vec3, Vec3) + Sync,
    ) -> Self {
        let hits = visible_points(tracer, camera, size);
        let seen: Vec<_> = hits.iter().enumerate().filter_map(|(pixel, hit)| Some((pixel, (*hit)?))).collect();
        let values: Vec<(Vec3, Vec3)> =
            seen.par_iter().map(|(_, hit)| irradiance(hit.triangle, hit.barycentric)).collect();
        Self {
            size,
            pixels: seen.into_iter().map(|(pixel, _)| pixel).collect(),
            direct: values.iter().map(|(direct, _)| direct.as_dvec3()).collect(),
            total: values.iter().map(|(_, total)| total.as_dvec3()).collect(),
        }
    }

    /// All irradiance, pixel by pixel; 0 where nothing is shown.
    pub fn total(&self) -> Vec<Vec3> {
        let mut picture = vec![Vec3::ZERO; (self.size[0] * self.size[1]) as usize];
        self.pixels.iter().zip(&self.total).for_each(|(pixel, value)| picture[*pixel] = value.as_vec3());
        picture
    }

    /// The errors of a picture of the same size: direct and all irradiance [W/m²], pixel by pixel.
    pub fn errors(&self, direct: &[Vec3], total: &[Vec3]) -> PictureErrors {
        let at =
            |values: &[Vec3]| -> Vec<DVec3> { self.pixels.iter().map(|&pixel| values[pixel].as_dvec3()).collect() };
        let (direct, total) = (at(direct), at(total));
        let truth = Field { direct: &self.direct, total: &self.total };
        let errors = field_errors(Field { direct: &direct, total: &total }, truth).all;
        let indirect = |direct: &[DVec3], total: &[DVec3]| -> Vec<DVec3> {
            total.iter().zip(direct).map(|(total, direct)| *total - *direct).collect()
        };
        let (found, known) = (indirect(&direct, &total), indirect(&self.direct, &self.total));
        let sum = |values: &[DVec3]| values.iter().map(|value| value.element_sum()).sum::<f64>();
        PictureErrors {
            pixels: self.pixels.len(),
            total: errors.total.relative_l2,
            indirect: errors.indirect.relative_l2,
            indirect_by_itself: relative_l2(&found, &known),
            bias: errors.total.bias,
            indirect_bias: crate::math::ratio_or_zero(sum(&found) - sum(&known), sum(&known)),
        }
    }
}
