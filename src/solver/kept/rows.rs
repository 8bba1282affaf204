//! The gather rays of a solve, and one bounce over them.
//!
//! Rows are kept as far as the memory budget goes; the others are traced again at each bounce, to the same bits: from
//! the elements that were around a vertex when it was first traced, to the elements of that time, and from those to
//! the elements as they are in the end.

use std::{sync::Arc, time::Instant};

use glam::Vec3;
use rayon::prelude::*;

use super::Context;
use crate::{
    scene::{Scene, Tessellation, tessellate::Refinement},
    solver::solve::SolveReport,
    transport::{RowChunk, VertexOrigins, rows::Outgoing},
};

/// Rows of some vertices.
pub(in crate::solver) struct Rows {
    pub(in crate::solver) vertices: Vec<u32>,
    /// Counts alone where the rows are not kept.
    pub(in crate::solver) chunk: RowChunk,
    /// The elements around the vertices when the rows were traced, if they are not kept and must be traced again.
    pub(in crate::solver) sources: Option<Arc<Sources>>,
}

impl Rows {
    /// Takes the rows of some vertices out.
    pub(in crate::solver) fn drop_vertices(&mut self, is_dropped: impl Fn(u32) -> bool) {
        if !self.vertices.iter().any(|&vertex| is_dropped(vertex)) {
            return;
        }
        self.chunk.retain_rows(|index| !is_dropped(self.vertices[index]));
        self.vertices.retain(|&vertex| !is_dropped(vertex));
    }
}

/// Elements that rows leave from.
#[derive(Clone)]
pub(in crate::solver) struct Sources {
    pub(in crate::solver) tessellation: Arc<Tessellation>,
    pub(in crate::solver) origins: VertexOrigins,
    /// Rays of each vertex, where they are not all the same.
    pub(in crate::solver) rays: Option<Vec<u32>>,
}

/// What has less than this part of all surface around it gets fewer rays.
const WHOLE_SHARE: f32 = 1.0 / 16_000.0;

/// No vertex gets fewer rays, if so many are asked for.
const FEWEST_RAYS: u32 = 64;

impl Sources {
    pub(in crate::solver) fn new(tessellation: Arc<Tessellation>) -> Self {
        Self { origins: VertexOrigins::new(&tessellation), tessellation, rays: None }
    }

    /// The vertices of a tessellation with rays in proportion to the root of the area that each stands for, which makes
    /// the least error of them: the variance of a vertex counts by its area. The largest get `most`, others a half, a
    /// quarter or less, so that Sobol points stay whole sets.
    pub(in crate::solver) fn by_area(tessellation: Arc<Tessellation>, most: u32) -> Self {
        let areas = tessellation.vertex_areas();
        let whole = WHOLE_SHARE * areas.iter().sum::<f32>();
        let halvings = |area: f32| (0.5 * (whole / area).log2()).clamp(0.0, 31.0) as u32;
        let rays = |&area: &f32| (most >> halvings(area)).max(most.min(FEWEST_RAYS));
        Self { rays: Some(areas.iter().map(rays).collect()), ..Self::new(tessellation) }
    }
}

/// All rows: of every vertex that gathers.
pub(in crate::solver) struct KeptRows {
    rows: Vec<Rows>,
    vertex_count: usize,
    /// The elements that rows are traced to.
    targets: Arc<Tessellation>,
    /// The node of each of them and the refinement that cut them further, if one did.
    cut_since: Option<(Vec<u32>, Refinement)>,
}

impl KeptRows {
    /// Rows of so many vertices that were traced to `targets`, whose nodes were cut further since then.
    pub(in crate::solver) fn new(
        mut rows: Vec<Rows>,
        targets: Arc<Tessellation>,
        cut_since: Option<(Vec<u32>, Refinement)>,
        vertex_count: usize,
    ) -> Self {
        if let Some((nodes, refinement)) = &cut_since {
            rows.par_iter_mut().for_each(|rows| relocate(&mut rows.chunk, nodes, refinement));
        }
        let cut_since = cut_since.filter(|_| rows.iter().any(|rows| rows.sources.is_some()));
        Self { rows, vertex_count, targets, cut_since }
    }

    /// Enters what the rows cost, and which textures they never meet.
    pub(in crate::solver) fn enter(&self, scene: &Scene, report: &mut SolveReport) {
        let mut is_touched = vec![false; scene.textures.len()];
        for Rows { chunk, .. } in &self.rows {
            for (material, _) in scene.materials.iter().zip(chunk.touched_materials()).filter(|(_, touched)| **touched)
            {
                material.reflectance_texture.iter().for_each(|&texture| is_touched[texture as usize] = true);
            }
            report.gather_rays += chunk.rays;
            report.gather_rays_skipped += chunk.skipped;
            report.row_bytes += chunk.bytes() as u64;
        }
        // Cut-outs are looked up while rays are traced.
        let opacities = scene.materials.iter().filter_map(|material| material.opacity_texture);
        opacities.for_each(|texture| is_touched[texture as usize] = true);
        report.textures_untouched = is_touched.into_iter().filter(|is_touched| !is_touched).count() as u64;
    }

