//! Faces cut along the lines on them.
//!
//! Points that lie within reach of each other are one, on all faces; points on an edge are points of every face that has
//! the edge. So faces that met edge to edge still do, and no ray passes between their pieces.

use std::collections::{HashMap, hash_map::Entry};

use glam::{DVec2, DVec3, I64Vec3, Vec2, Vec3};
use rayon::prelude::*;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation, handles::FixedVertexHandle};

use super::meet::{Flat, Line, Meetings};
use crate::scene::{load::merge::Faces, mesh::interpolate};

/// The pieces of a face may miss or double so much of its area; else it stays whole.
const LARGEST_GAP: f64 = 1e-4;

/// Faces with no longer edge than so many times the reach, some 1/300 of the scene, are not cut by what stands on them:
/// their own size says how far light is spread across.
const SMALL: f64 = 2700.0;

/// A part of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) face: u32,
    /// Positions of its corners.
    pub(super) ids: [u32; 3],
    /// Barycentric coordinates of the corners in the face.
    places: [DVec2; 3],
}

/// All faces in pieces, in the order of the faces.
pub(super) struct Cuts {
    pub(super) pieces: Vec<Piece>,
    /// For each face: was it cut along something that stands on it.
    pub(super) is_divided: Vec<bool>,
    /// For the edges, by the positions of their ends, along which something stands on a face: the face, and what stands.
    pub(super) standing: HashMap<[u32; 2], Vec<[u32; 2]>>,
    points: Points,
}

/// The points that faces are cut at.
struct Points {
    reach: f64,
    cells: HashMap<I64Vec3, Vec<u32>>,
    /// For each edge that has points on it, by the positions of its ends, lower first: those points and where they lie on
    /// the way, in order.
    on_edges: HashMap<[u32; 2], Vec<(f64, u32)>>,
}

/// A vertex of a triangulation: a position, or a point where two lines cross that has none yet.
#[derive(Clone, Copy)]
struct Corner {
    point: Point2<f64>,
    id: Option<u32>,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.point
    }
}

pub(super) fn edge_key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Points {
    fn cell(&self, point: DVec3) -> I64Vec3 {
        (point / (4.0 * self.reach)).floor().as_i64vec3()
    }

    fn enter(&mut self, id: u32, point: DVec3) {
        let cell = self.cells.entry((point / (4.0 * self.reach)).floor().as_i64vec3()).or_default();
        if !cell.contains(&id) {
            cell.push(id);
        }
    }

    /// The position at a point: the nearest one in reach, or a new one.
    fn at(&mut self, point: DVec3, positions: &mut Vec<Vec3>) -> u32 {
        let (low, high) = (self.cell(point - self.reach), self.cell(point + self.reach));
        let mut nearest = (1.5 * self.reach, None);
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    for &id in self.cells.get(&I64Vec3::new(x, y, z)).map_or(&[][..], Vec::as_slice) {
                        let distance = positions[id as usize].as_dvec3().distance(point);
                        if distance < nearest.0 || (distance == nearest.0 && nearest.1 > Some(id)) {
                            nearest = (distance, Some(id));
                        }
                    }
                }
            }
        }
        nearest.1.unwrap_or_else(|| {
            positions.push(point.as_vec3() + Vec3::ZERO);
            let id = positions.len() as u32 - 1;
            self.enter(id, point);
            id
        })
    }

    /// Puts a position on an edge of a face, if it lies on one.
    fn put_on_edge(&mut self, flat: &Flat, id: u32, point: DVec3) {
        for edge in 0..3 {
            let [from, to] = [flat.ids[edge], flat.ids[(edge + 1) % 3]];
            if let Some(place) = flat.place_on_edge(edge, point, 2.0 * self.reach) {
                let on_edge = self.on_edges.entry(edge_key(from, to)).or_default();
                if on_edge.iter().all(|(_, other)| *other != id) {
                    on_edge.push((if from < to { place } else { 1.0 - place }, id));
                }
            }
        }
    }

    /// The edge of a face that a line runs along, if it does.
    fn edge_along(&self, flat: &Flat, ids: [u32; 2], positions: &[Vec3]) -> Option<[u32; 2]> {
        (0..3).map(|edge| (edge, [flat.ids[edge], flat.ids[(edge + 1) % 3]])).find_map(|(edge, ends)| {
            let is_on = |id: u32| {
                ends.contains(&id)
                    || flat.place_on_edge(edge, positions[id as usize].as_dvec3(), 2.0 * self.reach).is_some()
            };
            (is_on(ids[0]) && is_on(ids[1])).then(|| edge_key(ends[0], ends[1]))
        })
    }

    fn is_cut(&self, [from, to]: [u32; 2]) -> bool {
        self.on_edges.contains_key(&edge_key(from, to))
    }

    /// The positions along an edge from one of its ends to the other.
    fn along(&self, [from, to]: [u32; 2]) -> Vec<u32> {
        let between = self.on_edges.get(&edge_key(from, to)).map_or(&[][..], Vec::as_slice);
        let mut ids = vec![from.min(to)];
        ids.extend(between.iter().map(|(_, id)| *id));
        ids.push(from.max(to));
        if from > to {
            ids.reverse();
        }
        ids
    }
}

