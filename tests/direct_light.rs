//! Direct light without samples against samples, closed forms and the rebuilt field.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::{cornell_light, own_scene, problem, solve_unwatched};
use glam::{DVec3, Vec3};
use radiosity::{
    check::{closed_form::polygon_irradiance, surface_points::area_uniform_points},
    math::sequence::Sampler,
    scene::{AreaLight, LoadOptions, Scene, area_light::AreaLightState, load::load_from_memory},
    solver::{PointIrradiance, Reconstruction, Reconstructor, SolveSettings},
    trace::{SurfacePoint, Tracer, locate_point},
    transport::{
        Lights,
        direct::{DirectContext, ShadowRays},
        lights::{DirectMethod, FinderCounts},
        visible_light::Scratch,
    },
};

fn direct_at(
    scene: &Arc<Scene>,
    light: Option<AreaLight>,
    method: DirectMethod,
    point: &SurfacePoint,
) -> (Vec3, ShadowRays) {
    let tracer = Tracer::new(Arc::clone(scene));
    let context = DirectContext {
        scene,
        tracer: &tracer,
        lights: &Lights::new(scene, light),
        method,
        sampler: Sampler::Sobol,
        seed: 3,
        light_rays: 16_384,
        finders: FinderCounts { gather: 0, light: 16_384 },
        is_cancelled: &|| false,
    };
    let mut rays = ShadowRays::default();
    (context.at_point(point, &mut Scratch::default(), &mut rays).irradiance(), rays)
}

/// The largest difference between a method without samples and one with them over `count` points, relative to the largest irradiance.
fn largest_difference(scene: &Arc<Scene>, light: Option<AreaLight>, count: u32, by: DirectMethod) -> f32 {
    let (mut worst, mut largest) = (0.0_f32, 0.0_f32);
    for (triangle, place) in area_uniform_points(scene, count, 7) {
        let point = SurfacePoint::new(scene, triangle, place);
        let (exact, rays) = direct_at(scene, light, DirectMethod::Analytic, &point);
        assert_eq!(rays.traced, 0, "a box of 30 triangles needs no shadow rays");
        let (sampled, _) = direct_at(scene, light, by, &point);
        worst = worst.max((exact - sampled).abs().max_element());
        largest = largest.max(sampled.max_element());
    }
    worst / largest
}

/// Expected: the samples' own answer; 16,384 Sobol points err by some 1e-4 in penumbra.
#[test]
fn light_without_samples_agrees_with_many_samples_in_light_shadow_and_penumbra() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let light = cornell_light().to_local(&scene.frame);
    assert!(largest_difference(&scene, Some(light), 300, DirectMethod::Sampled) < 1e-3);
    assert!(largest_difference(&scene, Some(light), 300, DirectMethod::Ratio) < 1e-3);
    // Tilted and half out of the room: partly below many horizons, and behind the back wall.
    let tilted = AreaLight {
        centre: scene.frame.point_to_local(DVec3::new(0.3, 0.4, 0.5)),
        half_extent_u: Vec3::new(0.3, 0.2, 0.0),
        half_extent_v: Vec3::new(0.1, -0.1, 0.4),
        radiance: Vec3::splat(3.0),
    };
    assert!(largest_difference(&scene, Some(tilted), 300, DirectMethod::Sampled) < 2e-3);
    assert!(largest_difference(&scene, Some(tilted), 300, DirectMethod::Ratio) < 2e-3);
}

/// Expected: Lambert's formula in its own words, where nothing lies between.
#[test]
fn a_point_that_sees_the_whole_light_has_the_closed_form_exactly() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let light = cornell_light().to_local(&scene.frame);
    let tracer = Tracer::new(Arc::clone(&scene));
    let mut seen = 0;
    for (x, z) in [(0.1, 0.05), (0.45, 0.02), (0.5, 0.5), (0.02, 0.3)] {
        let place = scene.frame.point_to_local(DVec3::new(x, 0.0, z));
        let (triangle, barycentric) = locate_point(&tracer, &scene, place, Vec3::Y).unwrap().on().unwrap();
        let point = SurfacePoint::new(&scene, triangle, barycentric);
        let whole = light.corners().iter().all(|corner| {
            let ray = point.ray_to(*corner).unwrap();
            !radiosity::trace::RayTracer::occluded(&tracer, &ray)
        });
        if whole {
            let expected = polygon_irradiance(point.origin, point.shading_normal, &light.corners(), light.radiance);
            let found = direct_at(&scene, Some(light), DirectMethod::Analytic, &point).0;
            assert!(found.abs_diff_eq(expected, 1e-5 * expected.max_element()), "{found} {expected}");
            seen += 1;
        }
    }
    assert!(seen >= 2, "{seen}");
}