    /// True if no ray has to be traced for a bounce.
    pub(super) fn are_all_kept(&self) -> bool {
        self.rows.iter().all(|rows| rows.sources.is_none())
    }

    /// One bounce: irradiance [W/m²] at the vertices that gather when `field` arrives at those of the elements. Each
    /// value is shown to `receive` as soon as it is known.
    pub(super) fn apply(
        &self,
        context: &Context,
        fine: &Tessellation,
        field: &[Vec3],
        receive: &(dyn Fn(u32, Vec3) + Sync),
        report: &mut SolveReport,
    ) -> Vec<Vec3> {
        let mut gathered = vec![Vec3::ZERO; self.vertex_count];
        self.apply_part(context, fine, field, 0..self.rows.len(), &mut gathered, receive, report);
        gathered
    }

    /// The same for one of `count` parts of the rows; the other vertices keep what is in `gathered`.
    pub(super) fn apply_to_part(
        &self,
        context: &Context,
        fine: &Tessellation,
        field: &[Vec3],
        (part, count): (usize, usize),
        gathered: &mut [Vec3],
        report: &mut SolveReport,
    ) {
        let place = |part: usize| part * self.rows.len() / count;
        self.apply_part(context, fine, field, place(part)..place(part + 1), gathered, &|_, _| (), report);
    }

    #[expect(clippy::too_many_arguments, reason = "what both callers have in hand")]
    fn apply_part(
        &self,
        context: &Context,
        fine: &Tessellation,
        field: &[Vec3],
        part: std::ops::Range<usize>,
        gathered: &mut [Vec3],
        receive: &(dyn Fn(u32, Vec3) + Sync),
        report: &mut SolveReport,
    ) {
        let outgoing = Outgoing::new(&context.problem.scene, fine, field);
        let part_of_work = field.len() as f64 / self.vertex_count as f64;
        let parts: Vec<(Vec<Vec3>, u64, u64, f64)> = self.rows[part.clone()]
            .par_iter()
            .map(|rows| {
                context.monitor.wait_while_paused();
                let mut values = vec![Vec3::ZERO; rows.vertices.len()];
                let started = Instant::now();
                let sources = rows.sources.as_ref();
                let traced_again = sources.map(|sources| self.traced_again(context, sources, &rows.vertices));
                let seconds = if traced_again.is_none() { 0.0 } else { started.elapsed().as_secs_f64() };
                if !context.is_cancelled() {
                    let chunk = traced_again.as_ref().unwrap_or(&rows.chunk);
                    chunk.apply(&outgoing, |index, value| {
                        values[index] = value;
                        receive(rows.vertices[index], value);
                    });
                }
                let reused = if traced_again.is_none() { rows.chunk.rays } else { 0 };
                let rays = traced_again.map_or(0, |chunk| chunk.rays);
                context.monitor.advance((rows.vertices.len() as f64 * part_of_work) as u64, rays);
                (values, rays, reused, seconds)
            })
            .collect();
        for (Rows { vertices, .. }, (values, rays, reused, seconds)) in self.rows[part].iter().zip(parts) {
            report.gather_rays += rays;
            report.gather_thread_seconds += seconds;
            report.gather_rays_reused += reused;
            for (&vertex, value) in vertices.iter().zip(values) {
                gathered[vertex as usize] = value;
            }
        }
    }

    /// The squared standard error of one bounce's irradiance at each vertex that gathers; 0 where no rows are kept.
    pub(super) fn squared_errors(&self, context: &Context, fine: &Tessellation, field: &[Vec3]) -> Vec<Vec3> {
        let mut errors = vec![Vec3::ZERO; self.vertex_count];
        let outgoing = Outgoing::new(&context.problem.scene, fine, field);
        let of_rows = |rows: &Rows| {
            let mut errors = vec![Vec3::ZERO; rows.vertices.len()];
            rows.chunk.squared_errors(&outgoing, |index, error| errors[index] = error);
            errors
        };
        let found: Vec<Vec<Vec3>> = self.rows.par_iter().map(of_rows).collect();
        for (rows, found) in self.rows.iter().zip(found) {
            for (&vertex, error) in rows.vertices.iter().zip(found) {
                errors[vertex as usize] = error;
            }
        }
        errors
    }

    fn traced_again(&self, context: &Context, sources: &Sources, vertices: &[u32]) -> RowChunk {
        let mut chunk = RowChunk::default();
        let transport = context.transport(sources, &self.targets);
        transport.trace(vertices.iter().copied(), &mut chunk, &|| context.is_cancelled(), |_, _, _| ());
        if let Some((nodes, refinement)) = &self.cut_since {
            relocate(&mut chunk, nodes, refinement);
        }
        chunk
    }
}

/// Brings rows to the elements as they are in the end, from those with these nodes.
fn relocate(chunk: &mut RowChunk, nodes: &[u32], refinement: &Refinement) {
    chunk.relocate(|element, place| refinement.locate_in_node(nodes[element as usize], place));
}
