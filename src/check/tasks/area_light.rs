//! Task `light`: uniform points on the area light.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec2Swizzles as _, Vec3};

use super::{
    charts::{self, light_coordinates},
    probe::{Check, Failure, PLAIN_POINTS, Problem, Trial, call, near, quiet, written},
    sampling,
};
use crate::{
    scene::AreaLight,
    student::{Functions, LightSample},
};

const SAMPLE: &str = "sample_area_light";
const INVERSE: &str = "area_light_inverse";

/// A rectangle of no special size or place.
const RECTANGLE: AreaLight = AreaLight {
    centre: Vec3::new(0.2, 0.9, -0.1),
    half_extent_u: Vec3::new(0.3, 0.1, 0.0),
    half_extent_v: Vec3::new(-0.02, 0.06, 0.1),
    radiance: Vec3::ONE,
};

/// A parallelogram: u and v are not at right angles.
const SKEWED: AreaLight = AreaLight { half_extent_v: Vec3::new(0.2, 0.2, 0.1), ..RECTANGLE };

/// A light without area.
const LINE: AreaLight = AreaLight { half_extent_v: Vec3::ZERO, ..RECTANGLE };

fn sample(functions: &Functions, light: &AreaLight, point: Vec2) -> Result<LightSample, Problem> {
    let input = format_args!("point {point} of half extents {} and {}", light.half_extent_u, light.half_extent_v);
    call(SAMPLE, input, || (functions.sample_area_light)(light, point))
}

pub(super) fn tests(trial: &Trial) -> Check {
    let functions = trial.functions;
    written(trial, SAMPLE, &PLAIN_POINTS, |functions, point| (functions.sample_area_light)(&RECTANGLE, point))?;
    for light in [&RECTANGLE, &SKEWED] {
        corners(functions, light)?;
        ranges(trial, light)?;
    }
    let line = sample(functions, &LINE, PLAIN_POINTS[0])?;
    if line.pdf_area != 0.0 {
        let measured = format!("density {} of a light without area", line.pdf_area);
        return Err(Failure::new(SAMPLE, "no area", measured, "0: it gives no light").into());
    }
    for light in [&RECTANGLE, &SKEWED] {
        let position = |point| (functions.sample_area_light)(light, point).position;
        let pdf = (functions.sample_area_light)(light, PLAIN_POINTS[0]).pdf_area;
        sampling::jacobian(SAMPLE, position, |_| pdf)?;
    }
    let positions = PLAIN_POINTS.map(|point| (functions.sample_area_light)(&RECTANGLE, point).position);
    written(trial, INVERSE, &positions, |functions, position| (functions.area_light_inverse)(&RECTANGLE, position))?;
    for light in [&RECTANGLE, &SKEWED] {
        sampling::round_trip(INVERSE, trial.points().take(1000), |point| {
            let position = (functions.sample_area_light)(light, point).position;
            call(INVERSE, position, || (functions.area_light_inverse)(light, position))
        })
        .map_err(|problem| skewed_inverse(problem, light))?;
        let position = |point| (functions.sample_area_light)(light, point).position;
        let pdf = 1.0 / light.area();
        sampling::chi_square_test(SAMPLE, trial, &charts::light(light), position, |_| pdf)?;
    }
    call(INVERSE, "a light without area", || (functions.area_light_inverse)(&LINE, LINE.centre)).map(|_| ())
}

/// An inverse that works on a rectangle and fails on a parallelogram has one cause.
fn skewed_inverse(problem: Problem, light: &AreaLight) -> Problem {
    match problem {
        Problem::Wrong(failure) if *light == SKEWED => failure
            .or_else(Some("u and v are taken to be at right angles: find u with a vector that is orthogonal to v"))
            .into(),
        other => other,
    }
}

