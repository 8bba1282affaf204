//! The engine that runs on a student's functions: against the program's own, which shares no sampler with it, and with
//! functions that are missing or fail.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{f32::consts::PI, sync::Arc, time::Instant};

use common::{cornell_light, own_scene, problem, solve_unwatched};
use glam::{Mat3, Vec3};
use radiosity::{
    scene::LoadOptions,
    solver::{
        Engine, Message, Monitor, Problem, Solution, SolveReport, SolveSettings, Solved,
        one_vertex::{Found, rays_of_vertex},
        solve_with,
        student_engine::HOLE_COLOUR,
    },
    student::{FUNCTIONS, Functions, LightSample, PLACEHOLDERS},
};

fn cornell(settings: SolveSettings) -> Problem {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    problem(&scene, Some(cornell_light()), SolveSettings { engine: Engine::Student, ..settings })
}

fn few_rays() -> SolveSettings {
    SolveSettings { rays: 16, light_rays: 8, bounces: Some(1), subdivide: 1, ..SolveSettings::even() }
}

fn solve_with_functions(problem: &Problem, functions: &Functions) -> (Solution, SolveReport) {
    let Solved { solution, report, .. } = solve_with(problem, functions, &Monitor::new(&problem.tessellation, None));
    (solution, report)
}

#[test]
fn every_ray_of_one_vertex_can_be_seen_and_gives_the_solves_own_value() {
    let problem = cornell(few_rays());
    let (solution, _) = solve_unwatched(&problem);
    let vertex = 40;
    let direct = rays_of_vertex(&problem, &FUNCTIONS, &[], vertex);
    assert_eq!(direct.irradiance.unwrap(), solution.bounces[0][vertex as usize]);
    assert!(direct.rays.iter().all(|seen| matches!(seen.found, Found::Blocked(_))));
    let bounce = rays_of_vertex(&problem, &FUNCTIONS, &[&solution.bounces[0]], vertex);
    assert_eq!(bounce.irradiance.unwrap(), solution.bounces[1][vertex as usize]);
    assert_eq!(bounce.rays.len(), 16, "one ray for each of the settings");
    assert!(bounce.rays.iter().all(|seen| matches!(seen.found, Found::Met(_))));
}

/// Root of the mean squared difference, relative to the mean of `expected`.
fn relative_difference(found: &[Vec3], expected: &[Vec3]) -> f32 {
    let count = expected.len() as f32;
    let squared: f32 = found.iter().zip(expected).map(|(a, b)| (*a - *b).length_squared() / 3.0).sum();
    let mean: f32 = expected.iter().map(|value| value.element_sum() / 3.0).sum();
    (squared / count).sqrt() / (mean / count)
}

#[test]
fn the_answers_and_the_programs_own_engine_agree_bounce_by_bounce() {
    let settings = SolveSettings { bounces: Some(3), subdivide: 3, ..SolveSettings::even() };
    let student = cornell(settings.clone());
    let own = problem(&student.scene, student.light, SolveSettings { engine: Engine::Reference, ..settings });
    let ((student, report), (own, _)) = (solve_unwatched(&student), solve_unwatched(&own));
    assert!(report.faults.is_empty() && report.holes.is_empty());
    for (bounce, (found, expected)) in student.bounces.iter().zip(&own.bounces).enumerate() {
        // Both err by their 256 rays, here 1 % and less; the points under the blocks' edges may be judged differently.
        let both_free: Vec<usize> =
            (0..found.len()).filter(|&vertex| !student.buried[vertex] && !own.buried[vertex]).collect();
        let of = |field: &[Vec3]| -> Vec<Vec3> { both_free.iter().map(|&vertex| field[vertex]).collect() };
        let difference = relative_difference(&of(found), &of(expected));
        assert!(difference < 0.05, "bounce {bounce} differs by {difference}");
    }
}

#[test]
fn with_nothing_written_the_mesh_shows_its_normals() {
    let problem = cornell(few_rays());
    let (solution, report) = solve_with_functions(&problem, &PLACEHOLDERS);
    assert!(report.faults.is_empty());
    for (vertex, value) in solution.bounces[0].iter().enumerate() {
        let expected = PI * (0.5 + 0.5 * problem.tessellation.mesh.normals[vertex]);
        assert!(solution.buried[vertex] || value.abs_diff_eq(expected, 1e-5), "vertex {vertex}: {value}");
    }
    assert!(solution.bounces[1..].iter().flatten().all(|value| *value == Vec3::ZERO));
}

