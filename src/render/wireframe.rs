//! Element edges as lines of constant width in pixels, hidden where the surface is hidden.

use glam::{Vec2, Vec3};

use super::picture::{RenderSettings, Subject};
use crate::{scene::Camera, trace::Hit};

/// sRGB-coded colour of the lines.
pub(super) const LINE_COLOUR: Vec3 = Vec3::new(0.25, 0.85, 0.95);
/// Half the width of a line, in pixels.
const HALF_WIDTH: f32 = 0.6;
/// Elements lower than this, in pixels, get fainter lines, so that a fine mesh does not become one flat colour.
const FULL_STRENGTH_HEIGHT: f32 = 6.0;

/// How a hit point moves with the pixel.
pub(super) struct Footprint {
    /// Unit direction of the ray.
    direction: Vec3,
    /// Movement across the ray, in local units, of the point at the hit's distance for one pixel to the right and
    /// one pixel down.
    steps: [Vec3; 2],
}

impl Footprint {
    /// The footprint of a ray with this unit direction, at a distance from the camera.
    pub(super) fn new(camera: &Camera, direction: Vec3, distance: f32, settings: &RenderSettings) -> Self {
        // Pixels are equally spaced in the plane at depth 1, square ones.
        let depth = distance * direction.dot(camera.forward);
        let pixel = 2.0 * camera.tan_half_fov / settings.height as f32 * depth;
        Self { direction, steps: [pixel * camera.right, -pixel * camera.up] }
    }

    /// Change of the hit point on a plane with this normal for one pixel to the right and one down.
    fn steps_on_plane(&self, normal: Vec3) -> [Vec3; 2] {
        let slope = normal.dot(self.direction);
        self.steps.map(|step| step - self.direction * (normal.dot(step) / slope))
    }
}

/// How much of the pixel the edges of the element at `hit` cover: 0 to 1.
///
/// A barycentric coordinate falls to 0 at its edge; divided by its change from pixel to pixel it is the distance to the
/// edge in pixels, and 1 divided by that change is the element's height.
pub(super) fn coverage<Tracer>(subject: &Subject<'_, Tracer>, hit: &Hit, footprint: &Footprint) -> f32 {
    let (element, local) = subject.tessellation.locate(hit.triangle, hit.barycentric);
    let [a, b, c] = subject.tessellation.mesh.corners(element);
    let (edge_u, edge_v) = (b - a, c - a);
    let normal = edge_u.cross(edge_v);
    let area_squared = normal.length_squared();
    let gradient_u = edge_v.cross(normal) / area_squared;
    let gradient_v = normal.cross(edge_u) / area_squared;
    let coordinates =
        [(1.0 - local.x - local.y, -gradient_u - gradient_v), (local.x, gradient_u), (local.y, gradient_v)];
    let [right, down] = footprint.steps_on_plane(normal);
    let (mut nearest, mut lowest) = (f32::INFINITY, f32::INFINITY);
    for (coordinate, gradient) in coordinates {
        let height = 1.0 / Vec2::new(gradient.dot(right), gradient.dot(down)).length();
        nearest = nearest.min(coordinate.max(0.0) * height);
        lowest = lowest.min(height);
    }
    let strength = (lowest / FULL_STRENGTH_HEIGHT).min(1.0);
    strength * (HALF_WIDTH + 0.5 - nearest).clamp(0.0, 1.0)
}
