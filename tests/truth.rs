//! The reference path tracer against the shared truths, which another program computed.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use glam::DVec3;
use radiosity::{
    check::{
        metrics::{Agreement, Estimates, agreement},
        path_tracer::{PathSettings, PathTracer},
        surface_points::{area_uniform_points, locate, ray_origin, truth_point},
        truth_file::{self, TruthPoint, TruthValue},
    },
    scene::{LoadOptions, Scene, area_light::AreaLightState, load},
    trace::Tracer,
};

/// Every so many-th point of a truth is computed, with so many paths: seconds, and enough to see an error of 1 %.
const STEP: usize = 16;
const SAMPLES: u32 = 1024;

/// Where light comes by rare paths alone, an estimate does not know its own error: this part of the mean is allowed.
const FLOOR: f64 = 0.01;

struct Case {
    scene: Arc<Scene>,
    light: Option<AreaLightState>,
    points: Vec<TruthPoint>,
    values: Vec<TruthValue>,
    bounces: u32,
}

/// A truth thinned out, with its scene and the light of its comment.
fn case(truth: &str, scene: &str) -> Option<Case> {
    let scene_path = common::shared(&format!("scenes/{scene}"))?;
    let truth = truth_file::read(&common::shared(&format!("truth/{truth}.csv"))?).unwrap();
    // The truths clamp no reflectance and know no `d`: the staircase's glass is a black surface there.
    let options = LoadOptions { reflectance_limit: 0.999, opaque: true, ..LoadOptions::default() };
    let scene = load::load(&scene_path, &options).unwrap();
    let comment = |key: &str| truth.comments.iter().find(|line| line.contains(key)).unwrap();
    let numbers = |text: &str| text.split(',').map(|word| word.trim().parse::<f64>().unwrap()).collect::<Vec<_>>();
    let words: Vec<&str> = comment("light (").split_once(':').unwrap().1.split_whitespace().collect();
    let light = (words.len() == 5).then(|| {
        let triple = |index: usize| <[f64; 3]>::try_from(numbers(words[index])).unwrap();
        AreaLightState { centre: triple(0), u: triple(1), v: triple(2), radiance: triple(4).map(|band| band as f32) }
    });
    let before_bounces = comment("indirect bounces").split(" indirect").next().unwrap();
    let bounces = before_bounces.split_whitespace().last().unwrap().parse().unwrap();
    let kept: Vec<usize> = (0..truth.points.len()).step_by(STEP).collect();
    let values = truth.values.unwrap();
    Some(Case {
        scene: Arc::new(scene),
        light,
        points: kept.iter().map(|&index| truth.points[index]).collect(),
        values: kept.iter().map(|&index| values[index]).collect(),
        bounces,
    })
}

/// The path tracer's total against the truth's, with the light multiplied by `brightness`.
fn agreement_of(case: &Case, brightness: f32) -> Agreement {
    let tracer = Tracer::new(case.scene.clone());
    let light =
        case.light.map(|light| AreaLightState { radiance: light.radiance.map(|band| band * brightness), ..light });
    let light = light.map(|light| light.to_local(&case.scene.frame));
    let origins: Vec<_> = case
        .points
        .iter()
        .map(|point| ray_origin(&case.scene, point, Some(locate(&case.scene, &tracer, point).unwrap())))
        .collect();
    let settings = PathSettings { samples: SAMPLES, bounces: case.bounces, seed: 5 };
    let path_tracer = PathTracer::new(&case.scene, &tracer, light.as_ref(), settings);
    let found = path_tracer.estimate_all(&origins, |_| ());
    let truth: Vec<DVec3> = case.values.iter().map(|value| value.total).collect();
    let mean = truth.iter().map(|value| value.element_sum() / 3.0).sum::<f64>() / truth.len() as f64;
    for (index, (found, truth)) in found.iter().zip(&truth).enumerate() {
        let leak = if *truth == DVec3::ZERO { found.total.mean.max_element() } else { 0.0 };
        assert!(leak < FLOOR * mean, "light leaks to {:?}: {leak}", case.points[index]);
    }
    agreement(
        Estimates {
            values: &found.iter().map(|found| found.total.mean).collect::<Vec<_>>(),
            standard_errors: &found.iter().map(|found| found.total.standard_error).collect::<Vec<_>>(),
        },
        Estimates {
            values: &truth,
            standard_errors: &case.values.iter().map(|value| value.standard_error).collect::<Vec<_>>(),
        },
        FLOOR * mean,
    )
}

fn assert_agrees(truth: &str, scene: &str) {
    let Some(case) = case(truth, scene) else {
        return;
    };
    let found = agreement_of(&case, 1.0);
    assert!(found.mean_difference.iter().all(|difference| difference.abs() < 3.0), "{truth}: {found:?}");
    assert!(found.largest < 6.0, "{truth}: {found:?} at {:?}", case.points[found.largest_at]);
}

#[test]
fn cornell_box_agrees_with_the_truth() {
    assert_agrees("cornell", "cornell/cornell.obj");
}

#[test]
fn original_cornell_box_with_its_emissive_quad_agrees_with_the_truth() {
    assert_agrees("cornell-original", "cornell-original/CornellBox-Original.obj");
}

#[test]
fn colour_bleeding_room_agrees_with_the_truth() {
    assert_agrees("indirect-test", "indirect-test/indirect-test_tex.obj");
}

#[test]
fn sponza_with_textures_and_interpolated_normals_agrees_with_the_truth() {
    assert_agrees("sponza", "sponza/sponza.obj");
}

#[test]
fn staircase_with_its_emissive_ceiling_agrees_with_the_truth() {
    assert_agrees("staircase", "staircase/staircase.obj");
}

#[test]
fn a_light_two_percent_too_bright_does_not_agree() {
    let Some(case) = case("cornell", "cornell/cornell.obj") else {
        return;
    };
    let found = agreement_of(&case, 1.02);
    assert!(found.mean_difference.iter().all(|&difference| difference > 3.0), "{found:?}");
}

#[test]
fn sampled_points_are_found_on_their_own_triangles_and_cover_the_area() {
    let Some(path) = common::shared("scenes/cornell/cornell.obj") else {
        return;
    };
    let scene = Arc::new(load::load(&path, &LoadOptions::default()).unwrap());
    let tracer = Tracer::new(scene.clone());
    let places = area_uniform_points(&scene, 20_000, 3);
    assert_eq!(places.len(), 20_000);
    let mut counts = vec![0.0_f32; scene.mesh.triangles.len()];
    for &(triangle, barycentric) in &places {
        counts[triangle as usize] += 1.0;
        let found = locate(&scene, &tracer, &truth_point(&scene, (triangle, barycentric)));
        let (other, place) = found.unwrap();
        let apart = scene.mesh.position(other, place).distance(scene.mesh.position(triangle, barycentric));
        assert!(apart < 1e-6, "{triangle} {barycentric} is found {apart} away on {other}");
        assert!(scene.mesh.geometric_normal(other).dot(scene.mesh.geometric_normal(triangle)) > 0.99);
    }
    let area: f32 = (0..counts.len() as u32).map(|triangle| scene.mesh.area(triangle)).sum();
    for (triangle, count) in counts.iter().enumerate() {
        let expected = 20_000.0 * scene.mesh.area(triangle as u32) / area;
        assert!((count - expected).abs() < 5.0 * expected.sqrt(), "{triangle}: {count} points, expected {expected}");
    }
}
