//! Task `barycentric`: interpolation in a triangle.

use glam::{Vec2, Vec3};

use super::probe::{Check, Failure, PLAIN_POINTS, Trial, call, quiet, written};

const FUNCTION: &str = "interpolate_barycentric";

/// With unit vectors at the corners the result is the three weights.
const UNIT_VALUES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

const VALUES: [Vec3; 3] = [Vec3::new(3.0, 0.5, 0.25), Vec3::new(0.125, 4.0, 1.0), Vec3::new(1.5, 2.0, 8.0)];

fn weights(point: Vec2) -> Vec3 {
    Vec3::new(1.0 - point.x - point.y, point.x, point.y)
}

/// Points of the triangle.
fn inside(trial: &Trial) -> impl Iterator<Item = Vec2> {
    trial.points().take(1000).map(|point| if point.element_sum() > 1.0 { Vec2::ONE - point } else { point })
}

pub(super) fn tests(trial: &Trial) -> Check {
    let interpolate = trial.functions.interpolate_barycentric;
    written(trial, FUNCTION, &PLAIN_POINTS, |functions, point| (functions.interpolate_barycentric)(VALUES, point))?;
    let corners = [Vec2::ZERO, Vec2::X, Vec2::Y];
    let middle = Vec2::splat(1.0 / 3.0);
    for (test, values) in [("weights of the corners", UNIT_VALUES), ("values at the corners", VALUES)] {
        for point in corners.into_iter().chain([middle]).chain(inside(trial)) {
            let found = call(FUNCTION, format_args!("(u, v) = {point}"), || interpolate(values, point))?;
            let weights = weights(point);
            let expected = values[0] * weights.x + values[1] * weights.y + values[2] * weights.z;
            if !found.abs_diff_eq(expected, 1e-4) {
                let [a, b, c] = values;
                let measured = format!("{found} at (u, v) = {point} between {a}, {b} and {c}");
                let expected = format!("{expected} = (1-u-v) a + u b + v c");
                return Err(Failure::new(FUNCTION, test, measured, &expected).into());
            }
        }
    }
    Ok(())
}

/// A wrong version: its weights as a function of the right ones, and what to say.
type Wrong = (fn(Vec3) -> Vec3, &'static str);

const KNOWN: [Wrong; 15] = [
    (|w| Vec3::new(w.x, w.z, w.y), "u and v are swapped: u belongs to b and v to c"),
    (
        |w| Vec3::new(w.y, w.z, w.x),
        "weights at the wrong corners: 1-u-v belongs to a, u to b and v to c (found: u, v, 1-u-v)",
    ),
    (
        |w| Vec3::new(w.z, w.x, w.y),
        "weights at the wrong corners: 1-u-v belongs to a, u to b and v to c (found: v, 1-u-v, u)",
    ),
    (|w| Vec3::new(w.y, w.x, w.z), "weights at the wrong corners: 1-u-v belongs to a, u to b (found: u, 1-u-v, v)"),
    (|w| Vec3::new(w.z, w.y, w.x), "weights at the wrong corners: 1-u-v belongs to a, v to c (found: v, u, 1-u-v)"),
    (|w| Vec3::ONE - w, "each weight is one minus the right one: the complement of a weight was taken"),
    (|w| 0.5 * (Vec3::ONE - w), "each weight is the complement of the right one: near a corner its own value must win"),
    (|w| Vec3::new(1.0, w.y, w.z), "the weight of a is 1: it must be 1-u-v, so that the three sum to 1"),
    (|w| Vec3::new(0.0, w.y, w.z), "corner a is missing: its weight is 1-u-v"),
    (|w| Vec3::new(w.x + w.z, w.y, 0.0), "v is not used: corner c has the weight v"),
    (|w| Vec3::new(w.x + w.y, 0.0, w.z), "u is not used: corner b has the weight u"),
    (
        |w| Vec3::new(w.x, 1.0 - w.y, 1.0 - w.z),
        "the complements of u and v stand at b and c: their weights are u and v",
    ),
    (|_| Vec3::ONE, "the plain sum of the corners: the barycentric coordinates are not used"),
    (|_| Vec3::splat(1.0 / 3.0), "the plain mean of the corners: the barycentric coordinates are not used"),
    (|w| w.normalize_or_zero(), "the result is brought to unit length: that is for normals, not for radiosity"),
];

pub(super) fn diagnose(trial: &Trial, _: &Failure) -> Option<String> {
    let interpolate = trial.functions.interpolate_barycentric;
    let found: Vec<(Vec3, Vec3)> =
        inside(trial).filter_map(|point| Some((weights(point), quiet(|| interpolate(UNIT_VALUES, point))?))).collect();
    let explains = |wrong: fn(Vec3) -> Vec3| {
        !found.is_empty() && found.iter().all(|&(weights, found)| wrong(weights).abs_diff_eq(found, 1e-4))
    };
    let known = KNOWN.iter().find(|(wrong, _)| explains(*wrong)).map(|(_, hint)| String::from(*hint));
    let is_a_corner = |value: Vec3| value.max_element() > 0.999 && value.element_sum() < 1.001;
    let nearest = || found.iter().all(|(_, found)| is_a_corner(*found));
    known.or_else(|| nearest().then(|| String::from("the value of one corner alone: mix all three by their weights")))
}
