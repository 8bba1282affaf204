//! Task `unshadowed`: direct light where nothing lies between.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::{
    probe::{Check, Failure, Problem, Trial, call, written},
    stage::{
        Always, Estimate, POINTS, Quad, Stage, differs, direct, estimate, matt, takes_its_own_points, turned,
        turned_light,
    },
};
use crate::{
    check::closed_form::polygon_irradiance,
    scene::AreaLight,
    student::{Receiver, World},
};

pub(super) const FUNCTION: &str = "direct_irradiance";

/// Faces down.
const LIGHT: AreaLight = AreaLight {
    centre: Vec3::new(0.1, 0.8, 0.0),
    half_extent_u: Vec3::new(0.25, 0.0, 0.0),
    half_extent_v: Vec3::new(0.0, 0.0, 0.2),
    radiance: Vec3::new(4.0, 2.0, 1.0),
};

/// A small parallelogram without right angles.
const SKEWED: AreaLight =
    AreaLight { half_extent_u: Vec3::new(0.1, 0.03, 0.05), half_extent_v: Vec3::new(0.05, 0.0, 0.13), ..LIGHT };

/// Nothing is in the way, not even by mistake.
const CLEAR: Always = Always { occluded: false };

/// A receiver and a light.
struct Look {
    name: &'static str,
    position: Vec3,
    normal: Vec3,
    /// The vertex's normal, where it is not that of the triangle.
    shading: Option<Vec3>,
    light: AreaLight,
}

const fn look(name: &'static str, position: [f32; 3], normal: [f32; 3], light: AreaLight) -> Look {
    Look { name, position: Vec3::from_array(position), normal: Vec3::from_array(normal), shading: None, light }
}

/// Where the whole front of the light is above the horizon.
const PLAIN: [Look; 5] = [
    look("below the light", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], LIGHT),
    look("close to the light", [0.25, 0.5, 0.1], [0.0, 1.0, 0.0], LIGHT),
    look("far to the side", [-0.9, -0.5, 0.3], [0.4, 0.9, 0.0], LIGHT),
    look("on a tilted surface", [0.3, 0.1, -0.2], [-0.3, 0.8, 0.4], LIGHT),
    look("below a light without right angles", [0.0, 0.2, 0.0], [0.2, 1.0, -0.1], SKEWED),
];

const BEHIND: Look = look("behind the light", [0.1, 1.1, 0.0], [0.1, -1.0, 0.0], LIGHT);
const BELOW: Look = look("where the light is below the horizon", [0.0, 0.0, 0.0], [0.1, -1.0, 0.0], LIGHT);
const CUT: Look = look("where the horizon cuts the light", [0.1, 0.2, 0.0], [1.0, 0.1, 0.2], LIGHT);
const SHADED: Look = Look {
    shading: Some(Vec3::new(0.5, 0.8, 0.3)),
    ..look("where the vertex's normal is not the triangle's", [0.0, 0.0, 0.1], [0.0, 1.0, 0.0], LIGHT)
};

impl Look {
    fn stage(&self) -> Stage {
        let normal = self.normal.normalize_or_zero();
        let (along, up) = normal.any_orthonormal_pair();
        let quad = Quad { corner: self.position, along: 0.02 * along, up: 0.02 * up, material: 0 };
        Stage::new(&[quad], vec![matt(Vec3::splat(0.5))], Vec::new(), 0)
    }

    fn receiver(&self, stage: &Stage) -> Receiver {
        let mut receiver = stage.receiver(self.position, self.normal.normalize_or_zero());
        if let Some(normal) = self.shading {
            receiver.point.shading_normal = turned(normal.normalize_or_zero());
        }
        receiver
    }

    fn light(&self) -> AreaLight {
        turned_light(&self.light)
    }

    fn estimate(&self, trial: &Trial) -> Result<Estimate, Problem> {
        self.estimate_seen_by(trial, &CLEAR)
    }

    fn estimate_seen_by(&self, trial: &Trial, tracer: &Always) -> Result<Estimate, Problem> {
        let stage = self.stage();
        let receiver = self.receiver(&stage);
        let world = World { tracer, ..stage.world(trial, Some(self.light())) };
        let input = format_args!("a receiver at {:.3} {}", receiver.point.origin, self.name);
        estimate(FUNCTION, input, &world, |world| direct(trial.functions, world, &receiver))
    }

    fn expected(&self) -> Vec3 {
        let receiver = self.receiver(&self.stage());
        let light = self.light();
        polygon_irradiance(receiver.point.origin, receiver.normal(), &light.corners(), light.radiance)
    }

