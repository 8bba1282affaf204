//! The program's numbers, measured: `cargo bench --bench numbers [-- SECTION ...]`.
//!
//! Sections: furnace, direct, truth, slopes, threads, rays, field, relight, large. Seconds of one run depend on the machine; ratios
//! are taken within one run. Sections that need the shared test scenes are skipped, and say so, where those are absent.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap ends the benchmark")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::{
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

use common::{
    cornell_light, own_scene, problem, shared, solve_unwatched, solve_with_elements,
    truths::{CASES, Case, agreement_of, case, load_options},
};
use cpu_time::ProcessTime;
use glam::{DVec3, Vec3};
use obvhs::{BvhBuildParams, bvh2::builder::build_bvh2};
use radiosity::{
    check::{
        closed_form::furnace_irradiance,
        metrics::{Field, FieldErrors, field_errors, relative_l2},
        ray_sets::RaySets,
        surface_points::locate,
    },
    files::loaded_scene,
    math::sequence::Sampler,
    scene::{LoadOptions, area_light::AreaLightState, load},
    solver::{Job, Monitor, Reconstruction, Reconstructor, SolveSettings, Solved},
    trace::{Ray, RayTracer, SurfacePoint, Tracer},
    transport::{
        Lights,
        direct::{DirectContext, ShadowRays},
        lights::{DirectMethod, FinderCounts},
        visible_light::Scratch,
    },
};
use rayon::prelude::*;

fn main() {
    let sections: [(&str, fn()); 9] = [
        ("furnace", furnace),
        ("direct", direct),
        ("truth", truth),
        ("slopes", slopes),
        ("threads", threads),
        ("rays", rays),
        ("field", field),
        ("relight", relight),
        ("large", large),
    ];
    // Cargo itself passes flags such as --bench.
    let asked: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    for (name, run) in sections {
        if asked.is_empty() || asked.iter().any(|word| word == name) {
            println!("\n== {name}");
            run();
        }
    }
}

fn as_doubles(field: &[Vec3]) -> Vec<DVec3> {
    field.iter().map(|value| value.as_dvec3()).collect()
}

/// Eq. 5 in closed boxes: the area mean and the worst vertex, over bounces 0 to 8.
fn furnace() {
    println!("reflectance  worst mean  worst vertex");
    for (name, reflectance) in [("furnace-30", 0.3), ("furnace-50", 0.5), ("furnace-80", 0.8), ("furnace-95", 0.95)] {
        let scene = own_scene(&format!("tests/{name}"), &LoadOptions::default());
        let settings = SolveSettings { rays: 1024, bounces: Some(8), ..SolveSettings::even() };
        let (solution, _) = solve_unwatched(&problem(&scene, None, settings));
        let direct = std::f64::consts::PI * f64::from(scene.materials[0].emitted_radiance.x);
        let (mut worst_mean, mut worst_vertex) = (0.0_f64, 0.0_f64);
        for bounce in 0..=8 {
            let expected = direct * furnace_irradiance(1.0, reflectance, bounce as u32);
            let total: Vec<f64> = (0..solution.buried.len())
                .map(|vertex| solution.bounces[..=bounce].iter().map(|field| f64::from(field[vertex].x)).sum())
                .collect();
            // All elements of these boxes are equal, so the plain mean is the area mean but for the edges.
            let mean = total.iter().sum::<f64>() / total.len() as f64;
            worst_mean = worst_mean.max((mean / expected - 1.0).abs());
            worst_vertex = total.iter().fold(worst_vertex, |worst, value| worst.max((value / expected - 1.0).abs()));
        }
        println!("{reflectance:11}  {:8.4} %  {:10.4} %", 100.0 * worst_mean, 100.0 * worst_vertex);
    }
}

/// Sampled direct light on Cornell's floor against Lambert's formula, without occluders.
fn direct() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let light = cornell_light().to_local(&scene.frame);
    let lights = Lights::new(&scene, Some(light));
    let empty = Arc::new(radiosity::scene::Scene { mesh: Default::default(), ..(*scene).clone() });
    let nothing = Tracer::new(empty);
    let floor: Vec<u32> = (0..scene.mesh.triangles.len() as u32)
        .filter(|&triangle| scene.mesh.corners(triangle).iter().all(|corner| corner.y < -0.49))
        .collect();
    println!("sampler     RMS error at 256 samples");
    let mut errors = Vec::new();
    for sampler in [Sampler::Random, Sampler::Stratified, Sampler::Sobol] {
        let context = DirectContext {
            scene: &scene,
            tracer: &nothing,
            lights: &lights,
            method: DirectMethod::Sampled,
            sampler,
            seed: 1,
            light_rays: 256,
            finders: FinderCounts { gather: 0, light: 256 },
            is_cancelled: &|| false,
        };
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for vertex in 0..1000_u32 {
            let place = glam::Vec2::new((vertex % 25) as f32 / 50.0, (vertex / 25) as f32 / 80.0);
            let point = SurfacePoint::new(&scene, floor[vertex as usize % floor.len()], place);
            let found = context
                .at_vertex(vertex, &[point], &[], &mut Scratch::default(), &mut ShadowRays::default())
                .irradiance();
            let exact = radiosity::check::closed_form::polygon_irradiance(
                point.origin,
                point.shading_normal,
                &light.corners(),
                light.radiance,
            );
            sum += f64::from(found.x / exact.x - 1.0).powi(2);
            count += 1.0;
        }
        errors.push((sum / count).sqrt());
        println!("{sampler:10?}  {:.4} %", 100.0 * errors[errors.len() - 1]);
    }
    println!("random / Sobol: {:.1}", errors[0] / errors[2]);
}

