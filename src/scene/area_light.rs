//! The placed area light: data only.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::LocalFrame;

/// A one-sided rectangle that emits to the side of u × v. It is not geometry: it blocks and reflects nothing.
/// In local units; made from [`AreaLightState`], which is in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Centre.
    pub centre: Vec3,
    /// From the centre to the middle of one side: half the width.
    pub half_extent_u: Vec3,
    /// From the centre to the middle of the other side: half the height.
    pub half_extent_v: Vec3,
    /// Emitted radiance [W/(m² sr)], the same from all points in all directions.
    pub radiance: Vec3,
}

impl AreaLight {
    /// Unit normal of the side that shines; 0 for a light without area.
    pub fn normal(&self) -> Vec3 {
        super::mesh::unit_or_zero(self.half_extent_u.cross(self.half_extent_v))
    }

    /// Area in local units²: 4 |u × v|.
    pub fn area(&self) -> f32 {
        4.0 * self.half_extent_u.cross(self.half_extent_v).length()
    }

    /// The corners, counter-clockwise seen from the side that shines.
    pub fn corners(&self) -> [Vec3; 4] {
        let (centre, u, v) = (self.centre, self.half_extent_u, self.half_extent_v);
        [centre - u - v, centre + u - v, centre + u + v, centre - u + v]
    }
}

/// The area light as people write it: in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AreaLightState {
    /// Centre, in metres.
    pub centre: [f64; 3],
    /// Half-extent vector u, in metres.
    pub u: [f64; 3],
    /// Half-extent vector v, in metres; the light shines to the side of u × v.
    pub v: [f64; 3],
    /// Radiance, linear RGB [W/(m² sr)].
    pub radiance: [f32; 3],
}

impl Default for AreaLightState {
    fn default() -> Self {
        Self { centre: [0.0, 1.0, 0.0], u: [0.25, 0.0, 0.0], v: [0.0, 0.0, 0.25], radiance: [10.0; 3] }
    }
}

impl AreaLightState {
    /// The light in a scene's local units.
    pub fn to_local(&self, frame: &LocalFrame) -> AreaLight {
        AreaLight {
            centre: frame.point_to_local(DVec3::from_array(self.centre)),
            half_extent_u: frame.vector_to_local(DVec3::from_array(self.u)),
            half_extent_v: frame.vector_to_local(DVec3::from_array(self.v)),
            radiance: Vec3::from_array(self.radiance),
        }
    }

    /// What is wrong with the light, if anything: a value that is not finite, or a negative radiance.
    pub fn problem(&self) -> Option<String> {
        let lengths = [self.centre, self.u, self.v];
        if lengths.iter().flatten().any(|value| !value.is_finite()) {
            return Some(String::from("the light's centre and half-extents must be finite numbers"));
        }
        if self.radiance.iter().any(|value| !value.is_finite() || *value < 0.0) {
            return Some(String::from("the light's radiance must be finite and not negative"));
        }
        None
    }
}
