//! Light moved and materials changed on the rows of a solve: the same field as a solve anew on the same elements, and
//! not one hemisphere ray.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering::Relaxed},
};

use common::{cornell_light, own_scene, problem, solve_unwatched, solve_with_elements};
use glam::Vec3;
use radiosity::{
    check::closed_form::furnace_irradiance,
    scene::{LoadOptions, Material, Scene, area_light::AreaLightState},
    solver::{Job, Kept, Message, Monitor, Problem, Solution, SolveSettings, Solved},
    trace::{Hit, Ray, RayTracer, Shaft, Tracer},
};

/// Counts the rays that ask what they meet: gather rays, and no shadow rays.
struct Counting {
    tracer: Tracer,
    hemisphere_rays: AtomicU64,
}

impl RayTracer for Counting {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.hemisphere_rays.fetch_add(1, Relaxed);
        self.tracer.closest_hit(ray)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.tracer.occluded(ray)
    }

    fn triangles_in_shaft(
        &self,
        shaft: &Shaft,
        is_left_out: &dyn Fn(u32) -> bool,
        limit: usize,
        triangles: &mut Vec<u32>,
    ) -> bool {
        self.tracer.triangles_in_shaft(shaft, is_left_out, limit, triangles)
    }
}

fn settings() -> SolveSettings {
    SolveSettings { rays: 64, unabsorbed: 1e-6, ..SolveSettings::default() }
}

fn even() -> SolveSettings {
    SolveSettings { adaptive: 0.0, subdivide: 3, ..settings() }
}

fn cornell(settings: SolveSettings) -> Problem {
    problem(&own_scene("cornell/cornell", &LoadOptions::default()), Some(cornell_light()), settings)
}

/// Elsewhere, smaller, tilted and of another colour.
fn other_light() -> AreaLightState {
    AreaLightState { centre: [0.15, 0.45, 0.2], u: [0.04, 0.01, 0.0], v: [0.0, 0.0, 0.05], radiance: [5.0, 20.0, 40.0] }
}

fn relit(kept: &Kept, scene: &Arc<Scene>, light: Option<AreaLightState>) -> Solved {
    kept.relight(scene, light, &Monitor::new(kept.tessellation(), None))
}

/// A scene with other materials.
fn with_materials(scene: &Scene, change: impl Fn(&mut Material)) -> Arc<Scene> {
    let mut scene = scene.clone();
    scene.materials.iter_mut().for_each(change);
    Arc::new(scene)
}

/// Root mean square difference by the mean of `expected`.
fn difference(found: &[Vec3], expected: &[Vec3]) -> f32 {
    assert_eq!(found.len(), expected.len());
    let squares: f32 = found.iter().zip(expected).map(|(found, expected)| (*found - *expected).length_squared()).sum();
    let mean = expected.iter().map(|value| value.element_sum()).sum::<f32>() / (3 * expected.len()) as f32;
    (squares / (3 * expected.len()) as f32).sqrt() / mean
}

fn assert_same_light(relit: &Solution, expected: &Solution, what: &str) {
    for (part, found, expected) in [
        ("direct", relit.direct().to_vec(), expected.direct().to_vec()),
        ("indirect", relit.indirect(), expected.indirect()),
        ("total", relit.total(), expected.total()),
    ] {
        let difference = difference(&found, &expected);
        assert!(difference < 1e-4, "{what}, {part} light: {difference}");
    }
}

/// Expected: a solve of the other light on the same elements, which even elements are whatever the light.
#[test]
fn on_even_elements_the_relit_field_is_that_of_a_solve_anew() {
    let problem = cornell(even());
    let kept = solve_with_elements(&problem).kept.unwrap();
    let other = Problem { light: Some(other_light()), ..problem.clone() };
    assert_same_light(&relit(&kept, &problem.scene, other.light).solution, &solve_unwatched(&other).0, "moved light");
    // Its own light, as bright and brighter.
    let same = relit(&kept, &problem.scene, problem.light);
    assert_same_light(&same.solution, &solve_unwatched(&problem).0, "same light");
    let brighter = AreaLightState { radiance: [80.0, 10.0, 1.0], ..cornell_light() };
    let solved = solve_unwatched(&Problem { light: Some(brighter), ..problem.clone() });
    assert_same_light(&relit(&kept, &problem.scene, Some(brighter)).solution, &solved.0, "brighter light");
    // Materials that reflect more and less, and one that begins to shine.
    let painted = with_materials(&problem.scene, |material| {
        material.reflectance = (Vec3::splat(0.9) - 0.7 * material.reflectance).max(Vec3::splat(0.02));
    });
    let solved = solve_unwatched(&Problem { scene: Arc::clone(&painted), ..problem.clone() });
    assert_same_light(&relit(&kept, &painted, problem.light).solution, &solved.0, "painted");
    let shining = with_materials(&problem.scene, |material| {
        if material.reflectance.x > 2.0 * material.reflectance.y {
            material.emitted_radiance = Vec3::new(0.5, 1.0, 2.0);
        }
    });
    assert!(shining.materials != problem.scene.materials);
    let solved = solve_unwatched(&Problem { scene: Arc::clone(&shining), ..problem.clone() });
    assert_same_light(&relit(&kept, &shining, problem.light).solution, &solved.0, "shining wall");
}

