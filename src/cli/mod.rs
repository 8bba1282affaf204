//! The command line: words in, words and files out.
//!
//! Each command is a file with its clap arguments and a `run` function that returns an [`Outcome`].

pub mod export;
pub mod files;
pub mod probe;
pub mod progress;

/// How a command ended; errors (bad input) end with exit status 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit status 0.
    Done,
    /// Stopped by Ctrl-C, with the partial result kept: exit status 130.
    Cancelled,
}
