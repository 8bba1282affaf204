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
    transport::{RowChunk, bytes_per_ray},
};

/// Gather rays that one task traces.
const RAYS_PER_TASK: usize = 1 << 14;

/// What the first bounce may be off by in an element of the scene that nobody looked into, relative to mean light: one that
/// is too small for this to count is not cut to find out.
const LARGEST_DIFFERENCE: f32 = 0.25;

/// The bend that an edge from a free to a buried vertex counts for: what lies along an object's foot.
const BEND_AT_FOOT: f32 = 0.15;

pub(super) struct IndirectElements<'a> {
    context: &'a Context<'a>,
    /// Where direct light is looked up.
    fine: &'a DirectElements<'a>,
    refinement: Refinement,
    pub(super) sources: Arc<Sources>,
    /// The first bounce [W/m²] at the vertices.
    pub(super) first_bounce: Vec<Vec3>,
    /// The gather rays' share of direct light [W/m²] at the vertices.
    pub(super) found_emission: Vec<Vec3>,
    /// The squared standard error of the first bounce at the vertices.
    squared_errors: Vec<Vec3>,
    /// For each vertex how far both were from what was expected, over the length of the edge it lies on.
    bend: Vec<f32>,
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
        let (first_bounce, found_emission, squared_errors, bend, buried, rows) = Default::default();
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
            buried,
            rows,
            seconds: 0.0,
            asked_rays: 0,
            row_bytes: context.problem.settings.row_bytes(),
            scale,
            rounds,
        }
    }

    /// Cuts until the light that rays gather at new vertices is near what was expected there.
    pub(super) fn follow_light(&mut self, tolerance: f32) {
        let count = self.sources.tessellation.mesh.positions.len();
        if self.context.problem.settings.bounces == Some(0) || self.context.lights.is_empty() {
            (self.first_bounce, self.buried) = (vec![Vec3::ZERO; count], vec![false; count]);
            self.found_emission = vec![Vec3::ZERO; count];
            return;
        }
        self.context.monitor.enter_stage(Stage::FollowingIndirect, 0, 1, 1.0);
        self.gather(0);
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
            let first_new_node = self.refinement.node_count();
            let before = self.first_bounce.len();
            let Sources { tessellation, origins, .. } = &*self.sources;
            let mut known = self.gathered();
            for (vertex, value) in fill_buried(&tessellation.mesh, origins, &known, &self.buried) {
                known[vertex] = value;
            }
            let smooth = SmoothField::new(tessellation, origins, &self.buried);
            if !cut(self.context, &mut self.refinement, &wanted) {
                return;
            }
            let tessellation = self.refinement.tessellation(&self.context.problem.scene);
            self.sources = Arc::new(Sources::by_area(Arc::new(tessellation), self.context.problem.settings.rays));
            self.gather(before);
            self.measure_bends(before, &known, &smooth);
            wanted = self.bent_elements(first_new_node, tolerance);
        }
    }

    /// All light that rays gathered [W/m²], at each vertex.
    fn gathered(&self) -> Vec<Vec3> {
        self.first_bounce.iter().zip(&self.found_emission).map(|(bounce, found)| *bounce + *found).collect()
    }

    /// How far the first bounce at the vertices from `first` on is from what the field before expects.
    fn measure_bends(&mut self, first: usize, known: &[Vec3], smooth: &SmoothField) {
        let gradients = smooth.gradients(known);
        for (vertex, gathered) in self.gathered().into_iter().enumerate().skip(first) {
            let ends = self.refinement.parents()[vertex];
            let [a, b] = ends.map(|end| end as usize);
            let surplus = smooth.surplus(&self.sources.tessellation.mesh, known, &gradients, ends);
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
        let is_bent = |&element: &u32| {
            let corners = tessellation.mesh.triangles[element as usize].map(|vertex| vertex as usize);
            let length = edge_length(tessellation, self.refinement.longest_edge(element));
            if nodes[element as usize] < first_new_node || length < FINEST_EDGE {
                return false;
            }
            let buried = corners.iter().filter(|&&vertex| self.buried[vertex]).count();
            let at_foot = if buried == 1 || buried == 2 { BEND_AT_FOOT } else { 0.0 };
            let bend = corners.iter().fold(0.0, |bend, &vertex| self.bend[vertex].max(bend)) * length;
            bend.max(at_foot) * length > tolerance
        };
        (0..nodes.len() as u32).filter(is_bent).collect()
    }

    /// Traces the rows of the vertices from `first` on, and applies them to direct light.
    fn gather(&mut self, first: usize) {
        let Context { problem, monitor, is_cancelled, .. } = *self.context;
        let transport = self.context.transport(&self.sources, &self.fine.tessellation);
        let outgoing = transport.outgoing(&self.fine.field());
        let per_task = (RAYS_PER_TASK / problem.settings.rays.max(1) as usize).clamp(1, 1024);
        let vertices: Vec<u32> = (first as u32..self.sources.tessellation.mesh.positions.len() as u32).collect();
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
                transport.apply(&chunk, &outgoing, |index, value| values[index] = value);
                let mut errors = vec![Vec3::ZERO; vertices.len()];
                transport.squared_errors(&chunk, &outgoing, |index, error| errors[index] = error);
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
            self.first_bounce.extend(values);
            self.squared_errors.extend(errors);
            self.found_emission.extend::<Vec<Vec3>>(emission);
            self.buried.extend(buried);
            self.rows.push(Rows { vertices, chunk, kept, sources: Arc::clone(&self.sources) });
        }
    }
}