/// Position, normal and density at the corners, the middle and elsewhere, in this order.
fn corners(functions: &Functions, light: &AreaLight) -> Check {
    let points = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y, Vec2::splat(0.5), Vec2::new(0.25, 0.625)];
    for point in points {
        let found = sample(functions, light, point)?.position;
        let centred = 2.0 * point - 1.0;
        let expected = light.centre + centred.x * light.half_extent_u + centred.y * light.half_extent_v;
        if !found.abs_diff_eq(expected, 1e-5) {
            let Vec2 { x, y } = centred;
            let measured = format!("{found:.4} for point {point} of the light around {}", light.centre);
            let expected = format!("{expected:.4} = centre + {x} u + {y} v");
            let failure = Failure::new(SAMPLE, "known positions", measured, &expected);
            return Err(failure
                .fallback("the points are not spread evenly: the factors of u and v are 2x - 1 and 2y - 1")
                .into());
        }
    }
    for point in points {
        let LightSample { normal, pdf_area, .. } = sample(functions, light, point)?;
        if !normal.abs_diff_eq(light.normal(), 1e-4) {
            let expected = format!("{:.4}: the unit vector along u × v", light.normal());
            let failure = Failure::new(SAMPLE, "normal", format!("{normal:.4}"), &expected);
            return Err(failure.or_else(Some(normal_mistake(normal, light))).into());
        }
        let expected = 1.0 / light.area();
        if !near(pdf_area, expected, 1e-4) {
            let source = format!("{expected:.4} = 1/area, the area being 4 |u × v| = {:.4}", light.area());
            let failure = Failure::new(SAMPLE, "known density", format!("{pdf_area:.4}"), &source);
            return Err(failure.or_else(density_mistake(pdf_area, light)).into());
        }
    }
    Ok(())
}

fn normal_mistake(normal: Vec3, light: &AreaLight) -> &'static str {
    let expected = light.normal();
    let direction = normal.normalize_or_zero();
    if direction.abs_diff_eq(-expected, 1e-3) {
        "the normal points to the light's back: swap the factors of the cross product, u × v"
    } else if direction.abs_diff_eq(expected, 1e-3) {
        "the normal is not normalised: bring u × v to unit length"
    } else if normal == Vec3::ZERO {
        "the normal is still 0: it is the unit vector along u × v"
    } else {
        "the normal is not at right angles to the light: it is the unit vector along u × v"
    }
}

fn density_mistake(pdf: f32, light: &AreaLight) -> Option<&'static str> {
    let (u, v) = (light.half_extent_u, light.half_extent_v);
    let (area, right) = (light.area(), 1.0 / light.area());
    let known = [
        (area, "the area itself where one over the area is meant"),
        (0.25 * area, "|u × v| where one over the area is meant, and the area is 4 |u × v|"),
        (1.0, "1 where one over the area is meant"),
        (4.0 * right, "the density of a quarter of the light: half extents taken for full ones, the area is 4 |u × v|"),
        (2.0 * right, "the density of half the light: the area is 4 |u × v|"),
        (0.5 * right, "the density is halved, as for a light of twice the area: the area is 4 |u × v|"),
        (0.25 * right, "the density is a quarter of the right one: half extents doubled twice, the area is 4 |u × v|"),
        (PI * right, "π has no place in the density: it is one over the area"),
        (FRAC_1_PI * right, "π has no place in the density: it is one over the area"),
        (
            0.25 / (u.length() * v.length()),
            "the area 4 |u| |v| is a rectangle's: u and v may be at other angles, 4 |u × v|",
        ),
        (0.25 / (u.length() + v.length()), "one over the perimeter where one over the area is meant"),
    ];
    known.into_iter().find(|(wrong, _)| near(pdf, *wrong, 1e-3)).map(|(_, hint)| hint)
}

