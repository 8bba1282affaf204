//! The Cornell box, built into the program, so that it runs from any folder.

use super::{LoadOptions, Scene, SceneError, load::load_from_memory};

/// Its geometry: OBJ text.
pub const CORNELL_OBJ: &str = include_str!("../../scenes/cornell/cornell.obj");
/// Its materials: MTL text.
pub const CORNELL_MTL: &str = include_str!("../../scenes/cornell/cornell.mtl");
/// Its state file: TOML text.
pub const CORNELL_STATE: &str = include_str!("../../scenes/cornell/cornell.toml");

/// Reads the built-in Cornell box.
///
/// # Errors
/// None with options that are in range: the text is part of the program.
pub fn cornell(options: &LoadOptions) -> Result<Scene, SceneError> {
    load_from_memory("cornell", CORNELL_OBJ, CORNELL_MTL, options)
}
