//! `radiosity grade`: marks of many hand-ins.

use std::path::PathBuf;

use clap::Args;

use super::{Outcome, check::table};
use crate::course::{
    grade::{self, Course},
    judge::Limits,
};

/// Arguments of `radiosity grade`.
///
/// Of each hand-in only the Rust files of src/student are used, in a fresh copy of the hand-out that is built and run
/// apart, within limits. The result is marks.csv, a line a student, and for each a page with what the tests say and the
/// pictures beside those of the answers. The limits stop mistakes, not malice: mark what you do not trust in a container.
#[derive(Clone, Debug, Args)]
pub struct GradeArgs {
    /// The hand-ins: archives, or folders with the same files.
    #[arg(value_name = "DIR_OR_ZIP", required = true)]
    pub hand_ins: Vec<PathBuf>,
    /// The tree that was handed out; without it, one is made of the source tree around the current folder.
    #[arg(long, value_name = "TREE")]
    pub tree: Option<PathBuf>,
    /// How long and how large the students' programs may become; a build may take ten times as long.
    #[command(flatten)]
    pub limits: Limits,
    /// Where marks.csv and the pages go: a folder, which also keeps what was built for the next time.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &GradeArgs) -> anyhow::Result<Outcome> {
    let mut say = |step: &str| eprintln!("{step}");
    let course = Course::prepare(args.tree.as_deref(), &args.output, args.limits, &mut say)?;
    let graded = grade::grade_all(&course, &args.hand_ins, table, &mut say)?;
    for student in &graded {
        let problem = student.problems.first().map_or("", String::as_str);
        println!(
            "{:24} {:4} points, {:3} extra  {problem}",
            student.hand_in,
            student.points(false),
            student.points(true)
        );
    }
    println!("marks      {}", args.output.join("marks.csv").display());
    Ok(Outcome::Done)
}
