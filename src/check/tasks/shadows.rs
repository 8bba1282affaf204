//! Task `shadows`: direct light with visibility.

use glam::{Vec2, Vec3};

use super::{
    cornell,
    probe::{Check, Failure, Problem, Trial, call, written},
    stage::{Estimate, Quad, Stage, Witness, differs, direct, estimate, matt, turned, turned_back, turned_light},
    unshadowed::FUNCTION,
};
use crate::{
    check::closed_form::polygon_irradiance,
    scene::AreaLight,
    student::{Receiver, World},
    trace::Ray,
};

/// Faces down, towards the floor at y = 0.
const LIGHT: AreaLight = AreaLight {
    centre: Vec3::new(0.0, 0.8, 0.0),
    half_extent_u: Vec3::new(0.2, 0.0, 0.0),
    half_extent_v: Vec3::new(0.0, 0.0, 0.2),
    radiance: Vec3::new(4.0, 2.0, 1.0),
};

/// What stands in the way besides the floor.
#[derive(Clone, Copy, PartialEq)]
enum Blocker {
    None,
    /// Between, its front to the receiver or to the light.
    Whole {
        faces_down: bool,
    },
    /// Between, in the way of a part.
    Part,
    /// Between, a hair above the receiver.
    Close,
    /// Beyond the light, this high.
    Beyond(f32),
}

/// How high [`Blocker::Part`] is, and from which x on it blocks.
const PART: (f32, f32) = (0.4, 0.03);

struct Case {
    blocker: Blocker,
    stage: Stage,
    receiver: Receiver,
}

fn plate(low: Vec2, high: Vec2, y: f32, faces_down: bool) -> Quad {
    let (x, z) = ((high.x - low.x) * Vec3::X, (high.y - low.y) * Vec3::Z);
    let (along, up) = if faces_down { (x, z) } else { (z, x) };
    Quad { corner: Vec3::new(low.x, y, low.y), along, up, material: 0 }
}

impl Case {
    fn new(blocker: Blocker) -> Self {
        let square = |size: f32| (Vec2::splat(-size), Vec2::splat(size));
        let (low, high) = square(0.5);
        let mut quads = vec![plate(low, high, 0.0, false)];
        quads.extend(match blocker {
            Blocker::None => None,
            Blocker::Whole { faces_down } => Some(plate(low, high, 0.4, faces_down)),
            Blocker::Part => Some(plate(Vec2::new(PART.1, -0.5), high, PART.0, true)),
            Blocker::Close => Some(plate(square(0.3).0, square(0.3).1, 0.002, true)),
            Blocker::Beyond(height) => Some(plate(square(0.9).0, square(0.9).1, height, true)),
        });
        let stage = Stage::new(&quads, vec![matt(Vec3::splat(0.5))], Vec::new(), 3);
        let receiver = stage.receiver(Vec3::new(0.06, 0.0, -0.06), Vec3::Y);
        Self { blocker, stage, receiver }
    }

    fn world<'a>(&'a self, trial: &Trial<'a>) -> World<'a> {
        self.stage.world(trial, Some(turned_light(&LIGHT)))
    }

    fn estimate(&self, trial: &Trial) -> Result<Estimate, Problem> {
        let world = self.world(trial);
        estimate(FUNCTION, "a receiver on a floor", &world, |world| direct(trial.functions, world, &self.receiver))
    }

    /// Irradiance from the part of the light that is in sight.
    fn expected(&self) -> Vec3 {
        let mut light = LIGHT;
        match self.blocker {
            Blocker::None | Blocker::Beyond(_) => {}
            Blocker::Whole { .. } | Blocker::Close => return Vec3::ZERO,
            Blocker::Part => {
                // The edge as the receiver sees it on the light.
                let start = turned_back(self.receiver.point.origin).x;
                let edge = start + (PART.1 - start) * LIGHT.centre.y / PART.0;
                let low = LIGHT.centre.x - LIGHT.half_extent_u.x;
                light.centre.x = 0.5 * (low + edge);
                light.half_extent_u.x = 0.5 * (edge - low);
            }
        }
        let light = turned_light(&light);
        polygon_irradiance(self.receiver.point.origin, self.receiver.normal(), &light.corners(), light.radiance)
    }

    fn rays(&self, trial: &Trial) -> Vec<Ray> {
        let witness = Witness::new(&self.stage);
        let world = World { tracer: &witness, ..self.world(trial) };
        // Rays that a fault cuts off are missing: no harm.
        let _ = call(FUNCTION, "", || direct(trial.functions, &world, &self.receiver));
        witness.rays()
    }
}

const WHOLE: Blocker = Blocker::Whole { faces_down: true };

