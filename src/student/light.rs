//! Points on the area light.

use glam::{Vec2, Vec3};

use crate::scene::AreaLight;

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

/// Maps the unit square to the area light, uniformly: what eq. 3 sums over.
///
/// `point` lies in [0, 1]²: x runs along the light's u, y along its v.
///
/// Placeholder while not done: the centre, no normal, density 0. Tests: `radiosity check`, task `light`.
///
/// Hint: the light's vectors are **half** extents. The density is one over the area, and the area is not |u × v|.
pub fn sample_area_light(light: &AreaLight, point: Vec2) -> LightSample {
    // <answer>
    let centred = 2.0 * point - 1.0;
    LightSample {
        position: light.centre + centred.x * light.half_extent_u + centred.y * light.half_extent_v,
        normal: light.normal(),
        pdf_area: density(light.area()),
    }
    // </answer> (super::PLACEHOLDERS.sample_area_light)(light, point)
}

/// The inverse of [`sample_area_light`]: a position on the light to its point of the unit square; (1/2, 1/2) for a
/// light without area.
///
/// Placeholder while not done: (1/2, 1/2). Tests: `radiosity check`, task `light`.
///
/// Hint: u and v need not be at right angles. The component along u is found with a vector that is orthogonal to v.
pub fn area_light_inverse(light: &AreaLight, position: Vec3) -> Vec2 {
    // <answer>
    let (u, v) = (light.half_extent_u, light.half_extent_v);
    let normal = u.cross(v);
    let offset = position - light.centre;
    let centred = Vec2::new(offset.cross(v).dot(normal), u.cross(offset).dot(normal)) / normal.length_squared();
    if centred.is_finite() { 0.5 * centred + 0.5 } else { Vec2::splat(0.5) }
    // </answer> (super::PLACEHOLDERS.area_light_inverse)(light, position)
}

// <answer>
/// One over the area; 0 where there is none to speak of.
fn density(area: f32) -> f32 {
    let density = 1.0 / area;
    if density.is_finite() { density } else { 0.0 }
}
// </answer>
