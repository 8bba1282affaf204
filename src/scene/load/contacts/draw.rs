//! What is drawn on each face: the points on its edges, and the lines inside, from point to point.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation, handles::FixedVertexHandle};

use super::{
    meet::{Flat, Line, Meetings},
    points::{Points, edge_key},
};
use crate::scene::load::merge::Faces;

/// Faces with no longer edge than so many times the reach, some 1/100 of the scene, are not cut by what stands on them: their
/// own size says how far light is spread across. Nor does what stands along so short a line cut any: the slivers around the
/// feet of a thousand small things would cost more than they tell.
const SMALL: f64 = 8000.0;

/// The parts of a face may miss or double so much of its area; else it stays whole.
const LARGEST_GAP: f64 = 1e-4;

/// What is drawn on one face.
pub(super) struct Drawing {
    /// For each edge its ends and the points on it, in order.
    outline: [Vec<u32>; 3],
    /// Between points, crossing no others.
    segments: Vec<[u32; 2]>,
    /// The segments along which a face stands on this one, with that face.
    pub(super) standing: Vec<([u32; 2], u32)>,
}

/// A line between two positions.
#[derive(Clone, Copy)]
struct DrawnLine {
    ids: [u32; 2],
    standing: Option<u32>,
}

/// Corners of a part of a face: positions, and their barycentric coordinates in the face.
pub(super) type Part = ([u32; 3], [DVec2; 3]);

/// A vertex of a triangulation.
#[derive(Clone, Copy)]
struct Corner {
    point: Point2<f64>,
    id: u32,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.point
    }
}

/// What is drawn on each face, if anything is.
pub(super) fn drawings(
    faces: &Faces,
    meetings: &Meetings,
    positions: &mut Vec<Vec3>,
    points: &mut Points,
) -> Vec<Option<Drawing>> {
    let lines = drawn_lines(faces, meetings, positions, points);
    let crossings: Vec<Vec<DVec3>> =
        lines.par_iter().zip(&meetings.flats).map(|(lines, flat)| crossings(lines, flat, positions)).collect();
    let mut inside: Vec<Vec<u32>> = vec![Vec::new(); lines.len()];
    for (face, crossings) in crossings.into_iter().enumerate() {
        for crossing in crossings {
            let id = points.on_face(&meetings.flats[face], crossing, positions);
            points.put_on_edge(&meetings.flats[face], id, crossing);
            inside[face].push(id);
        }
    }
    points.sort();
    let (points, positions): (&Points, &[Vec3]) = (points, positions);
    let draw = |((lines, flat), mut inside): ((&Vec<DrawnLine>, &Flat), Vec<u32>)| {
        let ends = [0, 1, 2].map(|edge| [flat.ids[edge], flat.ids[(edge + 1) % 3]]);
        if lines.is_empty() && !ends.iter().any(|ends| points.is_cut(*ends)) {
            return None;
        }
        let outline = ends.map(|ends| points.along(ends));
        inside.extend(lines.iter().flat_map(|line| line.ids).chain(outline.iter().flatten().copied()));
        inside.sort_unstable();
        inside.dedup();
        let (mut segments, mut standing) = (Vec::new(), Vec::new());
        for line in lines {
            let on_line = on_line(line.ids, &inside, positions, 2.0 * points.reach);
            for ends in on_line.windows(2).map(|ends| edge_key(ends[0], ends[1])) {
                segments.push(ends);
                standing.extend(line.standing.map(|face| (ends, face)));
            }
        }
        segments.sort_unstable();
        segments.dedup();
        Some(Drawing { outline, segments, standing })
    };
    lines.par_iter().zip(&meetings.flats).zip(inside).map(draw).collect()
}

