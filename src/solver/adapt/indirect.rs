//! Coarse elements that follow indirect light: gather rays are traced at their vertices.

use glam::Vec3;
use rayon::prelude::*;

use super::{COARSEST_EDGE, FINEST_EDGE, Making, direct::DirectElements, edge_length, smooth::SmoothField};
use crate::{
    scene::{Tessellation, tessellate::Refinement},
    solver::buried::fill_buried,
    trace::SurfacePoint,
    transport::{RowChunk, Transport, VertexOrigins, lights::FinderCounts},
};

/// Gather rays that one task traces.
const RAYS_PER_TASK: usize = 1 << 14;

/// The bend that an edge from a free to a buried vertex counts for: what lies along an object's foot.
const BEND_AT_FOOT: f32 = 0.15;

pub(super) struct IndirectElements<'a> {
    making: &'a Making<'a>,
    /// Where direct light is looked up.
    fine: &'a DirectElements<'a>,
    refinement: Refinement,
    pub(super) tessellation: Tessellation,
    pub(super) origins: VertexOrigins,
    /// The first bounce [W/m²] at the vertices.
    pub(super) first_bounce: Vec<Vec3>,
    /// For each vertex how far the first bounce was from what was expected, over the length of the edge it lies on.
    bend: Vec<f32>,
    pub(super) buried: Vec<bool>,
    /// Rows to the fine elements with the vertices that they are of.
    pub(super) rows: Vec<(Vec<u32>, RowChunk)>,
}

impl<'a> IndirectElements<'a> {
    pub(super) fn new(making: &'a Making<'a>, fine: &'a DirectElements<'a>) -> Result<Self, String> {
        let mut refinement = Refinement::new(making.scene, &making.settings.tessellation())?;
        let mut tessellation = refinement.tessellation(making.scene);
        loop {
            let is_long = |&element: &u32| edge_length(&tessellation, refinement.longest_edge(element)) > COARSEST_EDGE;
            let long: Vec<u32> = (0..tessellation.mesh.triangles.len() as u32).filter(is_long).collect();
            if !making.cut(&mut refinement, &long)? {
                break;
            }
            tessellation = refinement.tessellation(making.scene);
        }
        let origins = VertexOrigins::new(&tessellation);
        let (first_bounce, bend, buried, rows) = Default::default();
        Ok(Self { making, fine, refinement, tessellation, origins, first_bounce, bend, buried, rows })
    }

    /// Cuts until the first bounce at new vertices is near what was expected there.
    pub(super) fn follow_light(&mut self, tolerance: f32) -> Result<(), String> {
        if self.making.settings.bounces == Some(0) || self.making.lights.is_empty() {
            let count = self.tessellation.mesh.positions.len();
            (self.first_bounce, self.buried) = (vec![Vec3::ZERO; count], vec![false; count]);
            return Ok(());
        }
        self.gather(0);
        self.bend = vec![0.0; self.first_bounce.len()];
        let mut wanted: Vec<u32> = (0..self.tessellation.mesh.triangles.len() as u32).collect();
        loop {
            let first_new_node = self.refinement.node_count();
            let before = self.first_bounce.len();
            let mut known = self.first_bounce.clone();
            for (vertex, value) in fill_buried(&self.tessellation.mesh, &self.origins, &known, &self.buried) {
                known[vertex] = value;
            }
            let smooth = SmoothField::new(&self.tessellation, &self.origins, &self.buried);
            if !self.making.cut(&mut self.refinement, &wanted)? {
                return Ok(());
            }
            self.tessellation = self.refinement.tessellation(self.making.scene);
            self.origins = VertexOrigins::new(&self.tessellation);
            self.gather(before);
            if (self.making.is_cancelled)() {
                return Err(String::from("cancelled"));
            }
            self.measure_bends(before, &known, &smooth);
            wanted = self.bent_elements(first_new_node, tolerance);
        }
    }

    /// How far the first bounce at the vertices from `first` on is from what the field before expects.
    fn measure_bends(&mut self, first: usize, known: &[Vec3], smooth: &SmoothField) {
        let gradients = smooth.gradients(known);
        for vertex in first..self.first_bounce.len() {
            let ends = self.refinement.parents()[vertex];
            let [a, b] = ends.map(|end| end as usize);
            let surplus = smooth.surplus(&self.tessellation.mesh, known, &gradients, ends);
            let expected = 0.5 * (known[a] + known[b]) + surplus;
            let all_buried = self.buried[a] && self.buried[b];
            let is_compared = !self.buried[vertex] && !all_buried;
            let difference = (self.first_bounce[vertex] - expected).abs().max_element() / self.fine.scale;
            self.bend.push(if is_compared { difference / edge_length(&self.tessellation, ends) } else { 0.0 });
        }
    }

    /// The elements with new nodes that are too coarse still.
    fn bent_elements(&self, first_new_node: u32, tolerance: f32) -> Vec<u32> {
        let nodes: Vec<u32> = self.refinement.nodes().collect();
        let is_bent = |&element: &u32| {
            let corners = self.tessellation.mesh.triangles[element as usize].map(|vertex| vertex as usize);
            let length = edge_length(&self.tessellation, self.refinement.longest_edge(element));
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
        let Making { scene, tracer, settings, .. } = *self.making;
        let transport = Transport {
            scene,
            tracer,
            tessellation: &self.tessellation,
            targets: &self.fine.tessellation,
            origins: &self.origins,
            lights: &self.making.lights,
            finders: FinderCounts { gather: 0, light: settings.light_rays },
            sampler: settings.sampler,
            seed: settings.seed,
            rays: settings.rays,
        };
        let outgoing = transport.outgoing(&self.fine.direct);
        let per_task = (RAYS_PER_TASK / settings.rays.max(1) as usize).clamp(1, 1024);
        let vertices: Vec<u32> = (first as u32..self.tessellation.mesh.positions.len() as u32).collect();
        let traced: Vec<_> = vertices
            .par_chunks(per_task)
            .map(|vertices| {
                let (mut chunk, mut buried) = (RowChunk::default(), Vec::new());
                let receive = |vertex, usable: &[SurfacePoint], _: &[Vec3]| {
                    buried.push(usable.is_empty() && !self.origins.elements_around(vertex).is_empty());
                };
                transport.trace(vertices.iter().copied(), &mut chunk, self.making.is_cancelled, receive);
                let mut values = vec![Vec3::ZERO; vertices.len()];
                transport.apply(&chunk, &outgoing, |index, value| values[index] = value);
                buried.resize(vertices.len(), false);
                (vertices.to_vec(), chunk, values, buried)
            })
            .collect();
        for (vertices, chunk, values, buried) in traced {
            self.first_bounce.extend(values);
            self.buried.extend(buried);
            self.rows.push((vertices, chunk));
        }
    }
}