#[test]
fn while_nothing_is_written_and_somebody_watches_the_vertices_fill_in_over_some_seconds() {
    let problem = cornell(few_rays());
    let (sender, _messages) = std::sync::mpsc::channel();
    let monitor = Monitor::new(&problem.tessellation, Some(sender));
    let started = Instant::now();
    solve_with(&problem, &PLACEHOLDERS, &monitor);
    assert!((2.0..20.0).contains(&started.elapsed().as_secs_f32()), "{:?}", started.elapsed());
}

#[test]
fn a_function_that_fails_is_named_and_costs_only_its_vertices() {
    let nan_light =
        |light: &_, point| LightSample { pdf_area: f32::NAN, ..(FUNCTIONS.sample_area_light)(light, point) };
    let cases: [(&str, &str, Functions); 4] = [
        (
            "form_basis",
            "it panics: no frame downwards",
            Functions {
                form_basis: |normal| if normal.y < -0.9 { panic!("no frame downwards") } else { Mat3::IDENTITY },
                indirect_irradiance: |world, receiver, _| {
                    (world.functions.form_basis)(receiver.normal()).z_axis.abs() + Vec3::ONE
                },
                ..FUNCTIONS
            },
        ),
        (
            "sample_area_light",
            "not finite",
            Functions {
                sample_area_light: nan_light,
                direct_irradiance: |world, receiver| {
                    let point = world.light_points(receiver).next().unwrap();
                    Vec3::splat((world.functions.sample_area_light)(&world.light.unwrap(), point).pdf_area)
                },
                ..FUNCTIONS
            },
        ),
        (
            "direct_irradiance",
            "negative",
            Functions { direct_irradiance: |_, receiver| receiver.normal(), ..FUNCTIONS },
        ),
        (
            "indirect_irradiance",
            "it panics: index",
            Functions {
                indirect_irradiance: |_, receiver, bounces| bounces[0][receiver.vertex as usize + 10_000],
                ..FUNCTIONS
            },
        ),
    ];
    for (function, words, functions) in cases {
        let problem = cornell(few_rays());
        let (sender, messages) = std::sync::mpsc::channel();
        let monitor = Monitor::new(&problem.tessellation, Some(sender));
        let Solved { solution, report, .. } = solve_with(&problem, &functions, &monitor);
        let [fault] = report.faults.as_slice() else { panic!("{function}: {:?}", report.faults) };
        assert_eq!(fault.function, function, "{fault}");
        assert!(fault.problem.contains(words), "{fault}");
        assert!(!fault.input.is_empty());
        assert_eq!(messages.try_iter().filter(|message| matches!(message, Message::Fault(_))).count(), 1);
        assert!(!report.holes.is_empty());
        let live = monitor.live().total;
        for &hole in &report.holes {
            assert!(solution.bounces.last().unwrap()[hole as usize] == Vec3::ZERO);
            assert!(live[hole as usize].x >= HOLE_COLOUR.x, "a hole is magenta on the screen");
        }
        assert!(solution.bounces.iter().flatten().all(|value| value.is_finite()));
        assert!(function != "form_basis" || 4 * report.holes.len() < live.len(), "only what faces down has no frame");
    }
}

#[test]
fn the_students_engine_gives_the_same_bits_on_any_number_of_threads() {
    let problem = cornell(few_rays());
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve_unwatched(&problem).0.bounces)
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
}

#[test]
fn a_cancelled_solve_of_the_students_engine_ends_at_once_and_keeps_direct_light() {
    let problem = cornell(SolveSettings { rays: 50_000_000, light_rays: 4, ..few_rays() });
    let monitor = Arc::new(Monitor::new(&problem.tessellation, None));
    let watched = Arc::clone(&monitor);
    let solving = std::thread::spawn(move || solve_with(&problem, &FUNCTIONS, &watched));
    std::thread::sleep(std::time::Duration::from_millis(300));
    let started = Instant::now();
    monitor.cancel();
    let Solved { solution, report, .. } = solving.join().unwrap();
    // 100 ms are promised; a busy machine gets more.
    assert!(started.elapsed().as_secs_f32() < 0.5, "{:?}", started.elapsed());
    assert!(!solution.info.complete);
    assert_eq!(solution.bounces.len(), 1);
    assert!(report.faults.is_empty());
}
