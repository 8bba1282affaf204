//! The assignment's tasks: each with its points, its tests from cheap to dear, and a diagnosis of what went wrong.
//!
//! A task's tests stop at the first failure. Then its diagnosis compares what the functions do with known wrong
//! versions, and the first that fits becomes the hint. The tests of a sampler, in order: known values; range and unit
//! length (a panic, NaN or infinity is caught and told with the input); its density at known directions and its
//! integral; the density against the finite-difference Jacobian; the round trip through the inverse; chi-square.
//!
//! | task | points | of the assignment's |
//! | --- | --- | --- |
//! | `basis` | 1 | 6 for bounces |
//! | `disk` | 0.5 | 6 for bounces |
//! | `hemisphere` | 0.5 | 6 for bounces |
//! | `barycentric` | 1 | 6 for bounces |
//! | `light` | 2 | 4 for direct light |
//! | `unshadowed` | 1 | 4 for direct light |
//! | `shadows` | 1 | 4 for direct light |
//! | `bounce` | 1 | 6 for bounces |
//! | `bounces` | 1 | 6 for bounces |
//! | `textures` | 1 | 6 for bounces |
//! | `concentric` | 1 | extra: Shirley and Chiu |
//! | `stratified` | 1 | extra: stratified points |
//! | `qmc` | 2 | extra: quasi-Monte Carlo, for the light and for directions |
//!
//! The functions that return irradiance are tested in small scenes made in code (`stage`), against closed forms by a
//! t-test over runs with other sample points; their known mistakes are told apart by what each would give in each
//! scene. Last comes the Cornell box, against the reference path tracer's values, which are kept as data, since an
//! assignment is handed out without that tracer.
//!
//! A task whose tests fail while one that it builds on is not done waits for that one.

mod area_light;
mod barycentric;
mod basis;
mod bounce;
mod bounces;
mod charts;
mod concentric;
mod cornell;
mod disk;
mod disk_mistakes;
mod gather;
mod hemisphere;
mod inverse;
mod own_tracer;
mod points;
mod probe;
mod sampling;
mod shadows;
mod stage;
mod textures;
mod unshadowed;

use std::{
    borrow::Cow,
    fmt::{self, Display, Formatter},
};

use serde::{Deserialize, Serialize};

use crate::{solver::faults::caught, student::Functions};
pub use own_tracer::{TracerReport, compare_tracer};
use probe::{Failure, Problem, Trial};

/// One task of the assignment.
#[derive(Debug)]
pub struct Task {
    /// Its short name.
    pub name: &'static str,
    /// What is to be written, in a few words.
    pub title: &'static str,
    /// Points for it when it is done.
    pub points: f32,
    /// Whether the points are extra ones.
    pub is_extra: bool,
    /// The tasks that it builds on, by name: what is wrong there shows here.
    needs: &'static [&'static str],
    tests: fn(&Trial) -> Result<(), Problem>,
    diagnose: fn(&Trial, &Failure) -> Option<String>,
}

/// All tasks, in the order in which they are best done.
pub const TASKS: [Task; 13] = [
    Task {
        name: "basis",
        title: "frame around a normal",
        points: 1.0,
        is_extra: false,
        needs: &[],
        tests: basis::tests,
        diagnose: basis::diagnose,
    },
    Task {
        name: "disk",
        title: "square to disk",
        points: 0.5,
        is_extra: false,
        needs: &[],
        tests: disk::tests,
        diagnose: disk::diagnose,
    },
    Task {
        name: "hemisphere",
        title: "cosine-weighted hemisphere",
        points: 0.5,
        is_extra: false,
        needs: &[],
        tests: hemisphere::tests,
        diagnose: hemisphere::diagnose,
    },
    Task {
        name: "barycentric",
        title: "barycentric interpolation",
        points: 1.0,
        is_extra: false,
        needs: &[],
        tests: barycentric::tests,
        diagnose: barycentric::diagnose,
    },
    Task {
        name: "light",
        title: "points on the area light",
        points: 2.0,
        is_extra: false,
        needs: &[],
        tests: area_light::tests,
        diagnose: area_light::diagnose,
    },
    Task {
        name: "unshadowed",
        title: "direct light, no shadows",
        points: 1.0,
        is_extra: false,
        needs: &["light"],
        tests: unshadowed::tests,
        diagnose: unshadowed::diagnose,
    },
    Task {
        name: "shadows",
        title: "shadow rays",
        points: 1.0,
        is_extra: false,
        needs: &["unshadowed"],
        tests: shadows::tests,
        diagnose: shadows::diagnose,
    },
    Task {
        name: "bounce",
        title: "one bounce",
        points: 1.0,
        is_extra: false,
        needs: &["basis", "hemisphere", "barycentric"],
        tests: bounce::tests,
        diagnose: bounce::diagnose,
    },
    Task {
        name: "bounces",
        title: "more bounces",
        points: 1.0,
        is_extra: false,
        needs: &["unshadowed", "shadows", "bounce"],
        tests: bounces::tests,
        diagnose: bounces::diagnose,
    },
    Task {
        name: "textures",
        title: "textures",
        points: 1.0,
        is_extra: false,
        needs: &["bounce"],
        tests: textures::tests,
        diagnose: textures::diagnose,
    },
    Task {
        name: "concentric",
        title: "Shirley-Chiu square to disk",
        points: 1.0,
        is_extra: true,
        needs: &[],
        tests: concentric::tests,
        diagnose: concentric::diagnose,
    },
    Task {
        name: "stratified",
        title: "stratified points",
        points: 1.0,
        is_extra: true,
        needs: &[],
        tests: points::stratified,
        diagnose: points::diagnose_stratified,
    },
    Task {
        name: "qmc",
        title: "points of low discrepancy",
        points: 2.0,
        is_extra: true,
        needs: &[],
        tests: points::qmc,
        diagnose: points::diagnose_qmc,
    },
];

