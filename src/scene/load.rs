//! Reading OBJ and MTL files.

use std::path::Path;

use super::{LoadOptions, Scene, SceneError};

/// Reads a scene: `path` is an OBJ file; its MTL files and textures are looked for beside it.
pub fn load(path: &Path, _options: &LoadOptions) -> Result<Scene, SceneError> {
    Err(SceneError::new(path, "loading is not written", "wait"))
}
