//! Task `concentric`: the map of Shirley and Chiu 1997.

use std::f32::consts::{FRAC_1_PI, FRAC_1_SQRT_2};

use glam::{Vec2, Vec2Swizzles as _};

use super::{
    charts, disk,
    probe::{Check, Failure, PLAIN_POINTS, Trial, call, quiet, written},
    sampling,
};

const MAP: &str = "square_to_disk_concentric";
const INVERSE: &str = "disk_to_square_concentric";

/// The middle, the middles of the sides, the corners, and a point of each branch half way out.
fn known_values() -> [(Vec2, Vec2); 11] {
    let diagonal = FRAC_1_SQRT_2;
    let half = |turn: f32| 0.5 * Vec2::from_angle(turn * std::f32::consts::FRAC_PI_4);
    [
        ([0.5, 0.5], Vec2::ZERO),
        ([1.0, 0.5], Vec2::X),
        ([0.5, 1.0], Vec2::Y),
        ([0.0, 0.5], Vec2::NEG_X),
        ([0.5, 0.0], Vec2::NEG_Y),
        ([1.0, 1.0], Vec2::new(diagonal, diagonal)),
        ([0.0, 1.0], Vec2::new(-diagonal, diagonal)),
        ([0.0, 0.0], Vec2::new(-diagonal, -diagonal)),
        ([1.0, 0.0], Vec2::new(diagonal, -diagonal)),
        ([0.75, 0.625], half(0.5)),
        ([0.375, 0.75], half(2.5)),
    ]
    .map(|(point, place)| (Vec2::from_array(point), place))
}

pub(super) fn tests(trial: &Trial) -> Check {
    let (map, inverse) = (trial.functions.square_to_disk_concentric, trial.functions.disk_to_square_concentric);
    written(trial, MAP, &PLAIN_POINTS, |functions, point| (functions.square_to_disk_concentric)(point))?;
    for (point, expected) in known_values() {
        let found = call(MAP, format_args!("point {point}"), || map(point))?;
        if !found.abs_diff_eq(expected, 1e-4) {
            let measured = format!("{found:.4} for point {point}");
            return Err(
                Failure::new(MAP, "known values", measured, &format!("{expected:.4} (Shirley and Chiu)")).into()
            );
        }
    }
    disk::in_range(trial, MAP, map)?;
    for point in trial.points().take(1000) {
        let (found, expected) = (map(point).length(), (2.0 * point - 1.0).abs().max_element());
        if (found - expected).abs() > 1e-4 {
            let measured = format!("radius {found:.4} for point {point}");
            let expected = format!("{expected:.4}: squares around the middle become circles");
            return Err(Failure::new(MAP, "circles", measured, &expected).into());
        }
    }
    sampling::jacobian(MAP, |point| map(point).extend(0.0), |_| FRAC_1_PI)?;
    written(trial, INVERSE, &PLAIN_POINTS, |functions, place| (functions.disk_to_square_concentric)(place))?;
    let points = known_values().map(|(point, _)| point).into_iter().chain(trial.points().take(1000));
    sampling::round_trip(INVERSE, points, |point| {
        let place = map(point);
        call(INVERSE, place, || inverse(place))
    })?;
    sampling::chi_square_test(MAP, trial, &charts::disk(), map, |_| FRAC_1_PI)
}

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    let functions = trial.functions;
    if failure.function == INVERSE {
        let fails = quiet(|| (functions.disk_to_square_concentric)(Vec2::ZERO)).is_none();
        return fails.then(|| String::from("the middle of the disk is 0/0: return (1/2, 1/2) there by itself"));
    }
    let map = functions.square_to_disk_concentric;
    let samples: Vec<(Vec2, Vec2)> =
        trial.points().take(2000).filter_map(|point| Some((point, quiet(|| map(point))?))).collect();
    if quiet(|| map(Vec2::splat(0.5))).is_none() && samples.len() == 2000 {
        return Some(String::from("the middle of the square is 0/0: return (0, 0) there by itself"));
    }
    branch_mistake(&samples).map(String::from).or_else(|| disk::map_mistake(trial, map))
}

