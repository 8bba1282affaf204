//! State files: a view, a light and settings as TOML text. Every field is optional at every level.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use serde_ignored::Path;

use super::SolveSettings;
use crate::math::color::ToneMap;
use crate::scene::{LoadOptions, area_light::AreaLightState, camera::CameraState};

/// All that can be set up for a scene. What is `None` was not said, and keeps its default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct State {
    /// The view.
    pub camera: Option<CameraState>,
    /// The placed area light.
    pub light: Option<AreaLightState>,
    /// How to solve.
    pub settings: Option<SolveSettings>,
    /// How radiance is shown.
    pub tone_map: Option<ToneMap>,
    /// How the scene's file is read.
    pub load: Option<LoadOptions>,
}

impl State {
    /// Reads TOML text. The second value holds a line for each field that is not known, with the nearest one that
    /// is.
    ///
    /// # Errors
    /// One line, with its line number in the text, for text that is not TOML, a value of the wrong type or one out
    /// of range.
    pub fn from_toml(text: &str) -> Result<(Self, Vec<String>), String> {
        let error_line = |error: toml::de::Error| {
            let line = error.span().map_or(1, |span| line_number(text, span.start));
            format!("line {line}: {}", error.message().lines().collect::<Vec<_>>().join(", "))
        };
        let mut unknown = Vec::new();
        let deserializer = toml::Deserializer::parse(text).map_err(error_line)?;
        let state: Self =
            serde_ignored::deserialize(deserializer, |path| unknown.push(segments(&path))).map_err(error_line)?;
        if let Some((table, problem)) = state.problem() {
            return Err(format!("line {}: {problem}", line_of(text, &[String::from(table)])));
        }
        let known = known_fields();
        Ok((state, unknown.iter().map(|field| unknown_field_line(text, field, &known)).collect()))
    }

    /// The state as TOML text, which [`State::from_toml`] reads back unchanged.
    ///
    /// # Errors
    /// One line, should the TOML writer refuse a value; no value of these types is known to make it.
    pub fn to_toml(&self) -> Result<String, String> {
        toml::to_string(self).map_err(|error| format!("a state file cannot hold this: {error}"))
    }

    /// The table at fault and what is wrong with it, if anything is.
    pub fn problem(&self) -> Option<(&'static str, String)> {
        let camera = self.camera.as_ref().and_then(camera_problem).map(|problem| ("camera", problem));
        let light = || self.light.as_ref().and_then(AreaLightState::problem).map(|problem| ("light", problem));
        let settings = || self.settings.as_ref().and_then(SolveSettings::problem).map(|problem| ("settings", problem));
        let tone_map = || self.tone_map.as_ref().and_then(tone_map_problem).map(|problem| ("tone_map", problem));
        let load = || self.load.as_ref().and_then(load_problem).map(|problem| ("load", problem));
        camera.or_else(light).or_else(settings).or_else(tone_map).or_else(load)
    }
}

fn camera_problem(camera: &CameraState) -> Option<String> {
    let vectors = [camera.position, camera.target, camera.up];
    if vectors.iter().flatten().any(|value| !value.is_finite()) {
        return Some(String::from("the camera's position, target and up must be finite numbers"));
    }
    let fov = camera.fov_degrees;
    let in_range = fov > 0.0 && fov < 180.0;
    (!in_range).then(|| format!("the camera's fov_degrees must lie between 0 and 180, not be {fov}"))
}

fn tone_map_problem(tone_map: &ToneMap) -> Option<String> {
    let ToneMap { exposure, white, gamma, .. } = *tone_map;
    if !exposure.is_finite() {
        return Some(format!("the tone map's exposure must be a finite number of stops, not {exposure}"));
    }
    let usable = |value: f32| value.is_finite() && value > 0.0;
    (!usable(white) || !usable(gamma)).then(|| String::from("the tone map's white and gamma must be above 0"))
}

fn load_problem(load: &LoadOptions) -> Option<String> {
    let limit = load.reflectance_limit;
    if !(0.0..=0.999).contains(&limit) {
        return Some(format!("reflectance_limit must lie between 0 and 0.999, not be {limit}"));
    }
    if load.crease_angle.is_some_and(|angle| !(0.0..=180.0).contains(&angle)) {
        return Some(String::from("crease_angle must lie between 0 and 180 degrees"));
    }
    if load.weld.is_some_and(|fraction| !(0.0..1.0).contains(&fraction)) {
        return Some(String::from("weld must be a fraction of the scene's size, from 0 to below 1"));
    }
    None
}

/// The names along a path: `settings`, `rays`.
fn segments(path: &Path) -> Vec<String> {
    match path {
        Path::Root => Vec::new(),
        Path::Seq { parent, index } => [segments(parent), vec![index.to_string()]].concat(),
        Path::Map { parent, key } => [segments(parent), vec![key.clone()]].concat(),
        Path::Some { parent } | Path::NewtypeStruct { parent } | Path::NewtypeVariant { parent } => segments(parent),
    }
}

/// The path of every field there is, as the defaults serialise.
fn known_fields() -> BTreeSet<Vec<String>> {
    let everything = State {
        camera: Some(CameraState::default()),
        light: Some(AreaLightState::default()),
        settings: Some(SolveSettings::default()),
        tone_map: Some(ToneMap::default()),
        load: Some(LoadOptions::default()),
    };
    // JSON, because TOML leaves out the fields whose default is to have no value.
    let mut fields = BTreeSet::new();
    if let Ok(serde_json::Value::Object(tables)) = serde_json::to_value(&everything) {
        for (table, value) in tables {
            let names = value.as_object().into_iter().flat_map(|object| object.keys());
            fields.extend(names.map(|name| vec![table.clone(), name.clone()]));
            fields.insert(vec![table]);
        }
    }
    fields
}