/// Where lines on a face cross inside of both.
fn crossings(lines: &[DrawnLine], flat: &Flat, positions: &[Vec3]) -> Vec<DVec3> {
    let ends = |line: &DrawnLine| line.ids.map(|id| positions[id as usize].as_dvec3());
    let mut found = Vec::new();
    // In the order of their beginnings along one axis, each is compared with those that begin before it ends.
    let axis = flat.longest_axis();
    let mut sorted: Vec<[DVec3; 2]> = lines.iter().map(ends).collect();
    sorted.iter_mut().for_each(|[from, to]| {
        if from[axis] > to[axis] {
            std::mem::swap(from, to);
        }
    });
    sorted.sort_by(|one, other| one[0][axis].total_cmp(&other[0][axis]));
    for (index, &[a, b]) in sorted.iter().enumerate() {
        for &[c, d] in sorted[index + 1..].iter().take_while(|other| other[0][axis] <= b[axis]) {
            let side = |from: DVec3, to: DVec3, point: DVec3| (to - from).cross(point - from).dot(flat.normal);
            let (of_c, of_d) = (side(a, b, c), side(a, b, d));
            let (of_a, of_b) = (side(c, d, a), side(c, d, b));
            if of_c * of_d < 0.0 && of_a * of_b < 0.0 {
                found.push(a.lerp(b, of_a / (of_a - of_b)));
            }
        }
    }
    found
}

/// The positions within reach of the line between two of them, in order.
fn on_line(ends: [u32; 2], ids: &[u32], positions: &[Vec3], reach: f64) -> Vec<u32> {
    let [from, to] = ends.map(|id| positions[id as usize].as_dvec3());
    let (along, length) = ((to - from).normalize_or_zero(), from.distance(to));
    let mut found: Vec<(f64, u32)> = Vec::new();
    for &id in ids {
        let offset = positions[id as usize].as_dvec3() - from;
        let place = offset.dot(along);
        if ends.contains(&id) {
            found.push((if id == ends[0] { 0.0 } else { length }, id));
        } else if place > 0.0 && place < length && (offset - place * along).length() <= reach {
            found.push((place, id));
        }
    }
    found.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    found.into_iter().map(|(_, id)| id).collect()
}

/// The lines on each face between positions, which are made where there are none; the points on edges are entered, too.
fn drawn_lines(
    faces: &Faces,
    meetings: &Meetings,
    positions: &mut Vec<Vec3>,
    points: &mut Points,
) -> Vec<Vec<DrawnLine>> {
    let count = faces.corners.len();
    let is_met = |face: usize| !meetings.lines[face].is_empty() || !meetings.corners[face].is_empty();
    for flat in (0..count).filter(|&face| is_met(face)).map(|face| &meetings.flats[face]) {
        flat.ids.into_iter().zip(flat.points).for_each(|(id, point)| points.enter(id, point));
    }
    let mut lines: Vec<Vec<DrawnLine>> = vec![Vec::new(); count];
    // Those that run along an edge, with the edge: they part a face from a neighbour, or nothing.
    let mut along_edges: Vec<(u32, DrawnLine, [u32; 2])> = Vec::new();
    for (face, flat) in meetings.flats.iter().enumerate() {
        let small = SMALL * points.reach;
        for &Line { ends, standing } in &meetings.lines[face] {
            if standing.is_some() && (flat.longest_edge() < small || ends[0].distance(ends[1]) < small) {
                continue;
            }
            let ids = ends.map(|end| points.on_face(flat, end, positions));
            let line = DrawnLine { ids, standing };
            let edge = standing.and_then(|_| points.edge_along(flat, ids, positions));
            match edge {
                _ if ids[0] == ids[1] => {}
                Some(edge) => along_edges.push((face as u32, line, edge)),
                None => lines[face].push(line),
            }
        }
    }
    let mut around: HashMap<[u32; 2], Vec<u32>> = along_edges.iter().map(|(.., edge)| (*edge, Vec::new())).collect();
    let asked = if around.is_empty() { 0 } else { count as u32 };
    for face in 0..asked {
        let ids = faces.ids(face);
        for edge in 0..3 {
            around.entry(edge_key(ids[edge], ids[(edge + 1) % 3])).and_modify(|faces| faces.push(face));
        }
    }
    for (face, line, edge) in along_edges {
        let shaded = |face: u32| edge.map(|id| faces.corners[face as usize].iter().find(|corner| corner.0 == id));
        if around[&edge].iter().any(|&other| other != face && shaded(other) == shaded(face)) {
            lines[face as usize].push(line);
        }
    }
    for (face, flat) in meetings.flats.iter().enumerate() {
        let ends = lines[face].iter().flat_map(|line| line.ids);
        for id in ends.chain(meetings.corners[face].iter().copied()).filter(|id| !flat.ids.contains(id)) {
            points.put_on_edge(flat, id, positions[id as usize].as_dvec3());
        }
    }
    lines
}

