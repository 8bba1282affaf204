//! The coarse elements from whose vertices rays were gathered, and the fine ones between them.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{SmoothField, SmoothValues, Sources};
use crate::{scene::Tessellation, solver::buried::fill_buried};

/// The coarse elements in the end.
pub(in crate::solver) struct Coarse {
    pub(in crate::solver) sources: Arc<Sources>,
    /// Vertices that see next to nothing but back faces.
    pub(in crate::solver) buried: Vec<bool>,
    pub(in crate::solver) smooth: SmoothField,
    /// Where in the coarse elements each vertex of the fine ones lies.
    pub(in crate::solver) places: Vec<(u32, Vec2)>,
}

impl Coarse {
    /// Notes where the vertices of the fine elements lie.
    pub(in crate::solver) fn locate(&mut self, fine: &Tessellation) {
        let coarse = &self.sources.tessellation;
        self.places = vec![(0, Vec2::ZERO); fine.mesh.positions.len()];
        for (element, corners) in fine.mesh.triangles.iter().enumerate() {
            for (corner, &vertex) in corners.iter().enumerate() {
                let place = fine.corner_barycentrics[element][corner];
                self.places[vertex as usize] = coarse.locate(fine.scene_triangle[element], place);
            }
        }
    }

    /// A field [W/m²] at the fine elements' vertices, from its values at the coarse ones'. Linear in the values.
    pub(in crate::solver) fn spread(&self, mut values: Vec<Vec3>) -> Vec<Vec3> {
        let Sources { tessellation, origins, .. } = &*self.sources;
        for (vertex, value) in fill_buried(&tessellation.mesh, origins, &values, &self.buried) {
            values[vertex] = value;
        }
        let values = SmoothValues::new(&self.smooth, tessellation, &values);
        self.places.par_iter().with_min_len(256).map(|&place| values.at(place)).collect()
    }
}
