//! Solution files: arrays by name in the safetensors format, which many languages read.
//!
//! | array | type | shape | meaning |
//! | --- | --- | --- | --- |
//! | `irradiance` | f32 | bounces, vertices, 3 | irradiance [W/m²] of each bounce alone, linear RGB; 0 is direct |
//! | `cuts` | u32 | any | how elements that follow the light were cut; only there if they do |
//! | `buried` | u8 | vertices | 1 where the vertex's hemisphere mostly sees back faces, else 0 |
//!
//! The metadata has one entry, `radiosity-solution`: JSON with `version` (1) and `info`, a [`SolutionInfo`]. The
//! vertices are those of the tessellation that `info.settings` makes of the scene; `radiosity export` writes them out.
//! In Python:
//!
//! ```text
//! import json; from safetensors import safe_open
//! with safe_open("room.solution", framework="numpy") as file:
//!     irradiance, info = file.get_tensor("irradiance"), json.loads(file.metadata()["radiosity-solution"])["info"]
//! ```
//!
//! The same solution gives the same bytes. Nothing here opens a file: bytes in, bytes out.

use std::collections::HashMap;

use glam::Vec3;
use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde::{Deserialize, Serialize};

use super::solution::{Solution, SolutionInfo};
use crate::{
    math::is_radiometric,
    scene::{Scene, area_light::AreaLightState},
};

/// The version of the format that this program writes, and the newest that it reads.
pub const FORMAT_VERSION: u32 = 1;

/// The metadata entry that tells a solution from other safetensors files.
const METADATA_KEY: &str = "radiosity-solution";
const IRRADIANCE: &str = "irradiance";
const BURIED: &str = "buried";
const CUTS: &str = "cuts";

/// Why bytes are not a usable solution. Prints as one line, without the file's name.
#[derive(Debug, thiserror::Error)]
pub enum SolutionFileError {
    /// Not a safetensors file, cut short, or with wrong sizes, types or values.
    #[error("not a radiosity solution, or a damaged one ({0}); write it again with `radiosity solve`")]
    Damaged(String),
    /// Written by a newer program.
    #[error("solution format version {found} is newer than this program reads ({FORMAT_VERSION}); update the program")]
    NewerVersion {
        /// The file's version.
        found: u32,
    },
    /// A solution of another scene, or of this one before it was changed or loaded with other options.
    #[error(
        "the solution belongs to the scene {solved} ({solved_hash}), not to {given} ({given_hash}); give the scene it \
         was solved with, with the same options, or solve this one"
    )]
    OtherScene {
        /// Name of the solution's scene.
        solved: String,
        /// Start of its hash.
        solved_hash: String,
        /// Name of the scene that was given.
        given: String,
        /// Start of its hash.
        given_hash: String,
    },
    /// A solution of the same scene, cut into other elements.
    #[error(
        "the solution of {scene} belongs to the tessellation {solved_hash}, not to {given_hash}; it was written by \
         version {version} of the program: solve again"
    )]
    OtherTessellation {
        /// Name of the scene.
        scene: String,
        /// Start of the hash of the solution's tessellation.
        solved_hash: String,
        /// Start of the hash of the tessellation that was given.
        given_hash: String,
        /// The program version that wrote the solution.
        version: String,
    },
}

#[derive(Serialize, Deserialize)]
struct Header {
    version: u32,
    info: SolutionInfo,
}

/// Read before [`Header`], whose `info` a newer version may have changed.
#[derive(Deserialize)]
struct Version {
    version: u32,
}

/// A solution as the bytes of a file.
///
/// # Errors
/// A solution without bounces or vertices, with bounces of different lengths, with a value that is negative or not
/// finite, or with settings that have a problem: what [`decode`] would refuse.
pub fn encode(solution: &Solution) -> Result<Vec<u8>, SolutionFileError> {
    check_values(solution)?;
    let vertex_count = solution.buried.len();
    let irradiance: Vec<u8> =
        solution.bounces.iter().flatten().flat_map(|value| value.to_array()).flat_map(f32::to_le_bytes).collect();
    let buried: Vec<u8> = solution.buried.iter().map(|&buried| u8::from(buried)).collect();
    let cuts: Vec<u8> = solution.cuts.iter().copied().flat_map(u32::to_le_bytes).collect();
    let mut arrays = vec![
        (IRRADIANCE, TensorView::new(Dtype::F32, vec![solution.bounces.len(), vertex_count, 3], &irradiance)),
        (BURIED, TensorView::new(Dtype::U8, vec![vertex_count], &buried)),
    ];
    if !cuts.is_empty() {
        arrays.push((CUTS, TensorView::new(Dtype::U32, vec![solution.cuts.len()], &cuts)));
    }
    let arrays = arrays.into_iter().map(|(name, view)| Ok((name, view.map_err(damaged)?)));
    let arrays: Vec<_> = arrays.collect::<Result<_, SolutionFileError>>()?;
    // One entry alone: the order of several would change from run to run.
    let header = Header { version: FORMAT_VERSION, info: solution.info.clone() };
    let header = serde_json::to_string(&header).map_err(damaged)?;
    safetensors::serialize(arrays, Some(HashMap::from([(String::from(METADATA_KEY), header)]))).map_err(damaged)
}

