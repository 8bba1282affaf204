//! Visibility: rays against the scene's own triangles.
//!
//! [`RayTracer`] is all the solver asks of a ray tracer, so that a student can bring their own.

pub mod bvh;
mod curve;
pub mod locate;
mod shaft;
mod split_tree;
pub mod surface;
mod triangle;
mod walk;
mod wide_tree;

use glam::{Vec2, Vec3};

pub use bvh::Tracer;
pub use locate::{Located, locate_point};
pub use shaft::Shaft;
pub use surface::SurfacePoint;

/// No triangle: for rays that leave from no surface.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// A ray.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start.
    pub origin: Vec3,
    /// Direction, of unit length.
    pub direction: Vec3,
    /// Hits at this distance or beyond do not count; `f32::INFINITY` for none.
    pub max_distance: f32,
    /// The triangle that the ray leaves from, which it cannot hit; [`NO_TRIANGLE`] for none.
    pub origin_triangle: u32,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The scene's triangle.
    pub triangle: u32,
    /// Barycentric coordinates (u, v): the point is (1-u-v) a + u b + v c.
    pub barycentric: Vec2,
    /// Distance from the origin, in local units.
    pub distance: f32,
    /// True if the ray meets the side that the triangle's winding calls front.
    pub front: bool,
}

/// The ray tracer as the solver sees it.
pub trait RayTracer: Send + Sync {
    /// The nearest hit with 0 < distance < `max_distance`, from either side of a triangle; cut-outs let it through.
    fn closest_hit(&self, ray: &Ray) -> Option<Hit>;

    /// True if anything lies between the origin and `max_distance`.
    fn occluded(&self, ray: &Ray) -> bool;

    /// Adds all triangles that touch the shaft to `triangles`, in any order, but for those that `is_left_out` names. False,
    /// with any of them, if they are more than `limit`, if one has cut-outs, or if the tracer cannot tell, as one that only
    /// traces rays.
    fn triangles_in_shaft(
        &self,
        _shaft: &Shaft,
        _is_left_out: &dyn Fn(u32) -> bool,
        _limit: usize,
        _triangles: &mut Vec<u32>,
    ) -> bool {
        false
    }
}
