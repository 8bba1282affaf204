//! A field between the vertices of coarse elements: quadratic, from the values and their gradients at the vertices.

use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use crate::{
    scene::{Mesh, Tessellation, mesh::interpolate},
    transport::VertexOrigins,
};

/// The weights that make gradients of values at the vertices of a tessellation.
///
/// The gradient at a vertex is the plane that fits the differences to its neighbours best, those being weighed by one
/// over their squared distance. An edge's middle then differs from the mean of its ends by an eighth of the difference
/// of the slopes along it (cubic Hermite interpolation at 1/2), and a quadratic patch through corners and middles has
/// no gaps to its neighbours.
#[derive(Default)]
pub(in crate::solver) struct SmoothField {
    /// Vertices in a concave crease: another surface rises from there.
    pub(in crate::solver) in_crease: Vec<bool>,
    /// Those of them that the elements go around by more than half a turn: a corner of what stands there.
    pub(in crate::solver) at_foot: Vec<bool>,
    offsets: Vec<u32>,
    neighbours: Vec<u32>,
    weights: Vec<Vec3>,
    /// For each edge of each element which of its ends have neighbours behind them.
    reaches: Vec<[[bool; 2]; 3]>,
    /// How far off the neighbours of each vertex are that its slopes come from; the nearest count most [local units].
    spacing: Vec<f32>,
}

/// A slope tells of so many times the distance to the neighbours that it comes from: beyond, along the long edges of
/// slivers, their noise would be magnified.
const SPACINGS_TOLD: f32 = 3.0;

/// The derivatives of a field of three bands along x, y and z.
pub(in crate::solver) type Gradient = [Vec3; 3];

impl SmoothField {
    /// For all vertices of a tessellation; buried ones have no say.
    pub(in crate::solver) fn new(tessellation: &Tessellation, origins: &VertexOrigins, buried: &[bool]) -> Self {
        let mesh = &tessellation.mesh;
        let in_crease = in_creases(mesh, origins);
        let goes_around = |vertex: usize| angle_around(mesh, origins, vertex as u32) > HALF_A_TURN;
        let at_foot = (0..in_crease.len()).map(|vertex| in_crease[vertex] && goes_around(vertex)).collect();
        let (offsets, neighbours, weights, reaches) = (vec![0], Vec::new(), Vec::new(), Vec::new());
        let mut field = Self { in_crease, at_foot, offsets, neighbours, weights, reaches, spacing: Vec::new() };
        let mut around = Vec::new();
        for vertex in 0..mesh.positions.len() {
            around.clear();
            let elements = origins.elements_around(vertex as u32).iter();
            around.extend(elements.flat_map(|&element| mesh.triangles[element as usize]));
            around.sort_unstable();
            around.dedup();
            around.retain(|&other| other as usize != vertex && !buried[other as usize] && !buried[vertex]);
            let offset = |other: u32| mesh.positions[other as usize] - mesh.positions[vertex];
            let normal = mesh.normals[vertex];
            let flat = |other: u32| offset(other) - normal * normal.dot(offset(other));
            let outer = |v: Vec3| Mat3::from_cols(v * v.x, v * v.y, v * v.z);
            let sum = |sum: Mat3, &other: &u32| sum + outer(flat(other)) * (1.0 / offset(other).length_squared());
            let matrix = around.iter().fold(outer(normal) * around.len() as f32, sum);
            // Neighbours on one line say nothing of the slope across it.
            if matrix.determinant() > 1e-3 * (around.len() as f32).powi(3) {
                let inverse = matrix.inverse();
                for &other in &around {
                    field.neighbours.push(other);
                    field.weights.push(inverse * flat(other) / offset(other).length_squared());
                }
            }
            field.offsets.push(field.neighbours.len() as u32);
            let inverse_squares: f32 = around.iter().map(|&other| 1.0 / offset(other).length_squared()).sum();
            field.spacing.push((around.len() as f32 / inverse_squares).sqrt());
        }
        let of_element = |&corners: &[u32; 3]| edges(corners).map(|ends| field.reaches_behind(mesh, ends));
        field.reaches = mesh.triangles.par_iter().with_min_len(256).map(of_element).collect();
        field
    }