/// What is drawn on one face.
struct Drawing<'a> {
    flat: &'a Flat,
    /// For each edge its ends and the points on it, in order.
    outline: [Vec<u32>; 3],
    lines: &'a [DrawnLine],
}

/// A line between two positions.
#[derive(Clone, Copy)]
struct DrawnLine {
    ids: [u32; 2],
    standing: Option<u32>,
}

/// A corner of a piece: where it is, if it is one of the positions, and its barycentric coordinates in the face.
type DrawnCorner = (Option<u32>, DVec3, DVec2);

impl Cuts {
    pub(super) fn of(faces: &Faces, meetings: &Meetings, positions: &mut Vec<Vec3>, reach: f64) -> Self {
        let count = faces.corners.len();
        let mut points = Points { reach, cells: HashMap::new(), on_edges: HashMap::new() };
        let lines = drawn_lines(faces, meetings, positions, &mut points);
        for on_edge in points.on_edges.values_mut() {
            on_edge.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        }
        let drawings: Vec<Option<Drawing>> = (0..count)
            .into_par_iter()
            .with_min_len(1024)
            .map(|face| {
                let flat = &meetings.flats[face];
                let ends = |edge: usize| [flat.ids[edge], flat.ids[(edge + 1) % 3]];
                let is_cut = !lines[face].is_empty() || (0..3).any(|edge| points.is_cut(ends(edge)));
                is_cut.then(|| Drawing {
                    flat,
                    outline: [0, 1, 2].map(|edge| points.along(ends(edge))),
                    lines: &lines[face],
                })
            })
            .collect();
        let known: &[Vec3] = positions;
        let drawn: Vec<Option<Vec<[DrawnCorner; 3]>>> =
            drawings.par_iter().map(|drawing| drawing.as_ref().and_then(|drawing| drawing.triangles(known))).collect();
        let (is_divided, standing) = (vec![false; count], HashMap::new());
        let mut cuts = Self { pieces: Vec::with_capacity(count), is_divided, standing, points };
        for (face, (drawing, triangles)) in drawings.iter().zip(drawn).enumerate() {
            let whole =
                Piece { face: face as u32, ids: meetings.flats[face].ids, places: [DVec2::ZERO, DVec2::X, DVec2::Y] };
            let first = cuts.pieces.len();
            let parts = drawing.as_ref().zip(triangles).and_then(|(drawing, triangles)| {
                let named = |corners: [DrawnCorner; 3]| {
                    let ids = corners.map(|(id, point, _)| id.unwrap_or_else(|| cuts.points.at(point, positions)));
                    Piece { face: face as u32, ids, places: corners.map(|(.., place)| place) }
                };
                let parts = triangles.into_iter().map(named).collect();
                drawing.covering(parts, positions)
            });
            match parts {
                Some(parts) => cuts.pieces.extend(parts),
                None => cuts.pieces.push(whole),
            }
            if let Some(drawing) = drawing {
                cuts.note_standing(first, drawing.lines, positions);
            }
        }
        cuts
    }

    /// Notes the edges of the last face's pieces along which something stands on it.
    fn note_standing(&mut self, first: usize, lines: &[DrawnLine], positions: &[Vec3]) {
        let point = |id: u32| positions[id as usize].as_dvec3();
        let standing: Vec<(u32, [DVec3; 2])> =
            lines.iter().filter_map(|line| Some((line.standing?, line.ids.map(point)))).collect();
        let is_on = |point: DVec3, [from, to]: [DVec3; 2]| {
            let (along, length) = ((to - from).normalize_or_zero(), from.distance(to));
            let place = (point - from).dot(along).clamp(0.0, length);
            point.distance(from + place * along) <= 3.0 * self.points.reach
        };
        for piece in &self.pieces[first..] {
            self.is_divided[piece.face as usize] |= !standing.is_empty() && self.pieces.len() > first + 1;
            for edge in 0..3 {
                let [a, b] = [piece.ids[edge], piece.ids[(edge + 1) % 3]];
                let [from, to] = [a, b].map(point);
                for (other, line) in &standing {
                    if is_on(from, *line) && is_on(to, *line) {
                        let entries = self.standing.entry(edge_key(a, b)).or_default();
                        if !entries.contains(&[piece.face, *other]) {
                            entries.push([piece.face, *other]);
                        }
                    }
                }
            }
        }
    }

    /// The pieces that are left, as faces: normals between the corners are interpolated, texture coordinates too.
    pub(super) fn faces(&self, faces: &Faces, positions: &[Vec3]) -> Faces {
        let mut cut = Faces::default();
        for piece in &self.pieces {
            let corners = faces.corners[piece.face as usize];
            let normal = |place: usize| self.normal(piece, place, corners, positions);
            cut.corners.push([0, 1, 2].map(|place| (piece.ids[place], normal(place))));
            cut.materials.push(faces.materials[piece.face as usize]);
            if let Some(texcoords) = faces.texcoords.get(piece.face as usize) {
                cut.texcoords.push(piece.places.map(|place| interpolated(*texcoords, place.as_vec2())));
            }
        }
        cut
    }

