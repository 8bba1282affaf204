//! Task `hemisphere`: any map from the square to directions of density cosθ/π.

use std::f32::consts::{FRAC_1_PI, FRAC_2_PI, FRAC_PI_4};

use glam::{Vec2, Vec3, Vec3Swizzles as _};

use super::{
    charts, disk_mistakes,
    probe::{Check, Failure, PLAIN_POINTS, Trial, call, near, quiet, written},
    sampling,
};

const MAP: &str = "square_to_cosine_hemisphere";
const INVERSE: &str = "cosine_hemisphere_to_square";
const PDF: &str = "cosine_hemisphere_pdf_solid_angle";

/// Directions at four heights and azimuths, above the horizon.
const DIRECTIONS: [(f32, f32); 4] = [(1.0, 0.0), (0.5, 0.4), (0.1, 2.5), (0.8, 4.0)];

pub(super) fn tests(trial: &Trial) -> Check {
    let functions = trial.functions;
    let (map, pdf) = (functions.square_to_cosine_hemisphere, functions.cosine_hemisphere_pdf_solid_angle);
    written(trial, MAP, &PLAIN_POINTS, |functions, point| (functions.square_to_cosine_hemisphere)(point))?;
    unit_directions_above_the_horizon(trial)?;
    let heights = trial.points().map(|point| map(point).z);
    sampling::mean(MAP, "z", heights, (2.0 / 3.0, 0.005), "the integral of cos²θ/π; 1/2 for a uniform hemisphere")?;
    let directions = DIRECTIONS.map(|(z, angle)| charts::direction(z, angle));
    written(trial, PDF, &directions, |functions, direction| (functions.cosine_hemisphere_pdf_solid_angle)(direction))?;
    known_densities(pdf)?;
    integral(pdf)?;
    sampling::jacobian(MAP, map, pdf)?;
    written(trial, INVERSE, &directions, |functions, direction| (functions.cosine_hemisphere_to_square)(direction))?;
    // A map may fold at the sides of the square and lose digits there.
    let inner = trial.points().take(1000).map(|point| 0.98 * point + 0.01);
    sampling::round_trip(INVERSE, inner, |point| {
        let direction = map(point);
        call(INVERSE, direction, || (functions.cosine_hemisphere_to_square)(direction))
    })?;
    sampling::chi_square_test(MAP, trial, &charts::hemisphere(), map, pdf)
}

fn unit_directions_above_the_horizon(trial: &Trial) -> Check {
    let map = trial.functions.square_to_cosine_hemisphere;
    for point in trial.edges_and_points() {
        let direction = call(MAP, format_args!("point {point}"), || map(point))?;
        let length = direction.length();
        if (length - 1.0).abs() > 1e-4 {
            let measured = format!("length {length:.4} of {direction:.4} for point {point}");
            return Err(Failure::new(MAP, "unit length", measured, "1: a direction").into());
        }
        if direction.z < -1e-5 {
            let measured = format!("z = {:.4} for point {point}", direction.z);
            return Err(Failure::new(MAP, "range", measured, "z ≥ 0: directions above the surface").into());
        }
    }
    Ok(())
}

fn known_densities(pdf: fn(Vec3) -> f32) -> Check {
    let above = DIRECTIONS.map(|(z, angle)| (charts::direction(z, angle), z * FRAC_1_PI));
    let below = above.map(|(direction, _)| (-direction, 0.0));
    for (direction, expected) in above.into_iter().chain(below) {
        let found = call(PDF, format_args!("direction {direction:.4}"), || pdf(direction))?;
        if !near(found, expected, 1e-3) {
            let source = if expected > 0.0 { "cosθ/π, eq. 4" } else { "0 below the horizon" };
            let measured = format!("{found:.4} for direction {direction:.4}");
            return Err(Failure::new(PDF, "known density", measured, &format!("{expected:.4} ({source})")).into());
        }
    }
    Ok(())
}

