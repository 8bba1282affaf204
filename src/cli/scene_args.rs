//! The arguments that name a scene, its state and its light, and what they come to.
//!
//! A value given as a flag wins; else the state file's; else the default.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use clap::{ArgMatches, Args, parser::ValueSource};
use serde::{Serialize, de::DeserializeOwned};

pub use crate::files::loaded_scene::LoadedScene;
use crate::{
    files::loaded_scene,
    scene::{LoadOptions, area_light::AreaLightState},
    solver::{SolveSettings, State},
};

/// Which scene.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// The scene: an OBJ file, or `cornell` for the built-in Cornell box.
    pub scene: PathBuf,
    /// State file (TOML) with camera, light, settings and tone map. Without it, a file of the scene's own name and
    /// `.toml` is used if there is one beside it.
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// How the scene is read.
    #[command(flatten, next_help_heading = "Reading the scene")]
    pub load: LoadOptions,
}

/// The area light by flags; each replaces that part of the state's light.
#[derive(Clone, Debug, Default, Args)]
pub struct LightArgs {
    /// Centre of the area light, in metres.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true)]
    pub light_centre: Option<[f64; 3]>,
    /// Half-extent vector u of the area light, in metres.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true)]
    pub light_u: Option<[f64; 3]>,
    /// Half-extent vector v of the area light, in metres; it shines to the side of u × v.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true)]
    pub light_v: Option<[f64; 3]>,
    /// Radiance of the area light, linear RGB in W/(m² sr).
    #[arg(long, value_name = "R,G,B", value_parser = parse_triple, allow_hyphen_values = true)]
    pub light_radiance: Option<[f64; 3]>,
}

impl SceneArgs {
    /// Reads state and scene. Warnings go to standard error.
    pub fn load(&self, matches: &ArgMatches) -> anyhow::Result<LoadedScene> {
        self.load_with(matches, |_, options| Ok(options))
    }

    /// The same, with flat neighbours merged if the options do not say otherwise.
    pub fn load_merged(&self, matches: &ArgMatches) -> anyhow::Result<LoadedScene> {
        self.load_with(matches, |_, options| Ok(options.merging_flat(true)))
    }

    /// Reads state, settings and scene; if nothing says whether flat neighbours are merged, they are where elements follow
    /// the light.
    pub fn load_for_solve(
        &self,
        flags: &SolveSettings,
        matches: &ArgMatches,
    ) -> anyhow::Result<(LoadedScene, SolveSettings)> {
        let mut settings = SolveSettings::default();
        let loaded = self.load_with(matches, |state, options| {
            settings = solve_settings(state.settings.clone(), flags, matches)?;
            Ok(options.merging_flat(settings.follows_light()))
        })?;
        Ok((loaded, settings))
    }

    fn load_with(
        &self,
        matches: &ArgMatches,
        choose: impl FnOnce(&State, LoadOptions) -> anyhow::Result<LoadOptions>,
    ) -> anyhow::Result<LoadedScene> {
        let (state, warnings) = loaded_scene::read_state(&self.scene, self.state.as_deref())?;
        let options = choose(&state, overlay(state.load.clone(), &self.load, matches)?)?;
        let loaded = LoadedScene::load(&self.scene, state, options)?;
        print_warnings(&warnings);
        let path = loaded.path.display();
        loaded.scene.warnings.iter().for_each(|warning| eprintln!("warning: {path}: {warning}"));
        Ok(loaded)
    }

    /// Reads the scene with the options that a solution was computed with, whatever flags and state say. What was
    /// repaired was said then, and is not said again.
    pub fn load_as_solved(&self, options: &LoadOptions) -> anyhow::Result<LoadedScene> {
        let (state, warnings) = loaded_scene::read_state(&self.scene, self.state.as_deref())?;
        print_warnings(&warnings);
        LoadedScene::load(&self.scene, state, options.clone())
    }
}

fn print_warnings(warnings: &[String]) {
    warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
}

impl LightArgs {
    /// The state's light with the flags' parts in place; `None` if neither names a light.
    pub fn over(&self, saved: Option<AreaLightState>) -> anyhow::Result<Option<AreaLightState>> {
        let none_given = self.light_centre.is_none()
            && self.light_u.is_none()
            && self.light_v.is_none()
            && self.light_radiance.is_none();
        if none_given && saved.is_none() {
            return Ok(None);
        }
        let saved = saved.unwrap_or_default();
        let light = AreaLightState {
            centre: self.light_centre.unwrap_or(saved.centre),
            u: self.light_u.unwrap_or(saved.u),
            v: self.light_v.unwrap_or(saved.v),
            radiance: self.light_radiance.map_or(saved.radiance, |rgb| rgb.map(|band| band as f32)),
        };
        if let Some(problem) = light.problem() {
            bail!("{problem}; see --light-centre, --light-u, --light-v and --light-radiance");
        }
        Ok(Some(light))
    }
}

/// `saved` with those fields replaced that were given as flags on the command line (a clap argument has the name of
/// its field).
pub fn overlay<T: Clone + Serialize + DeserializeOwned>(
    saved: Option<T>,
    flags: &T,
    matches: &ArgMatches,
) -> anyhow::Result<T> {
    let Some(saved) = saved else {
        return Ok(flags.clone());
    };
    let mut merged = serde_json::to_value(&saved).context("the state's settings")?;
    let flags = serde_json::to_value(flags).context("the flags")?;
    if let (Some(merged), Some(flags)) = (merged.as_object_mut(), flags.as_object()) {
        for (name, value) in flags {
            if matches.value_source(name) == Some(ValueSource::CommandLine) {
                merged.insert(name.clone(), value.clone());
            }
        }
    }
    serde_json::from_value(merged).context("flags over the state's settings")
}

/// The settings of a solve: flags over the state's. Who says on the command line how finely to cut wants even elements.
fn solve_settings(
    saved: Option<SolveSettings>,
    flags: &SolveSettings,
    matches: &ArgMatches,
) -> anyhow::Result<SolveSettings> {
    let settings = overlay(saved, flags, matches)?;
    let is_given = |name: &str| matches.value_source(name) == Some(ValueSource::CommandLine);
    let is_even = !is_given("adaptive") && ["subdivide", "max_edge", "vertex_values"].into_iter().any(is_given);
    Ok(if is_even { SolveSettings { adaptive: 0.0, ..settings } } else { settings })
}

/// Three numbers, `X,Y,Z`.
fn parse_triple(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let numbers = numbers.map_err(|_| format!("`{text}` is not three numbers with commas, such as 0,1.5,0"))?;
    let triple: [f64; 3] =
        numbers.try_into().map_err(|_| format!("`{text}` is not three numbers with commas, such as 0,1.5,0"))?;
    if triple.iter().all(|value| value.is_finite()) { Ok(triple) } else { Err(format!("`{text}` is not finite")) }
}
