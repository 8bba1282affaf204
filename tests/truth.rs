//! The reference path tracer against the shared truths, which another program computed.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::truths::{CASES, agreement_of, case};
use radiosity::{
    check::surface_points::{area_uniform_points, locate, truth_point},
    scene::{LoadOptions, load},
    trace::Tracer,
};

/// Every so many-th point of a truth is computed, with so many paths: seconds, and enough to see an error of 1 %.
const STEP: usize = 16;
const SAMPLES: u32 = 1024;

/// Where light comes by rare paths alone, an estimate does not know its own error: this part of the mean is allowed.
const FLOOR: f64 = 0.01;

fn assert_agrees(truth: &str) {
    let (_, scene) = CASES.iter().find(|(name, _)| *name == truth).unwrap();
    let Some(case) = case(truth, scene, STEP) else {
        return;
    };
    let found = agreement_of(&case, 1.0, SAMPLES, FLOOR);
    assert!(found.mean_difference.iter().all(|difference| difference.abs() < 3.0), "{truth}: {found:?}");
    assert!(found.largest < 6.0, "{truth}: {found:?} at {:?}", case.points[found.largest_at]);
}

#[test]
fn cornell_box_agrees_with_the_truth() {
    assert_agrees("cornell");
}

#[test]
fn original_cornell_box_with_its_emissive_quad_agrees_with_the_truth() {
    assert_agrees("cornell-original");
}

#[test]
fn colour_bleeding_room_agrees_with_the_truth() {
    assert_agrees("indirect-test");
}

#[test]
fn sponza_with_textures_and_interpolated_normals_agrees_with_the_truth() {
    assert_agrees("sponza");
}

#[test]
fn staircase_with_its_emissive_ceiling_agrees_with_the_truth() {
    assert_agrees("staircase");
}

#[test]
fn a_light_two_percent_too_bright_does_not_agree() {
    let Some(case) = case("cornell", "cornell/cornell.obj", STEP) else {
        return;
    };
    let found = agreement_of(&case, 1.02, SAMPLES, FLOOR);
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
        let (other, place) = found.unwrap().on().unwrap();
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
