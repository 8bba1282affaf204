//! The program's own engine for the assignment's method: direct light, then bounces of gathering, `E_{n+1} = T E_n`.
//!
//! Every vertex traces its gather rays once, and its direct light from the origins that turned out not to be buried.
//! Later bounces are sums over the kept rows; rows beyond the memory budget are traced again, to the same bits.

use std::{sync::Arc, time::Instant};

use glam::Vec3;
use rayon::prelude::*;

use super::{
    monitor::{Monitor, Stage},
    settings::SolveSettings,
    solve::{Computed, Problem, SolveReport, bounce_on, fill},
};
use crate::transport::{
    Lights, RowChunk, Transport, VertexOrigins, bytes_per_ray,
    direct::{DirectContext, ShadowRays},
    lights::FinderCounts,
    visible_light::Scratch,
};

/// Gather rays that one task traces: some 10 ms of work, and 128 KiB of rows.
const RAYS_PER_TASK: usize = 1 << 14;

/// Rays that tell whether a vertex is buried when no bounce is asked for.
const RAYS_FOR_BURIAL: u32 = 64;

/// Everything that the stages of a solve share.
struct Solve<'a> {
    problem: &'a Problem,
    monitor: &'a Monitor,
    lights: Lights,
    origins: VertexOrigins,
}

/// What one task of the first stage brings home.
struct Traced {
    rows: RowChunk,
    direct: Vec<Vec3>,
    /// Squared standard errors of `direct`.
    direct_errors: Vec<Vec3>,
    buried: Vec<bool>,
    shadow_rays: ShadowRays,
    gather_seconds: f64,
    direct_seconds: f64,
}

/// Traces and bounces.
pub(super) fn solve(problem: &Problem, monitor: &Monitor, lights: Lights, report: &mut SolveReport) -> Computed {
    let solve = Solve { problem, monitor, lights, origins: VertexOrigins::new(&problem.tessellation) };
    let traced = solve.trace_all();
    let bounces_started = Instant::now();
    enter_traced(&traced, report);
    let buried: Vec<bool> = traced.iter().flat_map(|chunk| chunk.buried.iter().copied()).collect();
    let mut direct: Vec<Vec3> = traced.iter().flat_map(|chunk| chunk.direct.iter().copied()).collect();
    fill(&problem.tessellation, monitor, &solve.origins, &mut direct, &buried);
    let direct_errors: Vec<Vec3> = traced.iter().flat_map(|chunk| chunk.direct_errors.iter().copied()).collect();
    let rows: Vec<RowChunk> = traced.into_iter().map(|chunk| chunk.rows).collect();
    let bounces =
        bounce_on(problem, &problem.tessellation, monitor, &solve.lights, direct, report, |bounces, report| {
            let mut next = solve.next_bounce(&bounces[bounces.len() - 1], &rows, report);
            fill(&problem.tessellation, monitor, &solve.origins, &mut next, &buried);
            next
        });
    if monitor.is_watched() && !monitor.is_cancelled() {
        monitor.announce_sampling_error(solve.sampling_error(&bounces, &rows, direct_errors));
    }
    report.bounce_seconds = bounces_started.elapsed().as_secs_f64();
    Computed { bounces, buried, tessellation: Arc::clone(&problem.tessellation) }
}

