//! Which faces touch, and the lines that they draw on each other.

use std::time::Duration;

use glam::{DVec3, Vec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
};
use rayon::prelude::*;

use super::Rules;
use crate::scene::load::merge::Faces;

/// Faces whose normals have at least this cosine to each other, or to the other's reverse, may lie in one plane.
const PARALLEL: f64 = 0.99;

/// A line on a face, where another face touches it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) ends: [DVec3; 2],
    /// The face that stands there on the front, so that light on its two sides has nothing to do with each other; none
    /// where the line is the outline of a face in the same plane.
    pub(super) standing: Option<u32>,
}

/// A face in f64.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    pub(super) ids: [u32; 3],
    pub(super) points: [DVec3; 3],
    /// Of unit length.
    pub(super) normal: DVec3,
    /// For each edge, from corner k to the next, the unit vector in the plane that points inside.
    inwards: [DVec3; 3],
}

impl Flat {
    pub(super) fn of(face: u32, faces: &Faces, positions: &[Vec3]) -> Self {
        let (ids, points) = (faces.ids(face), faces.points(face, positions));
        let [a, b, c] = points;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let inwards = [b - a, c - b, a - c].map(|edge| normal.cross(edge).normalize_or_zero());
        Self { ids, points, normal, inwards }
    }

    /// The axis along which it reaches farthest.
    pub(super) fn longest_axis(&self) -> usize {
        let [a, b, c] = self.points;
        (a.max(b).max(c) - a.min(b).min(c)).max_position()
    }

    pub(super) fn longest_edge(&self) -> f64 {
        [0, 1, 2].map(|edge| self.points[edge].distance(self.points[(edge + 1) % 3])).into_iter().fold(0.0, f64::max)
    }

    pub(super) fn height_of(&self, point: DVec3) -> f64 {
        (point - self.points[0]).dot(self.normal)
    }

    /// Distances of a point in the plane from the three edges, positive inside.
    fn inwards(&self, point: DVec3) -> [f64; 3] {
        [0, 1, 2].map(|edge| self.inwards[edge].dot(point - self.points[edge]))
    }

    /// The ends of the edge that two faces have in common.
    fn shared_edge(&self, other: &Self) -> Option<[u32; 2]> {
        let mut shared = self.ids.into_iter().filter(|id| other.ids.contains(id));
        Some([shared.next()?, shared.next()?]).map(|[a, b]| [a.min(b), a.max(b)])
    }

    pub(super) fn contains(&self, point: DVec3) -> bool {
        (0..3).all(|edge| self.inwards[edge].dot(point - self.points[edge]) >= 0.0)
    }

    /// The place of a point on the line of an edge, from 0 to 1 between its ends, if the point is within `reach` of it and
    /// further than that from both ends.
    pub(super) fn place_on_edge(&self, edge: usize, point: DVec3, reach: f64) -> Option<f64> {
        let (from, to) = (self.points[edge], self.points[(edge + 1) % 3]);
        let (along, length) = ((to - from).normalize_or_zero(), from.distance(to));
        let place = (point - from).dot(along);
        let aside = (point - from - place * along).length();
        (aside <= reach && place > reach && place < length - reach).then_some(place / length)
    }

    /// The part of the segment between two points in the plane that lies inside; none if that is no longer than `reach`.
    fn clip(&self, [from, to]: [DVec3; 2], reach: f64) -> Option<[DVec3; 2]> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (start, end) in self.inwards(from).into_iter().zip(self.inwards(to)) {
            if start < 0.0 && end < 0.0 {
                return None;
            }
            if start < 0.0 {
                enter = enter.max(start / (start - end));
            } else if end < 0.0 {
                leave = leave.min(start / (start - end));
            }
        }
        ((leave - enter) * from.distance(to) > reach).then(|| [from.lerp(to, enter), from.lerp(to, leave)])
    }
}

/// What two faces have to do with each other.
enum Meeting {
    Apart,
    /// In one plane with common area, or only with common corners and edges.
    InPlane {
        share_area: bool,
    },
    /// Along a line; for each of the two, whether the other stands on its front there.
    Along {
        line: [DVec3; 2],
        stands: [bool; 2],
    },
}

/// What all faces have to do with each other.
pub(super) struct Meetings {
    /// All faces.
    pub(super) flats: Vec<Flat>,
    /// The lines on each face.
    pub(super) lines: Vec<Vec<Line>>,
    /// Corners of other faces in the same plane that lie on an edge of each face: T-junctions.
    pub(super) corners: Vec<Vec<u32>>,
    /// For each face those in its plane with which it shares area, whichever way they face.
    pub(super) partners: Vec<Vec<u32>>,
    /// Over all faces, one a leaf.
    pub(super) tree: Bvh2,
}

/// What one pair adds.
struct Found {
    pair: [u32; 2],
    lines: [Vec<Line>; 2],
    corners: [Vec<u32>; 2],
    is_in_plane: bool,
    share_area: bool,
    /// The edge that both have, if one stands on the other there.
    at_edge: Option<[u32; 2]>,
}