    fn failure(&self, test: &'static str, found: &Estimate) -> Failure {
        differs(FUNCTION, test, self.name, found, (self.expected(), "Lambert's formula for a polygon, eq. 6"))
    }
}

pub(super) fn tests(trial: &Trial) -> Check {
    let stage = PLAIN[0].stage();
    let (receiver, world) = (PLAIN[0].receiver(&stage), stage.world(trial, Some(PLAIN[0].light())));
    let world = World { tracer: &CLEAR, ..world };
    written(trial, FUNCTION, &[receiver.point], |functions, point| {
        direct(functions, &world, &Receiver { point, ..receiver })
    })?;
    for look in &PLAIN {
        let found = look.estimate(trial)?;
        if !found.is(look.expected()) {
            return Err(look.failure("light that is seen whole", &found).into());
        }
    }
    let special = [
        (&BEHIND, "the light's back", "the light's back side shines: count only points whose cosθ_l is positive"),
        (&BELOW, "light below the horizon", "light from below the horizon counts: leave out what has cosθ ≤ 0"),
        (&CUT, CUT_TEST, "light from below the horizon counts: each point by itself is left out where cosθ ≤ 0"),
        (
            &SHADED,
            "the vertex's normal",
            "the triangle's normal is used: cosθ is measured from the receiver's normal()",
        ),
    ];
    for (look, test, hint) in special {
        let found = look.estimate(trial)?;
        if !found.is(look.expected()) {
            let hint = if test == CUT_TEST && found.is_near(look.expected() / above_horizon(look)) {
                "the sum is divided by the number of points that contribute: divide by that of all points"
            } else if look.expected() == Vec3::ZERO && found.mean.min_element() < 0.0 {
                "negative cosines are summed: a point counts only where both cosines are positive"
            } else {
                hint
            };
            return Err(look.failure(test, &found).hint(hint).into());
        }
    }
    let no_light = World { light: None, ..world };
    let value = call(FUNCTION, "a world without a light", || direct(trial.functions, &no_light, &receiver))?;
    if value != Vec3::ZERO {
        return Err(Failure::new(FUNCTION, "no light", format!("{value} without a light"), "0").into());
    }
    takes_its_own_points(FUNCTION, &world, &receiver, |world, receiver| direct(trial.functions, world, receiver))
}

const CUT_TEST: &str = "light cut by the horizon";

/// The share of the light's area above the horizon.
fn above_horizon(look: &Look) -> f32 {
    let share = look.value([0, 0, 0, 0, 0, 0], GRID) / look.light.radiance;
    share.x
}

/// Exponents of what is multiplied in eq. 3: cosθ, cosθ_l, r, the density, π, and the number of points.
type Powers = [i32; 6];

const RIGHT: Powers = [1, 1, -2, -1, 0, 0];

/// The factor, its wrong exponent, and what to say.
const SINGLE: [(usize, i32, &str); 19] = [
    (0, 0, "the cosine at the receiver, cosθ, is missing"),
    (0, 2, "the cosine at the receiver, cosθ, is squared"),
    (1, 0, "the cosine at the light, cosθ_l, is missing"),
    (1, 2, "the cosine at the light, cosθ_l, is squared"),
    (2, -1, "r where r² is meant (or a cosine is taken of a vector that is not of unit length)"),
    (2, 0, "the division by r² is missing (or both cosines are taken of a vector that is not of unit length)"),
    (2, -3, "r³ where r² is meant"),
    (2, -4, "r⁴ where r² is meant: divided by the square of the distance twice"),
    (3, 0, "the division by the density pdf_area is missing"),
    (3, 1, "multiplied by the density pdf_area where it must be divided by it"),
    (3, -2, "divided by the density pdf_area twice"),
    (4, 1, "multiplied by π: eq. 3 has no π"),
    (4, 2, "multiplied by π twice: eq. 3 has no π"),
    (4, -1, "divided by π: eq. 3 has no π (B = π L is for surfaces that reflect)"),
    (4, -2, "divided by π twice: eq. 3 has no π"),
    (5, 1, "the sum is not divided by the number of points"),
    (5, -1, "divided by the number of points twice"),
    (2, 2, "multiplied by r² where it must be divided by it"),
    (2, 1, "multiplied by r, and r² is to divide by"),
];

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    if failure.test != "light that is seen whole" {
        return None;
    }
    let found: Vec<Estimate> = PLAIN.iter().filter_map(|look| look.estimate(trial).ok()).collect();
    if found.len() < PLAIN.len() {
        return None;
    }
    if found.iter().all(|found| found.mean == Vec3::ZERO) {
        return Some(String::from(dark(trial)));
    }
    if found.iter().all(|found| found.mean.max_element() <= 0.0) {
        return Some(String::from("the result is negative: a cosine has the wrong sign"));
    }
    let fits = |factor: &dyn Fn(&Look) -> Option<Vec3>| {
        PLAIN.iter().zip(&found).all(|(look, found)| factor(look).is_some_and(|wrong| found.is_near(wrong)))
    };
    let bands = |look: &Look| found_share(look, trial);
    let changes = SINGLE.iter().map(|single| vec![single]);
    let pairs = SINGLE.iter().flat_map(|a| SINGLE.iter().filter(|b| b.0 > a.0).map(move |b| vec![a, b]));
    for change in changes.chain(pairs) {
        let mut powers = RIGHT;
        for (factor, power, _) in &change {
            powers[*factor] = *power;
        }
        if fits(&|look| Some(look.value(powers, GRID))) {
            let hints: Vec<&str> = change.iter().map(|single| single.2).collect();
            return Some(hints.join("; and "));
        }
    }
    if fits(&|look| Some(look.value(RIGHT, 1))) {
        return Some(String::from("one point in the middle of the light is taken: take all points of the receiver"));
    }
    if fits(&|look| Some(look.expected() / look.light.radiance)) {
        return Some(String::from("the light's radiance is missing"));
    }
    if PLAIN.iter().all(bands) {
        return Some(String::from("the bands are mixed up: each band of the radiance goes by itself"));
    }
    own_points(trial)
}

