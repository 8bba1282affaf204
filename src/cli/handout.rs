//! `radiosity handout`: the tree that a teacher gives to students.

use std::path::PathBuf;

use clap::Args;

use super::Outcome;
use crate::course::handout;

/// Arguments of `radiosity handout`.
#[derive(Clone, Debug, Args)]
pub struct HandoutArgs {
    /// The folder to write: a new one, or one that is empty.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The source tree, if not the one around the current folder.
    #[arg(long, value_name = "TREE")]
    pub source: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &HandoutArgs) -> anyhow::Result<Outcome> {
    let count = handout::write(args.source.as_deref(), &args.folder)?;
    println!("{}: {count} files, without the answers; students begin with ASSIGNMENT.txt", args.folder.display());
    Ok(Outcome::Done)
}
