//! The shared truths, each with its scene, and the reference path tracer at their points.
#![allow(dead_code, reason = "which parts are unused differs from one program to the next")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use glam::DVec3;
use radiosity::{
    check::{
        metrics::{Agreement, Estimates, agreement},
        path_tracer::{PathSettings, PathTracer},
        surface_points::{locate, ray_origin},
        truth_file::{self, TruthPoint, TruthValue},
    },
    scene::{LoadOptions, Scene, area_light::AreaLightState, load},
    trace::Tracer,
};

use super::shared;

/// Truth and scene of each case.
pub(crate) const CASES: [(&str, &str); 5] = [
    ("cornell", "cornell/cornell.obj"),
    ("cornell-original", "cornell-original/CornellBox-Original.obj"),
    ("indirect-test", "indirect-test/indirect-test_tex.obj"),
    ("sponza", "sponza/sponza.obj"),
    ("staircase", "staircase/staircase.obj"),
];

/// How the scenes of the truths are read: the truths clamp no reflectance and know no `d` (the staircase's glass is a
/// black surface there).
pub(crate) fn load_options() -> LoadOptions {
    LoadOptions { reflectance_limit: 0.999, opaque: true, ..LoadOptions::default() }
}

/// A truth with its scene.
pub(crate) struct Case {
    pub(crate) scene: Arc<Scene>,
    pub(crate) light: Option<AreaLightState>,
    pub(crate) points: Vec<TruthPoint>,
    pub(crate) values: Vec<TruthValue>,
    pub(crate) bounces: u32,
}

/// Every `step`-th point of a truth, with its scene and the light of its comment. None where the files are absent.
pub(crate) fn case(truth: &str, scene: &str, step: usize) -> Option<Case> {
    let scene_path = shared(&format!("scenes/{scene}"))?;
    let truth = truth_file::read(&shared(&format!("truth/{truth}.csv"))?).unwrap();
    let scene = load::load(&scene_path, &load_options()).unwrap();
    let comment = |key: &str| truth.comments.iter().find(|line| line.contains(key)).unwrap();
    let numbers = |text: &str| text.split(',').map(|word| word.trim().parse::<f64>().unwrap()).collect::<Vec<_>>();
    let words: Vec<&str> = comment("light (").split_once(':').unwrap().1.split_whitespace().collect();
    let light = (words.len() == 5).then(|| {
        let triple = |index: usize| <[f64; 3]>::try_from(numbers(words[index])).unwrap();
        AreaLightState { centre: triple(0), u: triple(1), v: triple(2), radiance: triple(4).map(|band| band as f32) }
    });
    let before_bounces = comment("indirect bounces").split(" indirect").next().unwrap();
    let bounces = before_bounces.split_whitespace().last().unwrap().parse().unwrap();
    let kept: Vec<usize> = (0..truth.points.len()).step_by(step).collect();
    let values = truth.values.unwrap();
    Some(Case {
        scene: Arc::new(scene),
        light,
        points: kept.iter().map(|&index| truth.points[index]).collect(),
        values: kept.iter().map(|&index| values[index]).collect(),
        bounces,
    })
}

/// The path tracer's total by `samples` paths a point against the truth's, with the light multiplied by `brightness`.
/// To each point's standard error the part `floor` of the mean is added.
pub(crate) fn agreement_of(case: &Case, brightness: f32, samples: u32, floor: f64) -> Agreement {
    let tracer = Tracer::new(case.scene.clone());
    let light =
        case.light.map(|light| AreaLightState { radiance: light.radiance.map(|band| band * brightness), ..light });
    let light = light.map(|light| light.to_local(&case.scene.frame));
    let origins: Vec<_> = case
        .points
        .iter()
        .map(|point| ray_origin(&case.scene, &tracer, point, locate(&case.scene, &tracer, point).unwrap().on()))
        .collect();
    let settings = PathSettings { samples, bounces: case.bounces, seed: 5 };
    let path_tracer = PathTracer::new(&case.scene, &tracer, light.as_ref(), settings);
    let found = path_tracer.estimate_all(&origins, |_| ());
    let truth: Vec<DVec3> = case.values.iter().map(|value| value.total).collect();
    let mean = truth.iter().map(|value| value.element_sum() / 3.0).sum::<f64>() / truth.len() as f64;
    for (index, (found, truth)) in found.iter().zip(&truth).enumerate() {
        let leak = if *truth == DVec3::ZERO { found.total.mean.max_element() } else { 0.0 };
        assert!(leak < 0.01 * mean, "light leaks to {:?}: {leak}", case.points[index]);
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
        floor * mean,
    )
}
