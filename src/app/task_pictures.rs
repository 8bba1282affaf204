//! Pictures of what a student's samplers do: points, and the outline of where they belong.

use std::f32::consts::TAU;

use glam::Vec2;

use crate::{check::chi_square::random_points, scene::AreaLight, solver::faults::caught, student::Functions};

/// Points that a function made.
#[derive(Clone, Debug)]
pub struct TaskPicture {
    /// What is seen.
    pub title: &'static str,
    /// Where the points lie.
    pub points: Vec<[f64; 2]>,
    /// Where they belong: a closed line.
    pub outline: Vec<[f64; 2]>,
}

const POINTS: u32 = 1024;

/// The picture of a task, where one helps. Points that are not finite, and panics, leave no mark.
pub(super) fn picture(task: &str, functions: &Functions) -> Option<TaskPicture> {
    let circle =
        || -> Vec<[f64; 2]> { (0..=90_u8).map(|step| pair(Vec2::from_angle(f32::from(step) / 90.0 * TAU))).collect() };
    let square = |low: f32| {
        let corners = [Vec2::splat(low), Vec2::new(1.0, low), Vec2::ONE, Vec2::new(low, 1.0), Vec2::splat(low)];
        corners.map(pair).to_vec()
    };
    let drawn = |title, outline, of: &dyn Fn(u32, Vec2) -> Vec2| {
        let points = (0..POINTS).zip(random_points(1, POINTS));
        let points = points.filter_map(|(index, point)| caught(|| of(index, point)).ok());
        Some(TaskPicture { title, points: points.filter(|point| point.is_finite()).map(pair).collect(), outline })
    };
    match task {
        "disk" => drawn("square_to_disk_polar", circle(), &|_, point| (functions.square_to_disk_polar)(point)),
        "concentric" => {
            drawn("square_to_disk_concentric", circle(), &|_, point| (functions.square_to_disk_concentric)(point))
        }
        "hemisphere" => drawn("square_to_cosine_hemisphere, from above", circle(), &|_, point| {
            (functions.square_to_cosine_hemisphere)(point).truncate()
        }),
        "light" => drawn("sample_area_light, along u and v", square(-1.0), &|_, point| {
            let position = (functions.sample_area_light)(&LIGHT, point).position - LIGHT.centre;
            Vec2::new(position.dot(LIGHT.half_extent_u), position.dot(LIGHT.half_extent_v)) / HALF_SIZE_SQUARED
        }),
        "stratified" => drawn("stratified_point, 1,024 points", square(0.0), &|index, jitter| {
            (functions.stratified_point)(index, POINTS, jitter)
        }),
        "qmc" => drawn("low_discrepancy_point, the first 1,024", square(0.0), &|index, _| {
            (functions.low_discrepancy_point)(index)
        }),
        _ => None,
    }
}

/// A square light with extents of no special direction.
const LIGHT: AreaLight = AreaLight {
    centre: glam::Vec3::new(0.2, 0.9, -0.1),
    half_extent_u: glam::Vec3::new(0.3, 0.1, 0.0),
    half_extent_v: glam::Vec3::new(-0.1, 0.3, 0.0),
    radiance: glam::Vec3::ONE,
};
const HALF_SIZE_SQUARED: f32 = 0.1;

fn pair(point: Vec2) -> [f64; 2] {
    point.as_dvec2().to_array()
}