/// The steps: what is in the way, the test, where, and the mistake that is likely if no other is seen.
const STEPS: [(Blocker, &str, &str, &str); 7] = [
    (
        WHOLE,
        "a plate between",
        "below a plate that hides the light",
        "light comes through what lies between: leave out the samples whose shadow ray is blocked",
    ),
    (
        Blocker::None,
        "nothing between",
        "on a floor with nothing between",
        "the shadow ray meets the surface that it leaves from: take the ray that receiver.point makes (ray_to)",
    ),
    (
        Blocker::Beyond(0.9),
        "a wall behind the light",
        "with a wall beyond the light",
        "what lies beyond the light blocks: the shadow ray must end at the light's point (max_distance, ray_to)",
    ),
    (
        Blocker::Beyond(0.804),
        "a wall close behind the light",
        "with a wall close behind the light",
        "the shadow ray is a little too long and goes through the light's plane: it must end at the light's point",
    ),
    (
        Blocker::Part,
        "a plate over a part of the light",
        "below a plate that hides a part of the light",
        "the sum over the points in sight must be divided by the number of all points, and each point has its own ray",
    ),
    (
        Blocker::Whole { faces_down: false },
        "a plate that turns its back",
        "below a plate that hides the light and turns its back",
        "light comes through the back of a surface: front and back both block",
    ),
    (
        Blocker::Close,
        "a plate close to the floor",
        "below a plate close above the floor",
        "the shadow ray starts too far from the surface, beyond what lies close to it: take receiver.point's ray_to",
    ),
];

pub(super) fn tests(trial: &Trial) -> Check {
    let open = Case::new(Blocker::None);
    let world = open.world(trial);
    written(trial, FUNCTION, &[open.receiver.point], |functions, point| {
        direct(functions, &world, &Receiver { point, ..open.receiver })
    })?;
    if open.rays(trial).is_empty() && Case::new(WHOLE).rays(trial).is_empty() {
        return Err(Problem::NotDone("the shadow rays of direct_irradiance"));
    }
    for (blocker, test, place, fallback) in STEPS {
        let case = Case::new(blocker);
        let found = case.estimate(trial)?;
        let expected = case.expected();
        if !found.is(expected) {
            let source =
                if expected == Vec3::ZERO { "no light arrives" } else { "eq. 6, of the part that is in sight" };
            return Err(differs(FUNCTION, test, place, &found, (expected, source)).fallback(fallback).into());
        }
    }
    cornell::direct(trial)
}

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    if failure.test == cornell::TEST {
        return None;
    }
    let estimate = |blocker| Case::new(blocker).estimate(trial).ok();
    let (open, hidden) = (estimate(Blocker::None)?, estimate(WHOLE)?);
    let (light, dark) = (Case::new(Blocker::None).expected(), Vec3::ZERO);
    if open.is(dark) && hidden.is(light) {
        return Some(String::from(
            "the answer of the shadow ray is turned round: blocked samples bring 0, the others count",
        ));
    }
    if hidden.is(light) {
        return Some(String::from("the answer of the shadow ray is not used: blocked samples bring 0"));
    }
    let open_case = Case::new(Blocker::None);
    let rays = open_case.rays(trial);
    let light_centre = turned(LIGHT.centre);
    let origin = open_case.receiver.point.origin;
    let mean_direction = rays.iter().map(|ray| ray.direction).sum::<Vec3>() / rays.len().max(1) as f32;
    if rays.iter().any(|ray| !(ray.direction.is_normalized() && ray.direction.is_finite())) {
        return Some(String::from("the shadow ray's direction is not of unit length"));
    }
    let from_light = |ray: &Ray| ray.origin.distance(light_centre) < ray.origin.distance(origin);
    if failure.test == "nothing between" {
        return Some(String::from(if rays.iter().all(from_light) && !rays.is_empty() {
            "the shadow ray runs from the light to the receiver and meets the receiver's own surface: turn it round, \
             with receiver.point.ray_to"
        } else if mean_direction.dot(light_centre - origin) < 0.0 {
            "the shadow ray runs away from the light: its direction is turned round"
        } else {
            return None;
        }));
    }
    if failure.test != "a plate over a part of the light" {
        return None;
    }
    let found = estimate(Blocker::Part)?;
    let expected = Case::new(Blocker::Part).expected();
    let share = visible_share();
    let rays = Case::new(Blocker::Part).rays(trial);
    if rays.iter().all(|ray| ray.direction.abs_diff_eq(rays[0].direction, 1e-5)) {
        Some(String::from("one shadow ray serves all points, which gives hard shadows: each point has its own"))
    } else if found.is_near(expected / share) {
        Some(String::from(
            "the sum is divided by the number of unblocked rays: blocked ones count as samples that bring 0",
        ))
    } else {
        None
    }
}

/// The share of the light's area that [`Blocker::Part`] leaves in sight.
fn visible_share() -> f32 {
    let start = turned_back(Case::new(Blocker::Part).receiver.point.origin).x;
    let edge = start + (PART.1 - start) * LIGHT.centre.y / PART.0;
    (edge - LIGHT.centre.x) / (2.0 * LIGHT.half_extent_u.x) + 0.5
}
