//! The arguments that name a scene, its state and its light, and what they come to.
//!
//! A value given as a flag wins; else the state file's; else the default.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context as _, bail};
use clap::{ArgMatches, Args, parser::ValueSource};
use serde::{Serialize, de::DeserializeOwned};

use crate::{
    math::color::ToneMap,
    scene::{LoadOptions, Scene, area_light::AreaLightState, builtin, camera::CameraState, load},
    solver::state::State,
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
    /// Radiance of the area light, linear RGB [W/(m² sr)].
    #[arg(long, value_name = "R,G,B", value_parser = parse_triple, allow_hyphen_values = true)]
    pub light_radiance: Option<[f64; 3]>,
}

/// A scene that was read, with its state.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The options it was read with.
    pub load: LoadOptions,
    /// What the state file said.
    pub state: State,
    /// The state's camera, or one that looks at the whole scene.
    pub camera: CameraState,
    /// The state's tone map, or the default.
    pub tone_map: ToneMap,
}

impl SceneArgs {
    /// Reads state and scene. Warnings go to standard error.
    pub fn load(&self, matches: &ArgMatches) -> anyhow::Result<LoadedScene> {
        let state = self.read_state()?;
        let options = overlay(state.load.clone(), &self.load, matches)?;
        let loaded = self.load_with(state, options)?;
        for warning in &loaded.scene.warnings {
            eprintln!("warning: {}: {warning}", self.scene.display());
        }
        Ok(loaded)
    }

    /// Reads the scene with the options that a solution was computed with, whatever flags and state say. What was
    /// repaired was said then, and is not said again.
    pub fn load_as_solved(&self, options: &LoadOptions) -> anyhow::Result<LoadedScene> {
        self.load_with(self.read_state()?, options.clone())
    }

    fn load_with(&self, state: State, options: LoadOptions) -> anyhow::Result<LoadedScene> {
        let scene = if self.is_builtin() { builtin::cornell(&options)? } else { load::load(&self.scene, &options)? };
        let camera = state.camera.unwrap_or_else(|| {
            let (minimum, maximum) = scene.bounds_in_metres();
            CameraState::looking_at_bounds(minimum, maximum)
        });
        let tone_map = state.tone_map.unwrap_or_default();
        Ok(LoadedScene { scene: Arc::new(scene), load: options, state, camera, tone_map })
    }

    fn is_builtin(&self) -> bool {
        self.scene.as_os_str() == "cornell" && !self.scene.exists()
    }

    fn read_state(&self) -> anyhow::Result<State> {
        let beside = self.scene.with_extension("toml");
        let (text, path) = match &self.state {
            Some(path) => (read_text(path)?, path.as_path()),
            None if self.is_builtin() => (String::from(builtin::CORNELL_STATE), Path::new("cornell.toml")),
            None if beside.is_file() => (read_text(&beside)?, beside.as_path()),
            None => return Ok(State::default()),
        };
        let (state, warnings) =
            State::from_toml(&text).map_err(|problem| anyhow::anyhow!("{}: {problem}", path.display()))?;
        for warning in warnings {
            eprintln!("warning: {}: {warning}", path.display());
        }
        Ok(state)
    }
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

fn read_text(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("{}: cannot be read as text; check the path", path.display()))
}

/// Three numbers, `X,Y,Z`.
fn parse_triple(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let numbers = numbers.map_err(|_| format!("`{text}` is not three numbers with commas, such as 0,1.5,0"))?;
    let triple: [f64; 3] =
        numbers.try_into().map_err(|_| format!("`{text}` is not three numbers with commas, such as 0,1.5,0"))?;
    if triple.iter().all(|value| value.is_finite()) { Ok(triple) } else { Err(format!("`{text}` is not finite")) }
}