/// The warning about an unknown field: the nearest name, preferably in the same table.
fn unknown_field_line(text: &str, field: &[String], known: &BTreeSet<Vec<String>>) -> String {
    let distance = |candidate: &Vec<String>| {
        let names = [candidate, field].map(|path| path.last().map_or("", String::as_str));
        let elsewhere = candidate.split_last().map(|(_, table)| table) != field.split_last().map(|(_, table)| table);
        strsim::damerau_levenshtein(names[0], names[1]) + usize::from(elsewhere)
    };
    let nearest = known.iter().min_by_key(|candidate| distance(candidate)).map(|path| path.join("."));
    let (line, name) = (line_of(text, field), field.join("."));
    format!("line {line}: unknown field {name} is ignored; the nearest known one is {}", nearest.unwrap_or_default())
}

/// The line where a field stands, or the nearest table around it that can be found.
fn line_of(text: &str, field: &[String]) -> usize {
    let mut offset = 0;
    if let Ok(document) = toml::de::DeTable::parse(text) {
        let mut table = Some(document.get_ref());
        for name in field {
            let entry = table.and_then(|table| table.iter().find(|(key, _)| *key.get_ref() == name.as_str()));
            let Some((key, value)) = entry else { break };
            offset = key.span().start;
            table = value.get_ref().as_table();
        }
    }
    line_number(text, offset)
}

fn line_number(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|&byte| byte == b'\n').count()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;
    use crate::math::{color::ToneCurve, sequence::Sampler};

    #[test]
    fn empty_text_is_an_empty_state() {
        assert_eq!(State::from_toml("").unwrap(), (State::default(), vec![]));
    }

    #[test]
    fn a_partial_table_takes_the_rest_from_the_defaults() {
        let (state, warnings) = State::from_toml("[settings]\nrays = 64\nsampler = \"random\"\n").unwrap();
        let expected = SolveSettings { rays: 64, sampler: Sampler::Random, ..SolveSettings::default() };
        assert_eq!(state, State { settings: Some(expected), ..State::default() });
        assert!(warnings.is_empty());
    }

    #[test]
    fn a_full_state_is_read_back_as_it_was_written() {
        let state = State {
            camera: Some(CameraState { position: [0.1, -1e6, 3.0], ..CameraState::default() }),
            light: Some(AreaLightState { radiance: [18.4, 15.6, 8.0], ..AreaLightState::default() }),
            settings: Some(SolveSettings {
                seed: u64::MAX,
                bounces: Some(3),
                max_edge: Some(0.25),
                ..SolveSettings::default()
            }),
            tone_map: Some(ToneMap { exposure: -1.5, curve: ToneCurve::Plain, ..ToneMap::default() }),
            load: Some(LoadOptions { crease_angle: Some(30.0), two_sided: true, ..LoadOptions::default() }),
        };
        assert_eq!(State::from_toml(&state.to_toml().unwrap()).unwrap(), (state, vec![]));
    }

    #[test]
    fn a_misspelt_field_is_a_warning_that_names_the_nearest() {
        let nearest = |text: &str| State::from_toml(text).unwrap().1;
        assert_eq!(
            nearest("[settings]\nrays = 8\nboucnes = 2\n"),
            ["line 3: unknown field settings.boucnes is ignored; the nearest known one is settings.bounces"]
        );
        assert_eq!(
            nearest("\n[camra]\nposition = [0, 0, 1]\n"),
            ["line 2: unknown field camra is ignored; the nearest known one is camera"]
        );
        // A known name in the wrong table: the path says where it belongs. Optional fields are known, too.
        assert!(nearest("max_edge = 0.1\n")[0].ends_with("settings.max_edge"));
        assert!(nearest("[camera]\ncrease_angel = 30.0\n")[0].ends_with("load.crease_angle"));
    }

    #[test]
    fn wrong_types_and_values_are_one_line_with_its_number() {
        for (text, line, word) in [
            ("[settings]\nrays = \"many\"\n", 2, "string"),
            ("[settings]\n\nrays = -1\n", 3, "-1"),
            ("[settings]\nsampler = \"sobel\"\n", 2, "sobol"),
            ("[camera]\nposition = [0.0, 1.0]\n", 2, "length"),
            ("[camera\n", 1, "table"),
            ("\n[camera]\nposition = [0.0, 1.0, nan]\n", 2, "finite"),
            ("[camera]\nfov_degrees = 180.0\n", 1, "180"),
            ("[camera]\nfov_degrees = 40\n[light]\nradiance = [1.0, -2.0, 0.0]\n", 3, "negative"),
            ("[settings]\nunabsorbed = 1.5\n", 1, "1.5"),
            ("[settings]\nmax_edge = inf\n", 1, "positive"),
            ("[tone_map]\nwhite = 0.0\n", 1, "white"),
            ("[tone_map]\nexposure = 1e60\n", 1, "exposure"),
            ("[load]\nreflectance_limit = 1.0\n", 1, "0.999"),
            ("[load]\ncrease_angle = -5.0\n", 1, "180"),
            ("[load]\nweld = 2.0\n", 1, "weld"),
        ] {
            let problem = State::from_toml(text).unwrap_err();
            assert!(problem.starts_with(&format!("line {line}: ")), "{text:?}: {problem}");
            assert!(problem.contains(word) && !problem.contains('\n'), "{text:?}: {problem}");
        }
    }
}
