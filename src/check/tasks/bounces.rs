//! Task `bounces`: bounce after bounce, as the solver calls the function.

use std::sync::Arc;

use glam::Vec3;

use super::{
    bounce::{self, FUNCTION},
    cornell,
    gather::Case,
    probe::{Check, Failure, Problem, Trial},
    stage::{Estimate, differs},
};
use crate::{
    math::sequence::Sampler,
    scene::{LoadOptions, area_light::AreaLightState},
    solver::{Engine, Monitor, Problem as SolverProblem, SolveSettings, Solved, solve_with},
    student::Functions,
    trace::Tracer,
};

/// The bounces so far as multiples of one field: none is a sum or mean of others.
const SCALES: [f32; 3] = [1.0, 0.4, 0.15];

pub(super) fn tests(trial: &Trial) -> Check {
    bounce::is_written(trial)?;
    let (case, one) = bounce::painted();
    let found = after_three(trial, case)?;
    let expected = SCALES[2] * *one;
    if !found.is(expected) {
        if found.mean == Vec3::ZERO {
            return Err(Problem::NotDone("the bounces of indirect_irradiance after the first"));
        }
        let place = "after direct light and two bounces, in a box of six reflectances";
        let source = "the bounce before, gathered: eq. 4";
        let failure = differs(FUNCTION, "the bounce before", place, &found, (expected, source));
        return Err(failure.fallback("gather the last of the bounces, and that one alone").into());
    }
    furnace(trial)?;
    cornell::bounces(trial)
}

fn after_three(trial: &Trial, case: &Case) -> Result<Estimate, Problem> {
    let scaled = SCALES.map(|scale| case.field.iter().map(|value| scale * value).collect::<Vec<_>>());
    case.estimate_of(trial, &scaled.each_ref().map(|field| field.as_slice()))
}

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    if failure.test != "the bounce before" {
        return None;
    }
    let &(ref case, one) = bounce::painted();
    let found = after_three(trial, case).ok()?;
    let own = case.field[case.receiver.vertex as usize];
    let sum = SCALES.iter().sum::<f32>();
    let known = [
        (
            sum * one,
            "the sum of all bounces so far is gathered where the last one alone is meant: light is counted again in \
             each bounce",
        ),
        (SCALES[0] * one, "direct light is gathered each time: gather the last of the bounces, not the first"),
        (SCALES[1] * one, "the bounce before the last is gathered: take the last"),
        (sum / 3.0 * one, "the mean of the bounces is gathered where the last one alone is meant"),
        (
            (SCALES[2] + SCALES[0]) * one,
            "direct light is counted again in each bounce: gather the last of the bounces alone",
        ),
        (
            SCALES[2] * one + SCALES[0] * own,
            "direct light at the receiver is added to each bounce: this bounce alone is wanted, the solver sums them",
        ),
        (
            SCALES[2] * (one + own),
            "the receiver's own value of the bounce before is added: this bounce alone is wanted",
        ),
        (
            SCALES[2] * one + (SCALES[1] + SCALES[2]) * own,
            "what the receiver got in earlier bounces is added: this bounce alone is wanted, the solver sums them",
        ),
        (SCALES[2] * one + sum * own, "what the receiver got so far is added: this bounce alone is wanted"),
    ];
    known.into_iter().find(|(wrong, _)| found.is_near(*wrong)).map(|(_, hint)| String::from(hint))
}

/// A closed box through the solver: bounce n of direct irradiance 1 is the reflectance to the power n (eq. 5).
fn furnace(trial: &Trial) -> Check {
    let functions = Functions { direct_irradiance: |_, _| Vec3::ONE, ..*trial.functions };
    let case = bounce::furnace();
    let settings = SolveSettings {
        engine: Engine::Student,
        rays: 8,
        light_rays: 1,
        bounces: Some(4),
        sampler: Sampler::Random,
        seed: trial.seed,
        subdivide: 2,
        ..SolveSettings::even()
    };
    let problem = SolverProblem {
        tracer: Arc::new(Tracer::new(Arc::clone(&case.stage.scene))),
        tessellation: Arc::new(case.stage.tessellation),
        scene: case.stage.scene,
        load: LoadOptions::default(),
        light: Some(AreaLightState::default()),
        settings,
    };
    let Solved { solution, .. } = solve_with(&problem, &functions, &Monitor::new(&problem.tessellation, None));
    let reflectance = problem.scene.materials[0].reflectance;
    for (bounce, field) in solution.bounces.iter().enumerate() {
        let expected = reflectance.powf(bounce as f32);
        let count = field.len() as f32;
        let mean = field.iter().sum::<Vec3>() / count;
        let squares: Vec3 = field.iter().map(|value| (value - mean) * (value - mean)).sum();
        let standard_error = squares.max_element().sqrt() / count;
        // Each bounce takes the same points, so that their errors add up.
        let tolerance = 1e-3 + 6.0 * standard_error * bounce.max(1) as f32;
        if !mean.abs_diff_eq(expected, tolerance) {
            let measured = format!("{mean:.4} in bounce {bounce} of a closed box of direct irradiance 1");
            let expected = format!("{expected:.4}: reflectance to the power {bounce}, eq. 5");
            return Err(Failure::new(FUNCTION, "furnace, bounce by bounce", measured, &expected)
                .fallback("a bounce takes more than the bounce before: each is gathered from the last one alone")
                .into());
        }
    }
    Ok(())
}
