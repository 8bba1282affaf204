//! A solution together with the scene that it belongs to.

use std::{path::Path, sync::Arc};

use super::scene_args::{LoadedScene, SceneArgs};
use crate::{
    files::{
        elements_of, read_solution,
        solved_field::{AnySolution, SolvedField},
    },
    scene::{LoadOptions, Scene, Tessellation},
    solver::Solution,
};

/// A solution with the scene and the elements that it belongs to.
pub struct SolvedScene {
    /// The solution.
    pub solution: Solution,
    /// The scene, read with the options it was solved with.
    pub loaded: LoadedScene,
    /// The elements that carry the solution.
    pub tessellation: Tessellation,
}

/// Reads a solution and its scene: an OBJ file or the name of a built-in scene, and a state file, if not the one beside
/// the scene. The flags that say how a scene is read are not asked for: the solution knows them.
pub fn open_solved(path: &Path, scene: &Path, state: Option<&Path>) -> anyhow::Result<SolvedScene> {
    with_scene(path, read_solution(path)?, scene, state)
}

/// The same with a solution that was read from `path`.
pub fn with_scene(path: &Path, solution: Solution, scene: &Path, state: Option<&Path>) -> anyhow::Result<SolvedScene> {
    let loaded = load(scene, state, &solution.info.load)?;
    let tessellation = elements_of(path, &solution, &loaded.scene)?;
    Ok(SolvedScene { solution, loaded, tessellation })
}

/// Reads a scene as it was read for a solution.
pub fn load(scene: &Path, state: Option<&Path>, options: &LoadOptions) -> anyhow::Result<LoadedScene> {
    let (scene, state) = (scene.to_path_buf(), state.map(Path::to_path_buf));
    let scene = SceneArgs { scene, state, load: options.clone() };
    scene.load_as_solved(&scene.load)
}

/// Reads a solution of either kind and its scene, for reading irradiance at points.
pub fn open_field(path: &Path, scene: &Path) -> anyhow::Result<(SolvedField, Arc<Scene>)> {
    let solution = AnySolution::read(path)?;
    let scene = load(scene, None, solution.load_options())?.scene;
    Ok((SolvedField::new(path, solution, &scene)?, scene))
}
