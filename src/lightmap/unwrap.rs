//! Lightmap coordinates: where each triangle lies on the pages of the map, no two in one place.

use std::collections::HashMap;

use clap::Args;
use glam::Vec2;
use serde::{Deserialize, Serialize};
use uvunwrap::{Density, MeshInput, Options, Packing, Stage};

use super::{charts::Charts, coverage::TexelTriangle};
use crate::{
    math::sets::Sets,
    scene::{Mesh, Scene},
};

/// How fine a lightmap is.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(default)]
pub struct LightmapSettings {
    /// Texels along one metre of surface.
    #[arg(long, value_name = "DENSITY", conflicts_with = "texels")]
    pub texels_per_metre: Option<f64>,
    /// Texels on all surfaces together, about; used without a density.
    #[arg(long, value_name = "N", default_value_t = LightmapSettings::default().texels)]
    pub texels: u32,
    /// A page of the lightmap is no larger than this many texels a side; more become several pages.
    #[arg(long, value_name = "N", default_value_t = LightmapSettings::default().page_size)]
    pub page_size: u32,
    /// A texel counts whole if a triangle covers its middle, and not at all else; otherwise by what is covered of it.
    #[arg(long)]
    pub no_coverage: bool,
}

impl Default for LightmapSettings {
    fn default() -> Self {
        Self { texels_per_metre: None, texels: 20_000, page_size: 2048, no_coverage: false }
    }
}

impl LightmapSettings {
    /// What is wrong with the settings, if anything.
    pub fn problem(&self) -> Option<String> {
        if self.texels_per_metre.is_some_and(|density| !(density > 0.0 && density.is_finite())) {
            return Some(String::from("texels-per-metre must be a positive number"));
        }
        if !(64..=MOST_TEXELS).contains(&self.texels) {
            return Some(format!("texels must lie between 64 and {MOST_TEXELS}, not be {}", self.texels));
        }
        if !(64..=8192).contains(&self.page_size) {
            return Some(format!("the page size must lie between 64 and 8192, not be {}", self.page_size));
        }
        None
    }

    /// Texels along one local unit of a scene.
    ///
    /// # Errors
    /// One line, if the scene has no area or would need too many texels.
    fn texels_per_unit(&self, scene: &Scene) -> Result<f64, String> {
        let area: f64 = (0..scene.mesh.triangles.len() as u32).map(|index| f64::from(scene.mesh.area(index))).sum();
        if area <= 0.0 {
            return Err(String::from("the scene has no surface to map"));
        }
        let density = match self.texels_per_metre {
            Some(density) => density * scene.frame.metres_per_unit,
            None => (f64::from(self.texels) / area).sqrt(),
        };
        if area * density * density > f64::from(MOST_TEXELS) {
            return Err(format!("a lightmap of more than {MOST_TEXELS} texels; ask for fewer texels a metre"));
        }
        Ok(density)
    }
}

/// No more texels than this.
const MOST_TEXELS: u32 = 16_000_000;

/// Empty texels around each chart: bilinear reads then meet no other chart.
const PADDING: u32 = 2;

/// A surface that bends by more than this at an edge is cut there.
const CREASE_DEGREES: f32 = 30.0;

/// How far the unwrapping has come: what it does, and the part that is done where that is known.
pub type UnwrapProgress<'a> = dyn Fn(&str, Option<f32>) -> bool + Sync + 'a;

/// Finds lightmap coordinates: the scene's own texture coordinates where no two triangles share a place there, else new
/// ones by the crate uvunwrap. `progress` is told how far it is, and may stop it by returning false.
///
/// # Errors
/// One line; `Ok(None)` if it was stopped.
pub fn unwrap(
    scene: &Scene,
    settings: &LightmapSettings,
    progress: &UnwrapProgress<'_>,
) -> Result<Option<Charts>, String> {
    if let Some(problem) = settings.problem() {
        return Err(problem);
    }
    let density = settings.texels_per_unit(scene)?;
    let Seams { seams, is_torn } = Seams::of(scene);
    // The scene's own charts know nothing of what stands on its surfaces.
    let own = if is_torn { None } else { own_coordinates(scene, density, settings.page_size) };
    if own.is_some() {
        return Ok(own);
    }
    let sides = sides(scene);
    let materials = &scene.mesh.material_indices;
    let ignored: Vec<bool> = (0..materials.len() as u32).map(|triangle| is_hole(scene, triangle)).collect();
    let positions: &[[f32; 3]] = bytemuck::cast_slice(&scene.mesh.positions);
    let meshes: Vec<MeshInput<'_>> = sides
        .iter()
        .map(|side| MeshInput {
            face_materials: Some(&materials[side.clone()]),
            ignored_faces: Some(&ignored[side.clone()]),
            seams: Some(&seams[side.clone()]),
            ..MeshInput::new(positions, bytemuck::cast_slice(&scene.mesh.triangles[side.clone()]))
        })
        .collect();
    let report = |found: uvunwrap::Progress| {
        let fraction = found.total.map(|total| found.done as f32 / total.max(1) as f32);
        let stage = match found.stage {
            Stage::Segmenting => "finding charts",
            Stage::Parameterizing => "flattening charts",
            Stage::Packing => "packing charts",
            _ => "writing coordinates",
        };
        progress(stage, fraction)
    };
    match uvunwrap::generate_with_progress(&meshes, &options(scene, settings, density), report) {
        Ok(atlas) => Ok(Some(charts_of(&atlas, scene.mesh.triangles.len()))),
        Err(uvunwrap::Error::Cancelled) => Ok(None),
        Err(problem) => Err(format!("the scene could not be unwrapped: {problem}; try fewer texels a metre")),
    }
}