/// The reference path tracer against the truths, all points.
fn truth() {
    println!("scene              points  mean off [SE]  worst point [SE]  mean z²  seconds");
    for (name, scene) in CASES {
        let Some(case) = case(name, scene, 1) else { continue };
        let started = Instant::now();
        let found = agreement_of(&case, 1.0, 4096, 1e-4);
        let mean_off = found.mean_difference.iter().fold(0.0_f64, |worst, value| worst.max(value.abs()));
        println!(
            "{name:17}  {:6}  {mean_off:13.2}  {:16.2}  {:7.3}  {:7.1}",
            case.points.len(),
            found.largest,
            found.mean_square,
            started.elapsed().as_secs_f64()
        );
    }
}

/// How the vertex error (design 7.2) of direct light and one bounce falls with the number of rays.
fn slopes() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let solved = |sampler, rays, seed| {
        let settings = SolveSettings {
            rays,
            light_rays: rays,
            direct: DirectMethod::Sampled,
            sampler,
            seed,
            bounces: Some(1),
            subdivide: 3,
            ..SolveSettings::even()
        };
        as_doubles(&solve_unwatched(&problem(&scene, Some(cornell_light()), settings)).0.total())
    };
    let reference = solved(Sampler::Sobol, 32_768, 99);
    println!("sampler      N: vertex error ...  slope");
    for sampler in [Sampler::Random, Sampler::Stratified, Sampler::Sobol] {
        let counts = [16, 64, 256, 1024];
        let errors = counts.map(|rays| relative_l2(&solved(sampler, rays, 1), &reference));
        let slope = (errors[3] / errors[0]).ln() / f64::from(counts[3] / counts[0]).ln();
        let listed: Vec<String> =
            counts.iter().zip(errors).map(|(rays, error)| format!("{rays}: {:.3} %", 100.0 * error)).collect();
        println!("{sampler:10?}  {}  slope {slope:.2}", listed.join("  "));
    }
}

/// Seconds of the same solve on one and on two threads, in turn; the median ratio.
fn threads() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let settings = SolveSettings { rays: 1024, bounces: Some(4), subdivide: 4, ..SolveSettings::even() };
    let problem = problem(&scene, Some(cornell_light()), settings);
    let seconds = |threads| Job::start(problem.clone(), threads).unwrap().finish().unwrap().report.seconds;
    seconds(2);
    let mut ratios: Vec<f64> = (0..7).map(|_| seconds(1) / seconds(2)).collect();
    ratios.sort_by(f64::total_cmp);
    println!("one thread / two threads: median {:.2}, from {:.2} to {:.2}", ratios[3], ratios[0], ratios[6]);
}