fn integral(pdf: fn(Vec3) -> f32) -> Check {
    const CELLS: u16 = 100;
    let chart = charts::hemisphere();
    let at = |index: u16| (f32::from(index) + 0.5) / f32::from(CELLS);
    let mut sum = 0.0;
    for (x, y) in (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| (x, y))) {
        let direction = (chart.from_square)(Vec2::new(at(x), at(y)));
        sum += f64::from(call(PDF, format_args!("direction {direction:.4}"), || pdf(direction))?);
    }
    let integral = sum * chart.measure / (f64::from(CELLS) * f64::from(CELLS));
    if (integral - 1.0).abs() <= 0.01 {
        return Ok(());
    }
    let measured = format!("the integral over the hemisphere is {integral:.4}");
    Err(Failure::new(PDF, "density integrates to 1", measured, "1: some direction is always chosen").into())
}

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    let hint = match failure.function {
        MAP => map_mistake(trial),
        PDF => pdf_mistake(trial.functions.cosine_hemisphere_pdf_solid_angle),
        INVERSE => {
            let inverse = trial.functions.cosine_hemisphere_to_square;
            let is_place = |(z, angle)| {
                let direction = charts::direction(z, angle);
                quiet(|| inverse(direction)).is_some_and(|found| found.abs_diff_eq(direction.xy(), 1e-4))
            };
            let hint = "the inverse returns the shadow on the disk, not yet its point of the square";
            DIRECTIONS.into_iter().all(is_place).then_some(hint)
        }
        _ => None,
    };
    hint.map(String::from)
}

fn map_mistake(trial: &Trial) -> Option<&'static str> {
    let map = trial.functions.square_to_cosine_hemisphere;
    let fails = |point: Vec2| quiet(|| map(point)).is_none();
    let samples: Vec<Vec3> = trial.points().take(20_000).filter_map(|point| quiet(|| map(point))).collect();
    let any_fails = trial.edges_and_points().any(fails);
    let is_unit = |direction: &Vec3| (direction.length() - 1.0).abs() < 1e-4;
    if any_fails && samples.len() > 10_000 && samples.iter().all(is_unit) {
        return Some("1 - x² - y² falls below 0 by rounding at the rim, and its square root is NaN: take at least 0");
    }
    if samples.is_empty() {
        return None;
    }
    if !samples.iter().all(is_unit) {
        return Some(length_mistake(&samples));
    }
    let mean = |value: fn(Vec3) -> f32| {
        samples.iter().map(|&sample| f64::from(value(sample))).sum::<f64>() / samples.len() as f64
    };
    let all = |test: fn(Vec3) -> bool| samples.iter().all(|&sample| test(sample));
    if all(|sample| sample.z < 1e-5) {
        return Some("the hemisphere is upside down: z must not be negative");
    }
    if samples.iter().any(|sample| sample.z < -1e-3) {
        return Some(if all(|sample| sample.y > -1e-5) || all(|sample| sample.x > -1e-5) {
            "the hemisphere is about another axis: here z is up"
        } else {
            "directions of the whole sphere: z must not be negative"
        });
    }
    if all(|sample| sample.z > 0.3) {
        return Some(
            "directions near the horizon are missing: normalising a shifted square or sphere gives no cosine-weighted hemisphere",
        );
    }
    let places: Vec<Vec2> = samples.iter().map(|sample| sample.xy()).collect();
    disk_mistakes::azimuth(&places).or_else(|| {
        let height = mean(|sample| sample.z);
        let known = [
            (0.5, "a uniform hemisphere (mean z is 1/2 instead of 2/3): weigh it by the cosine"),
            (0.75, "the cosine is squared: the density falls too fast towards the horizon (mean z 3/4 instead of 2/3)"),
            (
                f64::from(FRAC_PI_4),
                "the disk below lacks its square root: too many directions near the pole (mean z is π/4)",
            ),
            (
                f64::from(FRAC_2_PI),
                "the angle from the pole is uniform (mean z 2/π instead of 2/3): it needs an arc cosine of a root",
            ),
            (1.0 / 3.0, "the square of a number where its square root is meant (mean z 1/3 instead of 2/3)"),
            (0.8, "the root of z is taken twice (mean z 4/5 instead of 2/3)"),
        ];
        known.into_iter().find(|(mean, _)| (height - mean).abs() < 0.006).map(|(_, hint)| hint)
    })
}

