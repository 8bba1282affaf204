//! Direct light without samples against samples, closed forms and the rebuilt field.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::{cornell_light, own_scene, problem, solve_unwatched};
use glam::{DVec3, Vec2, Vec3};
use radiosity::{
    check::{closed_form::polygon_irradiance, surface_points::area_uniform_points},
    math::sequence::Sampler,
    scene::{AreaLight, LoadOptions, Scene},
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

/// The largest difference between both methods over `count` points, relative to the largest irradiance.
fn largest_difference(scene: &Arc<Scene>, light: Option<AreaLight>, count: u32) -> f32 {
    let (mut worst, mut largest) = (0.0_f32, 0.0_f32);
    for (triangle, place) in area_uniform_points(scene, count, 7) {
        let point = SurfacePoint::new(scene, triangle, place);
        let (exact, rays) = direct_at(scene, light, DirectMethod::Analytic, &point);
        assert_eq!(rays.traced, 0, "a box of 30 triangles needs no shadow rays");
        let (sampled, _) = direct_at(scene, light, DirectMethod::Sampled, &point);
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
    assert!(largest_difference(&scene, Some(light), 300) < 1e-3);
    // Tilted and half out of the room: partly below many horizons, and behind the back wall.
    let tilted = AreaLight {
        centre: scene.frame.point_to_local(DVec3::new(0.3, 0.4, 0.5)),
        half_extent_u: Vec3::new(0.3, 0.2, 0.0),
        half_extent_v: Vec3::new(0.1, -0.1, 0.4),
        radiance: Vec3::splat(3.0),
    };
    assert!(largest_difference(&scene, Some(tilted), 300) < 2e-3);
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
        let (triangle, barycentric) = locate_point(&tracer, &scene, place, Vec3::Y).unwrap();
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
        let at = |x: f64, z: f64| -> PointIrradiance {
            let place = scene.frame.point_to_local(DVec3::new(x, 0.0, z));
            let (triangle, barycentric): (u32, Vec2) = locate_point(&tracer, &scene, place, Vec3::Y).unwrap();
            field.irradiance(triangle, barycentric, &mut Scratch::default())
        };
        // The short block's footprint has the corners (0.130, 0.065), (0.082, 0.225), (0.240, 0.272), (0.290, 0.114).
        for (x, z) in [(0.13, 0.075), (0.0875, 0.22), (0.19, 0.16)] {
            assert_eq!(at(x, z).total, Vec3::ZERO, "{x} {z}");
        }
        for (x, z) in [(0.12, 0.06), (0.075, 0.23), (0.3, 0.05)] {
            assert!(at(x, z).total.min_element() > 0.0, "{x} {z}");
        }
    }
}
