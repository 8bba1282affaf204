//! Points on surfaces, and rays that leave them without meeting them again.

use glam::{Mat3, Vec2, Vec3};

use super::{NO_TRIANGLE, Ray, RayTracer};
use crate::{math::sequence::spiral_direction, scene::Scene};

/// Rays that tell whether a point is buried.
const RAYS_FOR_BURIAL: u32 = 16;

/// A point on a scene triangle that rays can leave from, on its front side.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The point, lifted off the surface by its own rounding error ([`lift`]).
    pub origin: Vec3,
    /// Unit normal of the surface itself, below which nothing is seen: of the triangle's front side, or of the curved
    /// surface that it stands for ([`SurfacePoint::on_curve`]).
    pub geometric_normal: Vec3,
    /// Unit shading normal: the axis of the hemisphere that is gathered.
    pub shading_normal: Vec3,
    /// The scene triangle.
    pub triangle: u32,
}

impl SurfacePoint {
    /// The point of `triangle` at barycentric coordinates (u, v).
    pub fn new(scene: &Scene, triangle: u32, barycentric: Vec2) -> Self {
        let geometric_normal = scene.mesh.geometric_normal(triangle);
        Self {
            origin: lift(scene.mesh.position(triangle, barycentric), geometric_normal, scene.mesh.corners(triangle)),
            geometric_normal,
            shading_normal: scene.mesh.shading_normal(triangle, barycentric),
            triangle,
        }
    }

    /// The ray into `direction` (unit length), or `None` if it starts into the surface: light from there is blocked
    /// by the surface itself, which an interpolated shading normal does not know of.
    pub fn ray(&self, direction: Vec3) -> Option<Ray> {
        (direction.dot(self.geometric_normal) > 0.0).then_some(Ray {
            origin: self.origin,
            direction,
            max_distance: f32::INFINITY,
            origin_triangle: self.triangle,
        })
    }

    /// The ray that ends at `target`, or `None` if it starts into the surface or has no length.
    pub fn ray_to(&self, target: Vec3) -> Option<Ray> {
        let offset = target - self.origin;
        let distance = offset.length();
        if distance <= 0.0 || !distance.is_finite() {
            return None;
        }
        self.ray(offset / distance).map(|ray| Ray { max_distance: distance, ..ray })
    }

    /// True if nearly all rays from the point meet back faces: the rule by which vertices are found to be buried.
    pub fn is_buried(&self, tracer: &dyn RayTracer) -> bool {
        self.surroundings(tracer, |_| ()).is_buried
    }

    /// What rays all over the hemisphere meet; `see` is told each triangle whose front they do.
    pub fn surroundings(&self, tracer: &dyn RayTracer, mut see: impl FnMut(u32)) -> Surroundings {
        let normal = self.geometric_normal;
        let basis = Mat3::from_cols(
            normal.any_orthogonal_vector().normalize(),
            normal.cross(normal.any_orthogonal_vector()).normalize(),
            normal,
        );
        let direction = |index| basis * spiral_direction(index, RAYS_FOR_BURIAL);
        let rays = (0..RAYS_FOR_BURIAL).filter_map(|index| self.ray(direction(index)));
        let (mut traced, mut back_hits, mut clearance) = (0, 0, f32::INFINITY);
        for hit in rays.inspect(|_| traced += 1).filter_map(|ray| tracer.closest_hit(&ray)) {
            back_hits += u32::from(!hit.front);
            if hit.front {
                see(hit.triangle);
            }
            clearance = clearance.min(hit.distance);
        }
        Surroundings { is_buried: is_buried_by(back_hits, traced), clearance }
    }
}

/// True for a point from which so many of so many rays, spread by the cosine, meet back faces that it lies inside an object.
/// A point that sees back faces for the most part but not wholly is dark, and no more: light still reaches it from the rest.
pub fn is_buried_by(back_hits: u32, rays: u32) -> bool {
    10 * u64::from(back_hits) > 9 * u64::from(rays)
}

/// What lies around a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Nearly all of it are back faces.
    pub is_buried: bool,
    /// Distance of the nearest surface that rays met; infinite if none did.
    pub clearance: f32,
}

/// `position`, a computed point of the triangle with these corners, moved along `normal` past the surface.
///
/// A barycentric sum of f32 corners is off by at most about 4 units in the last place of their largest coordinate
/// (Waechter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems 2019, derive
/// such a bound); 8 of them also cover a coplanar neighbour's own rounding. So the step scales with the scene.
pub fn lift(position: Vec3, normal: Vec3, corners: [Vec3; 3]) -> Vec3 {
    const ULPS: f32 = 8.0;
    let largest = corners.map(|corner| corner.abs().max_element()).into_iter().fold(0.0, f32::max);
    position + normal * (ULPS * f32::EPSILON * largest)
}

/// A ray from a point in space, for cameras and tests. `direction` must be of unit length.
pub fn free_ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, max_distance: f32::INFINITY, origin_triangle: NO_TRIANGLE }
}
