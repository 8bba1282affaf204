//! Task `bounce`: one bounce, from values at the vertices.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::{
    gather::{self, Case, Shape},
    probe::{Check, Failure, Trial, written},
    stage::{Quad, Stage, box_inside, differs, matt, takes_its_own_points, turned},
};
use crate::student::Receiver;

pub(super) const FUNCTION: &str = "indirect_irradiance";

const LOW: Vec3 = Vec3::new(-0.5, -0.4, -0.6);
const HIGH: Vec3 = Vec3::new(0.5, 0.5, 0.6);

/// A place on the floor, off the middle.
const PLACE: Vec3 = Vec3::new(0.26, LOW.y, -0.3);

/// A closed box with these materials; the field is given by wall and place in the box.
fn room(reflectances: [Vec3; 6], field: impl Fn(usize, Vec3) -> Vec3) -> Case {
    let stage = Stage::new(&box_inside(LOW, HIGH), reflectances.map(matt).to_vec(), Vec::new(), 2);
    let receiver = stage.receiver(PLACE, Vec3::Y);
    Case::new(stage, receiver, field)
}

/// All surfaces alike.
pub(super) fn furnace() -> Case {
    room([Vec3::new(0.3, 0.5, 0.7); 6], |_, _| Vec3::new(1.0, 2.0, 4.0))
}

/// A value and a reflectance for each wall.
fn painted_room() -> Case {
    let reflectances =
        [[0.2, 0.3, 0.9], [0.8, 0.6, 0.1], [0.5, 0.5, 0.4], [0.3, 0.7, 0.6], [0.6, 0.2, 0.3], [0.7, 0.8, 0.5]];
    let values = [[9.0, 7.0, 8.0], [2.0, 1.0, 4.0], [3.0, 2.0, 1.0], [1.0, 3.0, 2.0], [4.0, 4.0, 1.0], [2.0, 3.0, 5.0]];
    room(reflectances.map(Vec3::from_array), |wall, _| Vec3::from_array(values[wall]))
}

/// One bright wall; the receiver's normal is not its triangle's.
fn tilted() -> Case {
    let bright = Vec3::new(2.0, 1.0, 3.0);
    let mut case = room([Vec3::splat(0.5); 6], |wall, _| if wall == 4 { bright } else { Vec3::ZERO });
    case.receiver.point.shading_normal = turned(Vec3::new(-0.6, 0.75, 0.2).normalize_or_zero());
    case
}

/// A plate this high above the receiver and nothing else but some floor: rays that pass it meet nothing.
fn plate(height: f32, faces_down: bool, field: impl Fn(usize, Vec2) -> Vec3) -> Case {
    let (x, z) = (0.7 * Vec3::X, 0.6 * Vec3::Z);
    let floor = Quad { corner: PLACE, along: 0.3 * Vec3::Z, up: 0.3 * Vec3::X, material: 0 };
    let corner = PLACE + height * Vec3::Y - 0.85 * x - 0.25 * z;
    let (along, up) = if faces_down { (x, z) } else { (z, x) };
    let quads = [floor, Quad { corner, along, up, material: 1 }];
    let materials = [Vec3::new(0.4, 0.4, 0.4), Vec3::new(0.8, 0.6, 0.4)].map(matt).to_vec();
    let stage = Stage::new(&quads, materials, Vec::new(), 0);
    let receiver = stage.receiver(PLACE, Vec3::Y);
    // From (0, 0) to (1, 1) on the plate.
    let on_plate = |place: Vec3| Vec2::new((place - corner).x / 0.7, (place - corner).z / 0.6);
    Case::new(stage, receiver, |quad, place| field(quad, on_plate(place)))
}

fn open_plate() -> Case {
    plate(0.3, true, |quad, _| if quad == 1 { Vec3::new(1.0, 2.0, 4.0) } else { Vec3::ZERO })
}

