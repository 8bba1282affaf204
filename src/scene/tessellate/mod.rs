//! Elements: the scene's triangles cut finer, and the way from a point of a scene triangle to its element.
//!
//! First every edge is cut in two `subdivide` times (`uniform`); then edges longer than `max_edge` are bisected
//! (`bisect`). A point finds its element by walking down the same cuts with its barycentric coordinates.

mod bisect;
mod refine;
mod uniform;

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::{Vec2, Vec3};

pub use refine::Refinement;

use super::{Scene, mesh::Mesh};

/// No more elements than this are made: some 5 GB with a solution of a few bounces.
pub const MAX_ELEMENTS: u64 = 50_000_000;

/// A tessellation of a scene. Rays meet the scene's own triangles; the element at a hit is found by
/// [`Tessellation::locate`].
#[derive(Clone, Debug)]
pub struct Tessellation {
    /// The elements as a mesh: vertices carry the solution. `texcoords` stay empty (they belong to the scene).
    pub mesh: Mesh,
    /// The scene triangle each element is a part of.
    pub scene_triangle: Vec<u32>,
    /// Barycentric coordinates of each element's corners in its scene triangle.
    pub corner_barycentrics: Vec<[Vec2; 3]>,
    /// What [`Refinement`] cut, round by round, so that it can be cut so again ([`Tessellation::with_cuts`]); empty
    /// for elements that options alone decide.
    pub cuts: Vec<u32>,
    /// How often each scene triangle was cut in four.
    subdivide: u32,
    /// The bisections, one root for each of the uniform parts; empty if there are none.
    nodes: Vec<bisect::Node>,
}

/// How fine the elements are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TessellationOptions {
    /// Every edge is cut in two this many times: 2^n segments an edge.
    pub subdivide: u32,
    /// Then every edge longer than this, in metres is bisected, longest first.
    pub max_edge: Option<f64>,
}

impl Tessellation {
    /// Cuts a scene's triangles.
    ///
    /// Triangles that share an edge, by the bits of its positions, are cut at the same points, also where a crease
    /// gives them different normals: cutting makes no T-junctions.
    ///
    /// # Errors
    /// One line, if there would be more than [`MAX_ELEMENTS`] elements or `max_edge` is not a usable length.
    pub fn new(scene: &Scene, options: &TessellationOptions) -> Result<Self, String> {
        let mut vertices = Vertices::of(&scene.mesh);
        let elements = uniform::subdivide(&scene.mesh, &mut vertices, options.subdivide)?;
        let (elements, nodes) = match options.max_edge {
            None => (elements, Vec::new()),
            Some(metres) => {
                let longest = metres / scene.frame.metres_per_unit;
                bisect::bisect(elements, &mut vertices, longest)
                    .map_err(|problem| format!("a longest edge of {metres} m {problem}"))?
            }
        };
        let mut tessellation = Self::of_elements(scene, &vertices, elements.into_iter());
        (tessellation.subdivide, tessellation.nodes) = (options.subdivide, nodes);
        Ok(tessellation)
    }

    /// Cuts a scene's triangles as the options say, or, if there are `cuts`, as [`Refinement`] did when it left them.
    ///
    /// # Errors
    /// As [`Tessellation::new`], and if the cuts are not of this scene.
    pub fn with_cuts(scene: &Scene, options: &TessellationOptions, cuts: &[u32]) -> Result<Self, String> {
        if cuts.is_empty() { Self::new(scene, options) } else { Refinement::replay(scene, cuts) }
    }

    /// Without the way down to the elements.
    fn of_elements(scene: &Scene, vertices: &Vertices, elements: impl Iterator<Item = Element> + Clone) -> Self {
        let scene_triangle: Vec<u32> = elements.clone().map(|element| element.scene_triangle).collect();
        let material_of = |triangle: &u32| scene.mesh.material_indices[*triangle as usize];
        Self {
            mesh: Mesh {
                positions: vertices.positions.clone(),
                normals: vertices.normals.clone(),
                triangles: elements.clone().map(|element| element.vertices).collect(),
                texcoords: Vec::new(),
                material_indices: scene_triangle.iter().map(material_of).collect(),
            },
            corner_barycentrics: elements.map(|element| element.barycentrics).collect(),
            scene_triangle,
            cuts: Vec::new(),
            subdivide: 0,
            nodes: Vec::new(),
        }
    }

