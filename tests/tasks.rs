//! The checker itself: right functions get all points, wrong ones are caught and the mistake is named.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use radiosity::{
    check::tasks::{Status, TASKS, TaskReport, run_all},
    cli::check::table,
    student::{Functions, PLACEHOLDERS},
};

mod mutants;

use mutants::{ANSWERS, right};

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

#[test]
fn every_wrong_version_is_caught_and_its_mistake_is_named() {
    let mutants = mutants::all();
    assert!(OTHER_HINT.len() * 10 <= mutants.len());
    let mut wrong_hints = Vec::new();
    for mutant in &mutants {
        for report in run_all(&mutant.functions, SEED) {
            if report.task != mutant.task {
                assert_eq!(report.status, Status::Done, "{}: {} is not concerned", mutant.name, report.task);
                continue;
            }
            assert_eq!(report.earned, 0.0);
            let Status::Wrong(finding) = report.status else { panic!("{}: {}", mutant.name, report.status) };
            let is_right = finding.hint.contains(mutant.hint);
            let (verdict, hint) = (if is_right { "right" } else { "WRONG" }, finding.hint);
            println!("{:11} | {:32} | {:30} | {hint} | {verdict}", mutant.task, mutant.name, finding.test);
            if !is_right && !OTHER_HINT.contains(&mutant.name) {
                wrong_hints.push(format!("{} ({}): {hint}", mutant.name, mutant.task));
            }
            assert!(!finding.measured.is_empty() && !finding.expected.is_empty());
        }
    }
    assert!(wrong_hints.is_empty(), "{}", wrong_hints.join("\n"));
}

#[test]
#[expect(clippy::todo, reason = "a function that its student has not written yet")]
fn placeholders_and_todo_count_as_not_done() {
    for report in run_all(&PLACEHOLDERS, SEED) {
        assert!(matches!(report.status, Status::NotDone(_)), "{}: {}", report.task, report.status);
    }
    let unwritten = Functions { form_basis: |_| todo!(), ..ANSWERS };
    assert_eq!(run_all(&unwritten, SEED)[0].status, Status::NotDone("form_basis"));
    let no_inverse = Functions { area_light_inverse: PLACEHOLDERS.area_light_inverse, ..ANSWERS };
    let light = run_all(&no_inverse, SEED).into_iter().find(|report| report.task == "light").unwrap();
    assert_eq!(light.status, Status::NotDone("area_light_inverse"));
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