impl Drawing {
    /// The constrained Delaunay triangulation of a face with the points on its edges and the lines inside. `None` if
    /// rounding makes something else of it.
    pub(super) fn parts(&self, flat: &Flat, positions: &[Vec3]) -> Option<Vec<Part>> {
        let [a, b, c] = flat.points;
        let along = (b - a).try_normalize()?;
        let across = flat.normal.cross(along);
        let flatten = |point: DVec3| DVec2::new((point - a).dot(along), (point - a).dot(across));
        let mut drawing = ConstrainedDelaunayTriangulation::<Corner>::new();
        let mut handles: HashMap<u32, FixedVertexHandle> = HashMap::new();
        for &id in self.outline.iter().flatten().chain(self.segments.iter().flatten()) {
            if let std::collections::hash_map::Entry::Vacant(entry) = handles.entry(id) {
                let place = flatten(positions[id as usize].as_dvec3());
                let point = spade::mitigate_underflow(Point2::new(place.x, place.y));
                entry.insert(drawing.insert(Corner { point, id }).ok()?);
            }
        }
        let outline = self.outline.iter().flat_map(|edge| edge.windows(2)).map(|ends| [ends[0], ends[1]]);
        for ends in outline.chain(self.segments.iter().copied()) {
            let [from, to] = ends.map(|id| handles[&id]);
            // Points that were brought together may let lines cross by a hair: then the earlier one stays.
            if from != to && drawing.can_add_constraint(from, to) {
                drawing.add_constraint(from, to);
            }
        }
        let (b, c) = (flatten(b), flatten(c));
        let place = |id: u32, point: DVec2| match flat.ids.iter().position(|&corner| corner == id) {
            Some(corner) => [DVec2::ZERO, DVec2::X, DVec2::Y][corner],
            None => DVec2::new(point.perp_dot(c), b.perp_dot(point)) / b.perp_dot(c),
        };
        let parts = drawing.inner_faces().map(|triangle| {
            let corners = triangle.vertices().map(|vertex| *vertex.data());
            let places = corners.map(|corner| place(corner.id, DVec2::new(corner.point.x, corner.point.y)));
            (corners.map(|corner| corner.id), places)
        });
        let parts = self.covering(parts.collect(), flat, positions)?;
        let fixed: HashSet<[u32; 2]> = self
            .outline
            .iter()
            .flat_map(|edge| edge.windows(2))
            .map(|ends| edge_key(ends[0], ends[1]))
            .chain(self.segments.iter().copied())
            .collect();
        let places = handles.iter().map(|(&id, &handle)| {
            let point = drawing.vertex(handle).position();
            (id, DVec2::new(point.x, point.y))
        });
        Some(with_settled_diagonals(parts, &fixed, &places.collect()))
    }

    /// The parts without those that have no area or lie beside the outline; `None` if the rest is not the face.
    fn covering(&self, mut parts: Vec<Part>, flat: &Flat, positions: &[Vec3]) -> Option<Vec<Part>> {
        let doubled = |ids: [u32; 3]| {
            let [a, b, c] = ids.map(|id| positions[id as usize].as_dvec3());
            (b - a).cross(c - a)
        };
        let expected = doubled(flat.ids).length();
        let mut covered = 0.0;
        parts.retain(|(ids, _)| {
            let is_beside = self.outline.iter().any(|edge| ids.iter().all(|id| edge.contains(id)));
            let area = doubled(*ids);
            let is_part = !is_beside && area.as_vec3() != Vec3::ZERO;
            covered += if is_part { area.dot(flat.normal) } else { 0.0 };
            is_part
        });
        ((covered - expected).abs() <= LARGEST_GAP * expected && !parts.is_empty()).then_some(parts)
    }
}

