//! Elements: the scene's triangles cut finer, and the way from a point of a scene triangle to its element.

use glam::{Vec2, Vec3};

use super::{Scene, mesh::Mesh};

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
}

/// How fine the elements are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TessellationOptions {
    /// Every edge is cut in two this many times: 2^n segments an edge.
    pub subdivide: u32,
    /// Then every edge longer than this [m] is bisected, longest first.
    pub max_edge: Option<f64>,
}

impl Tessellation {
    /// Cuts a scene's triangles.
    pub fn new(_scene: &Scene, _options: &TessellationOptions) -> Self {
        unimplemented!()
    }

    /// The element that holds a point of a scene triangle, and the point's barycentric coordinates in it.
    pub fn locate(&self, _scene_triangle: u32, _barycentric: Vec2) -> (u32, Vec2) {
        unimplemented!()
    }

    /// A field given at the vertices, at a point of a scene triangle.
    pub fn interpolate(&self, field: &[Vec3], scene_triangle: u32, barycentric: Vec2) -> Vec3 {
        let (element, local) = self.locate(scene_triangle, barycentric);
        let corners = self.mesh.triangles[element as usize].map(|vertex| field[vertex as usize]);
        super::mesh::interpolate(corners, local)
    }
}
