//! Elements that follow the light: their errors, their bits, and the way to a file and back.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{sync::Arc, time::Duration};

use common::{
    assert_ends_when_cancelled, cornell_light, own_scene, problem, solve_unwatched, solve_with_elements, truths::case,
};
use radiosity::{
    check::{
        metrics::{Field, field_errors},
        surface_points::locate,
    },
    files::elements_of,
    scene::{LoadOptions, Scene, Tessellation, load::load_from_memory},
    solver::{
        Job, Message, PointIrradiance, Problem, Reconstruction, Reconstructor, SolveSettings, Solved, Stage,
        energy::Ledger, solution_file,
    },
    trace::Tracer,
    transport::{lights::DirectMethod, visible_light::Scratch},
};

fn to_error(error: f32, rays: u32) -> SolveSettings {
    SolveSettings { adaptive: error, rays, unabsorbed: 1e-3, ..SolveSettings::default() }
}

fn cornell(settings: SolveSettings) -> Problem {
    problem(&own_scene("cornell/cornell", &LoadOptions::default()), Some(cornell_light()), settings)
}

/// Expected: the path-traced truth of another program. The same box cut evenly into 32 segments a wall, with 256 rays
/// at each of its 16,368 vertices, errs by 1.5 % with interpolated and by 1.1 % with direct light at the points.
#[test]
fn by_default_fewer_elements_and_rays_err_less_than_even_ones() {
    let Some(case) = case("cornell", "cornell/cornell.obj", 1) else { return };
    let problem = problem(&case.scene, case.light, SolveSettings::default());
    let Solved { solution, report, tessellation, .. } = solve_with_elements(&problem);
    assert!(solution.buried.len() < 12_000, "{} vertices", solution.buried.len());
    assert!(report.gather_rays < 2_000_000 && report.shadow_rays == 0, "{} rays", report.gather_rays);
    let tracer = Tracer::new(Arc::clone(&case.scene));
    for (reconstruction, most) in [(Reconstruction::Vertex, 0.011), (Reconstruction::PointDirect, 0.01)] {
        let field = Reconstructor::new(&case.scene, &tracer, &tessellation, &solution, reconstruction);
        let mut scratch = Scratch::default();
        let at = |point| {
            let place = locate(&case.scene, &tracer, point).unwrap().on();
            let found = place.map(|(triangle, place)| field.irradiance(triangle, place, &mut scratch));
            let PointIrradiance { direct, total } = found.unwrap_or_default();
            (direct.as_dvec3(), total.as_dvec3())
        };
        let (direct, total): (Vec<_>, Vec<_>) = case.points.iter().map(at).unzip();
        let (true_direct, true_total): (Vec<_>, Vec<_>) =
            case.values.iter().map(|value| (value.direct, value.total)).unzip();
        let errors =
            field_errors(Field { direct: &direct, total: &total }, Field { direct: &true_direct, total: &true_total });
        assert!(errors.lit.total.relative_l2 < most, "{reconstruction:?}: {:?}", errors.lit.total);
        assert!(errors.all.total.relative_l2 < 1.1 * most, "{reconstruction:?}: {:?}", errors.all.total);
        assert!(errors.lit.total.bias.abs() < 0.003, "{reconstruction:?}: {:?}", errors.lit.total);
    }
}

/// Expected: E = π L (1 + ρ + ρ² + ...) everywhere in a closed box of surfaces that all emit L and reflect ρ (eq. 5): of its
/// emissive triangles gather rays and samples find the light together if it is not found without samples.
#[test]
fn many_emissive_triangles_give_the_light_of_a_closed_box() {
    let scene = own_scene("tests/furnace-50", &LoadOptions::default());
    let radiance = scene.materials[0].emitted_radiance.x;
    let settings = SolveSettings { direct: DirectMethod::Sampled, ..to_error(0.05, 256) };
    let (solution, report) = solve_unwatched(&problem(&scene, None, settings));
    let expected = std::f32::consts::PI * radiance / (1.0 - 0.5);
    let total = solution.total();
    let mean = total.iter().map(|value| value.x).sum::<f32>() / total.len() as f32;
    assert!((mean / expected - 1.0).abs() < 0.005, "{mean}, not {expected}");
    for (vertex, value) in total.iter().enumerate() {
        assert!((value.x / expected - 1.0).abs() < 0.1, "vertex {vertex}: {value}, not {expected}");
    }
    assert!(report.shadow_rays > 0 && total.len() < 5_000, "{} vertices", total.len());
}

