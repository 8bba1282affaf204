//! Whole solves against answers known on paper.
#![cfg(feature = "reference")]

mod common;

use common::{cornell_light, own_scene, problem, solve_unwatched};
use glam::{DVec3, Vec3};
use radiosity::{
    check::closed_form::{
        furnace_irradiance, parallel_squares_form_factor, perpendicular_squares_form_factor, polygon_irradiance,
    },
    math::sequence::Sampler,
    scene::{LoadOptions, Scene, Tessellation},
    solver::{Solution, SolveSettings},
    transport::lights::DirectMethod,
};

/// Mean of a field over the elements' area, by the vertices' shares.
fn area_mean(scene: &Scene, tessellation: &Tessellation, field: &[Vec3], of: impl Fn(Vec3) -> bool) -> DVec3 {
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for element in 0..tessellation.mesh.triangles.len() as u32 {
        if !of(scene.mesh.geometric_normal(tessellation.scene_triangle[element as usize])) {
            continue;
        }
        let share = f64::from(tessellation.mesh.area(element)) / 3.0;
        for vertex in tessellation.mesh.triangles[element as usize] {
            sum += share * field[vertex as usize].as_dvec3();
            area += share;
        }
    }
    sum / area
}

/// The sum of bounces 0 to `last` at each vertex.
fn total_after(solution: &Solution, last: usize) -> Vec<Vec3> {
    let vertices = 0..solution.buried.len();
    vertices.map(|vertex| solution.bounces[..=last].iter().map(|bounce| bounce[vertex]).sum()).collect()
}

#[test]
fn furnaces_follow_equation_5_after_every_bounce() {
    for (name, reflectance) in [("furnace-30", 0.3), ("furnace-50", 0.5), ("furnace-80", 0.8), ("furnace-95", 0.95)] {
        let scene = own_scene(&format!("tests/{name}"), &LoadOptions::default());
        let settings = SolveSettings { rays: 1024, light_rays: 64, bounces: Some(8), ..SolveSettings::even() };
        let problem = problem(&scene, None, settings);
        let (solution, report) = solve_unwatched(&problem);
        assert!(!solution.buried.contains(&true), "{name}");
        // All walls emit radiance L: direct irradiance is π L everywhere.
        let direct = std::f64::consts::PI * scene.materials[0].emitted_radiance.as_dvec3();
        for bounce in 0..=8 {
            let total = total_after(&solution, bounce);
            let expected = direct.x * furnace_irradiance(1.0, reflectance, bounce as u32);
            let mean = area_mean(&scene, &problem.tessellation, &total, |_| true);
            assert!((mean.x / expected - 1.0).abs() < 1e-3, "{name}, bounce {bounce}: mean {mean}, not {expected}");
            for (vertex, value) in total.iter().enumerate() {
                let error = f64::from(value.x) / expected - 1.0;
                assert!(error.abs() < 0.01, "{name}, bounce {bounce}, vertex {vertex}: off by {error}");
            }
        }
        let powers: Vec<f64> = report.energy.bounces.iter().map(|bounce| bounce.arriving.x).collect();
        assert!(powers.windows(2).all(|pair| pair[1] <= pair[0]), "{name}: energy grew: {powers:?}");
        // A closed box of 6 m²: all of the emitted power π L A arrives, and ρ of what arrives is reflected to arrive again.
        let emitted = 6.0 * direct.x;
        assert!((report.energy.emitted.x / emitted - 1.0).abs() < 1e-5, "{name}: {:?}", report.energy.emitted);
        for (bounce, power) in report.energy.bounces.iter().enumerate() {
            let expected = emitted * f64::powi(reflectance, bounce as i32);
            assert!((power.arriving.x / expected - 1.0).abs() < 1e-3, "{name}, bounce {bounce}: {power:?}");
            assert!((power.absorbed.x / power.arriving.x - (1.0 - reflectance)).abs() < 1e-5, "{name}: {power:?}");
            assert!(power.escaped.x.abs() < 1e-3 * expected, "{name}, bounce {bounce}: {power:?}");
        }
    }
}