/// Expected: the solve itself. Its elements followed its own light: lit by it from the rows of a solve that knew another
/// would be other elements, so the way there and back is taken.
#[test]
fn elements_that_follow_the_light_give_their_own_solution_again_whatever_was_lit_before() {
    let problem = cornell(settings());
    let Solved { solution, kept, tessellation, .. } = solve_with_elements(&problem);
    let kept = kept.unwrap();
    let elsewhere = relit(&kept, &problem.scene, Some(other_light()));
    assert!(difference(&elsewhere.solution.total(), &solution.total()) > 0.5, "the other light is another");
    assert_eq!(elsewhere.solution.cuts, tessellation.cuts);
    // All materials changed a little and nothing is known of the field: every bounce is found anew.
    let same = with_materials(&problem.scene, |material| material.reflectance *= 1.0 + 1e-6);
    assert_same_light(&relit(&kept, &same, problem.light).solution, &solution, "back again");
    // A light that is elsewhere by a ten-millionth: its direct light is found anew.
    let mut shifted = cornell_light();
    shifted.centre[0] += 1e-7;
    let shifted = relit(&kept, &problem.scene, Some(shifted)).solution;
    assert_ne!(shifted.direct(), solution.direct());
    assert_same_light(&shifted, &solution, "shifted by nothing");
    // What was lit in between leaves no trace.
    assert_eq!(relit(&kept, &problem.scene, Some(other_light())).solution, elsewhere.solution);
}

/// Expected: direct light as the program computes it at points (which `tests/direct_light.rs` holds to closed forms); and as
/// much power as a solve anew, whose elements follow that light, finds.
#[test]
fn a_moved_light_shines_where_it_is_now() {
    let problem = cornell(settings());
    let kept = solve_with_elements(&problem).kept.unwrap();
    let Solved { solution, report, .. } = relit(&kept, &problem.scene, Some(other_light()));
    let anew = solve_unwatched(&Problem { light: Some(other_light()), ..problem });
    for bounce in 0..2 {
        let sum = |report: &radiosity::solver::SolveReport| {
            report.energy.bounces.iter().skip(bounce).map(|bounce| bounce.arriving.element_sum()).sum::<f64>()
        };
        let ratio = sum(&report) / sum(&anew.1);
        assert!((ratio - 1.0).abs() < 0.01, "from bounce {bounce}: {ratio} of the power");
    }
    let emitted = report.energy.emitted.element_sum();
    let balance: f64 = report.energy.bounces.iter().map(|part| (part.absorbed + part.escaped).element_sum()).sum();
    assert!((balance / emitted - 1.0).abs() < 1e-4, "{balance} of {emitted} W");
    assert!(solution.info.complete && solution.info.light == Some(other_light()));
    assert_eq!(solution.bounces.len(), 2);
}

/// Expected: the exact field over the area, but for penumbras, where few rays tell how much of a light is seen; a changed
/// reflectance alone leaves no noise.
#[test]
fn a_preview_is_the_field_to_a_few_percent_without_a_hemisphere_ray() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let tracer = Arc::new(Counting { tracer: Tracer::new(Arc::clone(&scene)), hemisphere_rays: AtomicU64::new(0) });
    let options = LoadOptions::default();
    let problem = Problem::new(Arc::clone(&scene), tracer.clone(), options, Some(cornell_light()), settings()).unwrap();
    let kept = solve_with_elements(&problem).kept.unwrap();
    let before = tracer.hemisphere_rays.load(Relaxed);
    let monitor = Monitor::new(kept.tessellation(), None);
    let painted = with_materials(&scene, |material| material.reflectance *= 0.8);
    for (what, scene, light, most) in
        [("moved", &scene, other_light(), 0.04), ("painted", &painted, cornell_light(), 1e-3)]
    {
        let quick = kept.preview(scene, Some(light), &monitor).unwrap();
        let exact = relit(&kept, scene, Some(light)).solution.total();
        let areas = kept.tessellation().vertex_areas();
        let (mut squares, mut sum) = (0.0, 0.0);
        for ((quick, exact), area) in quick.iter().zip(&exact).zip(&areas) {
            squares += area * (*quick - *exact).length_squared() / 3.0;
            sum += area * exact.element_sum() / 3.0;
        }
        let difference = (squares * areas.iter().sum::<f32>()).sqrt() / sum;
        assert!(difference < most, "{what}: {difference}");
    }
    assert_eq!(tracer.hemisphere_rays.load(Relaxed), before);
    monitor.cancel();
    assert!(kept.preview(&scene, Some(other_light()), &monitor).is_none());
}