/// Expected: what even elements say, whose gather rays find emissive triangles by themselves (`tests/closed_forms.rs`
/// holds those to closed forms).
#[test]
fn a_lamp_of_emissive_triangles_gives_the_light_that_it_gives_even_elements() {
    let scene = lamp_in_a_room();
    for direct in [DirectMethod::Analytic, DirectMethod::Sampled] {
        let even = SolveSettings { adaptive: 0.0, subdivide: 4, direct, ..to_error(0.05, 256) };
        let even = solve_unwatched(&problem(&scene, None, even)).1.energy;
        let adaptive =
            solve_unwatched(&problem(&scene, None, SolveSettings { direct, ..to_error(0.05, 256) })).1.energy;
        let arriving = |energy: &Ledger, bounce: usize| energy.bounces[bounce].arriving.element_sum();
        for bounce in 0..3 {
            let ratio = arriving(&adaptive, bounce) / arriving(&even, bounce);
            assert!((ratio - 1.0).abs() < 0.02, "{direct:?}, bounce {bounce}: {ratio} of the light");
        }
    }
}

/// A room with a lamp of two emissive triangles hanging in it, 1 m above a wall of its own.
fn lamp_in_a_room() -> Arc<Scene> {
    let obj = "mtllib a.mtl\nusemtl wall\n\
        v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n\
        f 1 2 3 4\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 5 6 2 1\nf 4 3 7 8\n\
        v 0.7 1.7 0.7\nv 1.3 1.7 0.7\nv 1.3 1.7 1.3\nv 0.7 1.7 1.3\nusemtl lamp\nf 9 10 11 12\n";
    let mtl = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0.2 0.2 0.2\nKe 5 5 5\n";
    Arc::new(load_from_memory("room", obj, mtl, &LoadOptions::default()).unwrap())
}

#[test]
fn rows_beyond_the_budget_are_traced_again_to_the_same_bits() {
    let settings = to_error(0.1, 64);
    let kept = solve_unwatched(&cornell(settings.clone()));
    let traced_again = solve_unwatched(&cornell(SolveSettings { row_memory: Some(0), ..settings }));
    assert!(kept.1.row_bytes > 0 && traced_again.1.row_bytes == 0);
    let bounces = kept.0.bounces.len() as u64;
    assert_eq!(traced_again.1.gather_rays, bounces * kept.1.gather_rays);
    assert_eq!(kept.0.bounces, traced_again.0.bounces);
}

#[test]
fn a_job_shows_elements_as_they_are_cut_and_how_far_it_is() {
    let job = Job::start(cornell(to_error(0.02, 256)), 2).unwrap();
    let monitor = Arc::clone(job.monitor());
    let mut stages = Vec::new();
    let (mut elements, mut last_bounce) = (None, None);
    while !job.is_finished() {
        match job.next_message(Duration::from_millis(20)) {
            Some(Message::Progress(progress)) => {
                assert!((0.0..=1.0).contains(&progress.fraction) && progress.seconds_left >= 0.0);
                stages.push(progress.stage);
            }
            Some(Message::Elements(tessellation)) => {
                assert!(last_bounce.is_none(), "elements are cut before there is a bounce");
                elements = Some(tessellation);
            }
            Some(Message::Bounce { irradiance, .. }) => last_bounce = Some(irradiance),
            _ => {}
        }
    }
    assert!(stages.contains(&Stage::FollowingIndirect), "{stages:?}");
    let Solved { solution, tessellation, .. } = job.finish().unwrap();
    let (elements, live) = (elements.unwrap(), monitor.live());
    assert!(Arc::ptr_eq(&elements, &tessellation) && Arc::ptr_eq(&live.tessellation, &tessellation));
    assert_eq!(last_bounce.unwrap().len(), tessellation.mesh.positions.len());
    for (live, total) in live.total.iter().zip(solution.total()) {
        assert!(live.abs_diff_eq(total, 1e-5 * total.max_element().max(1e-3)), "{live}, not {total}");
    }
}

