//! The checker itself: right functions get all points, wrong ones are caught and the mistake is named.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use glam::DVec2;
use radiosity::{
    check::tasks::{Status, TASKS, TaskReport, compare_tracer, run_all, run_task},
    cli::check::table,
    scene::Scene,
    student::{Functions, PLACEHOLDERS},
    trace::{Hit, Ray, RayTracer},
};

mod mutants;

use mutants::{ANSWERS, Mutant, right};

const SEED: u64 = 1;

const RIGHT: [(&str, Functions); 3] =
    [("the answers", ANSWERS), ("polar and cross products", right::POLAR), ("inversion", right::INVERSION)];

fn assert_all_done(name: &str, reports: &[TaskReport]) {
    assert!(reports.iter().all(|report| report.status == Status::Done), "{name}\n{}", table(reports));
    let points: f32 = TASKS.iter().map(|task| task.points).sum();
    assert_eq!(reports.iter().map(|report| report.earned).sum::<f32>(), points);
}

#[test]
fn right_functions_however_written_get_all_points() {
    for (name, functions) in RIGHT {
        assert_all_done(name, &run_all(&functions, SEED));
    }
}

#[test]
fn two_hundred_seeds_give_no_false_alarm() {
    for seed in 0..200 {
        let (name, functions) = RIGHT[seed as usize % 3];
        assert_all_done(&format!("{name}, seed {seed}"), &run_all(&functions, seed));
    }
}

/// Mutants whose first hint may be another than the best one; at most one in ten.
const OTHER_HINT: [&str; 0] = [];

/// Every task is done with one mistake, but for the mutant's own, and those that build on it. Returns what is said.
fn first_hint(mutant: &Mutant) -> (String, String) {
    let mut said = None;
    for task in TASKS {
        let report = run_task(&task, &mutant.functions, SEED);
        if report.task != mutant.task {
            if !matches!(report.status, Status::Done | Status::Waits(_)) {
                return (
                    String::from("another task"),
                    format!("{} is not concerned: {:?}", report.task, report.status),
                );
            }
            continue;
        }
        said = Some(match report.status {
            Status::Wrong(finding) => {
                assert!(!finding.measured.is_empty() && !finding.expected.is_empty());
                (finding.test.into_owned(), finding.hint)
            }
            Status::NotDone(step) => (String::from("not done"), format!("write {step}")),
            status => (String::from("not caught"), format!("{status:?}")),
        });
    }
    said.unwrap()
}

#[test]
fn every_wrong_version_is_caught_and_its_mistake_is_named() {
    let mutants = mutants::all();
    assert!(OTHER_HINT.len() * 10 <= mutants.len());
    let mut wrong_hints = Vec::new();
    for mutant in &mutants {
        let (test, hint) = first_hint(mutant);
        let is_right = hint.contains(mutant.hint);
        let verdict = if is_right { "right" } else { "WRONG" };
        println!("{:11} | {:32} | {test:30} | {hint} | {verdict}", mutant.task, mutant.name);
        if !is_right && !OTHER_HINT.contains(&mutant.name) {
            wrong_hints.push(format!("{} ({}): {hint}", mutant.name, mutant.task));
        }
    }
    assert!(wrong_hints.is_empty(), "{}", wrong_hints.join("\n"));
}

#[test]
#[expect(clippy::todo, reason = "a function that its student has not written yet")]
fn placeholders_and_todo_count_as_not_done() {
    for report in run_all(&PLACEHOLDERS, SEED) {
        let is_open = matches!(report.status, Status::NotDone(_) | Status::Waits(_));
        assert!(is_open && report.earned == 0.0, "{}: {}", report.task, report.status);
    }
    let unwritten = Functions { form_basis: |_| todo!(), ..ANSWERS };
    assert_eq!(run_all(&unwritten, SEED)[0].status, Status::NotDone("form_basis".into()));
    let no_inverse = Functions { area_light_inverse: PLACEHOLDERS.area_light_inverse, ..ANSWERS };
    let light = run_all(&no_inverse, SEED).into_iter().find(|report| report.task == "light").unwrap();
    assert_eq!(light.status, Status::NotDone("area_light_inverse".into()));
}

