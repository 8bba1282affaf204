//! The Cornell box, against irradiance that was computed beforehand by another method.
//!
//! `data/cornell.csv` is what the reference path tracer of this program finds at 256 points, each to about half a
//! percent: `radiosity truth cornell --sample 256 --samples 32768 --bounces 2 --seed 4 -o cornell.csv`.

use std::sync::{Arc, OnceLock};

use glam::Vec3;

use super::{
    probe::{Check, Failure, Trial, call},
    stage::{Stage, direct as direct_irradiance},
    unshadowed::FUNCTION,
};
use crate::{
    check::{
        surface_points::{TrianglePoint, locate},
        truth_file::{self, TruthValue},
    },
    math::sequence::Sampler,
    scene::{LoadOptions, area_light::AreaLightState, builtin},
    solver::{Engine, Monitor, Problem as SolverProblem, Solution, SolveSettings, State, solve_with},
    student::{Functions, PLACEHOLDERS, Receiver, World},
    trace::{SurfacePoint, Tracer},
};

pub(super) const TEST: &str = "Cornell box";

const TRUTH: &str = include_str!("data/cornell.csv");

/// What means may differ by beside their standard errors: the truths' own error for direct irradiance at points; for
/// the bounces of a solve, that elements of 1/8 of a wall make the means up to 4 % too small. (Mistakes that change less
/// are found in the small scenes.)
const DIRECT_TOLERANCE: f64 = 0.01;
const BOUNCE_TOLERANCE: f64 = 0.08;

/// Right functions go beyond this once in two million times.
const MOST_STANDARD_ERRORS: f64 = 5.0;

struct Cornell {
    stage: Stage,
    light: Option<AreaLightState>,
    truths: Vec<(TrianglePoint, TruthValue)>,
}

/// The box and the truths, read once.
fn cornell() -> &'static Cornell {
    static CORNELL: OnceLock<Cornell> = OnceLock::new();
    CORNELL.get_or_init(|| {
        let scene = builtin::cornell(&LoadOptions::default());
        let stage = Stage::of(Arc::new(scene.unwrap_or_else(|error| panic!("{error}"))), 3);
        let (state, _) = State::from_toml(builtin::CORNELL_STATE).unwrap_or_default();
        let truths = truth_file::parse(TRUTH).unwrap_or_default();
        let values = truths.values.unwrap_or_default();
        // Points under the blocks are dark, and told badly by elements that lie under them in part.
        let is_lit = |value: &TruthValue| value.total.max_element() > 1e-3;
        let pairs = truths.points.iter().zip(values).filter(|(_, value)| is_lit(value));
        let truths =
            pairs.filter_map(|(point, value)| Some((locate(&stage.scene, &stage.tracer, point)?.on()?, value)));
        let truths: Vec<_> = truths.collect();
        Cornell { light: state.light, truths, stage }
    })
}

/// Compares the means of (found, expected) pairs.
fn compare(function: &'static str, what: &str, pairs: &[(f64, f64)], tolerance: f64) -> Check {
    let count = pairs.len() as f64;
    let expected = pairs.iter().map(|pair| pair.1).sum::<f64>() / count;
    let difference = pairs.iter().map(|(found, expected)| found - expected).sum::<f64>() / count;
    let squares: f64 = pairs.iter().map(|(found, expected)| (found - expected - difference).powi(2)).sum();
    let standard_error = (squares / count).sqrt() / (count - 1.0).sqrt();
    if difference.abs() <= tolerance * expected + MOST_STANDARD_ERRORS * standard_error {
        return Ok(());
    }
    let found = expected + difference;
    let measured = format!("{what} is {found:.4} ± {standard_error:.4} W/m² on average over {count} points");
    let expected = format!("{expected:.4} (a path tracer's) within {:.1} %", 100.0 * tolerance);
    Err(Failure::new(function, TEST, measured, &expected)
        .fallback("in single steps all is right, in a whole scene it is not: look at the scene with --engine student")
        .into())
}

/// The functions with the program's own Sobol points, which make less noise.
fn with_given_points(trial: &Trial) -> Functions {
    Functions { low_discrepancy_point: PLACEHOLDERS.low_discrepancy_point, ..*trial.functions }
}

/// Direct irradiance at the points of the truth.
pub(super) fn direct(trial: &Trial) -> Check {
    let Cornell { stage, light, truths } = cornell();
    let functions = with_given_points(trial);
    let world = stage.world(trial, light.map(|light| light.to_local(&stage.scene.frame)));
    let world = World { functions: &functions, sampler: Sampler::Sobol, ..world };
    let mut pairs = Vec::new();
    for ((triangle, barycentric), value) in truths {
        let (element, _) = stage.tessellation.locate(*triangle, *barycentric);
        let vertex = stage.tessellation.mesh.triangles[element as usize][0];
        let point = SurfacePoint::new(&stage.scene, *triangle, *barycentric);
        let receiver = Receiver { vertex, place: (0, 1), point };
        let input = format_args!("a point of the Cornell box, {:.4}", point.origin);
        let found = call(FUNCTION, input, || direct_irradiance(trial.functions, &world, &receiver))?;
        pairs.push((f64::from(found.x), value.direct.x));
    }
    compare(FUNCTION, "direct irradiance (red)", &pairs, DIRECT_TOLERANCE)
}

/// Direct irradiance and two bounces of a whole solve.
pub(super) fn bounces(trial: &Trial) -> Check {
    const INDIRECT: &str = "indirect_irradiance";
    let solution = solved(trial);
    let Cornell { stage, truths, .. } = cornell();
    let expected: [fn(&TruthValue) -> f64; 3] =
        [|value| value.direct.y, |value| value.bounce1.y, |value| value.bounce2.y];
    let functions = [FUNCTION, INDIRECT, INDIRECT];
    let names = ["direct irradiance", "bounce 1", "bounce 2"];
    for (bounce, field) in solution.bounces.iter().enumerate() {
        let pair = |&((triangle, barycentric), value): &(TrianglePoint, TruthValue)| {
            let found: Vec3 = stage.tessellation.interpolate(field, triangle, barycentric);
            (f64::from(found.y), expected[bounce](&value))
        };
        let pairs: Vec<(f64, f64)> = truths.iter().map(pair).collect();
        compare(functions[bounce], names[bounce], &pairs, BOUNCE_TOLERANCE)?;
    }
    Ok(())
}

fn solved(trial: &Trial) -> Solution {
    let Cornell { stage, light, .. } = cornell();
    let settings = SolveSettings {
        engine: Engine::Student,
        rays: 16,
        light_rays: 16,
        bounces: Some(2),
        sampler: Sampler::Sobol,
        seed: trial.seed,
        subdivide: 3,
        ..SolveSettings::even()
    };
    let problem = SolverProblem {
        scene: Arc::clone(&stage.scene),
        tracer: Arc::new(Tracer::new(Arc::clone(&stage.scene))),
        tessellation: Arc::new(stage.tessellation.clone()),
        load: LoadOptions::default(),
        light: *light,
        settings,
    };
    solve_with(&problem, &with_given_points(trial), &Monitor::new(&problem.tessellation, None)).solution
}