/// How far a task is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Every test passed.
    Done,
    /// This function of `student` (or this step of one) is still to be written: it returns its placeholder, or calls
    /// `todo!()`.
    NotDone(Cow<'static, str>),
    /// Its tests fail, and this task, which it builds on, is not done or wrong: that one comes first.
    Waits(Cow<'static, str>),
    /// A test failed.
    Wrong(Finding),
}

/// What a failed test found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The function of `student` to look at.
    pub function: Cow<'static, str>,
    /// The test, in a few words.
    pub test: Cow<'static, str>,
    /// The likely mistake.
    pub hint: String,
    /// What was measured, and where.
    pub measured: String,
    /// What was expected, and why.
    pub expected: String,
}

/// What came of one task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskReport {
    /// The task's short name.
    pub task: &'static str,
    /// What is to be written.
    pub title: &'static str,
    /// Points for it when it is done.
    pub points: f32,
    /// Points earned: all of the task's or none.
    pub earned: f32,
    /// Whether the points are extra ones.
    pub is_extra: bool,
    /// How far it is.
    pub status: Status,
}

/// Runs the tests of every task. The same `seed` gives the same result; right functions pass with every seed but for
/// one in ten thousand, by the significance of the statistical tests.
pub fn run_all(functions: &Functions, seed: u64) -> Vec<TaskReport> {
    TASKS.iter().map(|task| run_task(task, functions, seed)).collect()
}

/// Runs the tests of one task of [`TASKS`], and if they fail those of the tasks that it builds on.
pub fn run_task(task: &Task, functions: &Functions, seed: u64) -> TaskReport {
    task.report(task.status(&Trial { functions, seed }))
}

/// The task of that name.
pub fn task(name: &str) -> Option<&'static Task> {
    static ALL: [Task; TASKS.len()] = TASKS;
    ALL.iter().find(|task| task.name == name)
}

impl Task {
    /// The report of this task, found to be so far.
    pub fn report(&self, status: Status) -> TaskReport {
        let earned = if status == Status::Done { self.points } else { 0.0 };
        let &Self { name, title, points, is_extra, .. } = self;
        TaskReport { task: name, title, points, earned, is_extra, status }
    }

    fn status(&self, trial: &Trial) -> Status {
        let Some(problem) = self.problem(trial) else { return Status::Done };
        let needed = self.needs.iter().filter_map(|name| task(name));
        match (needed.filter_map(|task| task.first_unfinished(trial)).next(), problem) {
            (Some(first), _) => Status::Waits(first.into()),
            (None, Problem::NotDone(function)) => Status::NotDone(function.into()),
            (None, Problem::Wrong(failure)) => Status::Wrong(self.finding(trial, failure)),
        }
    }

    /// The first of this task and those that it builds on that is not done.
    fn first_unfinished(&self, trial: &Trial) -> Option<&'static str> {
        self.problem(trial)?;
        let mut needed = self.needs.iter().filter_map(|name| task(name));
        Some(needed.find_map(|task| task.first_unfinished(trial)).unwrap_or(self.name))
    }

    fn problem(&self, trial: &Trial) -> Option<Problem> {
        match caught(|| (self.tests)(trial)) {
            Ok(result) => result.err(),
            Err(message) => Some(Problem::Wrong(probe::panicked(self.name, &message))),
        }
    }

    fn finding(&self, trial: &Trial, failure: Failure) -> Finding {
        let diagnosed = || caught(|| (self.diagnose)(trial, &failure)).ok().flatten();
        let hint = match &failure.hint {
            Some(hint) => hint.clone(),
            None => diagnosed().unwrap_or_else(|| String::from(failure.fallback)),
        };
        let Failure { function, test, measured, expected, .. } = failure;
        Finding { function: function.into(), test: test.into(), hint, measured, expected }
    }
}

impl Display for Status {
    fn fmt(&self, formatter: &mut Formatter) -> fmt::Result {
        formatter.pad(match self {
            Self::Done => "done",
            Self::NotDone(_) | Self::Waits(_) => "not done",
            Self::Wrong(_) => "wrong",
        })
    }
}
