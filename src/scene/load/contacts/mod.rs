//! Faces that touch: laid on one another, standing on one another, crossing.
//!
//! Where faces come within a millionth of the scene of each other, each draws a line on the other (`meet`). Every face is
//! cut along the lines on it (`draw`, `cut`), so that each piece lies on one side of whatever stands there. Then each place gets
//! one surface, and what is enclosed between solids is left out (`owners`); and pieces on two sides of what stands between
//! them get vertices of their own (`tears`), so that no method interpolates or averages across it.

mod cut;
mod draw;
mod meet;
mod owners;
mod points;
mod tears;

use std::collections::HashSet;

use glam::{DVec3, Vec3};

use super::{counted, merge::Faces};
use crate::scene::{LocalFrame, Material};
use cut::Cuts;
use meet::Meetings;

/// Nearer than this fraction of the scene's largest side counts as touching: a little over a millionth, so that a
/// millionth with its rounding is in.
const TOUCHING: f64 = 1.25e-6;

/// What is done where faces touch, and how the scene's materials and options bear on it.
pub(super) struct Rules<'a> {
    /// For each material: does it emit.
    pub(super) emits: &'a [bool],
    /// For each material: does it emit, and reflect nothing, so that nobody asks what light arrives on it.
    pub(super) is_lamp: &'a [bool],
    /// For each material: may light pass parts of it, so that what lies beneath is seen.
    pub(super) has_holes: &'a [bool],
    /// Every surface has two sides.
    pub(super) two_sided: bool,
}

impl Rules<'_> {
    /// Of faces in one place the one of the highest rank stays: what emits, then what comes later in the file.
    fn rank(&self, face: u32, faces: &Faces) -> (bool, u32) {
        (self.emits[faces.materials[face as usize] as usize], face)
    }

    fn is_lamp(&self, face: u32, faces: &Faces) -> bool {
        self.is_lamp[faces.materials[face as usize] as usize]
    }
}

/// What was found, for the report.
#[derive(Clone, Debug, Default)]
pub(super) struct Findings {
    /// Faces that lost a place to another one, and the first of those places [local units] with the materials of the face
    /// that lost and the one that won.
    pub(super) covered: Option<(usize, DVec3, [u32; 2])>,
    /// Faces of which a part is enclosed, and the first of those places [local units] with its material.
    pub(super) enclosed: Option<(usize, DVec3, u32)>,
    /// The corners of what is enclosed [local units].
    pub(super) enclosed_places: Vec<[Vec3; 3]>,
}

impl Findings {
    /// A line for each kind.
    pub(super) fn told(&self, materials: &[Material], frame: &LocalFrame) -> Vec<String> {
        let name = |material: u32| format!("`{}`", materials[material as usize].name);
        let at = |place: DVec3| {
            let [x, y, z] = (frame.origin + frame.metres_per_unit * place).to_array();
            format!("({x:.4} {y:.4} {z:.4}) m")
        };
        let place = |count: usize| if count == 1 { "at" } else { "first at" };
        let mut lines = Vec::new();
        if let Some((count, middle, [lost, won])) = self.covered {
            lines.push(format!(
                "{} in the place of another face, {} {}: {} stays and {} goes; of faces in one place that face one way \
                 what emits stays, then what comes later in the file",
                if count == 1 { String::from("1 face lies") } else { format!("{count} faces lie") },
                place(count),
                at(middle),
                name(won),
                name(lost),
            ));
        }
        if let Some((count, middle, material)) = self.enclosed {
            lines.push(format!(
                "left out what is enclosed in solids of {}, {} {}, of {}",
                counted(count, "face"),
                place(count),
                at(middle),
                name(material),
            ));
        }
        lines
    }
}

/// Faces that touch no other across their inside any more.
pub(super) struct Settled {
    pub(super) faces: Faces,
    /// Corners `3 · triangle + place` at one position with one normal share a vertex if these numbers agree.
    pub(super) fans: Vec<u32>,
    pub(super) findings: Findings,
}

impl Settled {
    /// The faces as they are.
    pub(super) fn unsettled(faces: Faces) -> Self {
        Self { fans: vec![0; 3 * faces.corners.len()], faces, findings: Findings::default() }
    }
}

/// Cuts faces where others touch them, leaves one of them in each place, and tells which of their corners belong
/// together. New positions are appended.
pub(super) fn settle(mut faces: Faces, positions: &mut Vec<Vec3>, rules: &Rules) -> Settled {
    let reach = TOUCHING * largest_side(&faces, positions);
    let mut meetings = Meetings::of(&faces, positions, reach, rules);
    let is_lifted = lift_pierced(&meetings, &faces, positions, rules, reach);
    if meetings.bring_into_planes(&faces, positions, reach) || is_lifted {
        meetings = Meetings::of(&faces, positions, reach, rules);
    }
    if meetings.is_empty() {
        return Settled::unsettled(faces);
    }
    let mut cuts = Cuts::of(&faces, &meetings, positions, reach);
    let findings = owners::settle(&mut cuts, &meetings, &faces, positions, rules);
    faces = cuts.faces(&faces, positions);
    let fans = tears::fans(&cuts, &faces);
    Settled { faces, fans, findings }
}

/// Lifts faces with holes, through which one sees what they lie on, off its plane: a decal. True if there is one.
fn lift_pierced(meetings: &Meetings, faces: &Faces, positions: &mut [Vec3], rules: &Rules, reach: f64) -> bool {
    let mut lifted = HashSet::new();
    for (face, partners) in (0..).zip(&meetings.partners) {
        let normal = meetings.flats[face as usize].normal;
        let lies_on = |&other: &u32| {
            normal.dot(meetings.flats[other as usize].normal) > 0.0
                && rules.rank(face, faces) > rules.rank(other, faces)
        };
        if rules.has_holes[faces.materials[face as usize] as usize] && partners.iter().any(lies_on) {
            for id in faces.ids(face).into_iter().filter(|&id| lifted.insert(id)) {
                positions[id as usize] += (3.0 * reach * normal).as_vec3();
            }
        }
    }
    !lifted.is_empty()
}

fn largest_side(faces: &Faces, positions: &[Vec3]) -> f64 {
    let points = (0..faces.corners.len() as u32).flat_map(|face| faces.points(face, positions));
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(none, |(low, high), point| (low.min(point), high.max(point)));
    (high - low).max_element()
}