impl Meetings {
    /// Where surfaces have two sides, what stands on the back of a face counts like what stands on its front. A lamp that
    /// stands on a face does not divide it, nor is it divided: its light is found in closed form while few triangles
    /// lie around it.
    pub(super) fn of(faces: &Faces, positions: &[Vec3], reach: f64, rules: &Rules) -> Self {
        let count = faces.corners.len();
        let flats: Vec<Flat> = (0..count as u32).into_par_iter().map(|face| Flat::of(face, faces, positions)).collect();
        let margin = Vec3A::splat(reach as f32);
        let boxes: Vec<Aabb> = flats
            .par_iter()
            .map(|flat| {
                let around = Aabb::from_points(&flat.points.map(|point| Vec3A::from(point.as_vec3())));
                Aabb::new(around.min - margin, around.max + margin)
            })
            .collect();
        let parameters = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::very_fast_build() };
        let tree = build_bvh2(&boxes, parameters, &mut Duration::default());
        let found: Vec<Found> = (0..count as u32)
            .into_par_iter()
            .with_min_len(256)
            .flat_map_iter(|face| {
                let mut others = Vec::new();
                tree.aabb_traverse(boxes[face as usize], |tree, node| {
                    let node = &tree.nodes[node as usize];
                    let first = node.first_index as usize;
                    let inside = &tree.primitive_indices[first..first + node.prim_count as usize];
                    others.extend(inside.iter().copied().filter(|&other| other > face));
                    true
                });
                others.sort_unstable();
                let flats = &flats;
                others.into_iter().filter_map(move |other| {
                    let found = find(flats, [face, other], reach, rules.two_sided)?;
                    let is_lamp = rules.is_lamp(face, faces) || rules.is_lamp(other, faces);
                    (found.is_in_plane || !is_lamp).then_some(found)
                })
            })
            .collect();
        let mut meetings = Self {
            lines: vec![Vec::new(); count],
            corners: vec![Vec::new(); count],
            partners: vec![Vec::new(); count],
            flats,
            tree,
        };
        let mut at_edges = Vec::new();
        for Found { pair, lines, corners, share_area, at_edge, .. } in found {
            if let Some(edge) = at_edge {
                at_edges.extend((0..2).filter(|&side| !lines[side].is_empty()).map(|side| {
                    let (face, line) = (pair[side], lines[side][0]);
                    (edge, pair[1 - side], face, line)
                }));
                continue;
            }
            for (side, (lines, corners)) in lines.into_iter().zip(corners).enumerate() {
                let face = pair[side] as usize;
                meetings.lines[face].extend(lines);
                meetings.corners[face].extend(corners);
                if share_area {
                    meetings.partners[face].push(pair[1 - side]);
                }
            }
        }
        // Where just two faces meet at an edge, neither parts anything; of three, one may stand between the others.
        at_edges.sort_unstable_by_key(|&(edge, standing, face, _)| (edge, standing, face));
        for several in at_edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)).filter(|all| all.len() > 1)
        {
            several.iter().for_each(|&(.., face, line)| meetings.lines[face as usize].push(line));
        }
        meetings
    }

    pub(super) fn is_empty(&self) -> bool {
        self.lines.iter().all(Vec::is_empty) && self.corners.iter().chain(&self.partners).all(Vec::is_empty)
    }

    /// Moves the corners of faces that share a place with another one, but lie a hair beside its plane, into that plane.
    /// True if any was moved.
    pub(super) fn bring_into_planes(&self, faces: &Faces, positions: &mut [Vec3], reach: f64) -> bool {
        let mut any = false;
        for (face, partners) in self.partners.iter().enumerate() {
            for &partner in partners.iter().filter(|&&partner| partner as usize > face) {
                let plane = Flat::of(face as u32, faces, positions);
                for id in faces.ids(partner) {
                    let position = &mut positions[id as usize];
                    let height = plane.height_of(position.as_dvec3());
                    // Less than this is rounding, and would not get less.
                    let rounding = 4.0 * f64::from(f32::EPSILON * position.abs().max_element());
                    if height.abs() > rounding && height.abs() <= reach && !plane.ids.contains(&id) {
                        *position = (position.as_dvec3() - height * plane.normal).as_vec3();
                        any = true;
                    }
                }
            }
        }
        any
    }
}

