//! Flat neighbours of one material as one surface: a wall that comes cut into a thousand triangles is cut anew into a few.
//!
//! Triangles are joined across edges that exactly two of them share (`regions`); what an outline needs of its vertices is
//! found for all surfaces at once, so that no surface keeps a vertex on an edge where its neighbour drops it (`outlines`);
//! and each outline, holes and all, is triangulated (`fill`). Where any of this fails, or gains little, the triangles stay.

mod fill;
mod outlines;
mod regions;

use glam::{DVec3, Vec2, Vec3};

use fill::Filler;
use outlines::Outlines;
use regions::Regions;

/// How far what is taken for flat or straight may be off, in local units (a scene's half-extent is between 1/2 and 1).
const FLAT: f64 = 1e-6;

/// No triangle, no region, no edge.
const NONE: u32 = u32::MAX;

/// A triangle's corners: index of the position, and unit shading normal.
pub(super) type ShadedCorners = [(u32, Vec3); 3];

/// Triangles, each counter-clockwise seen from the front.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    pub(super) corners: Vec<ShadedCorners>,
    pub(super) materials: Vec<u32>,
    /// As long as `corners`, or empty.
    pub(super) texcoords: Vec<[Vec2; 3]>,
}

impl Faces {
    /// The positions of a triangle's corners.
    pub(super) fn ids(&self, triangle: u32) -> [u32; 3] {
        self.corners[triangle as usize].map(|(id, _)| id)
    }

    pub(super) fn points(&self, triangle: u32, positions: &[Vec3]) -> [DVec3; 3] {
        self.ids(triangle).map(|id| positions[id as usize].as_dvec3())
    }

    /// The position of corner `3 · triangle + place`.
    pub(super) fn id(&self, corner: u32) -> u32 {
        self.corners[corner as usize / 3][corner as usize % 3].0
    }
}

/// Merges what is flat. Positions that are equal must have one index. A surface is what it was to within [`FLAT`], its
/// material and texture coordinates stay, for only triangles are joined whose texture goes straight on; of its normals,
/// which differ by rounding, it keeps one.
pub(super) fn merge_flat(faces: &mut Faces, positions: &[Vec3]) {
    let mut regions = Regions::of(faces, positions);
    let mut filler = Filler::default();
    // A region that cannot be filled keeps its triangles, and so all its vertices: its neighbours are asked again.
    while !regions.list.is_empty() {
        let outlines = Outlines::of(&regions, faces, positions);
        let fill = |region: usize| {
            let triangles = filler.fill(&regions.list[region], &outlines.loops[region], faces, positions);
            triangles.filter(|triangles| 2 * triangles.len() <= regions.list[region].triangles.len())
        };
        let filled: Vec<Option<Vec<[u32; 3]>>> = (0..regions.list.len()).map(fill).collect();
        if filled.iter().all(Option::is_some) {
            let filled: Vec<Vec<[u32; 3]>> = filled.into_iter().flatten().collect();
            *faces = replaced(faces, &regions, &filled);
            return;
        }
        let mut filled = filled.iter();
        regions.retain(|_| filled.next().is_some_and(Option::is_some));
    }
}

/// The faces with each region's triangles, made of its corners, in the place of its first one, and all with the normal of
/// its largest one.
fn replaced(faces: &Faces, regions: &Regions, filled: &[Vec<[u32; 3]>]) -> Faces {
    let mut merged = Faces::default();
    let mut is_done = vec![false; filled.len()];
    for triangle in 0..faces.corners.len() as u32 {
        let region = regions.region_of[triangle as usize];
        let own = [[0, 1, 2].map(|place| 3 * triangle + place)];
        let triangles: &[[u32; 3]] = match region {
            NONE => &own,
            region if is_done[region as usize] => continue,
            region => &filled[region as usize],
        };
        let mut normal = None;
        if region != NONE {
            is_done[region as usize] = true;
            normal = Some(faces.corners[regions.list[region as usize].triangles[0] as usize][0].1);
        }
        let corner_of = |corner: usize| {
            let (position, own) = faces.corners[corner / 3][corner % 3];
            (position, normal.unwrap_or(own))
        };
        for corners in triangles.iter().map(|corners| corners.map(|corner| corner as usize)) {
            merged.corners.push(corners.map(corner_of));
            merged.materials.push(faces.materials[triangle as usize]);
            if !faces.texcoords.is_empty() {
                merged.texcoords.push(corners.map(|corner| faces.texcoords[corner / 3][corner % 3]));
            }
        }
    }
    merged
}
