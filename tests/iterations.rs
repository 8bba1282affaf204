//! The ways to add the bounces up: Neumann, Gauss-Seidel, shooting, Krylov. All lead to one field, with a true ledger.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::{cornell_light, own_scene, problem, solve_unwatched};
use glam::Vec3;
use radiosity::{
    check::closed_form::furnace_irradiance,
    scene::{LoadOptions, Scene, load::load_from_memory},
    solver::{Iteration, Job, Message, Problem, Solution, SolveReport, SolveSettings, Solved},
};

const OTHERS: [Iteration; 3] = [Iteration::GaussSeidel, Iteration::Shooting, Iteration::Krylov];

fn settings(iteration: Iteration, unabsorbed: f32) -> SolveSettings {
    SolveSettings { rays: 64, unabsorbed, iteration, ..SolveSettings::default() }
}

fn even(iteration: Iteration, unabsorbed: f32) -> SolveSettings {
    SolveSettings { adaptive: 0.0, subdivide: 3, ..settings(iteration, unabsorbed) }
}

/// The Cornell box in paint that reflects this much, with a grey floor so that bands and surfaces differ.
fn bright_box(reflectance: f32) -> Arc<Scene> {
    let load = LoadOptions { reflectance_limit: 0.999, ..LoadOptions::default() };
    let mut scene = Scene::clone(&own_scene("cornell/cornell", &load));
    for (index, material) in scene.materials.iter_mut().enumerate() {
        let darker = if index % 2 == 0 { 0.0 } else { 0.02 };
        material.reflectance = Vec3::new(reflectance, reflectance - darker, reflectance - 0.01);
    }
    Arc::new(scene)
}

/// A closed cube whose walls emit π L = 1 W/m² and reflect this much.
fn furnace(reflectance: f32) -> Arc<Scene> {
    let obj = "mtllib a.mtl\nusemtl wall\n\
        v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n\
        f 1 2 3 4\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 5 6 2 1\nf 4 3 7 8\n";
    let mtl =
        format!("newmtl wall\nKd {reflectance} {reflectance} {reflectance}\nKe 0.31830989 0.31830989 0.31830989\n");
    let load = LoadOptions { reflectance_limit: 0.999, ..LoadOptions::default() };
    Arc::new(load_from_memory("furnace", obj, &mtl, &load).unwrap())
}

fn difference(found: &[Vec3], expected: &[Vec3]) -> f32 {
    let squares: f32 = found.iter().zip(expected).map(|(found, expected)| (*found - *expected).length_squared()).sum();
    let mean = expected.iter().map(|value| value.element_sum()).sum::<f32>() / (3 * expected.len()) as f32;
    (squares / (3 * expected.len()) as f32).sqrt() / mean
}

/// What was emitted was absorbed or escaped, but for what is said to be left.
fn assert_true_ledger(report: &SolveReport, unabsorbed: f64, what: &str) {
    let emitted = report.energy.emitted.element_sum();
    let parts = &report.energy.bounces;
    let spent: f64 = parts.iter().map(|part| (part.absorbed + part.escaped).element_sum()).sum();
    assert!((spent / emitted - 1.0).abs() < 2.0 * unabsorbed, "{what}: {spent} of {emitted} W");
    // Sweeps are stopped by the norm of what is left, not by its power.
    assert!(report.unabsorbed <= 4.0 * unabsorbed, "{what}: {} unabsorbed", report.unabsorbed);
}

/// Expected: Neumann's series, which other tests hold to closed forms; and its ledger.
fn assert_all_agree(name: &str, problem_of: impl Fn(Iteration) -> Problem, unabsorbed: f64) {
    let (solution, report) = solve_unwatched(&problem_of(Iteration::Neumann));
    let total = |report: &SolveReport, of: fn(&radiosity::solver::energy::BouncePower) -> glam::DVec3| -> f64 {
        report.energy.bounces.iter().map(|part| of(part).element_sum()).sum()
    };
    assert_true_ledger(&report, unabsorbed, name);
    for iteration in OTHERS {
        let what = format!("{name}, {iteration:?}");
        let (other, other_report) = solve_unwatched(&problem_of(iteration));
        let apart = difference(&other.total(), &solution.total());
        assert!(apart < 1e-4, "{what}: {apart}");
        assert_eq!((other.bounces.len(), other.direct()), (2, solution.direct()), "{what}: direct and indirect light");
        assert_true_ledger(&other_report, unabsorbed, &what);
        let emitted = report.energy.emitted.element_sum();
        let of_both = |of| (total(&other_report, of), total(&report, of));
        for (part, (found, expected)) in
            [("absorbed", of_both(|part| part.absorbed)), ("escaped", of_both(|part| part.escaped))]
        {
            let apart = (found - expected).abs() / emitted;
            assert!(apart < 2e-4, "{what}: {part} power is off by {apart}");
        }
    }
}

