//! Which triangles make one flat surface.

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::{FLAT, Faces, NONE};

/// Cosine from which on two directions are the same (some 0.08°).
const SAME: f64 = 1.0 - 1e-6;

/// How far, in repeats of the texture, its coordinates may be from going straight on.
const SAME_TEXCOORD: f64 = 1e-4;

/// While a region grows it is held to the plane of one triangle, which tells the region's own only so well.
const GROWING: f64 = 10.0 * FLAT;

/// Triangles that are connected, flat, and of one material.
pub(super) struct Region {
    pub(super) triangles: Vec<u32>,
    /// Unit normal of its plane.
    pub(super) normal: DVec3,
}

/// All regions of two triangles or more.
pub(super) struct Regions {
    pub(super) list: Vec<Region>,
    /// The region of each triangle, or [`NONE`].
    pub(super) region_of: Vec<u32>,
    /// For each corner c, whose edge leads from it to the triangle's next: the corner of the one triangle across, whose
    /// edge leads back. [`NONE`] if there is none, if there are several, or if it leads the same way.
    pub(super) mates: Vec<u32>,
}

/// What a triangle must fit to be in one region with another.
struct Fit {
    material: u32,
    origin: DVec3,
    normal: DVec3,
    /// Texture coordinates at `origin`, and their change along x, y and z.
    texcoord: DVec2,
    gradient: [DVec2; 3],
}

impl Regions {
    pub(super) fn of(faces: &Faces, positions: &[Vec3]) -> Self {
        let count = faces.corners.len();
        let mut regions = Self { list: Vec::new(), region_of: vec![NONE; count], mates: mates(faces) };
        let area = |triangle: u32| {
            let [a, b, c] = faces.points(triangle, positions);
            (b - a).cross(c - a).length()
        };
        let areas: Vec<f64> = (0..count as u32).map(area).collect();
        // The largest first: they know their plane best.
        let mut seeds: Vec<u32> = (0..count as u32).collect();
        seeds.par_sort_by(|&a, &b| areas[b as usize].total_cmp(&areas[a as usize]).then(a.cmp(&b)));
        let mut is_taken = vec![false; count];
        for seed in seeds {
            if is_taken[seed as usize] {
                continue;
            }
            let triangles = regions.grown(seed, faces, positions, &mut is_taken);
            if let Some(normal) = plane_normal(&triangles, faces, positions).filter(|_| triangles.len() > 2) {
                let number = regions.list.len() as u32;
                triangles.iter().for_each(|&triangle| regions.region_of[triangle as usize] = number);
                regions.list.push(Region { triangles, normal });
            }
        }
        regions
    }

    /// Leaves out the regions for which `is_kept` says so.
    pub(super) fn retain(&mut self, mut is_kept: impl FnMut(&Region) -> bool) {
        self.list.retain(|region| is_kept(region));
        self.region_of.fill(NONE);
        for (number, region) in self.list.iter().enumerate() {
            region.triangles.iter().for_each(|&triangle| self.region_of[triangle as usize] = number as u32);
        }
    }

    fn grown(&self, seed: u32, faces: &Faces, positions: &[Vec3], is_taken: &mut [bool]) -> Vec<u32> {
        let mut triangles = vec![seed];
        is_taken[seed as usize] = true;
        let Some(fit) = Fit::of(seed, faces, positions) else { return triangles };
        let mut next = 0;
        while let Some(&triangle) = triangles.get(next) {
            next += 1;
            for corner in 3 * triangle..3 * triangle + 3 {
                let mate = self.mates[corner as usize];
                let other = mate / 3;
                if mate != NONE && !is_taken[other as usize] && fit.admits(other, faces, positions) {
                    is_taken[other as usize] = true;
                    triangles.push(other);
                }
            }
        }
        triangles
    }

    /// The corner across an edge, if it is of the same region.
    pub(super) fn inner_mate(&self, corner: u32) -> Option<u32> {
        let mate = self.mates[corner as usize];
        let region = |corner: u32| self.region_of[corner as usize / 3];
        (mate != NONE && region(mate) == region(corner)).then_some(mate)
    }
}