/// Expected: eq. 5 with the new reflectance. A closed box of surfaces that all emit and reflect alike.
#[test]
fn a_changed_reflectance_gives_the_light_of_equation_5() {
    let scene = own_scene("tests/furnace-50", &LoadOptions::default());
    let problem = problem(&scene, None, SolveSettings { subdivide: 0, ..even() });
    let kept = solve_with_elements(&problem).kept.unwrap();
    let direct = f64::from(std::f32::consts::PI * scene.materials[0].emitted_radiance.x);
    for reflectance in [0.0, 0.3, 0.9] {
        let painted = with_materials(&scene, |material| material.reflectance = Vec3::splat(reflectance));
        let total = relit(&kept, &painted, None).solution.total();
        let mean = total.iter().map(|value| f64::from(value.x)).sum::<f64>() / total.len() as f64;
        let expected = direct * furnace_irradiance(1.0, f64::from(reflectance), 1000);
        assert!((mean / expected - 1.0).abs() < 2e-3, "{reflectance}: {mean}, not {expected}");
    }
}

#[test]
fn no_hemisphere_ray_is_traced() {
    for settings in [settings(), even()] {
        let scene = own_scene("cornell/cornell", &LoadOptions::default());
        let tracer = Counting { tracer: Tracer::new(Arc::clone(&scene)), hemisphere_rays: AtomicU64::new(0) };
        let tracer = Arc::new(tracer);
        let light = Some(cornell_light());
        let problem =
            Problem::new(Arc::clone(&scene), tracer.clone(), LoadOptions::default(), light, settings).unwrap();
        let kept = solve_with_elements(&problem).kept.unwrap();
        let before = tracer.hemisphere_rays.load(Relaxed);
        assert!(before > 10_000, "{before}");
        let painted = with_materials(&scene, |material| material.reflectance *= 0.5);
        let Solved { report, .. } = relit(&kept, &painted, Some(other_light()));
        assert_eq!((tracer.hemisphere_rays.load(Relaxed), report.gather_rays), (before, 0));
    }
}

#[test]
fn rows_that_are_not_kept_or_do_not_fit_are_refused() {
    let without_rows = SolveSettings { row_memory: Some(0), ..settings() };
    assert!(solve_with_elements(&cornell(without_rows)).kept.is_none());
    let problem = cornell(settings());
    let black = with_materials(&problem.scene, |material| material.reflectance = Vec3::ZERO);
    let problem = Problem { scene: Arc::clone(&black), ..problem };
    let kept = solve_with_elements(&problem).kept.unwrap();
    assert_eq!(kept.refuses(&black), None);
    let grey = with_materials(&black, |material| material.reflectance = Vec3::splat(0.5));
    assert!(kept.refuses(&grey).unwrap().contains("black"));
    assert!(kept.refuses(&own_scene("tests/furnace-50", &LoadOptions::default())).is_some());
}

#[test]
fn a_job_that_relights_tells_what_a_solve_tells() {
    let problem = cornell(settings());
    let kept = solve_with_elements(&problem).kept.unwrap();
    let job = Job::relight(Arc::clone(&kept), Arc::clone(&problem.scene), Some(other_light()), 2).unwrap();
    while !job.is_finished() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let told: Vec<(u32, Vec<Vec3>)> = job
        .messages()
        .filter_map(|message| match message {
            Message::Bounce { index, irradiance, .. } => Some((index, irradiance.to_vec())),
            _ => None,
        })
        .collect();
    let Solved { solution, .. } = job.finish().unwrap();
    assert_eq!(told, [(0, solution.bounces[0].clone()), (1, solution.bounces[1].clone())]);
    assert_eq!(relit(&kept, &problem.scene, Some(other_light())).solution, solution, "on one thread and on two");
}