    /// The element that holds a point of a scene triangle, and the point's barycentric coordinates in it. A point
    /// on a cut belongs to either side; one slightly outside of the triangle gets the nearest element.
    pub fn locate(&self, scene_triangle: u32, barycentric: Vec2) -> (u32, Vec2) {
        let (part, inside) = uniform::descend(self.subdivide, scene_triangle, barycentric);
        if self.nodes.is_empty() { (part, inside) } else { bisect::descend(&self.nodes, part, inside) }
    }

    /// A field given at the vertices, at a point of a scene triangle.
    pub fn interpolate(&self, field: &[Vec3], scene_triangle: u32, barycentric: Vec2) -> Vec3 {
        let (element, local) = self.locate(scene_triangle, barycentric);
        let corners = self.mesh.triangles[element as usize].map(|vertex| field[vertex as usize]);
        super::mesh::interpolate(corners, local)
    }

    /// The area that each vertex stands for [local units²]: a third of each element around it. Sums to the scene's.
    pub fn vertex_areas(&self) -> Vec<f32> {
        let mut areas = vec![0.0; self.mesh.positions.len()];
        for (index, corners) in self.mesh.triangles.iter().enumerate() {
            let third = self.mesh.area(index as u32) / 3.0;
            for &vertex in corners {
                areas[vertex as usize] += third;
            }
        }
        areas
    }

    /// A hash of the elements (positions, triangles, scene triangles), as 64 hexadecimal digits.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(bytemuck::cast_slice(&self.mesh.positions));
        hasher.update(bytemuck::cast_slice(&self.mesh.triangles));
        hasher.update(bytemuck::cast_slice(&self.scene_triangle));
        hasher.finalize().to_hex().to_string()
    }
}

/// One element while the mesh is being cut.
#[derive(Clone, Copy)]
struct Element {
    vertices: [u32; 3],
    scene_triangle: u32,
    /// The corners' barycentric coordinates in the scene triangle.
    barycentrics: [Vec2; 3],
}

/// The vertices so far, and the midpoints made in this round.
struct Vertices {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// The ends of the edge that a vertex is the midpoint of; of the scene's own vertices, themselves.
    parents: Vec<[u32; 2]>,
    midpoints: NumberMap<[u32; 2]>,
}

impl Vertices {
    fn of(mesh: &Mesh) -> Self {
        Self {
            positions: mesh.positions.clone(),
            normals: mesh.normals.clone(),
            parents: (0..mesh.positions.len() as u32).map(|vertex| [vertex; 2]).collect(),
            midpoints: NumberMap::default(),
        }
    }

    /// The vertex in the middle of the edge between two vertices, made if there is none yet. Its normal is the mean
    /// of theirs, or that of the lower number where they cancel.
    fn midpoint(&mut self, a: u32, b: u32) -> u32 {
        let ends = [a.min(b), a.max(b)];
        *self.midpoints.entry(ends).or_insert_with(|| {
            let [from, to] = ends.map(|end| end as usize);
            self.positions.push(0.5 * (self.positions[from] + self.positions[to]));
            let mean = self.normals[from] + self.normals[to];
            self.normals.push(mean.try_normalize().unwrap_or(self.normals[from]));
            self.parents.push(ends);
            (self.positions.len() - 1) as u32
        })
    }
}

/// From a few 32-bit words to a number.
type NumberMap<Key> = HashMap<Key, u32, BuildHasherDefault<WordHasher>>;

/// Multiplies and rotates words: numbers of vertices need no protection against an attacker.
#[derive(Default)]
struct WordHasher(u64);

impl Hasher for WordHasher {
    fn write(&mut self, bytes: &[u8]) {
        for word in bytes.chunks(4) {
            let value = word.iter().fold(0, |value, byte| value << 8 | u64::from(*byte));
            self.0 = (self.0.rotate_left(26) ^ value).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }

    /// The length of an array, which is the same for all keys of a map.
    fn write_usize(&mut self, _length: usize) {}

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }
}

/// An error line if `count` elements are too many.
fn check_count(count: u64) -> Result<(), String> {
    if count <= MAX_ELEMENTS {
        return Ok(());
    }
    Err(format!("would make more than {} million elements; cut less finely", MAX_ELEMENTS / 1_000_000))
}