    fn normal(&self, piece: &Piece, place: usize, corners: [(u32, Vec3); 3], positions: &[Vec3]) -> Vec3 {
        let (id, normals) = (piece.ids[place], corners.map(|(_, normal)| normal));
        if let Some((_, normal)) = corners.iter().find(|(corner, _)| *corner == id) {
            return *normal;
        }
        if normals[0] == normals[1] && normals[1] == normals[2] {
            return normals[0];
        }
        // On an edge from the lower end's and the higher end's alone, so that both faces there say the same.
        for edge in 0..3 {
            let ends = [corners[edge], corners[(edge + 1) % 3]];
            if self.points.along(ends.map(|(id, _)| id)).contains(&id) {
                let [low, high] = if ends[0].0 < ends[1].0 { ends } else { [ends[1], ends[0]] };
                let [from, to, at] = [low.0, high.0, id].map(|id| positions[id as usize]);
                let part = (at - from).dot(to - from) / from.distance_squared(to);
                return low.1.lerp(high.1, part).try_normalize().unwrap_or(low.1);
            }
        }
        interpolate(normals, piece.places[place].as_vec2()).try_normalize().unwrap_or(normals[0])
    }
}

fn interpolated([a, b, c]: [Vec2; 3], place: Vec2) -> Vec2 {
    (1.0 - place.x - place.y) * a + place.x * b + place.y * c
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
        let is_small = flat.longest_edge() < SMALL * points.reach;
        for &Line { ends, standing } in meetings.lines[face].iter().filter(|line| line.standing.is_none() || !is_small)
        {
            let ids = ends.map(|end| points.at(end, positions));
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

impl Drawing<'_> {
    /// The constrained Delaunay triangulation of the face with the points on its edges and the lines inside. `None` if
    /// rounding does not allow it.
    fn triangles(&self, positions: &[Vec3]) -> Option<Vec<[DrawnCorner; 3]>> {
        let [a, b, c] = self.flat.points;
        let along = (b - a).try_normalize()?;
        let across = self.flat.normal.cross(along);
        let flatten = |point: DVec3| DVec2::new((point - a).dot(along), (point - a).dot(across));
        let mut drawing = ConstrainedDelaunayTriangulation::<Corner>::new();
        let mut handles: HashMap<u32, FixedVertexHandle> = HashMap::new();
        for id in self.outline.iter().flatten().copied().chain(self.lines.iter().flat_map(|line| line.ids)) {
            if let Entry::Vacant(entry) = handles.entry(id) {
                let flat = flatten(positions[id as usize].as_dvec3());
                let point = spade::mitigate_underflow(Point2::new(flat.x, flat.y));
                entry.insert(drawing.insert(Corner { point, id: Some(id) }).ok()?);
            }
        }
        let at_crossing = |point| Corner { point, id: None };
        let segments = self.outline.iter().flat_map(|edge| edge.windows(2)).map(|ends| [ends[0], ends[1]]);
        for ends in segments.chain(self.lines.iter().map(|line| line.ids)) {
            let [from, to] = ends.map(|id| handles[&id]);
            if from != to {
                drawing.add_constraint_and_split(from, to, at_crossing);
            }
        }
        let (b, c) = (flatten(b), flatten(c));
        let place = |point: DVec2| DVec2::new(point.perp_dot(c), b.perp_dot(point)) / b.perp_dot(c);
        let corner = |corner: &Corner| {
            let point = DVec2::new(corner.point.x, corner.point.y);
            let own = self.flat.ids.iter().position(|&id| Some(id) == corner.id);
            let place = own.map_or_else(|| place(point), |own| [DVec2::ZERO, DVec2::X, DVec2::Y][own]);
            (corner.id, a + point.x * along + point.y * across, place)
        };
        Some(drawing.inner_faces().map(|triangle| triangle.vertices().map(|vertex| corner(vertex.data()))).collect())
    }

    /// The pieces without those that have no area or lie beside the outline; `None` if the rest is not the face.
    fn covering(&self, mut parts: Vec<Piece>, positions: &[Vec3]) -> Option<Vec<Piece>> {
        let doubled = |ids: [u32; 3]| {
            let [a, b, c] = ids.map(|id| positions[id as usize].as_dvec3());
            (b - a).cross(c - a)
        };
        let expected = doubled(self.flat.ids).length();
        let mut covered = 0.0;
        parts.retain(|Piece { ids, .. }| {
            let is_beside = self.outline.iter().any(|edge| ids.iter().all(|id| edge.contains(id)));
            let area = doubled(*ids);
            let is_part = !is_beside && area.as_vec3() != Vec3::ZERO;
            covered += if is_part { area.dot(self.flat.normal) } else { 0.0 };
            is_part
        });
        ((covered - expected).abs() <= LARGEST_GAP * expected && !parts.is_empty()).then_some(parts)
    }
}