#[test]
fn a_panic_and_a_nan_are_told_with_function_and_input() {
    let panics = Functions { interpolate_barycentric: |_, _| panic!("corner 3"), ..ANSWERS };
    let infinite = Functions { cosine_hemisphere_pdf_solid_angle: |_| f32::INFINITY, ..ANSWERS };
    for (functions, task, words) in [
        (panics, "barycentric", ["interpolate_barycentric", "corner 3", "(u, v) = [0, 0]"]),
        (infinite, "hemisphere", ["cosine_hemisphere_pdf_solid_angle", "inf", "[0.0000, 0.0000, 1.0000]"]),
    ] {
        let report = run_all(&functions, SEED).into_iter().find(|report| report.task == task).unwrap();
        let text = table(&[report]);
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
}

#[test]
fn the_same_seed_gives_the_same_report() {
    let mutant = &mutants::all()[0];
    assert_eq!(run_all(&mutant.functions, 7), run_all(&mutant.functions, 7));
}

#[test]
fn the_command_prints_the_same_as_json_and_refuses_what_is_no_seed() {
    let check = |words: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_radiosity")).arg("check").args(words).output().unwrap()
    };
    let output = check(&["--json", "--seed", "3"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["seed"], 3);
    assert_eq!(report["earned"], report["points"]);
    assert_eq!(report["tasks"].as_array().unwrap().len(), TASKS.len());
    assert!(report["tasks"].as_array().unwrap().iter().all(|task| task["status"] == "done"));
    assert_eq!(check(&["--seed", "many"]).status.code(), Some(2));
}

/// A right tracer that tries every triangle (Möller and Trumbore 1997).
struct Loop {
    scene: Arc<Scene>,
    /// What is wrong with it, if anything.
    mistake: &'static str,
}

impl RayTracer for Loop {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut hits = (0..self.scene.mesh.triangles.len() as u32).filter_map(|triangle| self.hit(triangle, ray));
        if self.mistake == "any hit" { hits.next_back() } else { hits.min_by(|a, b| a.distance.total_cmp(&b.distance)) }
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let ray = if self.mistake == "endless shadow" { Ray { max_distance: f32::INFINITY, ..*ray } } else { *ray };
        self.closest_hit(&ray).is_some()
    }
}

impl Loop {
    fn hit(&self, triangle: u32, ray: &Ray) -> Option<Hit> {
        let [a, b, c] = self.scene.mesh.corners(triangle).map(|corner| corner.as_dvec3());
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (edge_b, edge_c) = (b - a, c - a);
        let across = direction.cross(edge_c);
        let determinant = edge_b.dot(across);
        let offset = origin - a;
        let u = offset.dot(across) / determinant;
        let turned = offset.cross(edge_b);
        let v = direction.dot(turned) / determinant;
        let distance = (edge_c.dot(turned) / determinant) as f32;
        let slack = if self.mistake == "leaky edges" { -1e-7 } else { 1e-9 };
        let is_inside = u >= -slack && v >= -slack && u + v <= 1.0 + slack;
        let leaves = triangle == ray.origin_triangle && self.mistake != "own triangle";
        let is_hit = is_inside && distance > 0.0 && distance < ray.max_distance && !leaves;
        let (u, v) = if self.mistake == "u and v swapped" { (v, u) } else { (u, v) };
        let front = (determinant > 0.0) != (self.mistake == "front and back");
        is_hit.then_some(Hit { triangle, barycentric: DVec2::new(u, v).as_vec2(), distance, front })
    }
}

macro_rules! with_tracer {
    ($mistake:literal) => {
        Functions {
            ray_tracer: |scene| Some(Box::new(Loop { scene: Arc::clone(scene), mistake: $mistake })),
            ..ANSWERS
        }
    };
}

#[test]
fn a_ray_tracer_is_compared_and_a_wrong_one_is_told_with_a_ray() {
    assert!(compare_tracer(&ANSWERS, SEED).is_none(), "none is written");
    let report = compare_tracer(&with_tracer!(""), SEED).unwrap();
    assert_eq!(report.wrong, None);
    assert!(report.rays > 10_000 && report.relative_speed > 0.0, "{report:?}");
    let wrong = [
        (with_tracer!("any hit"), "not the nearest"),
        (with_tracer!("endless shadow"), "`occluded` says occluded"),
        (with_tracer!("leaky edges"), "a ray at"),
        (with_tracer!("own triangle"), "the triangle that it leaves"),
        (with_tracer!("u and v swapped"), "barycentric"),
        (with_tracer!("front and back"), "front and back"),
    ];
    for (functions, words) in wrong {
        let problem = compare_tracer(&functions, SEED).unwrap().wrong.unwrap();
        println!("{problem}");
        assert!(problem.contains(words), "{words}: {problem}");
    }
}
