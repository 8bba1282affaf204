//! Task `disk`: any map from the square to the disk of constant density.

use std::f32::consts::FRAC_1_PI;

use glam::Vec2;

use super::{
    charts, disk_mistakes,
    probe::{Check, Failure, PLAIN_POINTS, Trial, call, near, quiet, written},
    sampling,
};

const MAP: &str = "square_to_disk_polar";
const INVERSE: &str = "disk_to_square_polar";
const PDF: &str = "disk_pdf_area";

pub(super) fn tests(trial: &Trial) -> Check {
    let functions = trial.functions;
    let map = functions.square_to_disk_polar;
    written(trial, MAP, &PLAIN_POINTS, |functions, point| (functions.square_to_disk_polar)(point))?;
    in_range(trial, MAP, map)?;
    sampling::mean(
        MAP,
        "the radius",
        trial.points().map(|point| map(point).length()),
        (2.0 / 3.0, 0.005),
        "the integral of r · 2r over [0, 1]",
    )?;
    written(trial, PDF, &PLAIN_POINTS, |functions, place| (functions.disk_pdf_area)(place))?;
    density(functions.disk_pdf_area)?;
    sampling::jacobian(MAP, |point| map(point).extend(0.0), |place| (functions.disk_pdf_area)(place.truncate()))?;
    written(trial, INVERSE, &PLAIN_POINTS, |functions, place| (functions.disk_to_square_polar)(place))?;
    // The sides of the square meet in the middle and along an axis of the disk: no way back from there.
    let inner = trial.points().take(1000).map(|point| 0.98 * point + 0.01);
    sampling::round_trip(INVERSE, inner, |point| {
        let place = map(point);
        call(INVERSE, place, || (functions.disk_to_square_polar)(place))
    })?;
    sampling::chi_square_test(MAP, trial, &charts::disk(), map, |_| FRAC_1_PI)
}

/// All results are finite and lie in the disk.
pub(super) fn in_range(trial: &Trial, function: &'static str, map: fn(Vec2) -> Vec2) -> Check {
    for point in trial.edges_and_points() {
        let place = call(function, format_args!("point {point}"), || map(point))?;
        if place.length() > 1.0 + 1e-4 {
            let measured = format!("radius {:.4} for point {point}", place.length());
            return Err(Failure::new(function, "range", measured, "at most 1, the unit disk").into());
        }
    }
    Ok(())
}

fn density(pdf: fn(Vec2) -> f32) -> Check {
    let inside = [[0.0, 0.0], [0.5, 0.3], [-0.2, -0.9], [-0.6, 0.1]];
    let outside = [[1.1, 0.0], [-0.8, 0.8], [0.0, -3.0]];
    let cases = inside.map(|place| (place, FRAC_1_PI)).into_iter().chain(outside.map(|place| (place, 0.0)));
    for (place, expected) in cases {
        let place = Vec2::from_array(place);
        let found = call(PDF, place, || pdf(place))?;
        if near(found, expected, 1e-4) {
            continue;
        }
        let source = if expected > 0.0 { "1/π: one over the disk's area" } else { "no density outside the disk" };
        let failure =
            Failure::new(PDF, "known density", format!("{found:.4} at {place}"), &format!("{expected:.4} ({source})"));
        let hint = if expected > 0.0 {
            disk_mistakes::density_factor(found / expected)
        } else {
            Some("outside the disk the density must be 0")
        };
        return Err(failure.or_else(hint).into());
    }
    Ok(())
}

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    (failure.function == MAP).then(|| map_mistake(trial, trial.functions.square_to_disk_polar)).flatten()
}

/// The mistake of a map to the disk, by where its samples lie.
pub(super) fn map_mistake(trial: &Trial, map: fn(Vec2) -> Vec2) -> Option<String> {
    let samples: Vec<(Vec2, Vec2)> =
        trial.points().take(20_000).filter_map(|point| Some((point, quiet(|| map(point))?))).collect();
    disk_mistakes::map(&samples).map(String::from)
}