/// Rays a second of processor time, times the number of threads, by how the tree is built; the median of passes in turn.
fn rays() {
    // The presets' `search_depth_threshold` makes bad leaves on regular meshes.
    let preset = |preset| BvhBuildParams { max_prims_per_leaf: 1, search_depth_threshold: 0, ..preset };
    let builds = [
        ("own", None),
        ("medium", Some(preset(BvhBuildParams::medium_build()))),
        ("very slow", Some(preset(BvhBuildParams::very_slow_build()))),
    ];
    let atrium = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/atrium/atrium.obj");
    let state = loaded_scene::read_state(&atrium, None).unwrap().0;
    let mut scenes = vec![("atrium", own_scene("atrium/atrium", &load_options()), state.light)];
    let shared = [CASES[3], CASES[4]].into_iter().filter_map(|(name, path)| Some((name, case(name, path, 1)?)));
    scenes.extend(shared.map(|(name, case)| (name, case.scene, case.light)));
    println!("Mrays/s: closest hit, occluded                 scattered          gathered            shadow");
    for (name, scene, light) in scenes {
        let sets = RaySets::new(&scene, light.map(|light| light.to_local(&scene.frame)), 1 << 20, 1);
        let tracers = builds.map(|(build, parameters)| {
            let started = Instant::now();
            let scene = Arc::clone(&scene);
            let tracer = match parameters {
                None => Tracer::new(scene),
                Some(parameters) => {
                    Tracer::with_tree(scene, |boxes| build_bvh2(boxes, parameters, &mut Duration::default()))
                }
            };
            (build, tracer, started.elapsed())
        });
        let mut speeds = vec![<[[Vec<f64>; 2]; 3]>::default(); tracers.len()];
        for _ in 0..5 {
            for ((_, tracer, _), speeds) in tracers.iter().zip(&mut speeds) {
                for ((_, rays), speeds) in sets.named().iter().zip(speeds) {
                    speeds[0].push(mega_rays_a_second(rays, |ray| tracer.closest_hit(ray).is_some()));
                    speeds[1].push(mega_rays_a_second(rays, |ray| tracer.occluded(ray)));
                }
            }
        }
        for ((build, _, seconds), mut speeds) in tracers.iter().zip(speeds) {
            let median = |speeds: &mut Vec<f64>| {
                speeds.sort_by(f64::total_cmp);
                speeds[speeds.len() / 2]
            };
            let listed: Vec<String> = speeds
                .iter_mut()
                .map(|[closest, any]| format!("{:8.2} {:8.2}", median(closest), median(any)))
                .collect();
            println!("{name:9}  {build:9}  build {:7.3} s  {}", seconds.as_secs_f64(), listed.join(" "));
        }
    }
}

fn mega_rays_a_second(rays: &[Ray], is_hit: impl Fn(&Ray) -> bool + Sync) -> f64 {
    let before = processor_seconds();
    let hits: usize = rays.par_chunks(4096).map(|rays| rays.iter().filter(|ray| is_hit(ray)).count()).sum();
    std::hint::black_box(hits);
    rays.len() as f64 * 1e-6 * rayon::current_num_threads() as f64 / (processor_seconds() - before)
}

fn errors_at_truth(case: &Case, solved: &Solved, reconstruction: Reconstruction) -> FieldErrors {
    let tracer = Tracer::new(Arc::clone(&case.scene));
    let field = Reconstructor::new(&case.scene, &tracer, &solved.tessellation, &solved.solution, reconstruction);
    let at = |point| {
        let place = locate(&case.scene, &tracer, point).unwrap().on();
        let (direct, total) =
            place.map_or_else(Default::default, |(triangle, at)| field.direct_and_total(triangle, at));
        (direct.as_dvec3(), total.as_dvec3())
    };
    let (direct, total): (Vec<_>, Vec<_>) = case.points.iter().map(at).unzip();
    let truth = |part: fn(&radiosity::check::truth_file::TruthValue) -> DVec3| case.values.iter().map(part).collect();
    let (truth_direct, truth_total): (Vec<_>, Vec<_>) = (truth(|value| value.direct), truth(|value| value.total));
    field_errors(Field { direct: &direct, total: &total }, Field { direct: &truth_direct, total: &truth_total })
}

/// Processor seconds of this process, all threads.
fn processor_seconds() -> f64 {
    ProcessTime::now().as_duration().as_secs_f64()
}

/// Field error against seconds on the Cornell box: even cuts, then cuts that follow the light.
fn field() {
    let Some(case) = case(CASES[0].0, CASES[0].1, 1) else { return };
    println!(
        "                                             |          vertex reconstruction          |  direct at the point"
    );
    println!(
        "elements   vertices  gathered   rays  proc s  |  lit      bias     direct   all      |  lit      indirect  all"
    );
    for (subdivide, rays) in [(2, 256), (3, 256), (4, 64), (4, 256), (4, 1024), (5, 256), (5, 1024)] {
        let settings = SolveSettings { rays, bounces: Some(16), subdivide, ..SolveSettings::even() };
        field_line(&case, &format!("{} a wall", 1 << subdivide), settings);
    }
    for (error, rays) in
        [(0.2, 64), (0.1, 64), (0.1, 128), (0.05, 128), (0.03, 256), (0.02, 512), (0.01, 512), (0.005, 2048)]
    {
        let settings = SolveSettings { rays, adaptive: error, ..SolveSettings::default() };
        field_line(&case, &format!("to {error}"), settings);
    }
}

