//! Elements that follow the light: their errors, their bits, and the way to a file and back.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::{cornell_light, own_scene, problem, solve_unwatched, truths::case};
use radiosity::{
    check::{
        metrics::{Field, field_errors},
        surface_points::locate,
    },
    files::elements_of,
    scene::{LoadOptions, Tessellation},
    solver::{PointIrradiance, Problem, Reconstruction, Reconstructor, SolveSettings, solution_file},
    trace::Tracer,
    transport::visible_light::Scratch,
};

fn to_error(error: f32, rays: u32) -> SolveSettings {
    SolveSettings { adaptive: Some(error), rays, unabsorbed: 1e-3, ..SolveSettings::default() }
}

fn cornell(settings: SolveSettings) -> Problem {
    problem(&own_scene("cornell/cornell", &LoadOptions::default()), Some(cornell_light()), settings)
}

/// Expected: the path-traced truth of another program. The same box cut evenly into 16 segments a wall, with 256 rays
/// at each of its 4,352 vertices, errs by 2.7 % with interpolated and by 1.7 % with direct light at the points.
#[test]
fn fewer_elements_and_rays_err_less_than_even_ones() {
    let Some(case) = case("cornell", "cornell/cornell.obj", 1) else { return };
    let problem = problem(&case.scene, case.light, to_error(0.03, 256));
    let (solution, report) = solve_unwatched(&problem);
    assert!(solution.buried.len() < 6_000, "{} vertices", solution.buried.len());
    assert!(report.gather_rays < 600_000 && report.shadow_rays == 0, "{} rays", report.gather_rays);
    let tracer = Tracer::new(Arc::clone(&case.scene));
    for (reconstruction, most) in [(Reconstruction::Vertex, 0.015), (Reconstruction::PointDirect, 0.0145)] {
        let field = Reconstructor::new(&case.scene, &tracer, &problem.tessellation, &solution, reconstruction);
        let mut scratch = Scratch::default();
        let at = |point| {
            let (triangle, place) = locate(&case.scene, &tracer, point).unwrap();
            let PointIrradiance { direct, total } = field.irradiance(triangle, place, &mut scratch);
            (direct.as_dvec3(), total.as_dvec3())
        };
        let (direct, total): (Vec<_>, Vec<_>) = case.points.iter().map(at).unzip();
        let (true_direct, true_total): (Vec<_>, Vec<_>) =
            case.values.iter().map(|value| (value.direct, value.total)).unzip();
        let errors =
            field_errors(Field { direct: &direct, total: &total }, Field { direct: &true_direct, total: &true_total });
        assert!(errors.lit.total.relative_l2 < most, "{reconstruction:?}: {:?}", errors.lit.total);
        assert!(errors.all.total.relative_l2 < 1.1 * most, "{reconstruction:?}: {:?}", errors.all.total);
    }
}

#[test]
fn a_scene_of_too_many_emitters_is_refused_in_one_line() {
    let scene = own_scene("tests/furnace-50", &LoadOptions::default());
    let tracer = Arc::new(Tracer::new(Arc::clone(&scene)));
    let made = Problem::new(scene, tracer, LoadOptions::default(), None, to_error(0.05, 16), &|| false);
    assert!(made.is_err_and(|problem| problem.contains("emissive triangles") && problem.contains("--subdivide")));
}

#[test]
fn one_thread_and_three_give_the_same_bits() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve_unwatched(&cornell(to_error(0.2, 32))).0)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn the_elements_come_back_from_a_file_and_from_no_other_scene() {
    let problem = cornell(to_error(0.2, 16));
    let (solution, _) = solve_unwatched(&problem);
    let decoded = solution_file::decode(&solution_file::encode(&solution).unwrap()).unwrap();
    assert_eq!(decoded, solution);
    let path = std::path::Path::new("box.safetensors");
    let elements = elements_of(path, &decoded, &problem.scene).unwrap();
    assert_eq!(elements.hash(), problem.tessellation.hash());
    let options = solution.info.settings.tessellation();
    for wrong in [vec![0], vec![1, u32::MAX], vec![7, 0, 1]] {
        assert!(Tessellation::with_cuts(&problem.scene, &options, &wrong).is_err(), "{wrong:?}");
    }
}

#[test]
fn nothing_shines_and_nothing_bounces_without_complaint() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let (dark, _) = solve_unwatched(&problem(&scene, None, to_error(0.1, 16)));
    assert!(dark.total().iter().all(|value| *value == glam::Vec3::ZERO));
    let direct_alone = SolveSettings { bounces: Some(0), ..to_error(0.1, 16) };
    let (solution, report) = solve_unwatched(&problem(&scene, Some(cornell_light()), direct_alone));
    assert_eq!((solution.bounces.len(), report.gather_rays), (1, 0));
}

/// A cap on the vertices is kept to, about.
#[test]
fn no_more_vertices_than_allowed_are_made() {
    let settings = SolveSettings { max_vertices: 500, ..to_error(0.01, 16) };
    assert!(cornell(settings).tessellation.mesh.positions.len() < 1_000);
}
