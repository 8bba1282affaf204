//! Lamps: emissive triangles of one radiance that together are (a part of) the surface of a convex body, such as a panel,
//! a bulb or a tube. Lambert's sum over their triangles that face a point keeps only the edges of the outline that they
//! have from there: each inner edge is in it twice, in opposite directions. And none of them hides another.

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec3};

use crate::scene::{AreaLight, Scene};

/// No facet, triangle or position.
pub(super) const NONE: u32 = u32::MAX;

/// Triangles of a lamp; more make another one, since each is compared with all others.
const MOST_TRIANGLES: usize = 2048;

/// Corners of a facet; what has more stays in triangles.
pub(super) const MOST_FACET_CORNERS: usize = 12;

/// Triangles that are looked at for one facet.
const MOST_OF_A_FACET: usize = 32;

/// What rises above a plane by less than this times its distance from where the plane is known, or by [`ROUNDING`] local
/// units, lies in it: a file's decimals bend flat faces.
const FLAT: f64 = 1e-4;
const ROUNDING: f64 = 1e-6;

/// A light of constant radiance that shines to the outside of a convex surface.
#[derive(Clone, Debug)]
pub struct Lamp {
    /// Radiance [W/(m² sr)].
    pub radiance: Vec3,
    /// The scene's triangles that it is made of, ascending.
    triangles: Vec<u32>,
    /// Corners of facets and ends of edges.
    pub(super) positions: Vec<DVec3>,
    pub(super) facets: Vec<Facet>,
    /// Corners of each facet, counter-clockwise as seen from its front.
    pub(super) corners: Vec<Vec<u32>>,
    pub(super) edges: Vec<Edge>,
    /// A sphere around all of it.
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

/// The plane of a convex polygon of a lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// Unit normal of the side that shines.
    pub(super) normal: DVec3,
    /// `normal · p` in its plane.
    pub(super) offset: f64,
    /// Area in local units².
    pub(super) area: f64,
}

/// An edge between two facets, or of one alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Its ends in the direction in which the first facet goes around.
    pub(super) ends: [u32; 2],
    /// The facets; the second one may be [`NONE`].
    pub(super) facets: [u32; 2],
}

impl Lamp {
    /// The placed light, which no triangles are.
    pub(super) fn of_area_light(light: &AreaLight) -> Self {
        let mut lamp = Self::empty(light.radiance);
        lamp.positions.extend(light.corners().map(Vec3::as_dvec3));
        lamp.add_facet(vec![0, 1, 2, 3]);
        lamp.bound();
        lamp
    }

    /// True if it has this triangle of the scene.
    pub(super) fn contains(&self, triangle: u32) -> bool {
        self.triangles.binary_search(&triangle).is_ok()
    }

    fn empty(radiance: Vec3) -> Self {
        let (triangles, positions, facets, corners, edges) = Default::default();
        Self { radiance, triangles, positions, facets, corners, edges, centre: DVec3::ZERO, radius: 0.0 }
    }

    fn add_facet(&mut self, corners: Vec<u32>) {
        let at = |index: usize| self.positions[corners[index] as usize];
        let scaled = (2..corners.len()).map(|index| (at(index - 1) - at(0)).cross(at(index) - at(0))).sum::<DVec3>();
        let normal = scaled.normalize_or_zero();
        self.facets.push(Facet { normal, offset: normal.dot(at(0)), area: 0.5 * scaled.length() });
        self.corners.push(corners);
    }

    fn bound(&mut self) {
        self.centre = self.positions.iter().sum::<DVec3>() / self.positions.len().max(1) as f64;
        self.radius = self.positions.iter().map(|position| position.distance(self.centre)).fold(0.0, f64::max);
    }
}

/// The lamps that these triangles of a scene are, in an order that depends on nothing else; `None` if they are more than
/// `most`.
pub(super) fn lamps_of(scene: &Scene, triangles: &[u32], most: usize) -> Option<Vec<Lamp>> {
    let shapes = Shapes::new(scene, triangles);
    let mut lamp_of = vec![NONE; triangles.len()];
    let mut lamps = Vec::new();
    for first in 0..triangles.len() as u32 {
        if lamp_of[first as usize] == NONE {
            if lamps.len() == most {
                return None;
            }
            let group = shapes.convex_group(first, &mut lamp_of, lamps.len() as u32);
            lamps.push(shapes.lamp(scene, &group));
        }
    }
    Some(lamps)
}