/// The triangles of each side of a two-sided scene, which lie in the same places; else all.
fn sides(scene: &Scene) -> Vec<std::ops::Range<usize>> {
    let count = scene.mesh.triangles.len();
    if scene.two_sided { vec![0..count / 2, count / 2..count] } else { vec![0..count; 1] }
}

/// Where a surface is cut into charts.
struct Seams {
    /// The sides of triangles where it bends by more than [`CREASE_DEGREES`], or where something stands on it: there the
    /// light changes at once, and a texel must not reach across.
    seams: Vec<[bool; 3]>,
    /// Something stands on a surface somewhere.
    is_torn: bool,
}

impl Seams {
    fn of(scene: &Scene) -> Self {
        let mesh = &scene.mesh;
        let limit = CREASE_DEGREES.to_radians().cos();
        let mut neighbours: HashMap<[[u32; 3]; 2], Vec<u32>> = HashMap::new();
        let ends = |triangle: u32, side: usize| {
            let corners = mesh.corners(triangle);
            let mut ends = [corners[side], corners[(side + 1) % 3]].map(|end| end.to_array().map(f32::to_bits));
            ends.sort_unstable();
            ends
        };
        let count = mesh.triangles.len() as u32;
        for triangle in 0..count {
            (0..3).for_each(|side| neighbours.entry(ends(triangle, side)).or_default().push(triangle));
        }
        let mut is_torn = false;
        let mut is_seam = |triangle: u32, side: usize| {
            let normal = mesh.geometric_normal(triangle);
            let around = neighbours.get(&ends(triangle, side)).map_or(&[][..], Vec::as_slice);
            // The other side of a two-sided surface has charts of its own.
            let same_side = |other: u32| !scene.two_sided || (other < count / 2) == (triangle < count / 2);
            let others = || around.iter().filter(|&&other| same_side(other));
            let tears = others().any(|&other| are_torn(mesh, [triangle, other]));
            is_torn |= tears;
            tears || others().any(|&other| normal.dot(mesh.geometric_normal(other)) < limit)
        };
        let seams = (0..count).map(|triangle| [0, 1, 2].map(|side| is_seam(triangle, side))).collect();
        Self { seams, is_torn }
    }
}

/// True if two triangles have corners of one position and one normal that are vertices of their own: something stands
/// between them.
fn are_torn(mesh: &Mesh, triangles: [u32; 2]) -> bool {
    let [one, other] = triangles.map(|triangle| mesh.triangles[triangle as usize]);
    let key = |vertex: u32| [mesh.positions[vertex as usize], mesh.normals[vertex as usize]];
    one.iter().any(|&a| other.iter().any(|&b| a != b && key(a) == key(b)))
}

/// True for a triangle that light passes everywhere.
fn is_hole(scene: &Scene, triangle: u32) -> bool {
    let material = scene.material(triangle);
    material.opacity_texture.is_none() && material.opacity < 0.5
}

fn options(scene: &Scene, settings: &LightmapSettings, density: f64) -> Options {
    let area: f64 = (0..scene.mesh.triangles.len() as u32).map(|index| f64::from(scene.mesh.area(index))).sum();
    // Charts and their gutters fill about half of a page.
    let fits_one_page = 2.0 * area * density * density < f64::from(settings.page_size).powi(2);
    let page_size = if fits_one_page { None } else { Some(settings.page_size) };
    Options {
        density: Density::Fixed { texels_per_unit: density as f32, page_size },
        padding: PADDING,
        // A chart that fits no page is mapped more coarsely.
        max_chart_size: settings.page_size - 2 * PADDING,
        packing: if scene.mesh.triangles.len() > 20_000 { Packing::Fast } else { Packing::Shape },
        ..Options::default()
    }
}

