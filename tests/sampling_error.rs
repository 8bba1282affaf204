//! The estimate of the sampling error, against the scatter of solves with different seeds.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::{cornell_light, own_scene, problem};
use radiosity::{
    math::sequence::Sampler,
    scene::LoadOptions,
    solver::{Job, Message, Solution, SolveSettings},
};

/// A solution with the standard error that was told at each vertex.
fn solve(sampler: Sampler, seed: u64, row_memory: Option<u32>) -> (Solution, Arc<Vec<f32>>) {
    let settings = SolveSettings {
        rays: 64,
        light_rays: 64,
        bounces: Some(1),
        subdivide: 3,
        sampler,
        seed,
        row_memory,
        ..SolveSettings::even()
    };
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let job = Job::start(problem(&scene, Some(cornell_light()), settings), 2).unwrap();
    while !job.is_finished() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let told = job.messages().find_map(|message| match message {
        Message::SamplingError(errors) => Some(errors),
        _ => None,
    });
    (job.finish().unwrap().solution, told.unwrap())
}

/// Root mean squares over the vertices that are not buried: of the error that was told, and of the scatter of eight
/// seeds, which is the error itself (of a mean over bands, as it is told).
fn told_and_true(sampler: Sampler) -> [f64; 2] {
    const SEEDS: u64 = 8;
    let solved: Vec<_> = (1..=SEEDS).map(|seed| solve(sampler, seed, None)).collect();
    let totals: Vec<_> = solved.iter().map(|(solution, _)| solution.total()).collect();
    let (mut told, mut scatter) = (0.0, 0.0);
    for vertex in (0..totals[0].len()).filter(|&vertex| !solved[0].0.buried[vertex]) {
        let mean = totals.iter().map(|total| total[vertex].as_dvec3()).sum::<glam::DVec3>() / SEEDS as f64;
        let deviations = totals.iter().map(|total| (total[vertex].as_dvec3() - mean).length_squared() / 3.0);
        scatter += deviations.sum::<f64>() / (SEEDS - 1) as f64;
        told += solved.iter().map(|(_, errors)| f64::from(errors[vertex]).powi(2)).sum::<f64>() / SEEDS as f64;
    }
    [told.sqrt(), scatter.sqrt()]
}

#[test]
fn of_random_points_the_error_that_is_told_is_the_scatter_of_seeds() {
    // The squared error is an unbiased estimate: over 1,200 vertices and 8 seeds its root is known to a few percent.
    let [told, scatter] = told_and_true(Sampler::Random);
    assert!((told / scatter - 1.0).abs() < 0.08, "told {told}, true {scatter}");
}

#[test]
fn of_sobol_points_it_is_rather_too_large_but_not_by_much() {
    let [told, scatter] = told_and_true(Sampler::Sobol);
    let ratio = told / scatter;
    println!("told / true {ratio:.2}");
    assert!(ratio > 0.95 && ratio < 3.0, "told {told}, true {scatter}");
}
