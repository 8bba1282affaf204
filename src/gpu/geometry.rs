//! A tessellation as a graphics card draws it: streams of vertices, and triangles in the order of their materials.

use std::{ops::Range, sync::Arc};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::coarse::{Coarse, coarse};
use crate::{
    lightmap::Charts,
    scene::{Scene, Tessellation},
};

/// No more elements than this can be drawn: their indices fill WebGPU's largest buffer, 256 MiB.
pub const MAX_DRAWN_ELEMENTS: usize = 20_000_000;

/// The elements of a tessellation, ready to be uploaded. Making one takes a moment for a large mesh and can be done on
/// any thread; it holds no resources of the card, so it outlives a lost device.
///
/// The first vertices are the tessellation's. Where corners at one vertex differ in texture coordinates, or in their place
/// on a lightmap, copies of it follow.
pub struct ViewGeometry {
    /// For its textures.
    pub(super) scene: Arc<Scene>,
    pub(super) positions: Vec<Vec3>,
    /// Signed 16-bit fractions.
    pub(super) normals: Vec<[i16; 4]>,
    pub(super) texcoords: Vec<Vec2>,
    /// Column, row and page of each vertex on a lightmap; empty without one.
    pub(super) map_places: Vec<Vec3>,
    /// The tessellation's vertex that each vertex after the tessellation's own is a copy of.
    pub(super) copies: Vec<u32>,
    /// Number of the tessellation's vertices.
    pub(super) field_len: usize,
    pub(super) indices: Vec<[u32; 3]>,
    pub(super) draws: Vec<MaterialDraw>,
    /// What takes the place of many triangles for a moment.
    pub coarse: Option<Coarse>,
    /// Both ends of each edge, each edge once.
    pub(super) edges: Vec<[u32; 2]>,
    typical_edge: f32,
}

/// The triangles of one material.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaterialDraw {
    pub(super) material: u32,
    /// Range in [`ViewGeometry::indices`], in triangles.
    pub(super) triangles: Range<u32>,
}

impl ViewGeometry {
    /// Prepares the elements of a tessellation of `scene`.
    ///
    /// # Errors
    /// One line, if there are more than [`MAX_DRAWN_ELEMENTS`].
    pub fn new(scene: &Arc<Scene>, tessellation: &Tessellation) -> Result<Self, String> {
        Self::with_places(scene, tessellation, None)
    }

    /// The same for elements that show a lightmap as well.
    ///
    /// # Errors
    /// As [`ViewGeometry::new`].
    pub fn with_map(scene: &Arc<Scene>, tessellation: &Tessellation, charts: &Charts) -> Result<Self, String> {
        Self::with_places(scene, tessellation, Some(charts))
    }

    fn with_places(scene: &Arc<Scene>, tessellation: &Tessellation, charts: Option<&Charts>) -> Result<Self, String> {
        let mesh = &tessellation.mesh;
        let count = mesh.triangles.len().max(mesh.positions.len());
        if count > MAX_DRAWN_ELEMENTS {
            return Err(format!(
                "{count} elements or vertices are too many to draw (at most {} million); cut less finely",
                MAX_DRAWN_ELEMENTS / 1_000_000
            ));
        }
        let draws = material_draws(&mesh.material_indices, scene.materials.len());
        let mut corners = Corners::new(mesh.positions.len());
        let indices = sorted_triangles(scene, (tessellation, charts), &draws, &mut corners);
        let copied = |field_index: &u32| *field_index as usize;
        let mut positions = mesh.positions.clone();
        positions.extend(corners.copies.iter().map(|index| mesh.positions[copied(index)]));
        let mut normals: Vec<[i16; 4]> = mesh.normals.iter().map(|normal| packed(*normal)).collect();
        normals.extend(corners.copies.iter().map(|index| packed(mesh.normals[copied(index)])));
        let edges = edges(&mesh.triangles);
        let typical_edge = typical_edge(&mesh.positions, &edges);
        Ok(Self {
            scene: Arc::clone(scene),
            normals,
            texcoords: corners.places.iter().map(|place| place.texcoord).collect(),
            map_places: charts.map_or(Vec::new(), |_| corners.places.iter().map(|place| place.on_map).collect()),
            copies: corners.copies,
            // Merged across the edges of charts, vertices would read the map in between.
            coarse: if charts.is_none() { coarse(&positions, &indices, &draws, typical_edge) } else { None },
            positions,
            field_len: mesh.positions.len(),
            indices,
            draws,
            edges,
            typical_edge,
        })
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len()
    }

    /// Number of vertices on the card: the tessellation's, and copies that differ in texture coordinates.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Bytes that the geometry takes on the card, without textures and fields.
    pub fn bytes(&self) -> usize {
        self.positions.len() * 28 + self.map_places.len() * 12 + self.indices.len() * 12 + self.edges.len() * 8
    }

    /// Median length of the elements' edges, in local units.
    pub fn typical_edge(&self) -> f32 {
        self.typical_edge
    }