/// The right map, for comparison; written with the angle of the square's side, not with the two formulas of the task.
fn right(point: Vec2) -> Vec2 {
    let centred = 2.0 * point - 1.0;
    let radius = centred.abs().max_element();
    if radius == 0.0 {
        return Vec2::ZERO;
    }
    let side = centred / radius;
    let along = side.abs().min_element() * std::f32::consts::FRAC_PI_4;
    let octant = Vec2::from_angle(along);
    let first = if side.x.abs() >= side.y.abs() { octant } else { octant.yx() };
    radius * Vec2::new(first.x.copysign(centred.x), first.y.copysign(centred.y))
}

/// What explains the samples by a wrong branch, sign, scale or turn.
fn branch_mistake(samples: &[(Vec2, Vec2)]) -> Option<&'static str> {
    const NEAR: f32 = 1e-3;
    let all =
        |wrong: &dyn Fn(Vec2) -> Vec2| samples.iter().all(|(point, place)| place.abs_diff_eq(wrong(*point), NEAR));
    let is_wide = |point: Vec2| (point.x - 0.5).abs() > (point.y - 0.5).abs();
    let branch_is_right = |wide: bool| {
        samples
            .iter()
            .filter(|(point, _)| is_wide(*point) == wide)
            .all(|(point, place)| place.abs_diff_eq(right(*point), NEAR))
    };
    let radius_is_right = samples.iter().all(|(point, place)| (place.length() - right(*point).length()).abs() < NEAR);
    if all(&|point| right(point).yx()) {
        Some("x and y are swapped: the point (1, 1/2) belongs on the x axis")
    } else if all(&|point| right(0.5 * point + 0.5)) {
        Some("the point is not centred: move the middle of the square to (0, 0) first, with 2p - 1")
    } else if all(&|point| right(0.5 * point + 0.25)) {
        Some("the point is centred but not scaled: 2p - 1, not p - 1/2")
    } else if all(&|point| right(point) * (2.0 * point - 1.0).abs().max_element()) {
        Some("the radius is multiplied in twice: places lie at its square")
    } else if samples
        .iter()
        .all(|(point, place)| ((2.0 * *point - 1.0).abs().min_element() - place.length()).abs() < NEAR)
    {
        Some("the smaller coordinate is taken as the radius: it is the larger of |x| and |y|")
    } else if samples.iter().all(|(point, place)| right(*point).abs().abs_diff_eq(place.abs(), NEAR)) {
        Some("the sign of a coordinate is lost: the radius is x or y itself, not its absolute value")
    } else if samples.iter().all(|(point, place)| {
        place.abs_diff_eq((2.0 * *point - 1.0).normalize_or_zero() * right(*point).length(), NEAR)
    }) {
        Some("the square is only pulled to circles; the angle must be π/4 times the ratio of the coordinates")
    } else if radius_is_right && branch_is_right(true) {
        Some("the branch |y| > |x| has a wrong angle: π/2 - π/4 · x/y")
    } else if radius_is_right && branch_is_right(false) {
        Some("the branch |x| > |y| has a wrong angle: π/4 · y/x")
    } else if branch_is_right(true) || branch_is_right(false) {
        Some("only one of the two branches is right: the larger of |x| and |y| is the radius")
    } else if radius_is_right {
        Some("the radius is right, the angle is not: π/4 times the ratio of the smaller to the larger coordinate")
    } else if samples.iter().all(|(point, place)| near_polar(*point, *place)) {
        Some("this is the polar map: right in density, but squares do not become circles")
    } else {
        None
    }
}

/// Whether a place is that of a polar map, whichever coordinate turns.
fn near_polar(point: Vec2, place: Vec2) -> bool {
    let squared = place.length_squared();
    (squared - point.x).abs() < 1e-3 || (squared - point.y).abs() < 1e-3
}