impl Fit {
    /// `None` if the triangle is shaded as if it were not flat.
    fn of(triangle: u32, faces: &Faces, positions: &[Vec3]) -> Option<Self> {
        let [a, b, c] = faces.points(triangle, positions);
        let (along_b, along_c) = (b - a, c - a);
        let scaled = along_b.cross(along_c);
        let normal = scaled.try_normalize()?;
        let (mut texcoord, mut gradient) = (DVec2::ZERO, [DVec2::ZERO; 3]);
        if let Some(corners) = faces.texcoords.get(triangle as usize) {
            let [from, to_b, to_c] = corners.map(|corner| corner.as_dvec2());
            // The barycentric coordinates' gradients.
            let (of_b, of_c) = (along_c.cross(scaled), scaled.cross(along_b));
            let of_b = of_b / of_b.dot(along_b);
            let of_c = of_c / of_c.dot(along_c);
            texcoord = from;
            gradient = [0, 1, 2].map(|axis| of_b[axis] * (to_b - from) + of_c[axis] * (to_c - from));
        }
        let fit = Self { material: faces.materials[triangle as usize], origin: a, normal, texcoord, gradient };
        fit.admits(triangle, faces, positions).then_some(fit)
    }

    fn admits(&self, triangle: u32, faces: &Faces, positions: &[Vec3]) -> bool {
        let points = faces.points(triangle, positions);
        let is_straight_on = |place: usize| {
            let offset = points[place] - self.origin;
            let [x, y, z] = self.gradient;
            let expected = self.texcoord + offset.x * x + offset.y * y + offset.z * z;
            let found = faces.texcoords.get(triangle as usize).map_or(expected, |corners| corners[place].as_dvec2());
            (found - expected).abs().max_element() <= SAME_TEXCOORD
        };
        let [a, b, c] = points;
        let faces_along = (b - a).cross(c - a).normalize_or_zero().dot(self.normal) > SAME;
        let is_shaded_flat = |&(_, normal): &(u32, Vec3)| normal.as_dvec3().dot(self.normal) > SAME;
        faces.materials[triangle as usize] == self.material
            && faces_along
            && points.iter().all(|&point| (point - self.origin).dot(self.normal).abs() <= GROWING)
            && faces.corners[triangle as usize].iter().all(is_shaded_flat)
            && (0..3).all(is_straight_on)
    }
}

/// The unit normal of triangles' common plane; `None` if they have none.
fn plane_normal(triangles: &[u32], faces: &Faces, positions: &[Vec3]) -> Option<DVec3> {
    let (mut scaled, mut area, mut centre) = (DVec3::ZERO, 0.0, DVec3::ZERO);
    for &triangle in triangles {
        let [a, b, c] = faces.points(triangle, positions);
        let own = (b - a).cross(c - a);
        (scaled, area, centre) = (scaled + own, area + own.length(), centre + own.length() / 3.0 * (a + b + c));
    }
    let (normal, centre) = (scaled.try_normalize()?, centre / area);
    let mut points = triangles.iter().flat_map(|&triangle| faces.points(triangle, positions));
    points.all(|point| (point - centre).dot(normal).abs() <= FLAT).then_some(normal)
}

fn mates(faces: &Faces) -> Vec<u32> {
    let end = |corner: u32| faces.id(corner - corner % 3 + (corner + 1) % 3);
    let mut edges: Vec<(u32, u32, u32)> = (0..3 * faces.corners.len() as u32)
        .into_par_iter()
        .map(|corner| {
            let (from, to) = (faces.id(corner), end(corner));
            (from.min(to), from.max(to), corner)
        })
        .collect();
    edges.par_sort_unstable();
    let mut mates = vec![NONE; edges.len()];
    for edge in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
        if let &[(.., one), (.., other)] = edge
            && faces.id(one) == end(other)
        {
            (mates[one as usize], mates[other as usize]) = (other, one);
        }
    }
    mates
}