    /// The gradients of a field given at the vertices.
    pub(in crate::solver) fn gradients(&self, values: &[Vec3]) -> Vec<Gradient> {
        let at = |vertex: usize| {
            let mut gradient = [Vec3::ZERO; 3];
            for index in self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize {
                let difference = values[self.neighbours[index] as usize] - values[vertex];
                for (axis, sum) in gradient.iter_mut().enumerate() {
                    *sum += self.weights[index][axis] * difference;
                }
            }
            gradient
        };
        (0..values.len()).into_par_iter().with_min_len(256).map(at).collect()
    }

    /// How much the middle of an edge differs from the mean of its ends: an eighth of the length times the difference
    /// of the slopes. Where an end has no neighbours behind it, as on the outline of a surface, its slope is worth
    /// little, and the parabola through both ends with the slope of the other is taken. In a concave crease light falls
    /// as x ln x with the distance x, since what leaves the other surface changes along that one: the middle is twice
    /// as much higher there.
    pub(in crate::solver) fn surplus(
        &self,
        mesh: &Mesh,
        values: &[Vec3],
        gradients: &[Gradient],
        ends: [u32; 2],
    ) -> Vec3 {
        self.surplus_between(mesh, values, gradients, ends, self.reaches_behind(mesh, ends))
    }

    fn surplus_between(
        &self,
        mesh: &Mesh,
        values: &[Vec3],
        gradients: &[Gradient],
        ends: [u32; 2],
        reaches: [bool; 2],
    ) -> Vec3 {
        let [a, b] = ends.map(|end| end as usize);
        let along = mesh.positions[b] - mesh.positions[a];
        let rise = |vertex: usize| {
            let gradient = &gradients[vertex];
            along.x * gradient[0] + along.y * gradient[1] + along.z * gradient[2]
        };
        let difference = values[b] - values[a];
        // In a crease the profile is x ln x: its middle is as much higher again.
        let factor = |vertex: usize| if self.in_crease[vertex] { 0.5 } else { 0.25 };
        let told = (SPACINGS_TOLD * self.spacing[a].min(self.spacing[b]) / along.length()).min(1.0);
        let surplus = match reaches {
            [true, false] => factor(b) * (rise(a) - difference),
            [false, true] => factor(a) * (difference - rise(b)),
            [true, true] | [false, false] => 0.125 * (rise(a) - rise(b)),
        };
        told * told * surplus
    }

    /// Which ends of an edge have neighbours behind them.
    fn reaches_behind(&self, mesh: &Mesh, ends: [u32; 2]) -> [bool; 2] {
        let [a, b] = ends.map(|end| end as usize);
        let along = mesh.positions[b] - mesh.positions[a];
        [self.reaches(mesh, a, -along), self.reaches(mesh, b, along)]
    }

    /// True if a vertex has a neighbour roughly in this direction.
    fn reaches(&self, mesh: &Mesh, vertex: usize, direction: Vec3) -> bool {
        let around = &self.neighbours[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize];
        around.iter().any(|&other| {
            let offset = mesh.positions[other as usize] - mesh.positions[vertex];
            offset.dot(direction) > 0.3 * offset.length() * direction.length()
        })
    }
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Which vertices lie in a concave crease: at their place another surface begins that rises in front of theirs.
fn in_creases(mesh: &Mesh, origins: &VertexOrigins) -> Vec<bool> {
    let count = mesh.positions.len();
    let mut by_place: Vec<u32> = (0..count as u32).collect();
    let place = |vertex: u32| mesh.positions[vertex as usize].to_array().map(|value| (value + 0.0).to_bits());
    by_place.sort_unstable_by_key(|&vertex| place(vertex));
    let mut found = vec![false; count];
    for group in by_place.chunk_by(|&a, &b| place(a) == place(b)) {
        for &vertex in group {
            let (position, normal) = (mesh.positions[vertex as usize], mesh.normals[vertex as usize]);
            let rises = |&element: &u32| {
                let way = mesh.corners(element).into_iter().sum::<Vec3>() / 3.0 - position;
                way.dot(normal) > RISE * way.length()
            };
            let others = group.iter().filter(|&&other| other != vertex);
            found[vertex as usize] = others.flat_map(|&other| origins.elements_around(other)).any(rises);
        }
    }
    found
}

/// In radians, and a little more.
const HALF_A_TURN: f32 = 1.1 * std::f32::consts::PI;

/// The angle that the elements around a vertex take up there [rad].
fn angle_around(mesh: &Mesh, origins: &VertexOrigins, vertex: u32) -> f32 {
    let at = |&element: &u32| {
        let position = mesh.positions[vertex as usize];
        let others = mesh.triangles[element as usize].into_iter().filter(|&corner| corner != vertex);
        let mut ways = others.map(|corner| mesh.positions[corner as usize] - position);
        ways.next().zip(ways.next()).map_or(0.0, |(one, other)| one.angle_between(other))
    };
    origins.elements_around(vertex).iter().map(at).sum()
}

/// The sine of the angle from which on a surface is said to rise.
const RISE: f32 = 0.2;

/// Values at the vertices of elements, with what a smooth field between them needs.
pub(in crate::solver) struct SmoothValues<'a> {
    tessellation: &'a Tessellation,
    values: &'a [Vec3],
    /// How much the middle of each element's edge k, from corner k to the next, differs from the mean of its ends.
    surpluses: Vec<[Vec3; 3]>,
}

