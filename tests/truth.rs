//! The reference path tracer against the shared truths, which another program computed.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{f64::consts::PI, sync::Arc};

use common::truths::{CASES, agreement_of, case};
use glam::DVec3;
use radiosity::{
    check::{
        path_tracer::{PathSettings, PathTracer},
        surface_points::{area_uniform_points, locate, ray_origin, truth_point},
        truth_file::TruthPoint,
    },
    scene::{LoadOptions, load},
    trace::{Located, Tracer},
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

/// Expected: E = π L / (1 - ρ) everywhere in a closed box of surfaces that all emit L and reflect ρ (eq. 5), of which direct
/// light is π L: at its corners and the middles of its edges as well, where each point lies in the planes of other walls.
#[test]
fn at_corners_and_on_edges_of_a_closed_box_the_truth_is_that_of_its_walls() {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
    let walls = "usemtl w\nf 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 8 5 1 4\nf 3 2 6 7\n";
    let material = "newmtl w\nKd 0.5 0.5 0.5\nKe 1 1 1\n";
    let options = LoadOptions::default();
    let scene = Arc::new(load::load_from_memory("box", &(corners.to_owned() + walls), material, &options).unwrap());
    let tracer = Tracer::new(Arc::clone(&scene));
    let grid = || (0..27).map(|index| 0.5 * DVec3::new((index % 3).into(), (index / 3 % 3).into(), (index / 9).into()));
    let mut origins = Vec::new();
    for position in grid() {
        for axis in 0..3 {
            let inwards = 1.0 - 2.0 * position[axis];
            if inwards != 0.0 {
                let point = TruthPoint { position, normal: inwards * DVec3::AXES[axis] };
                let place = locate(&scene, &tracer, &point);
                assert!(place.is_some(), "{position}");
                origins.push(ray_origin(&scene, &tracer, &point, place.and_then(Located::on)));
            }
        }
    }
    assert_eq!(origins.len(), 54);
    let settings = PathSettings { samples: 200, bounces: 20, seed: 5 };
    for (found, origin) in
        PathTracer::new(&scene, &tracer, None, settings).estimate_all(&origins, |_| ()).iter().zip(&origins)
    {
        for (estimate, expected) in [(found.direct, PI), (found.total, 2.0 * PI)] {
            let error = (estimate.mean.x - expected) / estimate.standard_error.x;
            assert!(error.abs() < 4.5 && estimate.standard_error.x < 0.05 * expected, "{origin:?}: {found:?}");
        }
    }
}