/// Why directions are not of unit length.
fn length_mistake(samples: &[Vec3]) -> &'static str {
    let all = |test: fn(Vec3) -> bool| samples.iter().all(|&sample| test(sample));
    if all(|sample| sample.z == 0.0) {
        "the point of the disk is not lifted: z = √(1 - x² - y²)"
    } else if all(|sample| (sample.z - (1.0 - sample.xy().length_squared())).abs() < 1e-4) {
        "z lacks its square root: z = √(1 - x² - y²)"
    } else if all(|sample| (sample.z - (1.0 - sample.xy().length())).abs() < 1e-4) {
        "z is 1 - r: Pythagoras gives z = √(1 - r²)"
    } else {
        "the direction is not of unit length: z = √(1 - x² - y²), or normalise"
    }
}

fn pdf_mistake(pdf: fn(Vec3) -> f32) -> Option<&'static str> {
    let mut found = [0.0; DIRECTIONS.len()];
    for (slot, (z, angle)) in found.iter_mut().zip(DIRECTIONS) {
        *slot = quiet(|| pdf(charts::direction(z, angle)))?;
    }
    // Whether the density is `shape` at all heights.
    let is = |shape: &dyn Fn(f32) -> f32| {
        found.iter().zip(DIRECTIONS).all(|(found, (z, _))| (found - shape(z)).abs() < 1e-3 * shape(z).abs() + 1e-6)
    };
    let sine = |z: f32| (1.0 - z * z).max(0.0).sqrt();
    let below = quiet(|| pdf(Vec3::new(0.6, 0.0, -0.8)))?;
    let scale = found[0];
    if is(&|z| z * FRAC_1_PI) {
        Some(if below < 0.0 {
            "negative below the horizon: take at least 0"
        } else {
            "the cosine of the wrong side counts as well: below the horizon the density is 0, not |cosθ|/π"
        })
    } else if is(&|_| 0.0) && below > 0.0 || is(&|z| -z * FRAC_1_PI) {
        Some("the cosine is that of the wrong side: its sign is turned round")
    } else if is(&|z| z.acos() * FRAC_1_PI) {
        Some("the angle itself stands where its cosine is meant: cosθ is the direction's z")
    } else if near(quiet(|| pdf(Vec3::Y))?, FRAC_1_PI, 1e-3) && scale == 0.0 {
        Some("the cosine is to another axis: z is up, and cosθ is the direction's z")
    } else if is(&|_| 0.5 * FRAC_1_PI) {
        Some("this is the density of a uniform hemisphere, 1/(2π): weigh it by the cosine")
    } else if is(&|_| 0.25 * FRAC_1_PI) {
        Some("this is the density of a uniform sphere, 1/(4π)")
    } else if is(&|_| scale) {
        Some("the cosine is missing: the density must fall to 0 at the horizon")
    } else if is(&|z| scale * z * z) {
        Some("the cosine is squared")
    } else if is(&|z| found[1] / (0.5 * sine(0.5)) * z * sine(z)) {
        Some("a sine too many: this is the density over the angles θ and φ, not over solid angle")
    } else if is(&|z| found[1] / sine(0.5) * sine(z)) {
        Some("the sine stands where the cosine is meant: cosθ is the direction's z")
    } else if is(&|z| scale * z) {
        disk_mistakes::density_factor(scale / FRAC_1_PI)
    } else {
        None
    }
}