fn field_line(case: &Case, name: &str, settings: SolveSettings) {
    let rays = settings.rays;
    let before = processor_seconds();
    let problem = problem(&case.scene, case.light, settings);
    let solved = solve_with_elements(&problem);
    let seconds = processor_seconds() - before;
    let vertex = errors_at_truth(case, &solved, Reconstruction::Vertex);
    let point = errors_at_truth(case, &solved, Reconstruction::PointDirect);
    let Solved { solution, report, .. } = solved;
    println!(
        "{name:9}  {:8}  {:8}  {rays:5}  {seconds:6.2}  |  {:5.2} %  {:+5.2} %  {:5.2} %  {:5.2} %  |  {:5.2} %  {:5.2} %  {:5.2} %",
        solution.buried.len(),
        report.gathered_vertices,
        100.0 * vertex.lit.total.relative_l2,
        100.0 * vertex.lit.total.bias,
        100.0 * vertex.lit.direct.relative_l2,
        100.0 * vertex.all.total.relative_l2,
        100.0 * point.lit.total.relative_l2,
        100.0 * point.lit.indirect.relative_l2,
        100.0 * point.all.total.relative_l2,
    );
    if std::env::var_os("VERBOSE").is_some() {
        println!(
            "           wall {:.3}: following {:.3} (direct light {:.3}), bounces {:.3}; {:.2} M rays, {} shadow rays, {} bounces",
            report.seconds,
            report.seconds_adapting,
            report.seconds_following_direct,
            report.bounce_seconds,
            report.gather_rays as f64 * 1e-6,
            report.shadow_rays,
            solution.bounces.len()
        );
    }
}

/// The light moved along its longer side, a twentieth of it further each time: a preview, and the exact field.
fn relight() {
    println!("scene      vertices  light moved   preview ms  differs    exact ms  direct  bounces");
    for ((name, path), adaptive) in [(CASES[0], 0.015), (CASES[3], 0.02)] {
        let Some(Case { scene, light: Some(light), .. }) = case(name, path, 1) else { continue };
        let settings = SolveSettings { adaptive, ..SolveSettings::default() };
        let kept = solve_with_elements(&problem(&scene, Some(light), settings)).kept.unwrap();
        let longer = if DVec3::from(light.u).length() > DVec3::from(light.v).length() { light.u } else { light.v };
        for step in 1..=5 {
            let part = 0.1 * f64::from(step);
            let centre = (DVec3::from(light.centre) + part * DVec3::from(longer)).to_array();
            let moved = Some(AreaLightState { centre, ..light });
            let monitor = Monitor::new(kept.tessellation(), None);
            let started = Instant::now();
            let quick = kept.preview(&scene, moved, &monitor).unwrap();
            let quick_ms = 1e3 * started.elapsed().as_secs_f64();
            let Solved { solution, report, .. } = kept.relight(&scene, moved, &monitor);
            println!(
                "{name:9}  {:8}  {:9.0} %  {quick_ms:11.0}  {:5.1} %  {:10.0}  {:6.0}  {:7.0}",
                solution.buried.len(),
                50.0 * part,
                100.0 * relative_l2(&as_doubles(&quick), &as_doubles(&solution.total())),
                1e3 * report.seconds,
                1e3 * report.seconds_following_direct,
                1e3 * report.bounce_seconds
            );
        }
    }
}

/// Sponza and the staircase: as they come with 4 bounces, then cut to half a metre and converged.
fn large() {
    println!("scene      triangles  vertices  load s  build s  solve s  Mrays/s  lit error  bias");
    for (name, path) in [CASES[3], CASES[4]] {
        let Some(full_path) = shared(&format!("scenes/{path}")) else { continue };
        let Some(case) = case(name, path, 1) else { continue };
        let started = Instant::now();
        let loaded = Arc::new(load::load(&full_path, &load_options()).unwrap());
        let load_seconds = started.elapsed().as_secs_f64();
        let as_they_come = SolveSettings { bounces: Some(4), ..SolveSettings::even() };
        let cut = SolveSettings { max_edge: Some(0.5), unabsorbed: 0.001, ..SolveSettings::even() };
        let follow = SolveSettings { adaptive: 0.2, rays: 128, unabsorbed: 0.001, ..SolveSettings::default() };
        for settings in [as_they_come, follow, cut] {
            let started = Instant::now();
            let problem = problem(&loaded, case.light, settings);
            let build_seconds = started.elapsed().as_secs_f64();
            let solved = solve_with_elements(&problem);
            let errors = errors_at_truth(&case, &solved, Reconstruction::Vertex);
            let Solved { solution, report, .. } = solved;
            println!(
                "{name:9}  {:9}  {:8}  {load_seconds:6.2}  {build_seconds:7.2}  {:7.2}  {:7.2}  {:7.2} %  {:+.2} %",
                loaded.mesh.triangles.len(),
                solution.buried.len(),
                report.seconds,
                report.gather_rays as f64 * 1e-6 / report.seconds,
                100.0 * errors.lit.total.relative_l2,
                100.0 * errors.lit.total.bias
            );
        }
    }
}
