//! The one error of this module: what, where, what to do.

use std::path::{Path, PathBuf};

/// Why a scene or state file cannot be used. Prints as one line.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}; {advice}", path.display())]
pub struct SceneError {
    /// The file at fault.
    pub path: PathBuf,
    /// What is wrong, with the line or item where it is known.
    pub problem: String,
    /// What the user can do.
    pub advice: String,
}

impl SceneError {
    /// An error about `path`.
    pub fn new(path: &Path, problem: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { path: path.to_path_buf(), problem: problem.into(), advice: advice.into() }
    }
}
