//! The tests that all samplers share: Jacobian, round trip, chi-square.

use glam::{UVec2, Vec2, Vec3};

use super::{
    inverse,
    probe::{Check, Failure, Problem, Trial, near},
};
use crate::check::{
    chi_square::{Chart, ChiSquareSettings, chi_square},
    jacobian::{check_jacobian, fixed_points},
};

/// Chi-square tests in a whole check: disk, hemisphere, two lights, concentric.
const CHI_SQUARE_TESTS: u32 = 5;

/// Chance that a whole check rejects right functions.
const SIGNIFICANCE: f64 = 1e-4;

/// How far a point may be after the way there and back: rounding, where a square root near 0 makes the most of it.
const ROUND_TRIP_TOLERANCE: f32 = 1e-3;

/// The sampler `function` spreads points as `pdf` says, place by place.
pub(super) fn jacobian(function: &'static str, warp: impl Fn(Vec2) -> Vec3, pdf: impl Fn(Vec3) -> f32) -> Check {
    let Err(mismatch) = check_jacobian(fixed_points(), warp, pdf) else { return Ok(()) };
    let (point, measured, pdf) = (mismatch.point, mismatch.measured, mismatch.pdf);
    let ratio = measured / pdf;
    let degrees = 1.0_f32.to_degrees();
    let hint = if near(1.0 / ratio, degrees, 0.05) {
        Some("degrees where radians are meant: the angle goes round 57 times too often")
    } else if near(ratio, degrees, 0.05) {
        Some("the angle is 57 times too small: radians were taken for degrees and turned into radians")
    } else if measured.is_infinite() || measured > 1e4 * pdf {
        Some("one of the two numbers of the point is not used: the samples lie on a curve, not on a surface")
    } else {
        None
    };
    let failure = Failure::new(
        function,
        "density against the Jacobian",
        format!("density {measured:.4} around point {point}, {ratio:.4} times what it should be"),
        &format!("{pdf:.4}: the density, as one over the area that a small square is spread over"),
    );
    Err(failure
        .or_else(hint)
        .fallback("the samples are not spread as the density says: something is missing in the map (a square root?)")
        .into())
}

/// `back` leads to the point that `there` was given.
pub(super) fn round_trip(
    function: &'static str,
    points: impl Iterator<Item = Vec2>,
    there_and_back: impl Fn(Vec2) -> Result<Vec2, Problem>,
) -> Check {
    let mut pairs = Vec::new();
    for point in points {
        pairs.push((point, there_and_back(point)?));
    }
    let Some((point, found)) = pairs.iter().find(|(point, found)| point.distance(*found) > ROUND_TRIP_TOLERANCE) else {
        return Ok(());
    };
    let failure = Failure::new(
        function,
        "round trip",
        format!("point {point} comes back as {found}"),
        "the same point: the inverse undoes the sampler",
    );
    Err(failure
        .or_else(inverse::mistake(&pairs))
        .fallback("the inverse does not undo the sampler, step by step")
        .into())
}

/// The samples follow the density (Pearson's test).
pub(super) fn chi_square_test<T: Copy>(
    function: &'static str,
    trial: &Trial,
    chart: &Chart<T>,
    sample: impl Fn(Vec2) -> T,
    pdf: impl Fn(T) -> f32,
) -> Check {
    let settings =
        ChiSquareSettings { cells: UVec2::new(20, 20), significance: SIGNIFICANCE, test_count: CHI_SQUARE_TESTS };
    let report = chi_square(&settings, chart, trial.points().map(sample), pdf);
    let Some(rejection) = report.rejection else { return Ok(()) };
    let failure = Failure::new(function, "chi-square", rejection, "samples as dense as the density says");
    Err(failure
        .fallback("parts of the domain get too many samples and others too few: does the map fold or skip a part?")
        .into())
}

/// The mean of `value`, and its failure if it is further than `tolerance` from `expected`.
pub(super) fn mean(
    function: &'static str,
    what: &str,
    values: impl Iterator<Item = f32>,
    (expected, tolerance): (f32, f32),
    source: &str,
) -> Check {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + f64::from(value), count + 1.0));
    let found = sum / count;
    if (found - f64::from(expected)).abs() <= f64::from(tolerance) {
        return Ok(());
    }
    let expected = format!("{expected:.4} ({source})");
    Err(Failure::new(function, "known mean", format!("{what} is {found:.4} on average"), &expected).into())
}
