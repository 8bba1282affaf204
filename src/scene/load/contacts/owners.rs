//! Who owns a place: of faces that lie on one another, one; of what is enclosed between solids, none.

use glam::{DMat3, DVec3, Vec3};
use obvhs::ray::Ray;
use rayon::prelude::*;

use super::{
    Findings, Rules,
    cut::{Cuts, Piece},
    meet::Meetings,
};
use crate::{math::sequence::spiral_direction, scene::load::merge::Faces};

/// Rays that tell whether a point is enclosed.
const RAYS: u32 = 16;

/// Where on a piece that is asked, in weights of its corners: the middle, and towards each corner.
const ASKED: [[f64; 3]; 4] = [[1.0 / 3.0; 3], [0.9, 0.05, 0.05], [0.05, 0.9, 0.05], [0.05, 0.05, 0.9]];

/// Takes away the pieces whose place another face owns, and those that are enclosed.
///
/// Of faces that face the same way, one owns the place: one that emits before one that does not, then the one that comes
/// later in the file. Faces that turn their backs to each other both stay, like the two sides of a card; but what cannot
/// be seen from anywhere, as it lies where solids touch, goes.
pub(super) fn settle(
    cuts: &mut Cuts,
    meetings: &Meetings,
    faces: &Faces,
    positions: &[Vec3],
    rules: &Rules,
) -> Findings {
    let places = Places { meetings, faces, rules };
    let fate = |piece: &Piece| {
        let corners = piece.ids.map(|id| positions[id as usize].as_dvec3());
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        if let Some(owner) = places.owner(piece, middle) {
            return Fate::Covered(owner);
        }
        let is_touched = cuts.is_divided[piece.face as usize] || places.has_partner_behind(piece.face, middle);
        if is_touched && places.is_enclosed(piece.face, corners) { Fate::Enclosed } else { Fate::Stays }
    };
    let fates: Vec<Fate> = cuts.pieces.par_iter().with_min_len(64).map(fate).collect();
    let mut findings = Findings::default();
    let (mut last_covered, mut last_enclosed) = (u32::MAX, u32::MAX);
    let mut fates = fates.into_iter();
    cuts.pieces.retain(|piece| {
        let corners = piece.ids.map(|id| positions[id as usize]);
        let middle = corners.iter().sum::<Vec3>().as_dvec3() / 3.0;
        let material = |face: u32| faces.materials[face as usize];
        match fates.next() {
            Some(Fate::Covered(owner)) => {
                let (count, ..) = findings.covered.get_or_insert((0, middle, [material(piece.face), material(owner)]));
                *count += usize::from(last_covered != piece.face);
                last_covered = piece.face;
                false
            }
            Some(Fate::Enclosed) => {
                let (count, ..) = findings.enclosed.get_or_insert((0, middle, material(piece.face)));
                *count += usize::from(last_enclosed != piece.face);
                last_enclosed = piece.face;
                findings.enclosed_places.push(corners);
                false
            }
            _ => true,
        }
    });
    findings
}

/// What becomes of a piece.
enum Fate {
    Stays,
    /// This face owns its place.
    Covered(u32),
    Enclosed,
}

struct Places<'a> {
    meetings: &'a Meetings,
    faces: &'a Faces,
    rules: &'a Rules<'a>,
}

impl Places<'_> {
    /// The face that owns the place of a piece, if it is another one.
    fn owner(&self, piece: &Piece, middle: DVec3) -> Option<u32> {
        let rank = |face: u32| self.rules.rank(face, self.faces);
        let others = self.meetings.partners[piece.face as usize].iter().copied();
        let covers = |&other: &u32| {
            (self.rules.two_sided || self.cosine(piece.face, other) > 0.0)
                && !self.rules.has_holes[self.faces.materials[other as usize] as usize]
                && rank(other) > rank(piece.face)
                && self.meetings.flats[other as usize].contains(middle)
        };
        others.filter(covers).max_by_key(|&other| rank(other))
    }

    fn cosine(&self, one: u32, other: u32) -> f64 {
        self.meetings.flats[one as usize].normal.dot(self.meetings.flats[other as usize].normal)
    }

    /// True if, at a point of a face, another one lies with its back to it.
    fn has_partner_behind(&self, face: u32, point: DVec3) -> bool {
        !self.rules.two_sided
            && self.meetings.partners[face as usize]
                .iter()
                .any(|&other| self.cosine(face, other) < 0.0 && self.meetings.flats[other as usize].contains(point))
    }

    /// True if all that is seen from the front of a piece, through the contacts of solids, are backs.
    fn is_enclosed(&self, face: u32, corners: [DVec3; 3]) -> bool {
        let normal = self.meetings.flats[face as usize].normal;
        let (across, along) = normal.any_orthonormal_pair();
        let basis = DMat3::from_cols(across, along, normal);
        ASKED.iter().all(|weights| {
            let point: DVec3 = weights.iter().zip(corners).map(|(weight, corner)| *weight * corner).sum();
            (0..RAYS).all(|index| self.sees_back(face, point, basis * spiral_direction(index, RAYS).as_dvec3()))
        })
    }

    /// True if the first face that a ray meets, but for those that touch the back of another one there, shows its back.
    fn sees_back(&self, from: u32, origin: DVec3, direction: DVec3) -> bool {
        let mut nearest = (f64::INFINITY, false);
        let ray = Ray::new_inf(origin.as_vec3().into(), direction.as_vec3().into());
        let tree = &self.meetings.tree;
        let mut ray_hit = obvhs::ray::RayHit::none();
        tree.ray_traverse(ray, &mut ray_hit, |_, index| {
            let face = tree.primitive_indices[index];
            if face == from || self.meetings.partners[from as usize].contains(&face) {
                return f32::INFINITY;
            }
            let flat = &self.meetings.flats[face as usize];
            let slope = direction.dot(flat.normal);
            let distance = -flat.height_of(origin) / slope;
            if !(distance > 0.0 && distance < nearest.0) {
                return f32::INFINITY;
            }
            let point = origin + distance * direction;
            if !flat.contains(point) || self.has_partner_behind(face, point) {
                return f32::INFINITY;
            }
            nearest = (distance, slope > 0.0);
            distance as f32
        });
        nearest.1
    }
}
