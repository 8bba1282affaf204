//! Indexed triangles with shading normals.

use std::ops::{Add, Mul};

use glam::{Vec2, Vec3};

/// Triangles in local units. A vertex is a position with one shading normal: corners at one position that differ in
/// normal are different vertices. Texture coordinates belong to the corners and split no vertex.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Position of each vertex.
    pub positions: Vec<Vec3>,
    /// Unit shading normal of each vertex.
    pub normals: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of each triangle's corners, v up; as long as `triangles`, or empty if there are none.
    pub texcoords: Vec<[Vec2; 3]>,
    /// Material of each triangle.
    pub material_indices: Vec<u32>,
}

impl Mesh {
    /// The corner positions of a triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// Twice the area times the unit normal of the front side.
    pub fn scaled_normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// Unit normal of the front side; 0 for a triangle without area.
    pub fn geometric_normal(&self, triangle: u32) -> Vec3 {
        unit_or_zero(self.scaled_normal(triangle))
    }

    /// Area in local units².
    pub fn area(&self, triangle: u32) -> f32 {
        0.5 * self.scaled_normal(triangle).length()
    }

    /// The point with barycentric coordinates (u, v): (1-u-v) a + u b + v c.
    pub fn position(&self, triangle: u32, barycentric: Vec2) -> Vec3 {
        interpolate(self.corners(triangle), barycentric)
    }

    /// The interpolated, normalised shading normal; the geometric one where that vanishes.
    pub fn shading_normal(&self, triangle: u32, barycentric: Vec2) -> Vec3 {
        let normals = self.triangles[triangle as usize].map(|vertex| self.normals[vertex as usize]);
        interpolate(normals, barycentric).try_normalize().unwrap_or_else(|| self.geometric_normal(triangle))
    }

    /// The interpolated texture coordinates; (0, 0) if the mesh has none.
    pub fn texcoord(&self, triangle: u32, barycentric: Vec2) -> Vec2 {
        let Some([a, b, c]) = self.texcoords.get(triangle as usize) else {
            return Vec2::ZERO;
        };
        (1.0 - barycentric.x - barycentric.y) * *a + barycentric.x * *b + barycentric.y * *c
    }
}

/// (1-u-v) a + u b + v c: the barycentric convention of the whole program.
pub fn interpolate<Value: Add<Output = Value>>([a, b, c]: [Value; 3], barycentric: Vec2) -> Value
where
    f32: Mul<Value, Output = Value>,
{
    (1.0 - barycentric.x - barycentric.y) * a + barycentric.x * b + barycentric.y * c
}

/// `vector` at unit length, also where its square underflows; 0 for no length or a value that is not finite.
pub fn unit_or_zero(vector: Vec3) -> Vec3 {
    let largest = vector.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (vector / largest).normalize_or_zero() } else { Vec3::ZERO }
}