#[test]
fn plates_exchange_the_light_that_their_form_factors_say() {
    // The emitting plate's radiosity π L times F_21 = F_12 is the other plate's mean irradiance.
    let known = [
        ("parallel-plates", parallel_squares_form_factor(1.0)),
        ("perpendicular-plates", perpendicular_squares_form_factor()),
    ];
    for (name, form_factor) in known {
        let scene = own_scene(&format!("tests/{name}"), &LoadOptions::default());
        let emitter = scene.emissive_triangles().next().unwrap_or_else(|| panic!("{name}: nothing emits"));
        let emitter_normal = scene.mesh.geometric_normal(emitter);
        let settings =
            SolveSettings { rays: 256, light_rays: 256, bounces: Some(0), subdivide: 1, ..SolveSettings::even() };
        let problem = problem(&scene, None, settings);
        let (solution, _) = solve_unwatched(&problem);
        let mean =
            area_mean(&scene, &problem.tessellation, solution.direct(), |normal| normal.dot(emitter_normal) < 0.9);
        let expected = std::f64::consts::PI * f64::from(scene.material(emitter).emitted_radiance.x) * form_factor;
        // Linear interpolation between vertices of a 16 x 16 grid over a field that bends: 1 %.
        assert!((mean.x / expected - 1.0).abs() < 0.01, "{name}: {mean}, not {expected}");
    }
}

#[test]
fn sampled_direct_light_agrees_with_lamberts_formula_on_an_empty_floor() {
    // Cornell without its blocks: nothing stands between floor and light.
    let mut scene = (*own_scene("cornell/cornell", &LoadOptions::default())).clone();
    let low = scene.mesh.positions.iter().map(|position| position.y).fold(f32::INFINITY, f32::min);
    let on_floor = |scene: &Scene, triangle: u32| {
        let corners = scene.mesh.corners(triangle);
        scene.mesh.geometric_normal(triangle).y > 0.99 && corners.iter().all(|corner| corner.y - low < 1e-4)
    };
    let floor: Vec<usize> =
        (0..scene.mesh.triangles.len()).filter(|&triangle| on_floor(&scene, triangle as u32)).collect();
    scene.mesh.triangles = floor.iter().map(|&triangle| scene.mesh.triangles[triangle]).collect();
    scene.mesh.material_indices = floor.iter().map(|&triangle| scene.mesh.material_indices[triangle]).collect();
    scene.mesh.texcoords.clear();
    let scene = std::sync::Arc::new(scene);
    let light = cornell_light().to_local(&scene.frame);

    let root_mean_square = |sampler| {
        let settings = SolveSettings {
            rays: 1,
            light_rays: 256,
            bounces: Some(0),
            direct: DirectMethod::Sampled,
            sampler,
            subdivide: 4,
            ..SolveSettings::even()
        };
        let problem = problem(&scene, Some(cornell_light()), settings);
        let (solution, _) = solve_unwatched(&problem);
        let mesh = &problem.tessellation.mesh;
        let mut sum = 0.0;
        let mut count = 0.0;
        for (vertex, value) in solution.direct().iter().enumerate() {
            if mesh.triangles.iter().all(|triangle| !triangle.contains(&(vertex as u32))) {
                continue; // a vertex of the parts that were taken away
            }
            let exact =
                polygon_irradiance(mesh.positions[vertex], mesh.normals[vertex], &light.corners(), light.radiance);
            let error = value.x / exact.x - 1.0;
            // At 256 random samples the standard error here is at most 3 %; its 3-fold bounds every vertex.
            assert!(error.abs() < 0.09, "{sampler:?}, vertex {vertex}: {value}, not {exact}");
            sum += f64::from(error * error);
            count += 1.0;
        }
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let (random, sobol) = (root_mean_square(Sampler::Random), root_mean_square(Sampler::Sobol));
    assert!(random > 1e-4 && sobol < random / 5.0, "random errs by {random}, Sobol by {sobol}");
}
