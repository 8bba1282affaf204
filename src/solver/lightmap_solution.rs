//! A solution on a lightmap, and its file: arrays by name in the safetensors format.
//!
//! | array | type | shape | meaning |
//! | --- | --- | --- | --- |
//! | `irradiance` | f32 | 2, texels of all pages, 3 | irradiance [W/m²] of the lights alone, and of everything |
//! | `coordinates` | f32 | triangles, 3, 2 | each triangle's corners on its page, in texels |
//! | `pages` | u32 | triangles | the page of each triangle |
//!
//! The metadata has one entry, `radiosity-lightmap`: JSON with `version` (1), `info`, `page_size` and `page_count`.
//! Texels are counted page by page and row by row; all have values that a bilinear read may meet.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde::{Deserialize, Serialize};

use super::solution_file::SolutionFileError;
use crate::{
    lightmap::{Charts, GpuSettings, LightmapSettings},
    math::is_radiometric,
    scene::{LoadOptions, Scene, area_light::AreaLightState},
};

/// What a lightmap was computed from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightmapInfo {
    /// Name of the scene.
    pub scene_name: String,
    /// [`Scene::hash`] of the scene.
    pub scene_hash: String,
    /// How the scene was read.
    pub load: LoadOptions,
    /// How fine the map is.
    pub map: LightmapSettings,
    /// How it was solved.
    pub settings: GpuSettings,
    /// The placed area light, if there was one.
    pub light: Option<AreaLightState>,
    /// The program's version.
    pub program_version: String,
    /// False if the solve was cancelled.
    pub complete: bool,
}

/// Irradiance at the texels of a lightmap.
#[derive(Clone, Debug, PartialEq)]
pub struct LightmapSolution {
    /// What it was computed from.
    pub info: LightmapInfo,
    /// Where the scene's triangles lie.
    pub charts: Charts,
    /// Irradiance of the lights alone at every texel of all pages [W/m²].
    pub direct: Vec<Vec3>,
    /// All irradiance [W/m²].
    pub total: Vec<Vec3>,
}

const METADATA_KEY: &str = "radiosity-lightmap";
const FORMAT_VERSION: u32 = 1;
const IRRADIANCE: &str = "irradiance";
const COORDINATES: &str = "coordinates";
const PAGES: &str = "pages";

#[derive(Serialize, Deserialize)]
struct Header {
    version: u32,
    info: LightmapInfo,
    page_size: [u32; 2],
    page_count: u32,
}

/// Read before [`Header`], whose fields a newer version may have changed.
#[derive(Deserialize)]
struct Version {
    version: u32,
}

/// True for the bytes of a lightmap's file, whole or damaged.
pub fn is_lightmap(bytes: &[u8]) -> bool {
    header(bytes).is_ok_and(|found| found.is_some())
}

fn header(bytes: &[u8]) -> Result<Option<String>, SolutionFileError> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
    Ok(metadata.metadata().as_ref().and_then(|entries| entries.get(METADATA_KEY)).cloned())
}

/// A lightmap as the bytes of a file; the same lightmap gives the same bytes.
///
/// # Errors
/// What [`decode`] would refuse.
pub fn encode(solution: &LightmapSolution) -> Result<Vec<u8>, SolutionFileError> {
    check(solution)?;
    let charts = &solution.charts;
    let values = solution.direct.iter().chain(&solution.total).flat_map(|value| value.to_array());
    let irradiance: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
    let coordinates: Vec<u8> =
        charts.coordinates.iter().flatten().flat_map(|corner| corner.to_array()).flat_map(f32::to_le_bytes).collect();
    let pages: Vec<u8> = charts.pages.iter().flat_map(|page| page.to_le_bytes()).collect();
    let triangle_count = charts.pages.len();
    let arrays = [
        (IRRADIANCE, TensorView::new(Dtype::F32, vec![2, charts.pixel_count(), 3], &irradiance)),
        (COORDINATES, TensorView::new(Dtype::F32, vec![triangle_count, 3, 2], &coordinates)),
        (PAGES, TensorView::new(Dtype::U32, vec![triangle_count], &pages)),
    ];
    let arrays = arrays.into_iter().map(|(name, view)| Ok((name, view.map_err(damaged)?)));
    let arrays: Vec<_> = arrays.collect::<Result<_, SolutionFileError>>()?;
    let header = Header {
        version: FORMAT_VERSION,
        info: solution.info.clone(),
        page_size: charts.page_size,
        page_count: charts.page_count,
    };
    let header = serde_json::to_string(&header).map_err(damaged)?;
    safetensors::serialize(arrays, Some(HashMap::from([(String::from(METADATA_KEY), header)]))).map_err(damaged)
}