fn find(flats: &[Flat], pair: [u32; 2], reach: f64, both_sides: bool) -> Option<Found> {
    let [one, other] = pair.map(|face| &flats[face as usize]);
    let (lines, corners) = Default::default();
    let mut found = Found { pair, lines, corners, is_in_plane: false, share_area: false, at_edge: None };
    match meet([one, other], reach, both_sides) {
        Meeting::Apart => return None,
        Meeting::Along { line, stands } => {
            for side in 0..2 {
                if stands[side] {
                    found.lines[side].push(Line { ends: line, standing: Some(pair[1 - side]) });
                }
            }
            found.at_edge = one.shared_edge(other);
        }
        Meeting::InPlane { share_area } => {
            (found.is_in_plane, found.share_area) = (true, share_area);
            for (side, (here, there)) in [(one, other), (other, one)].into_iter().enumerate() {
                for place in 0..3 {
                    let ends = [there.points[place], there.points[(place + 1) % 3]];
                    let is_on_edge = (0..3).any(|edge| here.place_on_edge(edge, ends[0], reach).is_some());
                    let is_alike = both_sides || here.normal.dot(there.normal) > 0.0;
                    if is_on_edge && is_alike && !here.ids.contains(&there.ids[place]) {
                        found.corners[side].push(there.ids[place]);
                    }
                    if let Some(ends) = here.clip(ends, reach).filter(|_| share_area) {
                        found.lines[side].push(Line { ends, standing: None });
                    }
                }
            }
        }
    }
    let is_something = found.share_area || found.lines.iter().any(|lines| !lines.is_empty());
    (is_something || found.corners.iter().any(|corners| !corners.is_empty())).then_some(found)
}

fn meet([one, other]: [&Flat; 2], reach: f64, both_sides: bool) -> Meeting {
    let heights = |of: &Flat, above: &Flat| {
        of.points.map(|point| above.height_of(point)).map(|height| if height.abs() <= reach { 0.0 } else { height })
    };
    let is_aside = |[a, b, c]: [f64; 3]| (a > 0.0 && b > 0.0 && c > 0.0) || (a < 0.0 && b < 0.0 && c < 0.0);
    let of_other = heights(other, one);
    if is_aside(of_other) {
        return Meeting::Apart;
    }
    let of_one = heights(one, other);
    if is_aside(of_one) {
        return Meeting::Apart;
    }
    if of_other == [0.0; 3] || of_one == [0.0; 3] {
        return if one.normal.dot(other.normal).abs() < PARALLEL {
            Meeting::Apart
        } else {
            in_plane(one, other, reach)
        };
    }
    // Where each crosses the other's plane; the line on both is what these have in common.
    let (Some(on_one), Some(on_other)) = (crossing(other, of_other), crossing(one, of_one)) else {
        return Meeting::Apart;
    };
    let along = one.normal.cross(other.normal).normalize_or_zero();
    let sorted = |ends: [DVec3; 2]| if along.dot(ends[0]) <= along.dot(ends[1]) { ends } else { [ends[1], ends[0]] };
    let ([a, b], [c, d]) = (sorted(on_one), sorted(on_other));
    let from = if along.dot(a) >= along.dot(c) { a } else { c };
    let to = if along.dot(b) <= along.dot(d) { b } else { d };
    if along.dot(to - from) <= reach {
        return Meeting::Apart;
    }
    let stands = |heights: [f64; 3]| heights.iter().any(|&height| height > 0.0 || (both_sides && height < 0.0));
    Meeting::Along { line: [from, to], stands: [stands(of_other), stands(of_one)] }
}

/// Where a face crosses a plane over which its corners have these heights; none if it only touches it with a corner.
fn crossing(face: &Flat, heights: [f64; 3]) -> Option<[DVec3; 2]> {
    let mut ends = Vec::with_capacity(3);
    for place in 0..3 {
        let next = (place + 1) % 3;
        let (here, there) = (heights[place], heights[next]);
        if here == 0.0 {
            ends.push(face.points[place]);
        } else if here * there < 0.0 {
            // From the lower end to the higher one, so that both faces at an edge find the same point.
            let [low, high] = if face.ids[place] < face.ids[next] { [place, next] } else { [next, place] };
            let part = heights[low] / (heights[low] - heights[high]);
            ends.push(face.points[low].lerp(face.points[high], part));
        }
    }
    <[DVec3; 2]>::try_from(ends).ok()
}

fn in_plane(one: &Flat, other: &Flat, reach: f64) -> Meeting {
    // What of one face lies inside the other (Sutherland and Hodgman 1974).
    let mut inside = other.points.to_vec();
    for edge in 0..3 {
        let distances: Vec<f64> = inside.iter().map(|&point| one.inwards(point)[edge]).collect();
        let mut kept = Vec::with_capacity(inside.len() + 1);
        for place in 0..inside.len() {
            let next = (place + 1) % inside.len();
            let (here, there) = (distances[place], distances[next]);
            if here >= 0.0 {
                kept.push(inside[place]);
            }
            if here * there < 0.0 {
                kept.push(inside[place].lerp(inside[next], here / (here - there)));
            }
        }
        inside = kept;
    }
    let next = |place: usize| inside[(place + 1) % inside.len()];
    let doubled: DVec3 = (0..inside.len()).map(|place| inside[place].cross(next(place))).sum();
    let around: f64 = (0..inside.len()).map(|place| inside[place].distance(next(place))).sum();
    // A strip as narrow as what counts as touching is none.
    Meeting::InPlane { share_area: doubled.length() > 2.0 * reach * around }
}