    /// `value` of the tessellation's vertex behind each vertex on the card.
    pub(super) fn expand<T: Copy + Default>(&self, values: &[T]) -> Vec<T> {
        let value = |index: usize| values.get(index).copied().unwrap_or_default();
        let mut expanded = Vec::with_capacity(self.positions.len());
        expanded.extend_from_slice(&values[..values.len().min(self.field_len)]);
        expanded.resize(self.field_len, T::default());
        expanded.extend(self.copies.iter().map(|&index| value(index as usize)));
        expanded
    }
}

/// Ranges of triangles for each material that has any, as a counting sort by material puts them.
fn material_draws(material_indices: &[u32], material_count: usize) -> Vec<MaterialDraw> {
    let mut counts = vec![0_u32; material_count];
    for &material in material_indices {
        counts[material as usize] += 1;
    }
    let mut start = 0;
    let ranges = counts.into_iter().zip(0..).map(|(count, material)| {
        start += count;
        MaterialDraw { material, triangles: start - count..start }
    });
    ranges.filter(|draw| !draw.triangles.is_empty()).collect()
}

/// The triangles sorted by material, with vertices that also agree in texture coordinates.
fn sorted_triangles(
    scene: &Scene,
    (tessellation, charts): (&Tessellation, Option<&Charts>),
    draws: &[MaterialDraw],
    corners: &mut Corners,
) -> Vec<[u32; 3]> {
    let mesh = &tessellation.mesh;
    let textured = scene.materials.iter().map(|material| {
        !scene.mesh.texcoords.is_empty()
            && (material.reflectance_texture.is_some() || material.opacity_texture.is_some())
    });
    let textured: Vec<bool> = textured.collect();
    let mut next = vec![0_u32; scene.materials.len()];
    for draw in draws {
        next[draw.material as usize] = draw.triangles.start;
    }
    let mut sorted = vec![[0; 3]; mesh.triangles.len()];
    for (element, (vertices, material)) in mesh.triangles.iter().zip(&mesh.material_indices).enumerate() {
        let material = *material as usize;
        sorted[next[material] as usize] = if textured[material] || charts.is_some() {
            let triangle = tessellation.scene_triangle[element];
            let place = |place: Vec2| CornerPlace {
                texcoord: if textured[material] { scene.mesh.texcoord(triangle, place) } else { Vec2::ZERO },
                on_map: charts.map_or(Vec3::ZERO, |charts| {
                    charts.map_point(triangle, place).extend(charts.pages[triangle as usize] as f32)
                }),
            };
            let places = tessellation.corner_barycentrics[element].map(place);
            std::array::from_fn(|corner| corners.vertex(vertices[corner], places[corner]))
        } else {
            *vertices
        };
        next[material] += 1;
    }
    sorted
}

/// Where a corner of an element lies on pictures.
#[derive(Clone, Copy, Default, PartialEq)]
struct CornerPlace {
    texcoord: Vec2,
    /// Column, row and page on the lightmap.
    on_map: Vec3,
}

/// Vertices by their places on pictures: each vertex, then a chain of copies of it.
struct Corners {
    places: Vec<CornerPlace>,
    copies: Vec<u32>,
    /// The next copy of the same vertex, or [`UNUSED`] where the vertex has no place yet, or [`LAST`].
    next: Vec<u32>,
    vertex_count: u32,
}

const UNUSED: u32 = u32::MAX;
const LAST: u32 = u32::MAX - 1;

impl Corners {
    fn new(vertex_count: usize) -> Self {
        Self {
            places: vec![CornerPlace::default(); vertex_count],
            copies: Vec::new(),
            next: vec![UNUSED; vertex_count],
            vertex_count: vertex_count as u32,
        }
    }

    /// The vertex, or the copy of it, with this place.
    fn vertex(&mut self, vertex: u32, wanted: CornerPlace) -> u32 {
        let mut place = vertex as usize;
        if self.next[place] == UNUSED {
            self.next[place] = LAST;
            self.places[place] = wanted;
            return vertex;
        }
        while self.places[place] != wanted {
            if self.next[place] == LAST {
                let copy = self.vertex_count + self.copies.len() as u32;
                self.next[place] = copy;
                self.copies.push(vertex);
                self.places.push(wanted);
                self.next.push(LAST);
                return copy;
            }
            place = self.next[place] as usize;
        }
        place as u32
    }
}

/// Each edge once, the lower vertex first.
fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])).collect();
    edges.par_sort_unstable();
    edges.dedup();
    edges
}

/// Median length of up to a thousand evenly spread edges; 0 without any.
fn typical_edge(positions: &[Vec3], edges: &[[u32; 2]]) -> f32 {
    let step = (edges.len() / 1000).max(1);
    let length = |&[a, b]: &[u32; 2]| positions[a as usize].distance(positions[b as usize]);
    let mut lengths: Vec<f32> = edges.iter().step_by(step).map(length).collect();
    lengths.sort_unstable_by(f32::total_cmp);
    lengths.get(lengths.len() / 2).copied().unwrap_or(0.0)
}

/// A unit vector as signed 16-bit fractions.
fn packed(normal: Vec3) -> [i16; 4] {
    let fraction = |value: f32| (value.clamp(-1.0, 1.0) * 32767.0).round() as i16;
    [fraction(normal.x), fraction(normal.y), fraction(normal.z), 0]
}
