//! Solves as jobs: the same bits however they run, and no result lost.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::time::Duration;

use common::{assert_ends_when_cancelled, cornell_light, own_scene, problem, solve_unwatched};
use radiosity::{
    math::sequence::Sampler,
    scene::LoadOptions,
    solver::{Job, Message, Problem, Solution, SolveSettings},
};

fn cornell(settings: SolveSettings) -> Problem {
    problem(&own_scene("cornell/cornell", &LoadOptions::default()), Some(cornell_light()), settings)
}

fn small() -> SolveSettings {
    SolveSettings { rays: 32, light_rays: 16, bounces: Some(3), subdivide: 2, ..SolveSettings::even() }
}

fn solve_on(threads: usize, problem: &Problem) -> Solution {
    Job::start(problem.clone(), threads).unwrap().finish().unwrap().solution
}

#[test]
fn one_two_and_seven_threads_give_the_same_bits_with_every_sampler() {
    for sampler in [Sampler::Random, Sampler::Stratified, Sampler::Sobol] {
        let problem = cornell(SolveSettings { sampler, ..small() });
        let one = solve_on(1, &problem);
        assert_eq!(one, solve_on(2, &problem), "{sampler:?}");
        assert_eq!(one, solve_on(7, &problem), "{sampler:?}");
    }
}

#[test]
fn rows_that_do_not_fit_the_budget_are_traced_again_to_the_same_bits() {
    let kept = solve_unwatched(&cornell(small()));
    let traced_again = solve_unwatched(&cornell(SolveSettings { row_memory: Some(0), ..small() }));
    assert!(kept.1.row_bytes > 0 && traced_again.1.row_bytes == 0);
    assert!(traced_again.1.gather_rays == 4 * kept.1.gather_rays);
    assert_eq!(kept.0.bounces, traced_again.0.bounces);
    assert_eq!(kept.0.buried, traced_again.0.buried);
}

#[test]
fn another_seed_gives_another_solution_of_the_same_scene() {
    let first = solve_unwatched(&cornell(small())).0;
    let second = solve_unwatched(&cornell(SolveSettings { seed: 2, ..small() })).0;
    assert_ne!(first.bounces, second.bounces);
    assert_eq!(first.info.tessellation_hash, second.info.tessellation_hash);
}

#[test]
fn without_a_bounce_limit_bounces_go_on_until_the_rest_is_small() {
    let settings = SolveSettings { bounces: None, unabsorbed: 0.02, ..small() };
    let (solution, report) = solve_unwatched(&cornell(settings));
    assert!(report.unabsorbed <= 0.02);
    assert!(solution.bounces.len() > 4, "{} bounces", solution.bounces.len());
    // What is still missing is less than was asked for: ten more bounces add less than that of the emitted power.
    let more = SolveSettings { bounces: Some(solution.bounces.len() as u32 + 9), ..small() };
    let (_, longer) = solve_unwatched(&cornell(more));
    let added: f64 =
        longer.energy.bounces[solution.bounces.len()..].iter().map(|bounce| bounce.absorbed.element_sum()).sum();
    assert!(added < 0.02 * report.energy.emitted.element_sum(), "{added}");
}

#[test]
fn a_scene_without_light_is_solved_at_once_and_black() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let (solution, report) = solve_unwatched(&problem(&scene, None, small()));
    assert_eq!((report.gather_rays, report.shadow_rays), (0, 0));
    assert!(solution.bounces.len() == 1 && solution.direct().iter().all(|value| *value == glam::Vec3::ZERO));
}

#[test]
fn no_rays_are_traced_for_bounces_that_nobody_asked_for() {
    let few = solve_unwatched(&cornell(SolveSettings { rays: 4096, bounces: Some(0), ..small() }));
    let vertices = few.0.buried.len() as u64;
    assert!(few.1.gather_rays <= 64 * vertices, "only what tells buried vertices");
    assert_eq!(few.0.bounces.len(), 1);
}

#[test]
fn a_cancelled_solve_ends_within_a_tenth_of_a_second_and_keeps_what_it_had() {
    // 10 million rays a vertex: the cancel must reach into the work on one vertex.
    for rays in [4096, 10_000_000] {
        let problem = cornell(SolveSettings { rays, subdivide: 4, ..small() });
        let job = Job::start(problem, 2).unwrap();
        while job.monitor().progress().rays == 0 && rays < 10_000 {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(200));
        assert_ends_when_cancelled(&job, &format!("{rays} rays"));
        let solution = job.finish().unwrap().solution;
        assert!(!solution.info.complete);
        let is_lit = solution.direct().iter().any(|value| value.x > 0.0);
        assert!(is_lit || rays > 10_000, "what was computed is kept");
        assert!(solution.bounces.iter().flatten().all(|value| value.is_finite()));
    }
}

#[test]
fn a_paused_solve_stands_still_and_ends_with_the_same_bits() {
    let problem = cornell(SolveSettings { rays: 256, ..small() });
    let job = Job::start(problem.clone(), 2).unwrap();
    job.monitor().pause();
    std::thread::sleep(Duration::from_millis(200)); // the chunks under way are finished
    let before = job.monitor().progress().rays;
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(before, job.monitor().progress().rays);
    assert!(!job.is_finished());
    job.monitor().resume();
    assert_eq!(job.finish().unwrap().solution, solve_on(1, &problem));
}

#[test]
fn messages_bring_every_bounce_in_order_and_the_live_field_ends_as_the_solution() {
    let problem = cornell(small());
    let job = Job::start(problem, 2).unwrap();
    let monitor = std::sync::Arc::clone(job.monitor());
    while !job.is_finished() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let bounces: Vec<_> = job
        .messages()
        .filter_map(|message| match message {
            Message::Bounce { index, irradiance, .. } => Some((index, irradiance)),
            Message::Elements(_) | Message::Progress(_) | Message::Fault(_) | Message::SamplingError(_) => None,
        })
        .collect();
    let solution = job.finish().unwrap().solution;
    assert_eq!(bounces.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [0, 1, 2, 3]);
    for (index, irradiance) in &bounces {
        assert_eq!(**irradiance, solution.bounces[*index as usize]);
    }
    let live = monitor.live().total;
    for (vertex, (live, total)) in live.iter().zip(solution.total()).enumerate() {
        assert!(live.abs_diff_eq(total, 1e-5 * total.max_element().max(1e-3)), "vertex {vertex}: {live}, not {total}");
    }
}
