//! The curved surface that a triangle with smooth normals stands for.
//!
//! A triangle's own plane ends the light at its own terminator, while its shading normals tell of light beyond: so whole
//! triangles go dark one by one. On a triangle that is bent outwards, rays leave from the curved surface instead, and its
//! horizon is the shading normal's: all around lies below it and blocks nothing.
//! Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4, which moves the origin alone.

use glam::{Vec2, Vec3};

use super::{RayTracer, SurfacePoint, surface::lift};
use crate::scene::{Scene, mesh::interpolate};

/// Normals that all lie within so much (1 - cosine) of the triangle's own are those of a flat surface: a quarter of a degree.
const FLAT: f32 = 1e-5;

/// A triangle whose normals lean more than this (a cosine) is no piece of a smooth surface: 41°, a little more than an
/// icosahedron's on its sphere. A box with one normal a corner has 55°.
const MOST_LEAN: f32 = 0.75;

/// How far a corner may rise over another's tangent plane, by their distance: rounded normals in files.
const RISE: f32 = 1e-3;

impl SurfacePoint {
    /// The point at `barycentric` on the curved surface, with the shading normal's horizon; itself if the scene is
    /// faceted, the triangle flat or hollow, or something else stands between.
    #[must_use]
    pub fn on_curve(self, scene: &Scene, barycentric: Vec2, tracer: &dyn RayTracer) -> Self {
        let Some(position) = self.curved_position(scene, barycentric) else {
            return self;
        };
        let origin = lift(position, self.shading_normal, scene.mesh.corners(self.triangle));
        if self.ray_to(origin).is_some_and(|ray| tracer.occluded(&ray)) {
            return self;
        }
        Self { origin, geometric_normal: self.shading_normal, ..self }
    }

    /// The mean of the point's projections on the corners' tangent planes, weighted as the corners are; `None` where the
    /// surface is not bent outwards.
    fn curved_position(&self, scene: &Scene, barycentric: Vec2) -> Option<Vec3> {
        if scene.faceted {
            return None;
        }
        let mesh = &scene.mesh;
        let normals = mesh.triangles[self.triangle as usize].map(|vertex| mesh.normals[vertex as usize]);
        let least = normals.iter().map(|normal| normal.dot(self.geometric_normal)).fold(1.0, f32::min);
        if !(MOST_LEAN..=1.0 - FLAT).contains(&least) {
            return None;
        }
        let corners = mesh.corners(self.triangle);
        let rises = |(corner, normal): (Vec3, Vec3)| {
            let offsets = corners.into_iter().map(move |other| other - corner);
            offsets.into_iter().any(|offset| offset.dot(normal) > RISE * offset.length())
        };
        if corners.into_iter().zip(normals).any(rises) {
            return None;
        }
        let position = interpolate(corners, barycentric);
        let projection = |(corner, normal): (Vec3, Vec3)| position + (corner - position).dot(normal).max(0.0) * normal;
        let [a, b, c] = [0, 1, 2].map(|place| projection((corners[place], normals[place])));
        Some(interpolate([a, b, c], barycentric))
    }
}