/// How near to half a turn two opposite angles of a quadrangle must add up for its diagonal to be chosen by numbers [rad].
const ON_ONE_CIRCLE: f64 = 1e-3;

/// Where four points lie on one circle, rounding decides which diagonal is Delaunay's. There the one from the lowest
/// position is taken, and parts are put in the order of their positions: so the same faces of another size or in another
/// place get the same parts.
fn with_settled_diagonals(mut parts: Vec<Part>, fixed: &HashSet<[u32; 2]>, places: &HashMap<u32, DVec2>) -> Vec<Part> {
    // Each change brings a lower number to a diagonal, so this ends; the bound is for rounding.
    for _ in 0..parts.len() {
        let mut at_edges: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for (index, ([a, b, c], _)) in parts.iter().enumerate() {
            for ends in [edge_key(*a, *b), edge_key(*b, *c), edge_key(*c, *a)] {
                at_edges.entry(ends).or_default().push(index);
            }
        }
        let mut is_changed = vec![false; parts.len()];
        for (ends, around) in at_edges {
            let &[one, other] = &around[..] else { continue };
            if fixed.contains(&ends) || is_changed[one] || is_changed[other] {
                continue;
            }
            if let Some(turned) = with_other_diagonal(&parts[one], &parts[other], ends, places) {
                [parts[one], parts[other]] = turned;
                (is_changed[one], is_changed[other]) = (true, true);
            }
        }
        if !is_changed.contains(&true) {
            break;
        }
    }
    for (ids, places) in &mut parts {
        let first = (0..3).min_by_key(|&place| ids[place]).unwrap_or(0);
        ids.rotate_left(first);
        places.rotate_left(first);
    }
    parts.sort_by_key(|(ids, _)| *ids);
    parts
}

/// Two parts with a common edge as the two on either side of their quadrangle's other diagonal, if that is as good and has
/// the lowest position.
fn with_other_diagonal(one: &Part, other: &Part, ends: [u32; 2], places: &HashMap<u32, DVec2>) -> Option<[Part; 2]> {
    // `one` runs a, b, c with the edge from a to b, `other` b, a, d.
    let turned = |(ids, inside): &Part| {
        let apex = ids.iter().position(|id| !ends.contains(id))?;
        let at = |step: usize| (ids[(apex + step) % 3], inside[(apex + step) % 3]);
        Some([at(1), at(2), at(0)])
    };
    let ([a, b, c], [.., d]) = (turned(one)?, turned(other)?);
    if c.0.min(d.0) > ends[0] {
        return None;
    }
    let [at_a, at_b, at_c, at_d] = [a, b, c, d].map(|(id, _)| places.get(&id).copied());
    let (at_a, at_b, at_c, at_d) = (at_a?, at_b?, at_c?, at_d?);
    let angle = |at: DVec2, to: DVec2, from: DVec2| (to - at).angle_to(from - at).abs();
    let opposite = angle(at_c, at_a, at_b) + angle(at_d, at_a, at_b);
    let is_convex = |at: DVec2, from: DVec2, to: DVec2| (at - from).perp_dot(to - at) > 0.0;
    let is_tie = (opposite - std::f64::consts::PI).abs() < ON_ONE_CIRCLE;
    let stays_convex = is_convex(at_a, at_c, at_d) && is_convex(at_b, at_d, at_c);
    let part = |corners: [(u32, DVec2); 3]| (corners.map(|corner| corner.0), corners.map(|corner| corner.1));
    (is_tie && stays_convex).then(|| [part([c, a, d]), part([d, b, c])])
}
