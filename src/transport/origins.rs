//! Where the rays of a vertex start.
//!
//! A vertex often lies in a crease, where rays from the vertex itself see half a world and darken the field around.
//! So its rays start a little inside each of the elements around it, in turn; and an element whose start is buried
//! (nearly all its rays meet back faces) is left out of the vertex's value.

use clap::ValueEnum;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::{
    scene::{Scene, Tessellation, mesh::interpolate},
    trace::{RayTracer, SurfacePoint, surface::lift},
};

/// What a vertex's value stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VertexValues {
    /// The irradiance at the vertex.
    #[default]
    Point,
    /// The mean irradiance around it, weighted as the vertex is in interpolation (eq. 7).
    Average,
    /// What brings the interpolated field nearest to the light on the elements (Kavan, Bargteil and Sloan 2011).
    LeastSquares,
}

/// How far the start of a ray moves from its vertex towards the middle of the element.
const MOVE_INTO_ELEMENT: f32 = 0.01;

/// More elements around one vertex than this are thinned out, so that each keeps enough rays.
const MOST_ORIGINS: usize = 8;

/// The elements around each vertex, as one array with offsets.
#[derive(Clone, Debug)]
pub struct VertexOrigins {
    offsets: Vec<u32>,
    elements: Vec<u32>,
}

impl VertexOrigins {
    /// Finds the elements around each vertex.
    pub fn new(tessellation: &Tessellation) -> Self {
        let mesh = &tessellation.mesh;
        let mut offsets = vec![0_u32; mesh.positions.len() + 1];
        for vertex in mesh.triangles.iter().flatten() {
            offsets[*vertex as usize + 1] += 1;
        }
        for vertex in 0..mesh.positions.len() {
            offsets[vertex + 1] += offsets[vertex];
        }
        let mut next = offsets.clone();
        let mut elements = vec![0; mesh.triangles.len() * 3];
        for (element, corners) in mesh.triangles.iter().enumerate() {
            for &vertex in corners {
                let slot = &mut next[vertex as usize];
                elements[*slot as usize] = element as u32;
                *slot += 1;
            }
        }
        Self { offsets, elements }
    }

    /// The elements around a vertex.
    pub fn elements_around(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.elements[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }

    /// Puts the start points of a vertex's rays into `origins`; none for a vertex of no element. All have the
    /// vertex's own shading normal. `tracer` must hold the same scene.
    pub fn collect(
        &self,
        (scene, tracer): (&Scene, &dyn RayTracer),
        tessellation: &Tessellation,
        vertex: u32,
        origins: &mut Vec<SurfacePoint>,
    ) {
        origins.clear();
        let around = self.elements_around(vertex);
        let mesh = &tessellation.mesh;
        let position = mesh.positions[vertex as usize];
        for index in 0..around.len().min(MOST_ORIGINS) {
            let element = around[index * around.len() / around.len().min(MOST_ORIGINS)];
            let triangle = tessellation.scene_triangle[element as usize];
            let geometric_normal = scene.mesh.geometric_normal(triangle);
            let centroid = mesh.corners(element).into_iter().sum::<Vec3>() / 3.0;
            let moved = position.lerp(centroid, MOVE_INTO_ELEMENT);
            let corner = mesh.triangles[element as usize].iter().position(|&corner| corner == vertex).unwrap_or(0);
            let inside = Vec3::AXES[corner].lerp(Vec3::splat(1.0 / 3.0), MOVE_INTO_ELEMENT);
            let barycentrics = tessellation.corner_barycentrics[element as usize];
            let origin = SurfacePoint {
                origin: lift(moved, geometric_normal, scene.mesh.corners(triangle)),
                geometric_normal,
                shading_normal: mesh.normals[vertex as usize],
                triangle,
            };
            let on_triangle = interpolate(barycentrics, Vec2::new(inside.y, inside.z));
            origins.push(origin.on_curve(scene, on_triangle, tracer));
        }
    }
}

/// Which of `origin_count` origins sample `index` of `count` starts from: each gets one run of neighbours in the
/// sequence, and so a set of directions that is spread well by itself.
pub fn origin_of_sample(index: u32, count: u32, origin_count: usize) -> usize {
    (u64::from(index) * origin_count as u64 / u64::from(count.max(1))) as usize
}

/// The samples of `count` that start from origin `place` of `origin_count`: what [`origin_of_sample`] undoes.
pub fn samples_of_origin(place: usize, count: u32, origin_count: usize) -> std::ops::Range<u32> {
    let first = |place: usize| (place as u64 * u64::from(count)).div_ceil(origin_count.max(1) as u64) as u32;
    first(place)..first(place + 1)
}
