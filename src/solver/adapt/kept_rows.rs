//! The gather rays of the coarse elements' vertices, to the fine elements, and one bounce over them.
//!
//! Rows are kept as far as the memory budget goes; the others are traced again at each bounce, to the same bits: from
//! the elements that were around a vertex when it was first traced, to the fine elements of that time, and from those to
//! the fine elements as they are in the end.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::Making;
use crate::{
    scene::{Tessellation, tessellate::Refinement},
    solver::solve::SolveReport,
    transport::{RowChunk, VertexOrigins},
};

/// Rows of some vertices.
pub(super) struct Rows {
    pub(super) vertices: Vec<u32>,
    /// Counts alone where the rows are not kept.
    pub(super) chunk: RowChunk,
    pub(super) kept: bool,
    /// The elements around the vertices when the rows were traced.
    pub(super) sources: Arc<Sources>,
}

/// Elements that rows leave from.
pub(super) struct Sources {
    pub(super) tessellation: Tessellation,
    pub(super) origins: VertexOrigins,
}

/// All rows.
pub(super) struct KeptRows {
    rows: Vec<Rows>,
    /// The fine elements that rows are traced to.
    targets: Arc<Tessellation>,
    /// The node of each of them, and the refinement that cut them further.
    nodes: Vec<u32>,
    refinement: Refinement,
}

impl KeptRows {
    /// Rows that were traced to `targets`, whose nodes were cut further since then.
    pub(super) fn new(
        mut rows: Vec<Rows>,
        targets: Arc<Tessellation>,
        (nodes, refinement): (Vec<u32>, Refinement),
    ) -> Self {
        rows.par_iter_mut().for_each(|rows| relocate(&mut rows.chunk, &nodes, &refinement));
        Self { rows, targets, nodes, refinement }
    }

    /// Enters what the rows cost.
    pub(super) fn enter(&self, report: &mut SolveReport) {
        for Rows { chunk, .. } in &self.rows {
            report.gather_rays += chunk.rays;
            report.gather_rays_skipped += chunk.skipped;
            report.row_bytes += chunk.bytes() as u64;
        }
    }

    /// One bounce: irradiance [W/m²] at the coarse elements' vertices when `field` arrives at the fine ones'.
    pub(super) fn apply(
        &self,
        making: &Making,
        fine: &Tessellation,
        field: &[Vec3],
        report: &mut SolveReport,
    ) -> Vec<Vec3> {
        let mut coarse = vec![Vec3::ZERO; self.vertex_count()];
        let Some(first) = self.rows.first() else { return coarse };
        let outgoing = making.transport(&first.sources, fine).outgoing(field);
        let part_of_work = field.len() as f64 / coarse.len() as f64;
        let parts: Vec<(Vec<Vec3>, u64)> = self
            .rows
            .par_iter()
            .map(|rows| {
                making.monitor.wait_while_paused();
                let mut values = vec![Vec3::ZERO; rows.vertices.len()];
                let traced_again = (!rows.kept).then(|| self.traced_again(making, rows));
                if !(making.is_cancelled)() {
                    let chunk = traced_again.as_ref().unwrap_or(&rows.chunk);
                    making.transport(&rows.sources, fine).apply(chunk, &outgoing, |index, value| values[index] = value);
                }
                let rays = traced_again.map_or(0, |chunk| chunk.rays);
                making.monitor.advance((rows.vertices.len() as f64 * part_of_work) as u64, rays);
                (values, rays)
            })
            .collect();
        for (Rows { vertices, .. }, (values, rays)) in self.rows.iter().zip(parts) {
            report.gather_rays += rays;
            for (&vertex, value) in vertices.iter().zip(values) {
                coarse[vertex as usize] = value;
            }
        }
        coarse
    }

    /// The squared standard error of one bounce's irradiance at each of `count` coarse vertices; 0 where no rows are
    /// kept.
    pub(super) fn squared_errors(
        &self,
        making: &Making,
        fine: &Tessellation,
        field: &[Vec3],
        count: usize,
    ) -> Vec<Vec3> {
        let mut errors = vec![Vec3::ZERO; count];
        let Some(first) = self.rows.first() else { return errors };
        let outgoing = making.transport(&first.sources, fine).outgoing(field);
        for rows in self.rows.iter().filter(|rows| rows.kept) {
            making.transport(&rows.sources, fine).squared_errors(&rows.chunk, &outgoing, |index, error| {
                errors[rows.vertices[index] as usize] = error;
            });
        }
        errors
    }

    fn vertex_count(&self) -> usize {
        self.rows.iter().map(|rows| rows.vertices.len()).sum()
    }

    fn traced_again(&self, making: &Making, rows: &Rows) -> RowChunk {
        let mut chunk = RowChunk::default();
        let transport = making.transport(&rows.sources, &self.targets);
        transport.trace(rows.vertices.iter().copied(), &mut chunk, making.is_cancelled, |_, _, _| ());
        relocate(&mut chunk, &self.nodes, &self.refinement);
        chunk
    }
}

/// Brings rows to the fine elements as they are in the end, from those with these nodes.
fn relocate(chunk: &mut RowChunk, nodes: &[u32], refinement: &Refinement) {
    chunk.relocate(|element, place| refinement.locate_in_node(nodes[element as usize], place));
}
