//! Points on lights.

use glam::{Vec2, Vec3};

use crate::scene::{AreaLight, mesh};

/// A point on the area light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Where it lies, in local units.
    pub position: Vec3,
    /// Unit normal of the side that shines.
    pub normal: Vec3,
    /// Density of the point per local unit²; 0 for a light without area, which gives no light.
    pub pdf_area: f32,
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleSample {
    /// Barycentric coordinates (u, v): the point is (1-u-v) a + u b + v c.
    pub barycentric: Vec2,
    /// Where it lies, in the units of the corners.
    pub position: Vec3,
    /// Density of the point per square of that unit; 0 for a triangle without area.
    pub pdf_area: f32,
}

/// Maps the unit square to the area light, uniformly: what eq. 3 sums over.
///
/// `point` lies in [0, 1]²: x runs along the light's u, y along its v.
///
/// Placeholder while not done: the centre, no normal, density 0. Tests: `radiosity check`, task `light`.
///
/// Hint: the light's vectors are **half** extents. The density is one over the area, and the area is not |u × v|.
pub fn sample_area_light(light: &AreaLight, point: Vec2) -> LightSample {
    let centred = 2.0 * point - 1.0;
    LightSample {
        position: light.centre + centred.x * light.half_extent_u + centred.y * light.half_extent_v,
        normal: light.normal(),
        pdf_area: density(light.area()),
    }
}

/// The inverse of [`sample_area_light`]: a position on the light to its point of the unit square; (1/2, 1/2) for a
/// light without area.
///
/// Placeholder while not done: (1/2, 1/2). Tests: `radiosity check`, task `light`.
///
/// Hint: u and v need not be at right angles. The component along u is found with a vector that is orthogonal to v.
pub fn area_light_inverse(light: &AreaLight, position: Vec3) -> Vec2 {
    let (u, v) = (light.half_extent_u, light.half_extent_v);
    let normal = u.cross(v);
    let offset = position - light.centre;
    let centred = Vec2::new(offset.cross(v).dot(normal), u.cross(offset).dot(normal)) / normal.length_squared();
    if centred.is_finite() { 0.5 * centred + 0.5 } else { Vec2::splat(0.5) }
}

/// Maps the unit square to a triangle, uniformly: what eq. 3 sums over where the light is an emissive triangle.
///
/// `point` lies in [0, 1]². The map folds the square's diagonal onto the triangle and shears the two halves, so that a
/// stratified set stays well spread.
///
/// Method: Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
///
/// Hint: halve the smaller coordinate, and take that half away from the larger one.
pub fn sample_triangle(corners: [Vec3; 3], point: Vec2) -> TriangleSample {
    let half = 0.5 * point.min_element();
    let barycentric = if point.x < point.y { Vec2::new(half, point.y - half) } else { Vec2::new(point.x - half, half) };
    let [a, b, c] = corners;
    TriangleSample {
        barycentric,
        position: mesh::interpolate(corners, barycentric),
        pdf_area: density(0.5 * (b - a).cross(c - a).length()),
    }
}

/// The inverse of [`sample_triangle`]: barycentric coordinates to their point of the unit square.
///
/// Hint: the smaller barycentric coordinate is half of the smaller coordinate of the square.
pub fn triangle_inverse(barycentric: Vec2) -> Vec2 {
    let sum = barycentric.x + barycentric.y;
    if barycentric.x < barycentric.y {
        Vec2::new(2.0 * barycentric.x, sum)
    } else {
        Vec2::new(sum, 2.0 * barycentric.y)
    }
}

/// One over the area; 0 where there is none to speak of.
fn density(area: f32) -> f32 {
    let density = 1.0 / area;
    if density.is_finite() { density } else { 0.0 }
}
