//! Coarse elements that follow indirect light: gather rays are traced at their vertices.

use std::{sync::Arc, time::Instant};

use glam::Vec3;
use rayon::prelude::*;

use super::{
    COARSEST_EDGE, Context, FINEST_EDGE, NOISE, Rounds, cut,
    direct::{DirectElements, mean_of_lit},
    edge_length,
};
use crate::{
    scene::tessellate::Refinement,
    solver::{
        buried::fill_buried,
        kept::{Rows, SmoothField, Sources},
        monitor::Stage,
    },
    trace::SurfacePoint,
    transport::{RowChunk, bytes_per_ray, rows::Outgoing},
};

/// Gather rays that one task traces.
const RAYS_PER_TASK: usize = 1 << 14;

/// What the first bounce may be off by in an element of the scene that nobody looked into, relative to mean light: one that
/// is too small for this to count is not cut to find out.
const LARGEST_DIFFERENCE: f32 = 0.25;

/// The bend that an edge from a free to a buried vertex counts for, and an element at the corner of an object's foot.
const BEND_AT_FOOT: f32 = 0.15;

/// The bend that a fall of light from a vertex in a concave crease to the rest of its element counts for, in parts of it:
/// near a crease light may change much faster than the vertices around tell, as beneath an arch.
const BEND_IN_CREASE: f32 = 0.15;

/// Rays are added to vertices at most so many times, and doubled at most so often each time: what the noise of few rays
/// says is rough.
const MOST_ROUNDS_OF_MORE_RAYS: u32 = 3;
const MOST_DOUBLINGS: u32 = 3;

pub(super) struct IndirectElements<'a> {
    context: &'a Context<'a>,
    /// Where direct light is looked up.
    fine: &'a DirectElements<'a>,
    pub(super) refinement: Refinement,
    pub(super) sources: Arc<Sources>,
    /// The first bounce [W/m²] at the vertices.
    pub(super) first_bounce: Vec<Vec3>,
    /// The gather rays' share of direct light [W/m²] at the vertices.
    pub(super) found_emission: Vec<Vec3>,
    /// The squared standard error of the first bounce at the vertices.
    squared_errors: Vec<Vec3>,
    /// For each vertex how far both were from what was expected, over the length of the edge it lies on.
    bend: Vec<f32>,
    /// The field between the vertices.
    pub(super) smooth: SmoothField,
    pub(super) buried: Vec<bool>,
    /// Rows to the fine elements.
    pub(super) rows: Vec<Rows>,
    /// What all threads together spent on tracing them.
    pub(super) seconds: f64,
    /// Rays that were asked for so far.
    asked_rays: u64,
    /// Memory for rows.
    row_bytes: u64,
    /// Mean light [W/m²] of what is lit.
    scale: f32,
    rounds: Rounds<'a>,
}

impl<'a> IndirectElements<'a> {
    pub(super) fn new(context: &'a Context<'a>, fine: &'a DirectElements<'a>) -> Self {
        let scene = &context.problem.scene;
        let mut refinement = Refinement::new(scene);
        let mut tessellation = refinement.tessellation(scene);
        loop {
            let is_long = |&element: &u32| edge_length(&tessellation, refinement.longest_edge(element)) > COARSEST_EDGE;
            let long: Vec<u32> = (0..tessellation.mesh.triangles.len() as u32).filter(is_long).collect();
            if !cut(context, &mut refinement, &long) {
                break;
            }
            tessellation = refinement.tessellation(scene);
        }
        let sources = Arc::new(Sources::by_area(Arc::new(tessellation), context.problem.settings.rays));
        let (first_bounce, found_emission, squared_errors, bend, smooth, buried, rows) = Default::default();
        let (scale, rounds) = (fine.scale, Rounds::new(context.monitor));
        Self {
            context,
            fine,
            refinement,
            sources,
            first_bounce,
            found_emission,
            squared_errors,
            bend,
            smooth,
            buried,
            rows,
            seconds: 0.0,
            asked_rays: 0,
            row_bytes: context.problem.settings.row_bytes(),
            scale,
            rounds,
        }
    }