/// The hint about points that are not the world's, where it is those that keep the mean away from what is expected.
fn own_points(trial: &Trial) -> Option<String> {
    let stage = PLAIN[0].stage();
    let world = World { tracer: &CLEAR, ..stage.world(trial, Some(PLAIN[0].light())) };
    let run = |world: &World, receiver: &Receiver| direct(trial.functions, world, receiver);
    match takes_its_own_points(FUNCTION, &world, &PLAIN[0].receiver(&stage), run) {
        Err(Problem::Wrong(failure)) => failure.hint,
        _ => None,
    }
}

/// Whether the bands share the light in other parts than its radiance does.
fn found_share(look: &Look, trial: &Trial) -> bool {
    let Ok(found) = look.estimate(trial) else { return false };
    let ratio = found.mean / look.expected();
    ratio.max_element() > 1.1 * ratio.min_element()
}

/// What keeps all light away.
fn dark(trial: &Trial) -> &'static str {
    let shines = |look: &Look| look.estimate(trial).is_ok_and(|found| found.mean.x > 0.0);
    let blocked = Always { occluded: true };
    if PLAIN[0].estimate_seen_by(trial, &blocked).is_ok_and(|found| found.mean.x > 0.0) {
        "the answer of the shadow ray is turned round: blocked samples bring 0, the others count"
    } else if shines(&BEHIND) {
        "the cosine at the light has the wrong sign: the light shines to its back only (cosθ_l is taken of the \
         direction from the light to the receiver)"
    } else if shines(&BELOW) {
        "the cosine at the receiver has the wrong sign: light counts from below the horizon only"
    } else {
        "no light arrives: do both cosines have the right sign, and is the sum returned?"
    }
}

/// Points on a side of the light in [`Look::value`].
const GRID: u16 = 24;

impl Look {
    /// What a function with these exponents gives: the mean over a grid of points.
    fn value(&self, powers: Powers, grid: u16) -> Vec3 {
        let receiver = self.receiver(&self.stage());
        let light = self.light();
        let mut sum = 0.0;
        let middle = |index| (2.0 * f32::from(index) + 1.0) / f32::from(grid) - 1.0;
        for place in (0..grid).flat_map(|y| (0..grid).map(move |x| Vec2::new(middle(x), middle(y)))) {
            let to_light =
                light.centre + place.x * light.half_extent_u + place.y * light.half_extent_v - receiver.point.origin;
            let length = to_light.length();
            let factors = [
                to_light.dot(receiver.normal()).max(0.0) / length,
                (-to_light.dot(light.normal())).max(0.0) / length,
                length,
                1.0 / light.area(),
                PI,
                POINTS as f32,
            ];
            if factors[0] <= 0.0 {
                continue;
            }
            sum += factors.into_iter().zip(powers).map(|(factor, power)| factor.powi(power)).product::<f32>();
        }
        light.radiance * sum / (f32::from(grid) * f32::from(grid))
    }
}
