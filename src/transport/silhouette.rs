//! A lamp as it is seen from a point: which facets face it, and the convex polygons that they make together.
//!
//! From a point in front of some facets, the body of the lamp hides none of these: the segment to a facet lies in front of
//! its plane. So what is seen of them is what their outline encloses, and another surface blocks where it lies in front of
//! any of their planes.

use glam::DVec3;

use super::{
    lamps::{Facet, Lamp, MOST_FACET_CORNERS, NONE},
    polygon::Polygon,
};
use crate::trace::{Shaft, SurfacePoint};

/// What lies nearer to the light's surface than this, in local units, lies in it and blocks nothing.
const IN_LIGHT: f64 = 1e-6;

/// An outline that turns outwards by more than this, as a sine, is not taken for convex.
const STRAIGHT: f64 = 1e-4;

/// What is known of a lamp from one point, and memory that is used again from point to point. All places are relative to
/// the point.
#[derive(Default)]
pub(super) struct View {
    is_facing: Vec<bool>,
    /// Planes of the facets that face the point: `normal · p >= offset` in front.
    facing: Vec<Facet>,
    /// The outline, counter-clockwise; empty where it is not one convex polygon.
    outline: Vec<DVec3>,
    /// The next corner of the outline from each corner.
    next: Vec<u32>,
    /// The sum of facing areas times normals: all that is seen lies opposite to it.
    towards_point: DVec3,
    /// Nothing that is seen lies further along `-towards_point`.
    end: f64,
}

impl View {
    /// Looks at a lamp: `pieces` become the convex polygons that are seen of it above the point's horizon with nothing
    /// between, each once.
    pub(super) fn look(&mut self, lamp: &Lamp, from: &SurfacePoint, pieces: &mut Vec<Polygon>) {
        pieces.clear();
        self.facing.clear();
        self.outline.clear();
        let eye = from.origin.as_dvec3();
        let height = from.geometric_normal.as_dvec3().dot(lamp.centre - eye);
        if height <= -lamp.radius {
            return;
        }
        self.is_facing.clear();
        for facet in &lamp.facets {
            let offset = facet.offset - facet.normal.dot(eye);
            self.is_facing.push(offset < 0.0);
            if offset < 0.0 {
                self.facing.push(Facet { offset, ..*facet });
            }
        }
        let mut add = |corners: &mut dyn Iterator<Item = DVec3>| {
            let piece = above_horizon(from, Polygon::new(corners));
            if !piece.is_empty() {
                pieces.push(piece);
            }
        };
        if self.facing.len() > 1 && self.find_outline(lamp, eye) {
            // A fan of polygons, each with room for the corners that cuts add.
            let last = self.outline.len() - 1;
            for start in (1..last).step_by(MOST_FACET_CORNERS - 2) {
                let end = last.min(start + MOST_FACET_CORNERS - 2);
                add(&mut std::iter::once(self.outline[0]).chain(self.outline[start..=end].iter().copied()));
            }
        } else {
            for (corners, _) in lamp.corners.iter().zip(&self.is_facing).filter(|(_, is_facing)| **is_facing) {
                add(&mut corners.iter().map(|&corner| lamp.positions[corner as usize] - eye));
            }
        }
    }

    /// Chains the edges between what faces the point and what does not; false if that is not one convex polygon.
    fn find_outline(&mut self, lamp: &Lamp, eye: DVec3) -> bool {
        self.next.clear();
        self.next.resize(lamp.positions.len(), NONE);
        let (mut first, mut count) = (NONE, 0);
        for edge in &lamp.edges {
            let [one, other] = edge.facets.map(|facet| self.is_facing.get(facet as usize) == Some(&true));
            if one != other {
                let [start, end] = if one { edge.ends } else { [edge.ends[1], edge.ends[0]] };
                if self.next[start as usize] != NONE {
                    return false;
                }
                self.next[start as usize] = end;
                (first, count) = (start, count + 1);
            }
        }
        let mut corner = first;
        while corner != NONE && self.outline.len() < count {
            self.outline.push(lamp.positions[corner as usize] - eye);
            corner = self.next[corner as usize];
        }
        let is_one = corner == first && self.outline.len() == count && count > 2;
        if !is_one || !is_convex(&self.outline) {
            self.outline.clear();
        }
        !self.outline.is_empty()
    }

