//! Direct light from one polygon without samples: Lambert's formula (eq. 6) over the part of the light that is seen.
//!
//! The triangles that touch the shaft between the point and the light are all that can block. None: the light is fully
//! visible. A few: what lies behind each is cut out of the light's outline, as in Nishita and Nakamae 1985, "Continuous
//! tone representation of three-dimensional objects taking account of shadows and interreflection". Many: not done here.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

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

/// How much of a light is seen from a point, from least to most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sight {
    /// It lies below the horizon, or shines to the other side.
    BelowHorizon,
    /// Other surfaces hide all of it.
    Hidden,
    /// Other surfaces lie before it.
    Part,
    /// Nothing lies before what is above the horizon.
    Whole,
}

/// Shadow rays: those that were traced, and those that were not, by what was known without them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShadowRays {
    /// Traced.
    pub traced: u64,
    /// To a light below the horizon, or that shines to the other side.
    pub below_horizon: u64,
    /// To a light that other surfaces hide altogether.
    pub hidden: u64,
    /// To a light whose visible part is known.
    pub partly_seen: u64,
    /// To a light that nothing hides.
    pub fully_seen: u64,
    /// Those of the traced ones that were timed: one run a vertex, since looking at the clock takes time as well.
    pub timed: u64,
    /// What those took.
    pub timed_nanoseconds: u64,
}

impl ShadowRays {
    /// Those that were not traced.
    pub fn skipped(&self) -> u64 {
        self.below_horizon + self.hidden + self.partly_seen + self.fully_seen
    }

    /// Adds others.
    pub fn add(&mut self, other: &Self) {
        self.traced += other.traced;
        self.below_horizon += other.below_horizon;
        self.hidden += other.hidden;
        self.partly_seen += other.partly_seen;
        self.fully_seen += other.fully_seen;
        self.timed += other.timed;
        self.timed_nanoseconds += other.timed_nanoseconds;
    }

    #[cfg(feature = "reference")]
    pub(super) fn skip(&mut self, sight: Sight, count: u64) {
        *match sight {
            Sight::BelowHorizon => &mut self.below_horizon,
            Sight::Hidden => &mut self.hidden,
            Sight::Part => &mut self.partly_seen,
            Sight::Whole => &mut self.fully_seen,
        } += count;
    }
}

/// What is known of a light without samples.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Irradiance from it [W/m²].
    pub irradiance: Vec3,
    /// How much of it is seen.
    pub sight: Sight,
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
) -> Option<Seen> {
    let known = |value: f64, sight: Sight| Some(Seen { irradiance: times_radiance(light, value), sight });
    let outline = above_horizon(from, light);
    if outline.is_empty() {
        return known(0.0, Sight::BelowHorizon);
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
        if occluder.is_empty() {
            continue;
        }
        subtract(pieces, &occluder, spare);
        if pieces.len() > MOST_PIECES {
            return None;
        }
        if pieces.is_empty() {
            return known(0.0, Sight::Hidden);
        }
    }
    let normal = from.shading_normal.as_dvec3();
    let seen: f64 = pieces.iter().map(|piece| piece.irradiance(normal)).sum();
    // Slivers between occluders that touch are rounding, not light.
    let whole = above_horizon(from, light).irradiance(normal);
    match seen / whole {
        part if part > 1.0 - SLIVER => known(seen, Sight::Whole),
        part if part > SLIVER => known(seen, Sight::Part),
        _ => known(0.0, Sight::Hidden),
    }
}

/// Irradiance [W/m²] at a surface point from a polygon light with nothing between.
#[cfg(feature = "reference")]
pub(super) fn unhidden_irradiance(from: &SurfacePoint, light: &PolygonLight) -> Vec3 {
    times_radiance(light, above_horizon(from, light).irradiance(from.shading_normal.as_dvec3()))
}

/// Irradiance [W/m²] from what it is at radiance 1. A product that overflowed is dropped: no infinity may reach a result.
fn times_radiance(light: &PolygonLight, value: f64) -> Vec3 {
    let irradiance = light.radiance * value as f32;
    if irradiance.is_finite() { irradiance } else { Vec3::ZERO }
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
