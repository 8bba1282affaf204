//! `radiosity check`: the tests of the student's functions.

use std::fmt::Write as _;

use anyhow::Context as _;
use clap::{Args, builder::PossibleValuesParser};
use serde::Serialize;

use super::Outcome;
use crate::{
    check::tasks::{Status, TASKS, TaskReport, TracerReport, compare_tracer, run_task},
    student::FUNCTIONS,
};

/// Arguments of `radiosity check`.
///
/// Every task has its tests, from cheap to dear; the first that fails is told, with the likely mistake. Exit status: 0
/// if every task is done, 1 if one is wrong or not done, 2 for bad arguments.
#[derive(Clone, Debug, Args)]
pub struct CheckArgs {
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Seed of the random points that the functions are tested with.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Compare the ray tracer of src/student/tracer.rs with the program's own instead: right or wrong, and how fast.
    #[arg(long)]
    pub tracer: bool,
    /// Test this task alone; may be given more than once.
    #[arg(long = "task", value_name = "TASK", value_parser = PossibleValuesParser::new(TASKS.map(|task| task.name)))]
    pub only: Vec<String>,
}

/// What a whole check found.
#[derive(Debug, Serialize)]
struct CheckReport {
    seed: u64,
    earned: f32,
    points: f32,
    tasks: Vec<TaskReport>,
}

/// Runs the command.
///
/// # Errors
/// If the report cannot be written as JSON.
pub fn run(args: &CheckArgs) -> anyhow::Result<Outcome> {
    if args.tracer {
        return check_tracer(args, compare_tracer(&FUNCTIONS, args.seed).as_ref());
    }
    let is_wanted = |name: &str| args.only.is_empty() || args.only.iter().any(|wanted| wanted == name);
    let wanted = TASKS.iter().filter(|task| is_wanted(task.name));
    let tasks: Vec<TaskReport> = wanted.map(|task| run_task(task, &FUNCTIONS, args.seed)).collect();
    if args.json {
        let sum = |value: fn(&TaskReport) -> f32| tasks.iter().map(value).sum();
        let (earned, points) = (sum(|task| task.earned), sum(|task| task.points));
        let report = CheckReport { seed: args.seed, earned, points, tasks };
        println!("{}", serde_json::to_string_pretty(&report).context("the report")?);
        return Ok(outcome(&report.tasks));
    }
    print!("{}", table(&tasks));
    Ok(outcome(&tasks))
}

fn check_tracer(args: &CheckArgs, report: Option<&TracerReport>) -> anyhow::Result<Outcome> {
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report).context("the report")?);
    } else {
        println!("{}", tracer_line(report));
    }
    let is_right = report.is_some_and(|report| report.wrong.is_none());
    Ok(if is_right { Outcome::Done } else { Outcome::Unfinished })
}

/// The verdict on a ray tracer, for people.
fn tracer_line(report: Option<&TracerReport>) -> String {
    match report {
        None => String::from("ray tracer: not done (src/student/tracer.rs returns None)"),
        Some(TracerReport { rays, wrong: None, relative_speed }) => {
            format!("ray tracer: right on {rays} rays, {relative_speed:.2} times as fast as the program's own")
        }
        Some(TracerReport { rays, wrong: Some(wrong), .. }) => format!("ray tracer: wrong at ray {rays}\n  {wrong}"),
    }
}

fn outcome(tasks: &[TaskReport]) -> Outcome {
    if tasks.iter().all(|task| task.status == Status::Done) { Outcome::Done } else { Outcome::Unfinished }
}

/// The report for people: one line a task, and what to look at where one is not done.
pub fn table(tasks: &[TaskReport]) -> String {
    let mut text = format!("{:12} {:28} {:>9}  status\n", "task", "", "points");
    for task in tasks {
        let points = format!("{} / {}", task.earned, task.points);
        let extra = if task.is_extra { " (extra)" } else { "" };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:12} {:28} {points:>9}  {}{extra}", task.task, task.title, task.status);
        match &task.status {
            Status::Done => {}
            Status::NotDone(function) => {
                let _ = writeln!(text, "{:13}write {function}", "");
            }
            Status::Waits(task) => {
                let _ = writeln!(text, "{:13}first comes the task {task}", "");
            }
            Status::Wrong(finding) => {
                let _ = writeln!(text, "{:13}{}: {}", "", finding.function, finding.hint);
                let _ = writeln!(text, "{:15}test      {}", "", finding.test);
                let _ = writeln!(text, "{:15}measured  {}", "", finding.measured);
                let _ = writeln!(text, "{:15}expected  {}", "", finding.expected);
            }
        }
    }
    let sum = |is_extra: bool, value: fn(&TaskReport) -> f32| {
        tasks.iter().filter(|task| task.is_extra == is_extra).map(value).sum::<f32>()
    };
    let total = |is_extra| format!("{} of {}", sum(is_extra, |task| task.earned), sum(is_extra, |task| task.points));
    let _ = writeln!(text, "{:12} {} points, {} extra", "total", total(false), total(true));
    text
}

#[cfg(feature = "reference")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        check::tasks::run_all,
        student::{Functions, PLACEHOLDERS},
    };

    #[test]
    fn the_exit_status_tells_whether_all_is_done() {
        assert_eq!(outcome(&run_all(&FUNCTIONS, 1)), Outcome::Done);
        assert_eq!(outcome(&run_all(&PLACEHOLDERS, 1)), Outcome::Unfinished);
        let one_missing = Functions { form_basis: PLACEHOLDERS.form_basis, ..FUNCTIONS };
        assert_eq!(outcome(&run_all(&one_missing, 1)), Outcome::Unfinished);
    }

    #[test]
    fn the_table_counts_points_and_names_what_is_missing() {
        let done = table(&run_all(&FUNCTIONS, 1));
        assert!(done.ends_with("10 of 10 points, 4 of 4 extra\n"), "{done}");
        let nothing = table(&run_all(&PLACEHOLDERS, 1));
        assert!(nothing.contains("write form_basis"), "{nothing}");
        assert!(nothing.ends_with("0 of 10 points, 0 of 4 extra\n"), "{nothing}");
    }
}
