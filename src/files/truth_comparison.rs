//! A solution against a file of true values at points.

use std::path::Path;

use anyhow::{Context as _, bail};
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use crate::{
    check::{
        metrics::{Field, FieldErrors, field_errors},
        surface_points::locate,
        truth_file::{TruthFile, TruthValue},
    },
    scene::Scene,
    trace::Tracer,
};

/// How far a solution is from the truth.
#[derive(Clone, Debug)]
pub struct TruthComparison {
    /// The field errors.
    pub errors: FieldErrors,
    /// Points of the file that lie on no surface of the scene, and were left out.
    pub off_surface: usize,
    /// The error at each of the other points, but for those that are enclosed.
    pub points: Vec<PointError>,
}

/// The error at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointError {
    /// The scene's triangle.
    pub triangle: u32,
    /// Where in it.
    pub barycentric: Vec2,
    /// The total less its truth [W/m²].
    pub difference: DVec3,
}

/// Compares a field with the values of a truth file; `path` is the file's, for errors. `at` gives direct and total
/// irradiance [W/m²] at a point of a scene triangle.
///
/// # Errors
/// One line: the file holds no values, or none of its points lies on the scene.
pub fn compare_with_truth(
    scene: &Scene,
    tracer: &Tracer,
    at: impl Fn(u32, Vec2) -> (Vec3, Vec3) + Sync,
    (truth, path): (&TruthFile, &Path),
) -> anyhow::Result<TruthComparison> {
    let values = values_of(truth, path)?;
    let rebuilt: Vec<_> = truth
        .points
        .par_iter()
        .map(|point| {
            let place = locate(scene, tracer, point)?.on();
            let (direct, total) = place.map_or((Vec3::ZERO, Vec3::ZERO), |(triangle, place)| at(triangle, place));
            Some((direct.as_dvec3(), total.as_dvec3(), place))
        })
        .collect();
    let off_surface = rebuilt.iter().filter(|value| value.is_none()).count();
    if off_surface == rebuilt.len() {
        bail!("{}: none of its points lies on a surface of the scene; is it of this scene?", path.display());
    }
    let found = || rebuilt.iter().zip(values).filter_map(|(value, truth)| Some((value.as_ref()?, truth)));
    let (direct, total): (Vec<_>, Vec<_>) = found().map(|((direct, total, ..), _)| (*direct, *total)).unzip();
    let (true_direct, true_total): (Vec<_>, Vec<_>) = found().map(|(_, truth)| (truth.direct, truth.total)).unzip();
    let points = found().filter_map(|((_, total, place), truth)| {
        let (triangle, barycentric) = (*place)?;
        Some(PointError { triangle, barycentric, difference: *total - truth.total })
    });
    let points = points.collect();
    let errors =
        field_errors(Field { direct: &direct, total: &total }, Field { direct: &true_direct, total: &true_total });
    Ok(TruthComparison { errors, off_surface, points })
}

/// The values of a truth file.
///
/// # Errors
/// It holds points alone.
pub fn values_of<'a>(file: &'a TruthFile, path: &Path) -> anyhow::Result<&'a [TruthValue]> {
    let values = file.values.as_deref().filter(|values| !values.is_empty());
    values
        .with_context(|| format!("{}: holds points alone; compute their values with `radiosity truth`", path.display()))
}