fn charts_of(atlas: &uvunwrap::Atlas, triangle_count: usize) -> Charts {
    let size = Vec2::new(atlas.width as f32, atlas.height as f32);
    let mut charts = Charts {
        page_size: [atlas.width.max(1), atlas.height.max(1)],
        page_count: atlas.page_count.max(1),
        pages: Vec::with_capacity(triangle_count),
        chart_of_triangle: Vec::with_capacity(triangle_count),
        coordinates: Vec::with_capacity(triangle_count),
    };
    for mesh in &atlas.meshes {
        for corners in mesh.indices.chunks_exact(3) {
            let corners = [corners[0], corners[1], corners[2]].map(|corner| mesh.vertices[corner as usize]);
            charts.pages.push(corners[0].page.unwrap_or(0));
            charts.chart_of_triangle.push(corners[0].chart.unwrap_or(u32::MAX));
            charts.coordinates.push(corners.map(|corner| Vec2::from_array(corner.uv) * size));
        }
    }
    charts
}

/// The scene's own texture coordinates as one page, if they are usable: all within [0, 1], each triangle with an area,
/// and no texel covered more than once over.
fn own_coordinates(scene: &Scene, density: f64, most_texels: u32) -> Option<Charts> {
    let texcoords = &scene.mesh.texcoords;
    if texcoords.is_empty() || scene.two_sided {
        return None;
    }
    let is_inside = |corner: &Vec2| corner.cmpge(Vec2::ZERO).all() && corner.cmple(Vec2::ONE).all();
    if !texcoords.iter().flatten().all(is_inside) {
        return None;
    }
    let mesh_area: f64 = (0..texcoords.len() as u32).map(|triangle| f64::from(scene.mesh.area(triangle))).sum();
    let [mut map_area, mut low, mut high] = [0.0, f64::INFINITY, 0.0_f64];
    for (index, corners) in texcoords.iter().enumerate() {
        let area = TexelTriangle::new(*corners)?.area();
        let stretch = area / f64::from(scene.mesh.area(index as u32)).max(f64::MIN_POSITIVE);
        map_area += area;
        (low, high) = (low.min(stretch), high.max(stretch));
    }
    // A map that is a hundred times finer here than there was made for something else.
    if high > 1e4 * low {
        return None;
    }
    let side = ((mesh_area / map_area).sqrt() * density).ceil().clamp(8.0, f64::from(most_texels)) as u32;
    let scaled: Vec<[Vec2; 3]> = texcoords.iter().map(|corners| corners.map(|corner| corner * side as f32)).collect();
    let charts = Charts {
        page_size: [side; 2],
        page_count: 1,
        pages: vec![0; texcoords.len()],
        chart_of_triangle: connected_charts(&scaled),
        coordinates: scaled,
    };
    is_unique(&charts).then_some(charts)
}

/// True if no texel is covered by more than its own area, and none by two charts: then no two triangles overlap, but
/// for parts too small to tell.
fn is_unique(charts: &Charts) -> bool {
    let width = charts.page_size[0] as usize;
    let mut covered = vec![(0.0_f64, u32::MAX); width * charts.page_size[1] as usize];
    let mut is_unique = true;
    for (index, corners) in charts.coordinates.iter().enumerate() {
        let Some(triangle) = TexelTriangle::new(*corners) else { continue };
        let chart = charts.chart_of_triangle[index];
        triangle.for_each_piece(charts.page_size, |piece| {
            let (area, owner) = &mut covered[piece.texel[1] as usize * width + piece.texel[0] as usize];
            *area += piece.share * triangle.area();
            is_unique &= *area <= 1.0 + 1e-3 && (*owner == chart || *owner == u32::MAX);
            *owner = chart;
        });
    }
    is_unique
}

/// Numbers the charts: triangles that share an edge of the map are in one.
fn connected_charts(coordinates: &[[Vec2; 3]]) -> Vec<u32> {
    let mut charts = Sets::of_one(coordinates.len() as u32);
    let mut edges = HashMap::new();
    for (index, corners) in coordinates.iter().enumerate() {
        for side in 0..3 {
            let mut ends = [corners[side], corners[(side + 1) % 3]].map(|end: Vec2| end.to_array().map(f32::to_bits));
            ends.sort_unstable();
            let neighbour = *edges.entry(ends).or_insert(index as u32);
            charts.join(index as u32, neighbour);
        }
    }
    charts.into_lowest()
}