#[test]
fn all_ways_agree_in_the_cornell_box() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let light = Some(cornell_light());
    assert_all_agree("even", |iteration| problem(&scene, light, even(iteration, 1e-5)), 1e-5);
    assert_all_agree("adaptive", |iteration| problem(&scene, light, settings(iteration, 1e-5)), 1e-5);
}

#[test]
fn all_ways_agree_in_a_bright_box() {
    let settings = |iteration| SolveSettings { subdivide: 2, rays: 32, ..even(iteration, 1e-5) };
    for reflectance in [0.95, 0.99] {
        let scene = bright_box(reflectance);
        let name = format!("reflectance {reflectance}");
        assert_all_agree(&name, |iteration| problem(&scene, Some(cornell_light()), settings(iteration)), 1e-5);
    }
}

/// Expected: eq. 5 at its limit, E0 / (1 - ρ).
#[test]
fn a_closed_box_reaches_its_limit_at_reflectance_0_and_095_and_0999() {
    for reflectance in [0.0, 0.95, 0.999] {
        let scene = furnace(reflectance);
        let expected = furnace_irradiance(1.0, f64::from(reflectance), 100_000);
        // At 0.999 only the Krylov method gets there within a thousand sweeps.
        for iteration in OTHERS.into_iter().filter(|way| reflectance < 0.99 || *way == Iteration::Krylov) {
            let settings = SolveSettings { subdivide: 1, ..even(iteration, 1e-6) };
            let (solution, report) = solve_unwatched(&problem(&scene, None, settings));
            let total = solution.total();
            let mean = total.iter().map(|value| f64::from(value.x)).sum::<f64>() / total.len() as f64;
            let error = mean / expected - 1.0;
            // Barycentric coordinates in steps of 1/65535 and sums of f32: each bounce is off by some 1e-7.
            let allowed = 1e-4 + 2e-7 / (1.0 - f64::from(reflectance));
            assert!(error.abs() < 2.0 * allowed, "{iteration:?}, {reflectance}: off by {error:e}");
            assert!(reflectance > 0.0 || report.iterations <= 2, "{iteration:?}: nothing reflects");
        }
    }
}

/// Expected: fewer looks at the rows; a power of the reflectance against a polynomial that fits the few large eigenvalues.
#[test]
fn a_bright_box_takes_the_krylov_method_a_fifth_of_neumanns_bounces() {
    let scene = bright_box(0.99);
    let count = |iteration| {
        let settings = SolveSettings { subdivide: 2, rays: 32, ..even(iteration, 1e-4) };
        solve_unwatched(&problem(&scene, Some(cornell_light()), settings)).1.iterations
    };
    let (neumann, krylov) = (count(Iteration::Neumann), count(Iteration::Krylov));
    assert!(krylov * 5 <= neumann, "{krylov} of {neumann}");
}

#[test]
fn every_way_gives_the_same_bits_on_one_thread_and_three_with_rows_kept_or_not() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    for iteration in OTHERS {
        let on = |threads, settings: SolveSettings| -> Solution {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solve_unwatched(&problem(&scene, Some(cornell_light()), settings)).0)
        };
        let settings = SolveSettings { adaptive: 0.2, rays: 16, ..settings(iteration, 1e-3) };
        let one = on(1, settings.clone());
        assert_eq!(one, on(3, settings.clone()), "{iteration:?}");
        let again = on(2, SolveSettings { row_memory: Some(0), ..settings });
        assert_eq!(one.bounces, again.bounces, "{iteration:?}: traced again");
    }
}

#[test]
fn sweeps_are_told_like_bounces_and_counted_by_the_limit() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    for iteration in OTHERS {
        let settings = SolveSettings { bounces: Some(2), ..even(iteration, 1e-6) };
        let job = Job::start(problem(&scene, Some(cornell_light()), settings), 2).unwrap();
        while !job.is_finished() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let mut sum: Vec<Vec3> = Vec::new();
        let mut sweeps = 0;
        for message in job.messages() {
            if let Message::Bounce { index, irradiance, .. } = message {
                assert_eq!(index, sweeps);
                sum.resize(irradiance.len(), Vec3::ZERO);
                sum.iter_mut().zip(irradiance.iter()).for_each(|(sum, value)| *sum += *value);
                sweeps += 1;
            }
        }
        let Solved { solution, report, .. } = job.finish().unwrap();
        // Direct light, two sweeps, and the last gather.
        assert_eq!((sweeps, report.iterations), (4, 3), "{iteration:?}");
        assert!(difference(&sum, &solution.total()) < 1e-6, "{iteration:?}");
    }
}