    /// Cuts until the light that rays gather at new vertices is near what was expected there; then traces more rays where
    /// their noise is larger than `noise`, relative to mean light.
    pub(super) fn follow_light(&mut self, tolerance: f32, noise: f32) {
        let count = self.sources.tessellation.mesh.positions.len();
        if self.context.problem.settings.bounces == Some(0) || self.context.lights.is_empty() {
            (self.first_bounce, self.buried) = (vec![Vec3::ZERO; count], vec![false; count]);
            self.found_emission = vec![Vec3::ZERO; count];
            self.smooth = self.smooth_field();
            return;
        }
        self.context.monitor.enter_stage(Stage::FollowingIndirect, 0, 1, 1.0);
        self.gather_new();
        self.smooth = self.smooth_field();
        self.bend = vec![0.0; count];
        if self.fine.is_dark() {
            self.scale = mean_of_lit(&self.gathered(), &self.sources.tessellation.vertex_areas());
        }
        let is_worth_a_look = |&element: &u32| {
            let length = edge_length(&self.sources.tessellation, self.refinement.longest_edge(element));
            LARGEST_DIFFERENCE * length > tolerance
        };
        let elements = 0..self.sources.tessellation.mesh.triangles.len() as u32;
        let mut wanted: Vec<u32> = elements.filter(is_worth_a_look).collect();
        loop {
            let Sources { tessellation, origins, .. } = &*self.sources;
            let mut known = self.gathered();
            for (vertex, value) in fill_buried(&tessellation.mesh, origins, &known, &self.buried) {
                known[vertex] = value;
            }
            let first_new_node = self.refinement.node_count();
            if !cut(self.context, &mut self.refinement, &wanted) {
                break;
            }
            let tessellation = self.refinement.tessellation(&self.context.problem.scene);
            self.sources = Arc::new(Sources::by_area(Arc::new(tessellation), self.context.problem.settings.rays));
            self.gather_new();
            self.measure_bends(&known);
            self.smooth = self.smooth_field();
            wanted = self.bent_elements(first_new_node, tolerance);
        }
        self.trace_more_rays(noise);
    }

    /// What lies between the vertices as they are now.
    fn smooth_field(&self) -> SmoothField {
        SmoothField::new(&self.sources.tessellation, &self.sources.origins, &self.buried)
    }

    /// All light that rays gathered [W/m²], at each vertex.
    fn gathered(&self) -> Vec<Vec3> {
        self.first_bounce.iter().zip(&self.found_emission).map(|(bounce, found)| *bounce + *found).collect()
    }

    /// How far the first bounce at the new vertices is from what the field `known` before them expects.
    fn measure_bends(&mut self, known: &[Vec3]) {
        let gradients = self.smooth.gradients(known);
        for (vertex, gathered) in self.gathered().into_iter().enumerate().skip(known.len()) {
            let ends = self.refinement.parents()[vertex];
            let [a, b] = ends.map(|end| end as usize);
            let surplus = self.smooth.surplus(&self.sources.tessellation.mesh, known, &gradients, ends);
            let expected = 0.5 * (known[a] + known[b]) + surplus;
            let all_buried = self.buried[a] && self.buried[b];
            let is_compared = !self.buried[vertex] && !all_buried;
            // What may be noise of the samples says nothing.
            let [error, error_a, error_b] = [vertex, a, b].map(|vertex| self.squared_errors[vertex]);
            let noise = NOISE * (error + 0.25 * (error_a + error_b)).max_element().sqrt();
            let difference = (gathered - expected).abs().max_element();
            let difference = if difference > noise { difference / self.scale } else { 0.0 };
            self.bend.push(if is_compared { difference / edge_length(&self.sources.tessellation, ends) } else { 0.0 });
        }
    }

    /// The elements with new nodes that are too coarse still.
    fn bent_elements(&self, first_new_node: u32, tolerance: f32) -> Vec<u32> {
        let nodes: Vec<u32> = self.refinement.nodes().collect();
        let tessellation = &self.sources.tessellation;
        let gathered = self.gathered();
        let is_bent = |&element: &u32| {
            let corners = tessellation.mesh.triangles[element as usize].map(|vertex| vertex as usize);
            let length = edge_length(tessellation, self.refinement.longest_edge(element));
            if nodes[element as usize] < first_new_node || length < FINEST_EDGE {
                return false;
            }
            let bend = corners.iter().fold(0.0, |bend, &vertex| self.bend[vertex].max(bend)) * length;
            let at_border = match corners.iter().filter(|&&vertex| self.buried[vertex]).count() {
                0 if corners.iter().any(|&vertex| self.smooth.at_foot[vertex]) => BEND_AT_FOOT,
                0 => BEND_IN_CREASE * largest_fall(corners, &gathered, &self.smooth.in_crease) / self.scale,
                3 => 0.0,
                _ => BEND_AT_FOOT,
            };
            bend.max(at_border) * length > tolerance
        };
        (0..nodes.len() as u32).filter(is_bent).collect()
    }

    /// Traces rows anew where the noise of their rays counts most, until the estimate for all of them is no larger than
    /// asked for, relative to mean light.
    fn trace_more_rays(&mut self, noise: f32) {
        for _ in 0..MOST_ROUNDS_OF_MORE_RAYS {
            let Some(rays) = self.rays_for(noise) else { return };
            let before = self.sources.rays.as_ref();
            let is_more = |vertex: u32| before.is_some_and(|old| rays[vertex as usize] > old[vertex as usize]);
            let vertices: Vec<u32> = (0..rays.len() as u32).filter(|&vertex| is_more(vertex)).collect();
            if vertices.is_empty() || self.context.is_cancelled() {
                return;
            }
            self.rows.par_iter_mut().for_each(|rows| rows.drop_vertices(is_more));
            // Copied only where rows are not kept, and will be traced again as they were.
            Arc::make_mut(&mut self.sources).rays = Some(rays);
            self.gather(vertices);
            self.smooth = self.smooth_field();
        }
    }