/// A lightmap from the bytes of a file.
///
/// # Errors
/// Anything that [`encode`] does not write, and newer versions of the format.
pub fn decode(bytes: &[u8]) -> Result<LightmapSolution, SolutionFileError> {
    let header = header(bytes)?.ok_or_else(|| damaged("the metadata does not name it as a lightmap"))?;
    let Version { version: found } = serde_json::from_str(&header).map_err(damaged)?;
    if found > FORMAT_VERSION {
        return Err(SolutionFileError::NewerVersion { found });
    }
    let Header { info, page_size, page_count, .. } = serde_json::from_str(&header).map_err(damaged)?;
    let arrays = SafeTensors::deserialize(bytes).map_err(damaged)?;
    let array = |name: &str, dtype: Dtype| {
        let view = arrays.tensor(name).map_err(damaged)?;
        if view.dtype() == dtype { Ok(view) } else { Err(damaged(format!("{name} holds {}", view.dtype()))) }
    };
    let (irradiance, coordinates, pages) =
        (array(IRRADIANCE, Dtype::F32)?, array(COORDINATES, Dtype::F32)?, array(PAGES, Dtype::U32)?);
    let shapes = (irradiance.shape(), coordinates.shape(), pages.shape());
    let (&[2, pixel_count, 3], &[triangle_count, 3, 2], &[page_entries]) = shapes else {
        return Err(damaged(format!("arrays of shape {shapes:?}")));
    };
    let pixels = u64::from(page_size[0]) * u64::from(page_size[1]) * u64::from(page_count);
    if pixels != pixel_count as u64 || triangle_count != page_entries {
        return Err(damaged(format!("{pixel_count} texels for {page_count} pages of {page_size:?}")));
    }
    let values: Vec<Vec3> = floats(irradiance.data()).chunks_exact(3).map(Vec3::from_slice).collect();
    let corners: Vec<Vec2> = floats(coordinates.data()).chunks_exact(2).map(Vec2::from_slice).collect();
    let (direct, total) = values.split_at(pixel_count);
    let solution = LightmapSolution {
        info,
        charts: Charts {
            page_size,
            page_count,
            pages: pages.data().as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect(),
            chart_of_triangle: vec![0; triangle_count],
            coordinates: corners.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect(),
        },
        direct: direct.to_vec(),
        total: total.to_vec(),
    };
    check(&solution)?;
    Ok(solution)
}

/// Refuses a lightmap that was not computed for this scene.
///
/// # Errors
/// A line that names both scenes.
pub fn check_scene(solution: &LightmapSolution, scene: &Scene) -> Result<(), SolutionFileError> {
    super::solution_file::check_scene_hash(&solution.info.scene_name, &solution.info.scene_hash, scene)?;
    if solution.charts.pages.len() == scene.mesh.triangles.len() {
        return Ok(());
    }
    Err(damaged(format!("{} triangles for {}", solution.charts.pages.len(), scene.mesh.triangles.len())))
}

/// What an encoded and a decoded lightmap must both fulfil.
fn check(solution: &LightmapSolution) -> Result<(), SolutionFileError> {
    let LightmapSolution { info, charts, direct, total } = solution;
    let problem = info.map.problem().or_else(|| info.settings.problem());
    if let Some(problem) = problem.or_else(|| info.light.as_ref().and_then(AreaLightState::problem)) {
        return Err(damaged(problem));
    }
    if charts.pixel_count() == 0 || direct.len() != charts.pixel_count() || total.len() != charts.pixel_count() {
        return Err(damaged("it has no texels, or not a value for each"));
    }
    if charts.pages.len() != charts.coordinates.len() || charts.pages.iter().any(|&page| page >= charts.page_count) {
        return Err(damaged("a triangle lies on no page"));
    }
    if charts.coordinates.iter().flatten().any(|corner| !corner.is_finite()) {
        return Err(damaged("a lightmap coordinate is not finite"));
    }
    match direct.iter().chain(total).find(|value| !is_radiometric(**value)) {
        Some(value) => Err(damaged(format!("irradiance {value}"))),
        None => Ok(()),
    }
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

fn damaged(reason: impl ToString) -> SolutionFileError {
    SolutionFileError::Damaged(reason.to_string())
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    fn small() -> LightmapSolution {
        let charts = Charts {
            page_size: [3, 2],
            page_count: 2,
            pages: vec![0, 1],
            chart_of_triangle: vec![0; 2],
            coordinates: vec![[Vec2::ZERO, Vec2::new(3.0, 0.0), Vec2::new(0.0, 2.0)]; 2],
        };
        let info = LightmapInfo {
            scene_name: String::from("small"),
            scene_hash: String::from("none"),
            load: LoadOptions::default(),
            map: LightmapSettings::default(),
            settings: GpuSettings::default(),
            light: None,
            program_version: String::from("test"),
            complete: true,
        };
        let values: Vec<Vec3> = (0..12).map(|index| Vec3::new(index as f32, 0.5, 0.25)).collect();
        LightmapSolution { info, charts, direct: vec![Vec3::ZERO; 12], total: values }
    }

    #[test]
    fn a_lightmap_comes_back_as_it_was_written_and_reads_bilinearly() {
        let written = small();
        let bytes = encode(&written).unwrap();
        assert!(is_lightmap(&bytes));
        let found = decode(&bytes).unwrap();
        assert_eq!(found, written);
        // The second page's first two texels are 6 and 7; halfway between their middles lies 6.5.
        let place = Vec2::new(1.0 / 3.0, 0.25); // (1, 0.5) in texels
        assert!(found.charts.interpolate(&found.total, 1, place).abs_diff_eq(Vec3::new(6.5, 0.5, 0.25), 1e-5));
    }

    #[test]
    fn damaged_lightmaps_are_refused() {
        let bytes = encode(&small()).unwrap();
        for end in [0, 7, 100, bytes.len() - 1] {
            assert!(decode(&bytes[..end]).is_err(), "{end} bytes");
        }
        let version = br#"\"version\":1"#;
        let newer = bytes.windows(version.len()).position(|window| window == version).unwrap();
        let mut changed = bytes;
        changed[newer + 12] = b'9';
        assert!(decode(&changed).unwrap_err().to_string().contains("newer"));
        let mut lightmap = small();
        lightmap.total[3].x = f32::NAN;
        assert!(encode(&lightmap).is_err());
        let mut lightmap = small();
        lightmap.charts.pages[0] = 2;
        assert!(encode(&lightmap).is_err());
    }
}
