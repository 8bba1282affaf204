//! The points that faces are cut at: those within reach of each other are one.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3, Vec3};

use super::meet::Flat;

/// The points that faces are cut at.
pub(super) struct Points {
    pub(super) reach: f64,
    cells: HashMap<I64Vec3, Vec<u32>>,
    /// For each edge that has points on it, by the positions of its ends, lower first: those points and where they lie on
    /// the way, in order.
    on_edges: HashMap<[u32; 2], Vec<(f64, u32)>>,
}

pub(super) fn edge_key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Points {
    pub(super) fn new(reach: f64) -> Self {
        Self { reach, cells: HashMap::new(), on_edges: HashMap::new() }
    }

    /// Sorts the points on each edge from its lower end to its higher one.
    pub(super) fn sort(&mut self) {
        let order = |one: &(f64, u32), other: &(f64, u32)| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1));
        self.on_edges.values_mut().for_each(|on_edge| on_edge.sort_by(order));
    }

    fn cell(&self, point: DVec3) -> I64Vec3 {
        (point / (4.0 * self.reach)).floor().as_i64vec3()
    }

    pub(super) fn enter(&mut self, id: u32, point: DVec3) {
        let cell = self.cell(point);
        let cell = self.cells.entry(cell).or_default();
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

    /// The position at a point of a face: its own corner, if one is in reach, or as [`Points::at`].
    pub(super) fn on_face(&mut self, flat: &Flat, point: DVec3, positions: &mut Vec<Vec3>) -> u32 {
        let own = flat.ids.into_iter().zip(flat.points).find(|(_, corner)| corner.distance(point) <= 1.5 * self.reach);
        own.map_or_else(|| self.at(point, positions), |(id, _)| id)
    }

    /// Puts a position on an edge of a face, if it lies on one.
    pub(super) fn put_on_edge(&mut self, flat: &Flat, id: u32, point: DVec3) {
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
    pub(super) fn edge_along(&self, flat: &Flat, ids: [u32; 2], positions: &[Vec3]) -> Option<[u32; 2]> {
        (0..3).map(|edge| (edge, [flat.ids[edge], flat.ids[(edge + 1) % 3]])).find_map(|(edge, ends)| {
            let is_on = |id: u32| {
                ends.contains(&id)
                    || flat.place_on_edge(edge, positions[id as usize].as_dvec3(), 2.0 * self.reach).is_some()
            };
            (is_on(ids[0]) && is_on(ids[1])).then(|| edge_key(ends[0], ends[1]))
        })
    }

    pub(super) fn is_cut(&self, [from, to]: [u32; 2]) -> bool {
        self.on_edges.contains_key(&edge_key(from, to))
    }

    /// The positions along an edge from one of its ends to the other.
    pub(super) fn along(&self, [from, to]: [u32; 2]) -> Vec<u32> {
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
