//! Direct light from one polygon without samples: Lambert's formula (eq. 6) over the part of the light that is seen.
//!
//! The triangles that touch the shaft between the point and the light are all that can block. None: the light is fully
//! visible. A few: what lies behind each is cut out of the light's outline, as in Nishita and Nakamae 1985, "Continuous
//! tone representation of three-dimensional objects taking account of shadows and interreflection". Many: not done here.

use glam::{DVec3, Vec3};

use super::polygon::{Polygon, subtract};
use crate::trace::{RayTracer, Shaft, SurfacePoint};

/// More triangles in the shaft than this are left to sampling.
const MOST_OCCLUDERS: usize = 64;

/// More pieces of a light than this are left to sampling.
const MOST_PIECES: usize = 64;

/// A part of the light smaller than this is none.
const SLIVER: f64 = 1e-6;

/// What lies nearer to the light's plane than this, in local units, lies in it and blocks nothing.
const IN_LIGHT: f64 = 1e-6;

/// A one-sided polygon light of constant radiance.
#[derive(Clone, Copy, Debug)]
pub struct PolygonLight<'a> {
    /// 3 or 4 coplanar corners, counter-clockwise seen from the side that shines.
    pub corners: &'a [Vec3],
    /// Unit normal of the side that shines.
    pub normal: Vec3,
    /// Radiance [W/(m² sr)].
    pub radiance: Vec3,
    /// The scene triangle that is the light, and blocks nothing of itself; [`crate::trace::NO_TRIANGLE`] for none.
    pub triangle: u32,
}

/// Memory that is used again from point to point.
#[derive(Default)]
pub struct Scratch {
    triangles: Vec<u32>,
    pieces: Vec<Polygon>,
    spare: Vec<Polygon>,
}

/// Irradiance [W/m²] at a surface point from a polygon light, what the scene's triangles block taken out; exact but for
/// rounding. `None` if too much lies between.
pub fn visible_irradiance(
    tracer: &dyn RayTracer,
    corners_of: impl Fn(u32) -> [Vec3; 3],
    from: &SurfacePoint,
    light: &PolygonLight,
    scratch: &mut Scratch,
) -> Option<Vec3> {
    let known = |value: f64| {
        let irradiance = light.radiance * value as f32;
        // A product that overflowed is dropped: no infinity may reach a result.
        Some(if irradiance.is_finite() { irradiance } else { Vec3::ZERO })
    };
    let outline = above_horizon(from, light);
    if outline.is_empty() {
        return known(0.0);
    }
    let Scratch { triangles, pieces, spare } = scratch;
    triangles.clear();
    let shaft = Shaft::new(from.origin, from.geometric_normal, light.corners, light.normal);
    if !tracer.triangles_in_shaft(&shaft, MOST_OCCLUDERS, triangles) {
        return None;
    }
    pieces.clear();
    pieces.push(outline);
    let light_height = (light.corners[0].as_dvec3() - from.origin.as_dvec3()).dot(light.normal.as_dvec3());
    for &triangle in triangles.iter().filter(|&&triangle| triangle != from.triangle && triangle != light.triangle) {
        let occluder = Polygon::seen_from(from.origin, &corners_of(triangle));
        let (occluder, _) = occluder.split(from.geometric_normal.as_dvec3(), 0.0);
        let (occluder, _) = occluder.split(light.normal.as_dvec3(), light_height + IN_LIGHT);
        if !occluder.is_empty() {
            subtract(pieces, &occluder, spare);
        }
        if pieces.len() > MOST_PIECES {
            return None;
        }
        if pieces.is_empty() {
            return known(0.0);
        }
    }
    let normal = from.shading_normal.as_dvec3();
    let seen: f64 = pieces.iter().map(|piece| piece.irradiance(normal)).sum();
    // Slivers between occluders that touch are rounding, not light.
    let whole = above_horizon(from, light).irradiance(normal);
    known(if seen > SLIVER * whole { seen } else { 0.0 })
}

/// The light's outline above both planes of a surface point, its own and the one of its shading normal; none if the
/// point lies behind the light.
fn above_horizon(from: &SurfacePoint, light: &PolygonLight) -> Polygon {
    let outline = Polygon::seen_from(from.origin, light.corners);
    let towards: DVec3 = outline.corners()[0];
    if towards.dot(light.normal.as_dvec3()) >= 0.0 {
        return Polygon::NONE;
    }
    let (outline, _) = outline.split(from.geometric_normal.as_dvec3(), 0.0);
    if from.shading_normal == from.geometric_normal {
        return outline;
    }
    outline.split(from.shading_normal.as_dvec3(), 0.0).0
}