    /// A shaft around all of the lamp that is seen.
    pub(super) fn shaft(&mut self, lamp: &Lamp, from: &SurfacePoint) -> Shaft {
        let eye = from.origin.as_dvec3();
        let place = |corner: &u32| lamp.positions[*corner as usize] - eye;
        let seen = || {
            let facing = lamp.corners.iter().zip(&self.is_facing).filter(|(_, is_facing)| **is_facing);
            facing.flat_map(|(corners, _)| corners).map(place)
        };
        self.towards_point = match self.facing[..] {
            [facet] => facet.normal,
            _ => self.facing.iter().map(|facet| facet.area * facet.normal).sum::<DVec3>().normalize_or_zero(),
        };
        let along = |place: DVec3| self.towards_point.dot(place);
        self.end = seen().map(along).fold(f64::INFINITY, f64::min);
        let mut polygon = Polygon::NONE;
        if self.facing.len() == 1 {
            polygon = Polygon::new(seen());
        }
        let mut sides = [DVec3::ZERO; Shaft::MOST_SIDES];
        if (3..=sides.len()).contains(&polygon.corners().len()) {
            polygon
                .edges()
                .zip(&mut sides)
                .for_each(|((start, end), side)| *side = start.cross(end).normalize_or_zero());
        } else if self.outline.is_empty() {
            sides = pyramid(self.towards_point, seen());
        } else {
            sides = pyramid(self.towards_point, self.outline.iter().copied());
        }
        let end = (eye + self.end * self.towards_point).as_vec3();
        let sides = sides.map(DVec3::as_vec3);
        Shaft::new(from.origin, from.geometric_normal, sides, (end, self.towards_point.as_vec3()))
    }

    /// What of an occluder can hide the lamp, and the part of this that lies behind all of it; `None` if they have more
    /// corners than there is room for. Of lamps of one facet nothing is left behind them.
    pub(super) fn in_front(&self, occluder: &Polygon) -> Option<(Polygon, Polygon)> {
        let (mut occluder, _) = occluder.split(self.towards_point, self.end + IN_LIGHT);
        if self.facing.len() == 1 || occluder.is_empty() || self.is_before_a_facet(&occluder) {
            return Some((occluder, Polygon::NONE));
        }
        for (start, end) in edges(&self.outline) {
            // What is left beside the outline does no harm.
            if !occluder.is_full() {
                (occluder, _) = occluder.split(end.cross(start), 0.0);
            }
        }
        if occluder.is_empty() || self.is_before_a_facet(&occluder) {
            return Some((occluder, Polygon::NONE));
        }
        let mut behind = occluder;
        for facet in &self.facing {
            let is_before = |corner: &DVec3| facet.normal.dot(*corner) > facet.offset + IN_LIGHT;
            if behind.corners().iter().any(is_before) {
                if behind.is_full() {
                    return None;
                }
                (_, behind) = behind.split(facet.normal, facet.offset + IN_LIGHT);
            }
        }
        Some((occluder, behind))
    }

    /// True if all of a polygon lies in front of one facet that faces the point.
    fn is_before_a_facet(&self, polygon: &Polygon) -> bool {
        let is_before = |facet: &Facet| {
            polygon.corners().iter().all(|corner| facet.normal.dot(*corner) >= facet.offset + 0.5 * IN_LIGHT)
        };
        self.facing.iter().any(is_before)
    }
}

/// Above both planes of a surface point, its own and the one of its shading normal.
fn above_horizon(from: &SurfacePoint, polygon: Polygon) -> Polygon {
    let (polygon, _) = polygon.split(from.geometric_normal.as_dvec3(), 0.0);
    if from.shading_normal == from.geometric_normal {
        return polygon;
    }
    polygon.split(from.shading_normal.as_dvec3(), 0.0).0
}

fn edges(corners: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    (0..corners.len()).map(|index| (corners[index], corners[(index + 1) % corners.len()]))
}

/// True if a closed line, counter-clockwise as it is seen from the origin, turns to its inner side at every corner.
fn is_convex(corners: &[DVec3]) -> bool {
    let next = |index: usize| corners[(index + 2) % corners.len()];
    edges(corners).enumerate().all(|(index, (start, end))| {
        let inwards = end.cross(start).normalize_or_zero();
        inwards.dot(next(index)) >= -STRAIGHT * next(index).distance(end)
    })
}

/// Outward normals of a pyramid around places that all lie opposite to `axis` from the origin: a rectangle around their
/// central projection, along its longer extent.
fn pyramid(axis: DVec3, places: impl Iterator<Item = DVec3> + Clone) -> [DVec3; 4] {
    let (mut across, mut along) = axis.any_orthonormal_pair();
    let project = |place: DVec3, side: DVec3| place.dot(side) / -place.dot(axis);
    let count = places.clone().count().max(1) as f64;
    let mean = |side: DVec3| places.clone().map(|place| project(place, side)).sum::<f64>() / count;
    let (x, y) = (mean(across), mean(along));
    let offsets = places.clone().map(|place| (project(place, across) - x, project(place, along) - y));
    let squared = |(x, y): &(f64, f64)| x * x + y * y;
    if let Some((x, y)) = offsets.max_by(|a, b| squared(a).total_cmp(&squared(b))) {
        let length = x.hypot(y);
        if length > 0.0 {
            (across, along) = ((x * across + y * along) / length, (x * along - y * across) / length);
        }
    }
    let range = |side: DVec3| {
        let projected = places.clone().map(|place| project(place, side));
        projected.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let ((left, right), (low, high)) = (range(across), range(along));
    // A place p lies within where p · side <= high (-p · axis).
    [across + right * axis, -across - left * axis, along + high * axis, -along - low * axis]
        .map(DVec3::normalize_or_zero)
}
