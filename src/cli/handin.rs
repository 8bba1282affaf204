//! `radiosity handin`: the archive of a student's work.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use clap::Args;

use super::{Outcome, check::table};
use crate::course::{
    handin::{self, Notes},
    judge::{Limits, Program},
    tree::find_root,
};

/// Arguments of `radiosity handin`.
///
/// The archive holds the files of src/student, a README.txt made of handin.toml, what `check` says, and pictures that
/// are computed with your functions: the Cornell box, and the atrium at two states.
#[derive(Clone, Debug, Args)]
pub struct HandinArgs {
    /// What you say about your work, if not in handin.toml.
    #[command(flatten, next_help_heading = "Instead of handin.toml")]
    pub notes: Notes,
    /// The source tree, if not the one around the current folder.
    #[arg(long, value_name = "TREE")]
    pub source: Option<PathBuf>,
    /// How long and how large the tests and the solves may become.
    #[command(flatten)]
    pub limits: Limits,
    /// Where the archive goes.
    #[arg(short, long, value_name = "FILE.zip")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &HandinArgs) -> anyhow::Result<Outcome> {
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("zip")) {
        bail!("{}: the archive is a ZIP file; end the name in .zip", args.output.display());
    }
    let root = find_root(args.source.as_deref())?;
    let path = root.join("handin.toml");
    let saved = if path.exists() {
        let text = std::fs::read_to_string(&path).with_context(|| format!("{}: cannot be read", path.display()))?;
        Notes::from_toml(&text).with_context(|| path.display().to_string())?
    } else {
        Notes::default()
    };
    let notes = args.notes.clone().over(saved);
    let executable = std::env::current_exe().context("the program does not find itself")?;
    let program = Program { executable, root, limits: args.limits };
    let written = handin::write(&program, &notes, &args.output, table, &mut |step| eprintln!("{step}"))?;
    print!("{}", table(&written.reports));
    written.problems.iter().for_each(|problem| println!("note: {problem}"));
    println!("archive    {}", args.output.display());
    Ok(Outcome::Done)
}