/// Every position lies on the light.
fn ranges(trial: &Trial, light: &AreaLight) -> Check {
    for point in trial.edges_and_points() {
        let position = sample(trial.functions, light, point)?.position;
        let height = (position - light.centre).dot(light.normal());
        if height.abs() > 1e-4 {
            let measured = format!("{height:.4} above its plane for point {point}");
            return Err(Failure::new(SAMPLE, "range", measured, "0: on the light").into());
        }
        let place = light_coordinates(light, position);
        if place.abs().max_element() > 1.0 + 1e-3 {
            let measured = format!("centre + {:.3} u + {:.3} v for point {point}", place.x, place.y);
            return Err(Failure::new(SAMPLE, "range", measured, "factors of u and v from -1 to 1").into());
        }
    }
    Ok(())
}

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    if failure.test == "no area" || failure.test == "finite values" {
        let fails = quiet(|| (trial.functions.sample_area_light)(&LINE, PLAIN_POINTS[0]));
        let only_line = fails.is_none_or(|sample| sample.pdf_area != 0.0);
        let hint = "a light without area: one over it is infinite, and 0 is meant";
        return (failure.function == SAMPLE && only_line).then(|| String::from(hint));
    }
    if failure.function != SAMPLE {
        return None;
    }
    let light = &RECTANGLE;
    let samples: Vec<(Vec2, Vec2, f32)> = trial
        .points()
        .take(5000)
        .filter_map(|point| {
            let position = quiet(|| (trial.functions.sample_area_light)(light, point))?.position;
            let height = (position - light.centre).dot(light.normal());
            Some((2.0 * point - 1.0, light_coordinates(light, position), height))
        })
        .collect();
    let around_origin = PLAIN_POINTS.into_iter().all(|point| {
        let right = (2.0 * point.x - 1.0) * light.half_extent_u + (2.0 * point.y - 1.0) * light.half_extent_v;
        quiet(|| (trial.functions.sample_area_light)(light, point))
            .is_some_and(|found| found.position.abs_diff_eq(right, 1e-5))
    });
    if around_origin {
        return Some(String::from("the light's centre is missing: the points lie around the origin"));
    }
    position_mistake(&samples).map(String::from)
}

/// A wrong version: factors of u and v as a function of the right ones, and what to say.
type Wrong = (fn(Vec2) -> Vec2, &'static str);

const CORNER: &str = "the centre is taken for a corner: the factors of u and v must run from -1 to 1";

const KNOWN: [Wrong; 10] = [
    (
        |p| 0.5 * p,
        "half_extent_u and _v are taken for the full extents: only the inner quarter of the light is sampled",
    ),
    (|p| 2.0 * p, "the extents are doubled: half_extent_u and _v already reach from the centre to the sides"),
    (|p| 0.5 * p + 0.5, CORNER),
    (|p| p + 1.0, CORNER),
    (|p| p - 1.0, CORNER),
    (|p| p.yx(), "x and y are swapped: x runs along u, y along v"),
    (|p| -p, "the light is mirrored: x runs from -u to +u, y from -v to +v"),
    (|p| Vec2::new(-p.x, p.y), "the light is mirrored along u: x runs from -u to +u"),
    (|p| Vec2::new(p.x, -p.y), "the light is mirrored along v: y runs from -v to +v"),
    (|p| p * p * p.signum(), "the coordinates are squared: the points crowd in the middle"),
];

fn position_mistake(samples: &[(Vec2, Vec2, f32)]) -> Option<&'static str> {
    if samples.is_empty() {
        return None;
    }
    if samples.iter().any(|(_, _, height)| height.abs() > 1e-4) {
        return Some("the points leave the light's plane: only u and v may be added to the centre");
    }
    let all = |test: &dyn Fn(Vec2, Vec2) -> bool| samples.iter().all(|(point, place, _)| test(*point, *place));
    let known = KNOWN.iter().find(|(wrong, _)| all(&|point, place| wrong(point).abs_diff_eq(place, 1e-3)));
    if let Some((_, hint)) = known {
        return Some(hint);
    }
    if all(&|_, place| place.abs().max_element() < 1e-3) {
        Some("every point is the centre: that gives hard shadows")
    } else if all(&|_, place| (place.x - place.y).abs() < 1e-3 || (place.x + place.y).abs() < 1e-3) {
        Some("the points lie on the light's diagonal: u and v need a number each")
    } else if all(&|_, place| place.x.abs().min(place.y.abs()) < 1e-3) {
        Some("the points lie on one line of the light: u and v need a number each")
    } else if all(&|_, place| place.length() < 1.0 + 1e-3) {
        Some("the points lie on a disk: the light is a rectangle, and its corners shine as well")
    } else {
        None
    }
}
