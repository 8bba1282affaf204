//! Faces cut along the lines on them.
//!
//! Points that lie within reach of each other are one, on all faces; points on an edge are points of every face that has
//! the edge. So faces that met edge to edge still do, and no ray passes between their pieces.

use std::collections::HashMap;

use glam::{DVec2, Vec2, Vec3};
use rayon::prelude::*;

use super::{
    draw::{Drawing, Part, drawings},
    meet::Meetings,
    points::Points,
};
use crate::scene::{load::merge::Faces, mesh::interpolate};

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

impl Cuts {
    pub(super) fn of(faces: &Faces, meetings: &Meetings, positions: &mut Vec<Vec3>, reach: f64) -> Self {
        let mut points = Points::new(reach);
        let drawings = drawings(faces, meetings, positions, &mut points);
        let positions: &[Vec3] = positions;
        let cut = |(drawing, flat): (&Option<Drawing>, &_)| {
            drawing.as_ref().and_then(|drawing| drawing.parts(flat, positions))
        };
        let parts: Vec<Option<Vec<Part>>> = drawings.par_iter().zip(&meetings.flats).map(cut).collect();
        let mut pieces = Vec::with_capacity(parts.len());
        let mut standing: HashMap<[u32; 2], Vec<[u32; 2]>> = HashMap::new();
        let mut is_divided = Vec::with_capacity(parts.len());
        for (face, (drawing, parts)) in (0..).zip(drawings.iter().zip(parts)) {
            let lines = drawing.as_ref().map_or(&[][..], |drawing| &drawing.standing);
            is_divided.push(parts.as_ref().is_some_and(|parts| parts.len() > 1) && !lines.is_empty());
            let whole = || vec![(meetings.flats[face as usize].ids, [DVec2::ZERO, DVec2::X, DVec2::Y])];
            let parts = parts.unwrap_or_else(whole).into_iter();
            pieces.extend(parts.map(|(ids, places)| Piece { face, ids, places }));
            for &(edge, stands) in lines {
                let entries = standing.entry(edge).or_default();
                if !entries.contains(&[face, stands]) {
                    entries.push([face, stands]);
                }
            }
        }
        Self { pieces, is_divided, standing, points }
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