/// Emissive triangles by their place in the list of them, and who touches whom. Corners at one position are the same,
/// whatever their shading normals.
struct Shapes<'a> {
    triangles: &'a [u32],
    positions: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
    normals: Vec<DVec3>,
    /// The triangle across each edge (from corner k to corner k + 1), or [`NONE`].
    neighbours: Vec<[u32; 3]>,
}

impl<'a> Shapes<'a> {
    fn new(scene: &Scene, triangles: &'a [u32]) -> Self {
        let (mut positions, mut known) = (Vec::new(), HashMap::new());
        let mut place = |position: Vec3| {
            // Adding 0 makes one of both zeros.
            *known.entry((position + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert_with(|| {
                positions.push(position.as_dvec3());
                positions.len() as u32 - 1
            })
        };
        let corners: Vec<[u32; 3]> =
            triangles.iter().map(|&triangle| scene.mesh.corners(triangle).map(&mut place)).collect();
        let normal = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| positions[corner as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let normals = corners.iter().map(normal).collect();
        let neighbours = vec![[NONE; 3]; triangles.len()];
        let mut shapes = Self { triangles, positions, corners, normals, neighbours };
        shapes.find_neighbours(scene);
        shapes
    }

    /// Of several triangles across an edge, as where surfaces have two sides, the one that goes on straightest.
    fn find_neighbours(&mut self, scene: &Scene) {
        let mut by_edge: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        for (triangle, corners) in (0_u32..).zip(&self.corners) {
            for side in 0..3 {
                by_edge.entry([corners[side], corners[(side + 1) % 3]]).or_default().push(triangle);
            }
        }
        let radiance = |triangle: u32| scene.material(self.triangles[triangle as usize]).emitted_radiance;
        let straightest = |triangle: u32, side: usize| {
            let corners = self.corners[triangle as usize];
            let across = by_edge.get(&[corners[(side + 1) % 3], corners[side]]).map_or(&[][..], Vec::as_slice);
            let straightness = |other: u32| self.normals[triangle as usize].dot(self.normals[other as usize]);
            let equal = across.iter().copied().filter(|&other| radiance(other) == radiance(triangle));
            equal.max_by(|&a, &b| straightness(a).total_cmp(&straightness(b))).unwrap_or(NONE)
        };
        let wanted: Vec<[u32; 3]> = (0..self.corners.len() as u32)
            .map(|triangle| std::array::from_fn(|side| straightest(triangle, side)))
            .collect();
        let is_mutual =
            |triangle: u32, other: u32| wanted.get(other as usize).is_some_and(|sides| sides.contains(&triangle));
        self.neighbours = (0_u32..)
            .zip(&wanted)
            .map(|(triangle, sides)| sides.map(|other| if is_mutual(triangle, other) { other } else { NONE }))
            .collect();
    }

    /// How far a position lies above a triangle's plane, beyond what is flat.
    fn rise(&self, triangle: u32, position: u32) -> f64 {
        let offset = self.positions[position as usize] - self.positions[self.corners[triangle as usize][0] as usize];
        self.normals[triangle as usize].dot(offset) - FLAT * offset.length() - ROUNDING
    }

    /// The triangles that are reached from `first` over edges, as long as all lie on or behind the planes of all others.
    /// One that once rises above the group always does.
    fn convex_group(&self, first: u32, lamp_of: &mut [u32], lamp: u32) -> Vec<u32> {
        lamp_of[first as usize] = lamp;
        let mut group = vec![first];
        let mut positions = self.corners[first as usize].to_vec();
        let mut known: HashSet<u32> = positions.iter().copied().collect();
        let mut refused = HashSet::new();
        let mut next = 0;
        while next < group.len() && group.len() < MOST_TRIANGLES {
            for other in self.neighbours[group[next] as usize] {
                if other == NONE || lamp_of[other as usize] != NONE || refused.contains(&other) {
                    continue;
                }
                let new = || self.corners[other as usize].into_iter().filter(|corner| !known.contains(corner));
                let is_convex = positions.iter().all(|&position| self.rise(other, position) <= 0.0)
                    && new().all(|corner| group.iter().all(|&triangle| self.rise(triangle, corner) <= 0.0));
                if is_convex {
                    positions.extend(new());
                    known.extend(self.corners[other as usize]);
                    lamp_of[other as usize] = lamp;
                    group.push(other);
                } else {
                    refused.insert(other);
                }
            }
            next += 1;
        }
        group
    }

    fn lamp(&self, scene: &Scene, group: &[u32]) -> Lamp {
        let mut lamp = Lamp::empty(scene.material(self.triangles[group[0] as usize]).emitted_radiance);
        lamp.triangles.extend(group.iter().map(|&triangle| self.triangles[triangle as usize]));
        lamp.triangles.sort_unstable();
        let mut places = HashMap::new();
        let mut facet_of = HashMap::new();
        let mut place = |lamp: &mut Lamp, position: u32| {
            *places.entry(position).or_insert_with(|| {
                lamp.positions.push(self.positions[position as usize]);
                lamp.positions.len() as u32 - 1
            })
        };
        let mut is_left: HashSet<u32> = group.iter().copied().collect();
        for &first in group {
            if !is_left.contains(&first) {
                continue;
            }
            let mut flat = self.flat_group(first, &is_left);
            let corners = self.convex_outline(&flat).unwrap_or_else(|| {
                flat = vec![first];
                self.corners[first as usize].to_vec()
            });
            for triangle in flat {
                is_left.remove(&triangle);
                facet_of.insert(triangle, lamp.facets.len() as u32);
            }
            let corners = corners.into_iter().map(|corner| place(&mut lamp, corner)).collect();
            lamp.add_facet(corners);
        }
        for &triangle in group {
            for (side, other) in self.neighbours[triangle as usize].into_iter().enumerate() {
                let corners = self.corners[triangle as usize];
                let facets = [triangle, other].map(|triangle| facet_of.get(&triangle).copied().unwrap_or(NONE));
                // Each edge once, from the facet of the lower number.
                if facets[0] < facets[1] {
                    let ends = [corners[side], corners[(side + 1) % 3]].map(|corner| place(&mut lamp, corner));
                    lamp.edges.push(Edge { ends, facets });
                }
            }
        }
        lamp.bound();
        lamp
    }

    /// The triangles that are reached from `first` in its plane.
    fn flat_group(&self, first: u32, among: &HashSet<u32>) -> Vec<u32> {
        let is_flat = |other: u32| {
            let corners = self.corners[other as usize];
            let lies_in = |plane: u32, corner: u32| {
                let offset = self.positions[corner as usize] - self.positions[self.corners[plane as usize][0] as usize];
                self.normals[plane as usize].dot(offset).abs() <= FLAT * offset.length() + ROUNDING
            };
            self.normals[first as usize].dot(self.normals[other as usize]) > 0.0
                && corners.iter().all(|&corner| lies_in(first, corner))
                && self.corners[first as usize].iter().all(|&corner| lies_in(other, corner))
        };
        let mut group = vec![first];
        let mut next = 0;
        while next < group.len() && group.len() <= MOST_OF_A_FACET {
            for other in self.neighbours[group[next] as usize] {
                if among.contains(&other) && !group.contains(&other) && is_flat(other) {
                    group.push(other);
                }
            }
            next += 1;
        }
        group
    }

    /// The outline of triangles in a plane, if it is one convex polygon of few corners.
    fn convex_outline(&self, flat: &[u32]) -> Option<Vec<u32>> {
        let mut next = HashMap::new();
        for &triangle in flat {
            let corners = self.corners[triangle as usize];
            for side in (0..3).filter(|&side| !flat.contains(&self.neighbours[triangle as usize][side])) {
                if next.insert(corners[side], corners[(side + 1) % 3]).is_some() {
                    return None;
                }
            }
        }
        let start = *self.corners[flat[0] as usize].iter().find(|corner| next.contains_key(corner))?;
        let mut outline = vec![start];
        while let Some(&corner) = next.get(outline.last()?).filter(|&&corner| corner != start) {
            outline.push(corner);
            if outline.len() > next.len() {
                return None;
            }
        }
        if outline.len() != next.len() {
            return None;
        }
        let normal = self.normals[flat[0] as usize];
        let turn = |index: usize| {
            let [a, b, c] =
                [outline.len() - 1, 0, 1].map(|step| self.positions[outline[(index + step) % outline.len()] as usize]);
            (b - a).normalize_or_zero().cross((c - b).normalize_or_zero()).dot(normal)
        };
        let turns: Vec<f64> = (0..outline.len()).map(turn).collect();
        if turns.iter().any(|&turn| turn < -FLAT) {
            return None;
        }
        let corners: Vec<u32> =
            outline.iter().zip(turns).filter(|(_, turn)| *turn > FLAT).map(|(&corner, _)| corner).collect();
        (3..=MOST_FACET_CORNERS).contains(&corners.len()).then_some(corners)
    }
}
