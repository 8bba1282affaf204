//! `radiosity stress`: does the solver stay sound at the edges of what can be given to it?

use anyhow::Context as _;
use clap::Args;

use super::Outcome;
use crate::check::stress::{self, Row};

/// Arguments of `radiosity stress`.
///
/// Scenes that are tiny, huge or far away, needles, faces that coincide, lights in walls, extreme reflectances and
/// emission, and soups of random triangles are solved, and each answer is held to what must be true of it. Exit status: 0
/// if all is as it must be, 1 if not.
#[derive(Clone, Debug, Args)]
pub struct StressArgs {
    /// More and larger soups, and ten million rays a vertex: some minutes instead of some seconds.
    #[arg(long)]
    pub full: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// If the report cannot be written as JSON.
pub fn run(args: &StressArgs) -> anyhow::Result<Outcome> {
    let tell = |row: &Row| {
        if !args.json {
            let verdict = if row.passed { "ok" } else { "WRONG" };
            println!(
                "{verdict:5}  {:7} {:47} {:30} {:30} {:6.2} s",
                row.group, row.name, row.asked, row.found, row.seconds
            );
        }
    };
    let rows = stress::run(args.full, tell);
    let passed = rows.iter().filter(|row| row.passed).count();
    if args.json {
        println!("{}", serde_json::to_string_pretty(&rows).context("the report")?);
    } else {
        println!("{passed} of {} are as they must be", rows.len());
    }
    Ok(if passed == rows.len() { Outcome::Done } else { Outcome::Unfinished })
}