impl Solve<'_> {
    fn settings(&self) -> &SolveSettings {
        &self.problem.settings
    }

    fn vertex_count(&self) -> usize {
        self.problem.tessellation.mesh.positions.len()
    }

    /// True if traced rows fit the memory budget, and will be used.
    fn keeps_rows(&self) -> bool {
        let bytes =
            bytes_per_ray(&self.problem.scene) as f64 * self.vertex_count() as f64 * f64::from(self.settings().rays);
        self.settings().bounces != Some(0) && bytes <= f64::from(self.settings().row_memory) * 1024.0 * 1024.0
    }

    fn transport(&self, rays: u32) -> Transport<'_> {
        Transport {
            scene: &self.problem.scene,
            tracer: &*self.problem.tracer,
            tessellation: &self.problem.tessellation,
            targets: &self.problem.tessellation,
            origins: &self.origins,
            lights: &self.lights,
            finders: self.finders(rays),
            sampler: self.settings().sampler,
            seed: self.settings().seed,
            rays,
        }
    }

    fn finders(&self, rays: u32) -> FinderCounts {
        FinderCounts { gather: rays, light: self.settings().light_rays }
    }

    /// Vertices that one task handles.
    fn chunk_size(&self) -> usize {
        (RAYS_PER_TASK / self.settings().rays.max(1) as usize).clamp(1, 1024)
    }

    fn chunk_range(&self, chunk: usize) -> std::ops::Range<u32> {
        let size = self.chunk_size();
        let end = ((chunk + 1) * size).min(self.vertex_count());
        (chunk * size) as u32..end as u32
    }

    /// The first stage: rows, which vertices are buried, and direct light, all in one pass over the vertices.
    fn trace_all(&self) -> Vec<Traced> {
        let rays = if self.settings().bounces == Some(0) {
            self.settings().rays.min(RAYS_FOR_BURIAL)
        } else {
            self.settings().rays
        };
        let work = self.vertex_count() as u64;
        self.monitor.enter_stage(Stage::Tracing, 0, work, 1.0);
        let chunk_count = self.vertex_count().div_ceil(self.chunk_size());
        // Neighbours have numbers near each other; taken far apart, a picture is whole long before it is done.
        let order = spread_order(chunk_count);
        let traced: Vec<Traced> = order.par_iter().map(|&chunk| self.trace_chunk(chunk, rays)).collect();
        let mut in_place: Vec<Option<Traced>> = order.iter().map(|_| None).collect();
        for (chunk, traced) in order.into_iter().zip(traced) {
            in_place[chunk] = Some(traced);
        }
        in_place.into_iter().flatten().collect()
    }

    fn trace_chunk(&self, chunk: usize, rays: u32) -> Traced {
        let vertices = self.chunk_range(chunk);
        let count = vertices.len();
        let mut traced = Traced {
            rows: RowChunk::default(),
            direct: Vec::with_capacity(count),
            direct_errors: Vec::with_capacity(count),
            buried: Vec::with_capacity(count),
            shadow_rays: ShadowRays::default(),
            gather_seconds: 0.0,
            direct_seconds: 0.0,
        };
        self.monitor.wait_while_paused();
        if !self.lights.is_empty() && !self.monitor.is_cancelled() {
            self.trace_vertices(vertices, rays, &mut traced);
        }
        if !self.keeps_rows() {
            traced.rows.forget_rows();
        }
        self.monitor.advance(count as u64, traced.rows.rays + traced.shadow_rays.traced);
        traced.direct.resize(count, Vec3::ZERO);
        traced.direct_errors.resize(count, Vec3::ZERO);
        traced.buried.resize(count, false);
        traced
    }

    fn trace_vertices(&self, vertices: std::ops::Range<u32>, rays: u32, traced: &mut Traced) {
        let direct_light = DirectContext {
            scene: &self.problem.scene,
            tracer: &*self.problem.tracer,
            lights: &self.lights,
            method: self.settings().direct,
            sampler: self.settings().sampler,
            seed: self.settings().seed,
            light_rays: self.settings().light_rays,
            finders: self.finders(rays),
            is_cancelled: &|| self.monitor.is_cancelled(),
        };
        let started = Instant::now();
        let mut scratch = Scratch::default();
        let Traced { rows, direct, direct_errors, buried, shadow_rays, direct_seconds, .. } = traced;
        self.transport(rays).trace(vertices, rows, &|| self.monitor.is_cancelled(), |vertex, usable, found| {
            let since = Instant::now();
            let (irradiance, squared_error) = direct_light.irradiance(vertex, usable, found, &mut scratch, shadow_rays);
            self.monitor.add_live(vertex as usize, irradiance);
            direct.push(irradiance);
            direct_errors.push(squared_error);
            buried.push(usable.is_empty() && !self.origins.elements_around(vertex).is_empty());
            *direct_seconds += since.elapsed().as_secs_f64();
        });
        traced.gather_seconds = started.elapsed().as_secs_f64() - traced.direct_seconds;
    }

    /// The standard error of the sum of all bounces at each vertex [W/m²], the root of its mean square over the bands:
    /// that of the samples on the lights, and that of one gather of the light of all bounces. Not in it is light of
    /// emissive triangles that gather rays found, and the error of what they saw, which is a mean of many others.
    fn sampling_error(&self, bounces: &[Arc<Vec<Vec3>>], rows: &[RowChunk], direct_errors: Vec<Vec3>) -> Vec<f32> {
        let mut squared = direct_errors;
        let mut total = vec![Vec3::ZERO; self.vertex_count()];
        for bounce in &bounces[..bounces.len() - 1] {
            total.iter_mut().zip(bounce.iter()).for_each(|(sum, value)| *sum += *value);
        }
        if self.keeps_rows() {
            let transport = self.transport(self.settings().rays);
            let total = transport.outgoing(&total);
            squared.par_chunks_mut(self.chunk_size()).zip(rows).for_each(|(squared, rows)| {
                transport.squared_errors(rows, &total, |index, error| squared[index] += error);
            });
        }
        squared.into_iter().map(|error| (error.element_sum() / 3.0).sqrt()).collect()
    }

    /// E_{n+1} = T E_n over the kept rows, or over rows traced anew.
    fn next_bounce(&self, previous: &[Vec3], rows: &[RowChunk], report: &mut SolveReport) -> Vec<Vec3> {
        let transport = self.transport(self.settings().rays);
        let outgoing = transport.outgoing(previous);
        let chunks: Vec<(Vec<Vec3>, u64)> = rows
            .par_iter()
            .enumerate()
            .map(|(chunk, kept)| {
                let vertices = self.chunk_range(chunk);
                let mut irradiance = vec![Vec3::ZERO; vertices.len()];
                self.monitor.wait_while_paused();
                let (mut traced, mut rays) = (RowChunk::default(), 0);
                let kept = if self.keeps_rows() {
                    kept
                } else {
                    transport.trace(vertices.clone(), &mut traced, &|| self.monitor.is_cancelled(), |_, _, _| ());
                    rays = traced.rays;
                    &traced
                };
                if !self.monitor.is_cancelled() {
                    transport.apply(kept, &outgoing, |index, value| {
                        irradiance[index] = value;
                        self.monitor.add_live(vertices.start as usize + index, value);
                    });
                }
                self.monitor.advance(vertices.len() as u64, rays);
                (irradiance, rays)
            })
            .collect();
        report.gather_rays += chunks.iter().map(|(_, rays)| rays).sum::<u64>();
        chunks.into_iter().flat_map(|(irradiance, _)| irradiance).collect()
    }
}

/// The numbers below `count` in an order that leaves no part of them out for long: steps of the golden section.
fn spread_order(count: usize) -> Vec<usize> {
    let divisor = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let golden = (count as f64 * 0.618_033_988_749_895) as usize;
    let step = (golden.max(1)..).find(|&step| divisor(step, count) == 1).unwrap_or(1);
    let mut next = 0;
    let place = |_| {
        let place = next;
        next = (next + step) % count;
        place
    };
    (0..count).map(place).collect()
}

fn enter_traced(traced: &[Traced], report: &mut SolveReport) {
    for chunk in traced {
        report.gather_thread_seconds += chunk.gather_seconds;
        report.direct_thread_seconds += chunk.direct_seconds;
        report.gather_rays += chunk.rows.rays;
        report.gather_rays_skipped += chunk.rows.skipped;
        report.shadow_rays += chunk.shadow_rays.traced;
        report.shadow_rays_skipped += chunk.shadow_rays.skipped;
        report.row_bytes += chunk.rows.bytes() as u64;
    }
}