#[test]
fn a_cancelled_job_ends_at_once_in_every_stage_and_keeps_what_it_had() {
    // Rays enough for each stage to be met: seconds of direct light, then seconds of gathering.
    let slow_direct = SolveSettings { direct: DirectMethod::Sampled, light_rays: 16_384, ..to_error(0.02, 16) };
    for (settings, stage) in
        [(slow_direct, Stage::FollowingDirect), (to_error(0.02, 1_000_000), Stage::FollowingIndirect)]
    {
        let job = Job::start(cornell(settings), 2).unwrap();
        while job.monitor().progress().stage != stage {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(200));
        assert_ends_when_cancelled(&job, &format!("{stage:?}"));
        let Solved { solution, tessellation, .. } = job.finish().unwrap();
        assert!(!solution.info.complete);
        assert_eq!(solution.direct().len(), tessellation.mesh.positions.len());
        assert!(solution.direct().iter().any(|value| value.x > 0.0), "{stage:?}: what was computed is kept");
        let encoded = solution_file::encode(&solution).unwrap();
        let decoded = solution_file::decode(&encoded).unwrap();
        let path = std::path::Path::new("box.safetensors");
        let scene = own_scene("cornell/cornell", &LoadOptions::default());
        assert_eq!(elements_of(path, &decoded, &scene).unwrap().hash(), tessellation.hash());
    }
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
    let Solved { solution, tessellation, .. } = solve_with_elements(&problem);
    let decoded = solution_file::decode(&solution_file::encode(&solution).unwrap()).unwrap();
    assert_eq!(decoded, solution);
    let path = std::path::Path::new("box.safetensors");
    let elements = elements_of(path, &decoded, &problem.scene).unwrap();
    assert_eq!(elements.hash(), tessellation.hash());
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
    assert!(solve_unwatched(&cornell(settings)).0.buried.len() < 1_000);
}

/// Few rays a vertex are not enough for a small error: more are traced where their noise counts most, until the estimate
/// allows it. For a large error they are enough.
#[test]
fn rays_are_added_where_their_noise_is_larger_than_the_error_allows() {
    const RAYS: u32 = 16;
    let told = |error: f32| {
        let job = Job::start(cornell(to_error(error, RAYS)), 2).unwrap();
        while !job.is_finished() {
            std::thread::sleep(Duration::from_millis(2));
        }
        let errors = job.messages().find_map(|message| match message {
            Message::SamplingError(errors) => Some(errors),
            _ => None,
        });
        let Solved { solution, report, tessellation, .. } = job.finish().unwrap();
        let areas = tessellation.vertex_areas();
        let mean = |of: &dyn Fn(usize) -> f64| {
            let sum: f64 = (0..areas.len()).map(|vertex| f64::from(areas[vertex]) * of(vertex)).sum();
            sum / areas.iter().map(|area| f64::from(*area)).sum::<f64>()
        };
        let errors = errors.unwrap();
        let noise = mean(&|vertex| f64::from(errors[vertex]).powi(2)).sqrt();
        let light = mean(&|vertex| f64::from(solution.total()[vertex].element_sum() / 3.0));
        (noise / light, report.gather_rays as f64 / (f64::from(RAYS) * report.gathered_vertices as f64))
    };
    let (loose, strict) = (told(0.2), told(0.01));
    assert!(loose.1 <= 1.0, "{} times the rays", loose.1);
    assert!(strict.1 > 1.5, "{} times the rays", strict.1);
    // The estimate is at most twice the error; it is of the first bounce, and what is told here of all of them.
    assert!(loose.0 > 0.06 && strict.0 < 0.05, "noise of {loose:?} and {strict:?}");
}
