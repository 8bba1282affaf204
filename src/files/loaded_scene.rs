//! A scene with its state file: what a solve, a picture and the window start from.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::Context as _;

use super::first_camera::first_camera;
use crate::{
    math::color::ToneMap,
    scene::{LoadOptions, Scene, SceneError, builtin, camera::CameraState, load},
    solver::State,
};

/// The name of the built-in scene.
pub const BUILTIN: &str = "cornell";

/// A scene that was read, with its state.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// Its file, or [`BUILTIN`].
    pub path: PathBuf,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The options it was read with.
    pub load: LoadOptions,
    /// What the state file said.
    pub state: State,
    /// The state's camera, or one that looks at the whole scene, or into it if it is a room.
    pub camera: CameraState,
    /// The state's tone map, or the default.
    pub tone_map: ToneMap,
}

impl LoadedScene {
    /// Reads a scene with the given options; `state` is kept beside it.
    ///
    /// # Errors
    /// One line, if there is no usable scene at `path`.
    pub fn load(path: &Path, state: State, options: LoadOptions) -> anyhow::Result<Self> {
        let scene = Arc::new(read_scene(path, &options)?);
        let camera = state.camera.unwrap_or_else(|| first_camera(&scene));
        let tone_map = state.tone_map.unwrap_or_default();
        Ok(Self { path: path.to_path_buf(), scene, load: options, state, camera, tone_map })
    }
}

/// Reads a file, or the built-in scene where its name is given.
///
/// # Errors
/// One line, if there is no usable scene at `path`.
pub fn read_scene(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    if is_builtin(path) { builtin::cornell(options) } else { load::load(path, options) }
}

/// True for the name of the built-in scene, if no file has that name.
pub fn is_builtin(path: &Path) -> bool {
    path.as_os_str() == BUILTIN && !path.is_file()
}

/// The state for a scene: the named file, or else the one of the scene's own name and `.toml` beside it, or else an
/// empty one. The second value holds its warnings, each with the file's name.
///
/// # Errors
/// One line, for a file that cannot be read or is no state file.
pub fn read_state(scene: &Path, named: Option<&Path>) -> anyhow::Result<(State, Vec<String>)> {
    let beside = scene.with_extension("toml");
    match named {
        Some(path) => read_state_file(path),
        None if is_builtin(scene) => parse_state(builtin::CORNELL_STATE, Path::new("cornell.toml")),
        None if beside.is_file() => read_state_file(&beside),
        None => Ok((State::default(), Vec::new())),
    }
}

/// Reads a state file. The second value holds its warnings, each with the file's name.
///
/// # Errors
/// One line, for a file that cannot be read or is no state file.
pub fn read_state_file(path: &Path) -> anyhow::Result<(State, Vec<String>)> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("{}: cannot be read as text; check the path", path.display()))?;
    parse_state(&text, path)
}

fn parse_state(text: &str, path: &Path) -> anyhow::Result<(State, Vec<String>)> {
    let (state, warnings) =
        State::from_toml(text).map_err(|problem| anyhow::anyhow!("{}: {problem}", path.display()))?;
    Ok((state, warnings.iter().map(|warning| format!("{}: {warning}", path.display())).collect()))
}