    /// Rays for each vertex, no fewer than it had. A vertex of area a has a squared error of s²/n with n rays; its mean over
    /// the area is what is allowed, with the fewest rays in all, where n is in proportion to s √a.
    fn rays_for(&self, noise: f32) -> Option<Vec<u32>> {
        let areas = self.sources.tessellation.vertex_areas();
        let mut rays = self.sources.rays.clone()?;
        let weight = |vertex: usize| {
            let variance = f64::from(self.squared_errors[vertex].element_sum() / 3.0) * f64::from(rays[vertex]);
            (variance * f64::from(areas[vertex])).sqrt()
        };
        let weights: Vec<f64> = (0..areas.len()).map(weight).collect();
        let lit = (0..areas.len()).filter(|&vertex| self.first_bounce[vertex] != Vec3::ZERO);
        let area: f64 = lit.map(|vertex| f64::from(areas[vertex])).sum();
        let rays_per_weight = weights.iter().sum::<f64>() / (f64::from(noise * self.scale).powi(2) * area);
        for (rays, weight) in rays.iter_mut().zip(weights) {
            // Doubled, so that Sobol points stay whole sets.
            let doublings = (weight * rays_per_weight / f64::from(*rays)).log2().round();
            *rays = rays.saturating_mul(1 << (doublings.max(0.0) as u32).min(MOST_DOUBLINGS));
        }
        Some(rays)
    }

    /// Traces the rows of the new vertices.
    fn gather_new(&mut self) {
        let (before, count) = (self.first_bounce.len(), self.sources.tessellation.mesh.positions.len());
        for field in [&mut self.first_bounce, &mut self.squared_errors, &mut self.found_emission] {
            field.resize(count, Vec3::ZERO);
        }
        self.buried.resize(count, false);
        self.gather((before as u32..count as u32).collect());
    }

    /// Traces the rows of some vertices, and applies them to direct light.
    fn gather(&mut self, vertices: Vec<u32>) {
        let Context { problem, monitor, is_cancelled, .. } = *self.context;
        let transport = self.context.transport(&self.sources, &self.fine.tessellation);
        let outgoing = Outgoing::new(&problem.scene, &self.fine.tessellation, &self.fine.field());
        let per_task = (RAYS_PER_TASK / problem.settings.rays.max(1) as usize).clamp(1, 1024);
        self.rounds.begin(vertices.len() as u64);
        let bytes = bytes_per_ray(&problem.scene) as u64;
        let mut asked = self.asked_rays;
        let asked_until = |&vertex: &u32| {
            asked += u64::from(transport.rays_of(vertex));
            asked
        };
        let asked_until: Vec<u64> = vertices.iter().map(asked_until).collect();
        let traced: Vec<_> = vertices
            .par_chunks(per_task)
            .zip(asked_until.par_chunks(per_task))
            .map(|(vertices, asked_until)| {
                monitor.wait_while_paused();
                let (mut chunk, mut buried, mut emission) = (RowChunk::default(), Vec::new(), Vec::new());
                let receive = |vertex, usable: &[SurfacePoint], found: &[Vec3]| {
                    buried.push(usable.is_empty() && !self.sources.origins.elements_around(vertex).is_empty());
                    emission.push(found.iter().sum());
                };
                let started = Instant::now();
                transport.trace(vertices.iter().copied(), &mut chunk, is_cancelled, receive);
                let seconds = started.elapsed().as_secs_f64();
                let mut values = vec![Vec3::ZERO; vertices.len()];
                chunk.apply(&outgoing, |index, value| values[index] = value);
                let mut errors = vec![Vec3::ZERO; vertices.len()];
                chunk.squared_errors(&outgoing, |index, error| errors[index] = error);
                buried.resize(vertices.len(), false);
                emission.resize(vertices.len(), Vec3::ZERO);
                let kept = asked_until.last().is_none_or(|&rays| bytes * rays <= self.row_bytes);
                if !kept {
                    chunk.forget_rows();
                }
                monitor.advance(vertices.len() as u64, chunk.rays);
                (vertices.to_vec(), (chunk, kept, seconds), (values, errors), (emission, buried))
            })
            .collect();
        self.asked_rays = asked;
        for (vertices, (chunk, kept, seconds), (values, errors), (emission, buried)) in traced {
            self.seconds += seconds;
            for (index, &vertex) in vertices.iter().enumerate() {
                let vertex = vertex as usize;
                (self.first_bounce[vertex], self.squared_errors[vertex]) = (values[index], errors[index]);
                (self.found_emission[vertex], self.buried[vertex]) = (emission[index], buried[index]);
            }
            let sources = (!kept).then(|| Arc::clone(&self.sources));
            self.rows.push(Rows { vertices, chunk, sources });
        }
    }
}

/// The largest difference [W/m²] between corners in a concave crease and others; 0 if there are no such.
fn largest_fall(corners: [usize; 3], gathered: &[Vec3], in_crease: &[bool]) -> f32 {
    let pairs = corners.into_iter().flat_map(|a| corners.map(|b| (a, b)));
    let across = pairs.filter(|&(a, b)| in_crease[a] && !in_crease[b]);
    across.map(|(a, b)| (gathered[a] - gathered[b]).abs().max_element()).fold(0.0, f32::max)
}
