//! The solver at the edges of what can be given to it: the short form of `radiosity stress`, and random scenes.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{fmt::Write as _, sync::Arc};

use glam::Vec3;
use proptest::prelude::*;
use radiosity::{
    check::stress,
    math::sequence::Sampler,
    scene::{LoadOptions, area_light::AreaLightState, load::load_from_memory},
    solver::{Monitor, Problem, SolveSettings, solve},
    trace::Tracer,
    transport::lights::DirectMethod,
};

#[test]
fn every_case_of_the_short_stress_test_is_as_it_must_be() {
    let rows = stress::run(false, |row| println!("{row:?}"));
    let wrong: Vec<_> = rows.iter().filter(|row| !row.passed).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(rows.len() > 60, "only {} cases", rows.len());
}

/// Corners from few values, so that they coincide and line up, or from many.
fn corner() -> impl Strategy<Value = [f64; 3]> {
    let coordinate = prop_oneof![
        prop::sample::select(vec![-1.0, -0.5, 0.0, 1e-7, 0.5, 1.0]),
        -1.0..1.0,
        prop::sample::select(vec![-1e-30, 1e-12, 0.5 + 1e-9]),
    ];
    prop::array::uniform3(coordinate)
}

fn light() -> impl Strategy<Value = Option<AreaLightState>> {
    let radiance = prop_oneof![Just(0.0_f32), Just(1e-20), 0.1_f32..20.0, Just(1e15)];
    let light = (corner(), corner(), corner(), prop::array::uniform3(radiance));
    prop::option::of(light.prop_map(|(centre, u, v, radiance)| AreaLightState { centre, u, v, radiance }))
}

prop_compose! {
    fn settings()(
        rays in prop::sample::select(vec![0_u32, 1, 3, 17]),
        light_rays in prop::sample::select(vec![1_u32, 5]),
        subdivide in 0_u32..2,
        adaptive in prop_oneof![4 => Just(0.0_f32), 1 => 0.3_f32..1.0],
        sampled in any::<bool>(),
        sampler in prop::sample::select(vec![Sampler::Random, Sampler::Stratified, Sampler::Sobol]),
        bounces in prop::option::of(0_u32..5),
        row_memory in prop::sample::select(vec![Some(0_u32), None]),
    ) -> SolveSettings {
        let direct = if sampled { DirectMethod::Sampled } else { DirectMethod::Analytic };
        SolveSettings { rays, light_rays, subdivide, adaptive, direct, sampler, bounces, row_memory, max_vertices: 2000, ..SolveSettings::default() }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: prop::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// Eq. 5 bounds every vertex by the largest direct irradiance over 1 minus the largest reflectance.
    #[test]
    fn random_triangles_never_give_what_is_no_irradiance_or_more_than_equation_5_lets_them(
        triangles in prop::collection::vec(prop::array::uniform3(corner()), 1..24),
        reflectance in prop::sample::select(vec![0.0, 0.5, 0.95]),
        emitted in prop::sample::select(vec![0.0, 0.0, 1.0]),
        light in light(),
        settings in settings(),
    ) {
        let mut obj = String::from("usemtl m\n");
        for triangle in &triangles {
            for [x, y, z] in triangle {
                writeln!(obj, "v {x} {y} {z}").unwrap();
            }
            obj.push_str("f -3 -2 -1\n");
        }
        let mtl = format!("newmtl m\nKd {reflectance} {reflectance} 0\nKe {emitted} 0 {emitted}\n");
        let load = LoadOptions::default();
        // A scene of which nothing is left is refused.
        let Ok(scene) = load_from_memory("soup", &obj, &mtl, &load) else { return Ok(()) };
        let scene = Arc::new(scene);
        let tracer = Arc::new(Tracer::new(Arc::clone(&scene)));
        let problem = Problem::new(scene, tracer, load, light, settings).unwrap();
        let solved = solve(&problem, &Monitor::new(&problem.tessellation, None));
        let largest = |field: &[Vec3]| field.iter().map(|value| value.max_element()).fold(0.0, f32::max);
        let total = solved.solution.total();
        for value in &total {
            prop_assert!(value.is_finite() && value.min_element() >= 0.0, "irradiance {value}");
        }
        let limit = largest(solved.solution.direct()) / (1.0 - reflectance as f32);
        prop_assert!(largest(&total) <= 1.0001 * limit, "{} above {limit}", largest(&total));
        let energy = &solved.report.energy;
        let powers = energy.bounces.iter().flat_map(|bounce| [bounce.arriving, bounce.absorbed, bounce.reflected]);
        for power in powers {
            prop_assert!(power.is_finite() && power.min_element() >= 0.0, "power {power}");
        }
    }
}