/// Values that differ from corner to corner of two large elements.
fn slope() -> Case {
    plate(0.06, true, |quad, Vec2 { x, y }| {
        if quad == 1 { 10.0 * Vec3::new((1.0 - x) * (1.0 - y), x * (1.0 - y), x * y) } else { Vec3::ZERO }
    })
}

fn turned_plate() -> Case {
    plate(0.3, false, |quad, _| if quad == 1 { Vec3::splat(5.0) } else { Vec3::ZERO })
}

/// The steps: the test, the set-up, where, and the mistake that is likely if no other is seen.
type Step = (&'static str, fn() -> Case, &'static str, &'static str);

const STEPS: [Step; 6] = [
    (
        "furnace",
        furnace,
        "in a closed box of one reflectance (0.3, 0.5, 0.7) and one irradiance (1, 2, 4)",
        "each ray brings reflectance times irradiance, band by band; the mean over the rays is the result",
    ),
    (
        "a plate in the open",
        open_plate,
        "below a plate with nothing around",
        "the rays are not spread by the cosine: density cosθ/π about the receiver's normal",
    ),
    (
        "painted walls",
        painted_room,
        "in a box of six reflectances and six irradiances",
        "reflectance and irradiance must be those of the place that the ray meets",
    ),
    (
        "values from corner to corner",
        slope,
        "below a plate whose corners have different irradiances",
        "the irradiance at a hit must lie between the values of the three vertices by its barycentric coordinates",
    ),
    (
        "a plate that turns its back",
        turned_plate,
        "below the back of a plate",
        "the back of a surface reflects: a ray that meets a back side brings 0 (hit.front)",
    ),
    (
        "the vertex's normal",
        tilted,
        "where the vertex's normal is not the triangle's",
        "the directions are taken about another normal: the hemisphere stands about receiver.normal()",
    ),
];

/// The set-ups of the steps with what is expected there, made once.
fn cases() -> &'static [(Case, Vec3)] {
    static CASES: OnceLock<Vec<(Case, Vec3)>> = OnceLock::new();
    let with_expected = |case: Case| {
        let expected = case.expected(&Shape::default());
        (case, expected)
    };
    CASES.get_or_init(|| STEPS.iter().map(|step| with_expected((step.1)())).collect())
}

/// [`painted_room`], with what is expected there.
pub(super) fn painted() -> &'static (Case, Vec3) {
    &cases()[2]
}

pub(super) fn tests(trial: &Trial) -> Check {
    is_written(trial)?;
    for (&(test, _, place, fallback), &(ref case, expected)) in STEPS.iter().zip(cases()) {
        let found = case.estimate(trial)?;
        if !found.is(expected) {
            let source =
                if test == "furnace" { "reflectance times irradiance, eq. 4" } else { "eq. 6 for each surface" };
            return Err(differs(FUNCTION, test, place, &found, (expected, source)).fallback(fallback).into());
        }
    }
    let (case, _) = painted();
    let world = case.stage.world(trial, None);
    takes_its_own_points(FUNCTION, &world, &case.receiver, |world, receiver| {
        (trial.functions.indirect_irradiance)(world, receiver, &[&case.field])
    })
}

/// That the gather is written at all.
pub(super) fn is_written(trial: &Trial) -> Check {
    let case = furnace();
    let world = case.stage.world(trial, None);
    let is_written = written(trial, FUNCTION, &[case.receiver.point], |functions, point| {
        (functions.indirect_irradiance)(&world, &Receiver { point, ..case.receiver }, &[&case.field])
    });
    if is_written.is_err() && gather::traces(trial, &case) {
        let failure = Failure::new(FUNCTION, "furnace", String::from("0 in a closed box"), "what the walls send back");
        let hint = "rays are traced, but nothing is summed: front sides are those that shine back (hit.front)";
        return Err(failure.hint(hint).into());
    }
    is_written
}

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    match failure.test {
        "furnace"
        | "a plate in the open"
        | "painted walls"
        | "values from corner to corner"
        | "the vertex's normal" => gather::mistake(trial, cases()),
        _ => None,
    }
}