/// Under a block no light arrives; beside it, the field of the free corners does. The floor's elements know neither.
#[test]
fn a_point_under_a_block_is_dark_and_one_beside_it_is_not() {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    let settings = SolveSettings { rays: 64, bounces: Some(1), subdivide: 3, ..SolveSettings::even() };
    let problem = problem(&scene, Some(cornell_light()), settings);
    let (solution, _) = solve_unwatched(&problem);
    for reconstruction in [Reconstruction::Vertex, Reconstruction::PointDirect] {
        let field = Reconstructor::new(&scene, &*problem.tracer, &problem.tessellation, &solution, reconstruction);
        let tracer = Tracer::new(Arc::clone(&scene));
        let at = |x: f64, z: f64| -> Option<PointIrradiance> {
            let place = scene.frame.point_to_local(DVec3::new(x, 0.0, z));
            let (triangle, barycentric) = locate_point(&tracer, &scene, place, Vec3::Y).unwrap().on()?;
            Some(field.irradiance(triangle, barycentric, &mut Scratch::default()))
        };
        // The short block's footprint has the corners (0.130, 0.065), (0.082, 0.225), (0.240, 0.272), (0.290, 0.114).
        for (x, z) in [(0.13, 0.075), (0.0875, 0.22), (0.19, 0.16)] {
            assert_eq!(at(x, z), None, "{x} {z}: enclosed");
        }
        for (x, z) in [(0.12, 0.06), (0.075, 0.23), (0.3, 0.05)] {
            assert!(at(x, z).unwrap().total.min_element() > 0.0, "{x} {z}");
        }
    }
}

fn floor_light() -> AreaLightState {
    AreaLightState { centre: [0.0, 1.0, 0.0], u: [3.0, 0.0, 0.0], v: [0.0, 0.0, 3.0], radiance: [2.0; 3] }
}

/// A floor of 2 x 2 m under a light of 6 x 6 m at 1 m, and what else there is.
fn floor_and_light(more: &str) -> (Arc<Scene>, AreaLight) {
    let obj = format!("v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n{more}");
    let scene = Arc::new(load_from_memory("floor", &obj, "", &LoadOptions::default()).unwrap());
    let light = floor_light().to_local(&scene.frame);
    (scene, light)
}

/// Rows of `columns` x `columns` level triangles of this size, 0.5 m above the floor, as OBJ.
fn level_triangles(columns: u32, size: f64) -> String {
    let corner = |x: f64, z: f64| format!("v {x} 0.5 {z}\n");
    let at = |index: u32| 2.4 * (f64::from(index) + 0.5) / f64::from(columns) - 1.2;
    let places = (0..columns).flat_map(|row| (0..columns).map(move |column| (at(column), at(row))));
    places.map(|(x, z)| corner(x, z) + &corner(x, z + size) + &corner(x + size, z) + "f -3 -2 -1\n").collect()
}

fn origin_of_floor(scene: &Arc<Scene>) -> SurfacePoint {
    let tracer = Tracer::new(Arc::clone(scene));
    let place = scene.frame.point_to_local(DVec3::new(0.1, 0.0, 0.03));
    let (triangle, barycentric) = locate_point(&tracer, scene, place, Vec3::Y).unwrap().on().unwrap();
    SurfacePoint::new(scene, triangle, barycentric)
}

/// Expected: Lambert's formula for the whole light. A hundred specks, 10 micrometres large, lie in the shaft, too many to cut
/// the light's outline by, and no sample meets one.
#[test]
fn where_all_samples_see_the_light_its_closed_form_is_taken_and_the_rest_is_not_traced() {
    let (scene, light) = floor_and_light(&level_triangles(10, 1e-5));
    let point = origin_of_floor(&scene);
    let expected = polygon_irradiance(point.origin, point.shading_normal, &light.corners(), light.radiance);
    let (found, rays) = direct_at(&scene, Some(light), DirectMethod::Analytic, &point);
    assert!(found.abs_diff_eq(expected, 1e-5 * expected.x), "{found}, not {expected}");
    assert!(rays.traced <= 4_096 && rays.fully_seen > 12_000, "{rays:?}");
}