impl<'a> SmoothValues<'a> {
    pub(in crate::solver) fn new(field: &SmoothField, tessellation: &'a Tessellation, values: &'a [Vec3]) -> Self {
        let gradients = field.gradients(values);
        let mesh = &tessellation.mesh;
        let of_element = |(corners, reaches): (&[u32; 3], &[[bool; 2]; 3])| {
            let edges = edges(*corners);
            [0, 1, 2].map(|edge| field.surplus_between(mesh, values, &gradients, edges[edge], reaches[edge]))
        };
        let elements = mesh.triangles.par_iter().zip(&field.reaches).with_min_len(256);
        Self { tessellation, values, surpluses: elements.map(of_element).collect() }
    }

    /// The field at a place in an element. Linear in the values: where they fall steeply it may be negative.
    pub(in crate::solver) fn at(&self, (element, place): (u32, Vec2)) -> Vec3 {
        let corners = self.tessellation.mesh.triangles[element as usize];
        let weights = [1.0 - place.x - place.y, place.x, place.y];
        let linear = interpolate(corners.map(|corner| self.values[corner as usize]), place);
        let bent = |(edge, surplus): (usize, &Vec3)| 4.0 * weights[edge] * weights[(edge + 1) % 3] * *surplus;
        let bends: Vec3 = self.surpluses[element as usize].iter().enumerate().map(bent).sum();
        linear + bends
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;
    use crate::scene::{LoadOptions, load::load_from_memory, tessellate::TessellationOptions};

    /// Expected: the parabola itself; inside a regular grid the gradients are its own.
    #[test]
    fn a_parabola_is_rebuilt_between_the_vertices_far_better_than_by_straight_lines() {
        let obj = "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nf 4 3 2 1\n";
        let scene = load_from_memory("floor", obj, "", &LoadOptions::default()).unwrap();
        let options = TessellationOptions { subdivide: 3, max_edge: None };
        let tessellation = Tessellation::new(&scene, &options).unwrap();
        let parabola = |p: Vec3| Vec3::new(4.0 - p.x * p.x - 0.5 * p.z * p.z + p.x * p.z, 4.0 + p.x, 1.0);
        let values: Vec<Vec3> = tessellation.mesh.positions.iter().map(|&position| parabola(position)).collect();
        let origins = VertexOrigins::new(&tessellation);
        let field = SmoothField::new(&tessellation, &origins, &vec![false; values.len()]);
        let smooth = SmoothValues::new(&field, &tessellation, &values);
        let (mut bent, mut straight) = (0.0_f32, 0.0_f32);
        for element in 0..tessellation.mesh.triangles.len() as u32 {
            let place = Vec2::new(0.4, 0.25);
            let corners = tessellation.mesh.triangles[element as usize].map(|vertex| values[vertex as usize]);
            let expected = parabola(interpolate(tessellation.mesh.corners(element), place));
            bent += (smooth.at((element, place)) - expected).length_squared();
            straight += (interpolate(corners, place) - expected).length_squared();
        }
        // Along the outline the slopes are guessed from one side.
        assert!(bent.sqrt() < 0.25 * straight.sqrt(), "{bent} of {straight}");
    }
}
