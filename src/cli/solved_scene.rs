//! A solution together with the scene that it belongs to.

use std::{path::Path, sync::Arc};

use super::scene_args::{LoadedScene, SceneArgs};
use crate::{
    files::{
        elements_of, read_solution,
        solved_field::{AnySolution, SolvedField},
    },
    scene::{Scene, Tessellation},
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
    let solution = read_solution(path)?;
    let load = solution.info.load.clone();
    let scene = SceneArgs { scene: scene.to_path_buf(), state: state.map(Path::to_path_buf), load };
    let loaded = scene.load_as_solved(&scene.load)?;
    let tessellation = elements_of(path, &solution, &loaded.scene)?;
    Ok(SolvedScene { solution, loaded, tessellation })
}

/// Reads a solution of either kind and its scene, for reading irradiance at points.
pub fn open_field(path: &Path, scene: &Path) -> anyhow::Result<(SolvedField, Arc<Scene>)> {
    let solution = AnySolution::read(path)?;
    let load = solution.load_options().clone();
    let scene = SceneArgs { scene: scene.to_path_buf(), state: None, load };
    let scene = scene.load_as_solved(&scene.load)?.scene;
    Ok((SolvedField::new(path, solution, &scene)?, scene))
}