/// Expected: what 16,384 samples say, to the error of 256 random ones, four times as many as a vertex gets; its square
/// scatters by a sixth over 64 points. Small triangles hide 8 % of the light, which the few samples of a vertex may miss altogether.
#[test]
fn a_point_that_is_shown_gets_samples_enough_to_see_what_hides_little_of_the_light() {
    let (scene, _) = floor_and_light(&level_triangles(60, 0.016));
    let state = AreaLightState { u: [0.5, 0.0, 0.0], v: [0.0, 0.0, 0.5], ..floor_light() };
    let light = state.to_local(&scene.frame);
    let settings = SolveSettings { rays: 64, bounces: Some(0), subdivide: 1, ..SolveSettings::even() };
    let problem = problem(&scene, Some(state), settings);
    let (solution, _) = solve_unwatched(&problem);
    let tracer = Tracer::new(Arc::clone(&scene));
    let field = Reconstructor::new(&scene, &tracer, &problem.tessellation, &solution, Reconstruction::PointDirect);
    let points = area_uniform_points(&scene, 400, 7).into_iter().filter(|(triangle, _)| *triangle < 2).take(64);
    let (mut squared, mut of_random) = (0.0, 0.0);
    for (triangle, place) in points {
        let point = SurfacePoint::new(&scene, triangle, place);
        let whole = polygon_irradiance(point.origin, point.shading_normal, &light.corners(), light.radiance).x;
        let expected = direct_at(&scene, Some(light), DirectMethod::Sampled, &point).0.x;
        let found = field.irradiance(triangle, place, &mut Scratch::default()).direct.x;
        squared += (found - expected).powi(2);
        of_random += expected * (whole - expected) / 256.0;
    }
    assert!(of_random > 0.0 && squared < 1.5 * of_random, "{squared} {of_random}");
}

/// Expected: what 16,384 samples of eq. 3 say by themselves, which err by some 1e-3.
#[test]
fn where_many_triangles_hide_part_of_a_light_samples_tell_the_part_alone() {
    let (scene, light) = floor_and_light(&level_triangles(12, 0.14));
    let point = origin_of_floor(&scene);
    let whole = polygon_irradiance(point.origin, point.shading_normal, &light.corners(), light.radiance);
    let (by_part, rays) = direct_at(&scene, Some(light), DirectMethod::Analytic, &point);
    let (sampled, _) = direct_at(&scene, Some(light), DirectMethod::Sampled, &point);
    assert!(rays.traced > 16_000, "{rays:?}");
    assert!(sampled.x > 0.5 * whole.x && sampled.x < 0.9 * whole.x, "{sampled} of {whole}");
    assert!((by_part.x / sampled.x - 1.0).abs() < 3e-3, "{by_part}, not {sampled}");
}

/// Expected: Lambert's formula for the light without the plate. A plate whose back is to the floor takes up 83 % of what the
/// floor's middle sees: that is most of it, but the point is no more than dark.
#[test]
fn a_point_that_sees_back_faces_for_the_most_part_has_the_light_of_the_rest() {
    let (scene, light) = floor_and_light("v -0.6 0.3 -0.6\nv -0.6 0.3 0.6\nv 0.6 0.3 0.6\nv 0.6 0.3 -0.6\nf 5 6 7 8\n");
    let settings = SolveSettings { rays: 64, bounces: Some(0), subdivide: 1, ..SolveSettings::even() };
    let problem = problem(&scene, Some(floor_light()), settings);
    let (solution, _) = solve_unwatched(&problem);
    let middle = scene.frame.point_to_local(DVec3::ZERO);
    let positions = &problem.tessellation.mesh.positions;
    let vertex = positions.iter().position(|position| position.distance(middle) < 1e-6).unwrap();
    let plate: Vec<Vec3> = scene.mesh.corners(2).into_iter().chain([scene.mesh.corners(3)[2]]).collect();
    let plate = [plate[0], plate[3], plate[2], plate[1]];
    let above = Vec3::Y * 1e-6;
    let of = |corners: &[Vec3]| polygon_irradiance(middle + above, Vec3::Y, corners, light.radiance);
    let expected = of(&light.corners()) - of(&plate);
    let found = solution.direct()[vertex];
    assert!(!solution.buried[vertex]);
    assert!((found.x / expected.x - 1.0).abs() < 0.02, "{found}, not {expected}");
}