/// A solution from the bytes of a file. Needs little more memory than the bytes themselves, whatever they say.
///
/// # Errors
/// Anything that [`encode`] does not write, and newer versions of the format.
pub fn decode(bytes: &[u8]) -> Result<Solution, SolutionFileError> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
    let header = metadata.metadata().as_ref().and_then(|entries| entries.get(METADATA_KEY));
    let header = header.ok_or_else(|| damaged("the metadata does not name it as one"))?;
    let Version { version: found } = serde_json::from_str(header).map_err(damaged)?;
    if found > FORMAT_VERSION {
        return Err(SolutionFileError::NewerVersion { found });
    }
    let Header { info, .. } = serde_json::from_str(header).map_err(damaged)?;
    let arrays = SafeTensors::deserialize(bytes).map_err(damaged)?;
    let buried_flags = array(&arrays, BURIED, Dtype::U8)?;
    let irradiance = array(&arrays, IRRADIANCE, Dtype::F32)?;
    let (&[vertex_count], &[bounce_count, irradiance_count, 3]) = (buried_flags.shape(), irradiance.shape()) else {
        return Err(damaged(format!("arrays of shape {:?} and {:?}", buried_flags.shape(), irradiance.shape())));
    };
    // Arrays with values are no longer than the file says; empty ones could claim any number of bounces.
    if vertex_count == 0 || bounce_count == 0 || irradiance_count != vertex_count {
        return Err(damaged(format!(
            "{bounce_count} bounces of {irradiance_count} vertices, {vertex_count} buried flags"
        )));
    }
    if buried_flags.data().iter().any(|&flag| flag > 1) {
        return Err(damaged("a buried flag is neither 0 nor 1"));
    }
    let (values, _) = irradiance.data().as_chunks::<12>();
    let bounces = values.chunks(vertex_count).map(|bounce| bounce.iter().map(vec3_from_bytes).collect());
    let buried = buried_flags.data().iter().map(|&flag| flag == 1);
    let cuts = match arrays.tensor(CUTS) {
        Ok(_) => array(&arrays, CUTS, Dtype::U32)?
            .data()
            .as_chunks::<4>()
            .0
            .iter()
            .copied()
            .map(u32::from_le_bytes)
            .collect(),
        Err(_) => Vec::new(),
    };
    let solution = Solution { info, bounces: bounces.collect(), buried: buried.collect(), cuts };
    check_values(&solution)?;
    Ok(solution)
}

/// Refuses a solution that was not computed for this scene.
///
/// # Errors
/// A line that names the scene of the solution and the one given.
pub fn check_scene(info: &SolutionInfo, scene: &Scene) -> Result<(), SolutionFileError> {
    check_scene_hash(&info.scene_name, &info.scene_hash, scene)
}

/// Refuses what was computed for a scene of another hash; `solved` is that scene's name.
pub(super) fn check_scene_hash(solved: &str, solved_hash: &str, scene: &Scene) -> Result<(), SolutionFileError> {
    let scene_hash = scene.hash();
    if solved_hash == scene_hash {
        return Ok(());
    }
    Err(SolutionFileError::OtherScene {
        solved: String::from(solved),
        solved_hash: short(solved_hash),
        given: scene.name.clone(),
        given_hash: short(&scene_hash),
    })
}

/// Refuses a solution that was not computed on these elements; the scene is checked first, by [`check_scene`], since
/// another scene could take very long to cut.
///
/// # Errors
/// A line that names both tessellations.
pub fn check_tessellation(info: &SolutionInfo, tessellation_hash: &str) -> Result<(), SolutionFileError> {
    if info.tessellation_hash == tessellation_hash {
        return Ok(());
    }
    Err(SolutionFileError::OtherTessellation {
        scene: info.scene_name.clone(),
        solved_hash: short(&info.tessellation_hash),
        given_hash: short(tessellation_hash),
        version: info.program_version.clone(),
    })
}

/// The array of a name, if it has the type that it should have.
fn array<'data>(arrays: &SafeTensors<'data>, name: &str, dtype: Dtype) -> Result<TensorView<'data>, SolutionFileError> {
    let view = arrays.tensor(name).map_err(damaged)?;
    if view.dtype() != dtype {
        return Err(damaged(format!("{name} holds {}, not {dtype}", view.dtype())));
    }
    Ok(view)
}

/// What an encoded and a decoded solution must both fulfil.
fn check_values(solution: &Solution) -> Result<(), SolutionFileError> {
    let SolutionInfo { settings, light, .. } = &solution.info;
    if let Some(problem) = settings.problem().or_else(|| light.as_ref().and_then(AreaLightState::problem)) {
        return Err(damaged(problem));
    }
    let vertex_count = solution.buried.len();
    if vertex_count == 0 || solution.bounces.is_empty() {
        return Err(damaged("it has no vertices or no bounces"));
    }
    for (bounce, values) in solution.bounces.iter().enumerate() {
        if values.len() != vertex_count {
            return Err(damaged(format!("bounce {bounce} has {} vertices of {vertex_count}", values.len())));
        }
        if let Some(vertex) = values.iter().position(|&value| !is_radiometric(value)) {
            return Err(damaged(format!("irradiance {} at bounce {bounce}, vertex {vertex}", values[vertex])));
        }
    }
    Ok(())
}

fn vec3_from_bytes(bytes: &[u8; 12]) -> Vec3 {
    let (numbers, _) = bytes.as_chunks::<4>();
    Vec3::from_array(std::array::from_fn(|band| f32::from_le_bytes(numbers[band])))
}

fn damaged(reason: impl ToString) -> SolutionFileError {
    SolutionFileError::Damaged(reason.to_string())
}

/// The start of a hash, enough to tell two apart. Counts characters: a damaged file may hold any text.
fn short(hash: &str) -> String {
    hash.chars().take(12).collect()
}
