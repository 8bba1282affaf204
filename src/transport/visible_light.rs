//! Direct light from one lamp without samples: Lambert's formula (eq. 6) over the part of it that is seen.
//!
//! The triangles that touch the shaft between the point and the lamp are all that can block. None: the lamp is fully
//! visible. A few: what lies behind each is cut out of the lamp's outline, as in Nishita and Nakamae 1985, "Continuous
//! tone representation of three-dimensional objects taking account of shadows and interreflection". Many: not done here.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{
    lamps::Lamp,
    polygon::{Polygon, subtract, subtract_but},
    silhouette::View,
};
use crate::trace::{RayTracer, SurfacePoint};

/// More triangles in the shaft than this are left to sampling.
const MOST_OCCLUDERS: usize = 64;

/// More pieces of a light than this, or more than so many times those of its outline, are left to sampling.
const MOST_PIECES: usize = 64;
const MORE_PIECES: usize = 16;

/// A part of the light smaller than this is none.
const SLIVER: f64 = 1e-6;

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
    view: View,
    triangles: Vec<u32>,
    pieces: Vec<Polygon>,
    spare: Vec<Polygon>,
}

/// Irradiance [W/m²] at a surface point from a lamp, what the scene's triangles block taken out; exact but for rounding.
/// `None` if too much lies between.
pub fn visible_irradiance(
    tracer: &dyn RayTracer,
    corners_of: impl Fn(u32) -> [Vec3; 3],
    from: &SurfacePoint,
    lamp: &Lamp,
    scratch: &mut Scratch,
) -> Option<Seen> {
    let known = |value: f64, sight: Sight| Some(Seen { irradiance: times_radiance(lamp, value), sight });
    let Scratch { view, triangles, pieces, spare } = scratch;
    view.look(lamp, from, pieces);
    if pieces.is_empty() {
        return known(0.0, Sight::BelowHorizon);
    }
    triangles.clear();
    let is_left_out = |triangle: u32| triangle == from.triangle || lamp.contains(triangle);
    if !tracer.triangles_in_shaft(&view.shaft(lamp, from), &is_left_out, MOST_OCCLUDERS, triangles) {
        return None;
    }
    let whole = irradiance(from, pieces);
    let most_pieces = MOST_PIECES.max(MORE_PIECES * pieces.len());
    for &triangle in &*triangles {
        let occluder = Polygon::seen_from(from.origin, &corners_of(triangle));
        let (occluder, _) = occluder.split(from.geometric_normal.as_dvec3(), 0.0);
        let (occluder, behind) = view.in_front(&occluder)?;
        if occluder.is_empty() {
            continue;
        }
        if behind.is_empty() {
            subtract(pieces, &occluder, spare);
        } else {
            subtract_but(pieces, &occluder, &behind, spare);
        }
        if pieces.len() > most_pieces {
            return None;
        }
        if pieces.is_empty() {
            return known(0.0, Sight::Hidden);
        }
    }
    let seen = irradiance(from, pieces);
    // Slivers between occluders that touch are rounding, not light.
    match seen / whole {
        part if part > 1.0 - SLIVER => known(seen, Sight::Whole),
        part if part > SLIVER => known(seen, Sight::Part),
        _ => known(0.0, Sight::Hidden),
    }
}

/// Irradiance [W/m²] at a surface point from a lamp with nothing between.
#[cfg(feature = "reference")]
pub(super) fn unhidden_irradiance(from: &SurfacePoint, lamp: &Lamp, scratch: &mut Scratch) -> Vec3 {
    scratch.view.look(lamp, from, &mut scratch.pieces);
    times_radiance(lamp, irradiance(from, &scratch.pieces))
}

/// Irradiance [W/m²] from polygons of radiance 1.
fn irradiance(from: &SurfacePoint, pieces: &[Polygon]) -> f64 {
    let normal = from.shading_normal.as_dvec3();
    pieces.iter().map(|piece| piece.irradiance(normal)).sum()
}

/// Irradiance [W/m²] from what it is at radiance 1. A product that overflowed is dropped: no infinity may reach a result.
fn times_radiance(lamp: &Lamp, value: f64) -> Vec3 {
    let irradiance = lamp.radiance * value as f32;
    if irradiance.is_finite() { irradiance } else { Vec3::ZERO }
}
