//! What a vertex's value stands for: the light at the point, its mean around (eq. 7), or the nearest interpolated field.
#![cfg(feature = "reference")]

mod common;

use common::{cornell_light, own_scene, problem, solve_unwatched};
use glam::{DVec3, Vec3};
use radiosity::{
    check::{closed_form::furnace_irradiance, metrics::relative_l2, surface_points::area_uniform_points},
    math::sequence::Sampler,
    scene::LoadOptions,
    solver::{Reconstruction, Reconstructor, SolveSettings},
    transport::{origins::VertexValues, visible_light::Scratch},
};

const ALL: [VertexValues; 3] = [VertexValues::Point, VertexValues::Average, VertexValues::LeastSquares];

/// In a box whose light is the same everywhere, so is every mean of it and every fit to it (eq. 5).
#[test]
fn a_furnace_is_the_same_whatever_values_stand_for() {
    let scene = own_scene("tests/furnace-80", &LoadOptions::default());
    for vertex_values in ALL {
        for sampler in [Sampler::Sobol, Sampler::Stratified, Sampler::Random] {
            let settings =
                SolveSettings { rays: 1024, bounces: Some(4), vertex_values, sampler, ..SolveSettings::even() };
            let problem = problem(&scene, None, settings);
            let (solution, _) = solve_unwatched(&problem);
            assert!(!solution.buried.contains(&true));
            let direct = std::f64::consts::PI * f64::from(scene.materials[0].emitted_radiance.x);
            let expected = direct * furnace_irradiance(1.0, 0.8, 4);
            let errors: Vec<f64> = (0..solution.buried.len())
                .map(|vertex| {
                    let total: Vec3 = solution.bounces.iter().map(|bounce| bounce[vertex]).sum();
                    f64::from(total.x) / expected - 1.0
                })
                .collect();
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            assert!(mean.abs() < 2e-3, "{vertex_values:?}, {sampler:?}: off by {mean} in the mean");
            // Random points scatter by 1 % at a vertex.
            let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
            assert!(sampler == Sampler::Random || worst < 0.01, "{vertex_values:?}, {sampler:?}: off by {worst}");
        }
    }
}

/// Relative L2 error of interpolated direct light on the Cornell box, against light that is computed at the points.
fn error_of(vertex_values: VertexValues) -> f64 {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let settings = SolveSettings { rays: 256, bounces: Some(0), subdivide: 3, vertex_values, ..SolveSettings::even() };
    let problem = problem(&scene, Some(cornell_light()), settings);
    let (solution, _) = solve_unwatched(&problem);
    assert!(solution.bounces.iter().flatten().all(|value| value.is_finite() && value.min_element() >= 0.0));
    let mut fields = [Reconstruction::Vertex, Reconstruction::PointDirect].map(|reconstruction| {
        let field = Reconstructor::new(&scene, &*problem.tracer, &problem.tessellation, &solution, reconstruction);
        let points = area_uniform_points(&scene, 3000, 5).into_iter();
        let at = |(triangle, place)| field.irradiance(triangle, place, &mut Scratch::default()).direct.as_dvec3();
        points.map(at).collect::<Vec<DVec3>>()
    });
    let [interpolated, exact] = &mut fields;
    relative_l2(interpolated, exact)
}

/// Expected: the fit is the best of all fields that are linear on the elements, but for its samples' noise.
#[test]
fn least_squares_lie_nearer_to_the_light_than_values_at_the_points_or_averages() {
    let [point, average, least_squares] = ALL.map(error_of);
    println!(
        "direct light of Cornell, 3 cuts: point {point:.4}, average {average:.4}, least squares {least_squares:.4}"
    );
    assert!(least_squares < 0.8 * point && least_squares < 0.8 * average, "{point} {average} {least_squares}");
}
