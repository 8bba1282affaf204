//! `radiosity window`: the window, on a scene.

use std::path::{Path, PathBuf};

use clap::{ArgMatches, Args};

use super::{Outcome, scene_args::overlay};
use crate::{
    app,
    files::loaded_scene::{self, BUILTIN, LoadedScene},
    scene::LoadOptions,
};

/// Arguments of `radiosity window`.
#[derive(Clone, Debug, Args)]
pub struct WindowArgs {
    /// The scene: an OBJ file, or `cornell` for the built-in Cornell box.
    #[arg(default_value = BUILTIN)]
    pub scene: PathBuf,
    /// State file (TOML) with camera, light, settings and tone map. Without it, a file of the scene's own name and
    /// `.toml` is used if there is one beside it.
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// How the scene is read.
    #[command(flatten, next_help_heading = "Reading the scene")]
    pub load: LoadOptions,
}

/// Runs the command.
pub fn run(args: &WindowArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    let (state, warnings) = loaded_scene::read_state(&args.scene, args.state.as_deref())?;
    let options = overlay(state.load.clone(), &args.load, matches)?;
    let loaded = LoadedScene::load(&args.scene, state, options)?;
    app::run(app::loader::prepare(loaded, warnings)?)?;
    Ok(Outcome::Done)
}

/// Opens the window on the built-in scene.
pub fn run_builtin() -> anyhow::Result<()> {
    app::run(app::loader::open_scene(Path::new(BUILTIN), None)?)
}
