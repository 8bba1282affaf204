//! The assignment's method: direct light, then bounces of gathering, `E_{n+1} = T E_n` (Neumann series).
//!
//! Every vertex traces its gather rays once, and its direct light from the origins that turned out not to be buried.
//! Later bounces are sums over the kept rows; rows beyond the memory budget are traced again, to the same bits.

use std::{sync::Arc, time::Instant};

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    buried::fill_buried,
    energy::{Ledger, VertexWeights},
    monitor::{Monitor, Stage},
    settings::SolveSettings,
    solution::{Solution, SolutionInfo},
};
use crate::{
    scene::{LoadOptions, Scene, Tessellation, area_light::AreaLightState},
    trace::RayTracer,
    transport::{
        Lights, RowChunk, Transport, VertexOrigins,
        direct::{DirectContext, ShadowRays},
        lights::FinderCounts,
    },
};

/// What is to be solved.
#[derive(Clone)]
pub struct Problem {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its ray tracer.
    pub tracer: Arc<dyn RayTracer>,
    /// Its elements.
    pub tessellation: Arc<Tessellation>,
    /// How the scene was read: kept with the solution, so that it can be read so again.
    pub load: LoadOptions,
    /// The placed area light, if any.
    pub light: Option<AreaLightState>,
    /// The settings.
    pub settings: SolveSettings,
}

/// What a solve did, for reports.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SolveReport {
    /// Wall-clock seconds of the whole solve.
    pub seconds: f64,
    /// Seconds of all threads together spent on gather rays.
    pub gather_thread_seconds: f64,
    /// Seconds of all threads together spent on direct light.
    pub direct_thread_seconds: f64,
    /// Wall-clock seconds of the bounces after the rays were traced.
    pub bounce_seconds: f64,
    /// Gather rays traced.
    pub gather_rays: u64,
    /// Gather rays that needed no tracing.
    pub gather_rays_skipped: u64,
    /// Shadow rays traced.
    pub shadow_rays: u64,
    /// Shadow rays that needed no tracing.
    pub shadow_rays_skipped: u64,
    /// Bytes of the kept rows; 0 if they were traced anew at each bounce.
    pub row_bytes: u64,
    /// Vertices that see mostly back faces.
    pub buried_vertices: u64,
    /// Fraction of the emitted power that is still unabsorbed.
    pub unabsorbed: f64,
    /// Where the power went.
    pub energy: Ledger,
}

/// Gather rays that one task traces: some 10 ms of work, and 128 KiB of rows.
const RAYS_PER_TASK: usize = 1 << 14;

/// Without a bounce limit, no more than this many.
const MOST_BOUNCES: u32 = 1000;

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
    buried: Vec<bool>,
    shadow_rays: ShadowRays,
    gather_seconds: f64,
    direct_seconds: f64,
}

/// Solves. A cancelled solve returns what it has, with [`SolutionInfo::complete`] false.
pub fn solve(problem: &Problem, monitor: &Monitor) -> (Solution, SolveReport) {
    let started = Instant::now();
    let scene = &problem.scene;
    let lights = Lights::new(scene, problem.light.map(|light| light.to_local(&scene.frame)));
    let emitted = lights.emitted_power(scene).as_dvec3() * scene.frame.square_metres_per_unit();
    let solve = Solve { problem, monitor, lights, origins: VertexOrigins::new(&problem.tessellation) };
    let weights = VertexWeights::new(scene, &problem.tessellation);

    let traced = solve.trace_all();
    let bounces_started = Instant::now();
    let mut report = SolveReport::of_traced(&traced, emitted);
    let buried: Vec<bool> = traced.iter().flat_map(|chunk| chunk.buried.iter().copied()).collect();
    report.buried_vertices = buried.iter().filter(|&&is_buried| is_buried).count() as u64;
    let mut direct: Vec<Vec3> = traced.iter().flat_map(|chunk| chunk.direct.iter().copied()).collect();
    solve.fill(&mut direct, &buried);
    let rows: Vec<RowChunk> = traced.into_iter().map(|chunk| chunk.rows).collect();
    let bounces = solve.bounce_on(direct, &rows, &buried, &weights, &mut report);

    report.unabsorbed = report.energy.unabsorbed();
    report.bounce_seconds = bounces_started.elapsed().as_secs_f64();
    report.seconds = started.elapsed().as_secs_f64();
    let bounces = bounces.into_iter().map(Arc::unwrap_or_clone).collect();
    (Solution { info: solve.info(), bounces, buried }, report)
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
        let bytes = 8.0 * self.vertex_count() as f64 * f64::from(self.settings().rays);
        self.settings().bounces != Some(0) && bytes <= f64::from(self.settings().row_memory) * 1024.0 * 1024.0
    }

    fn transport(&self, rays: u32) -> Transport<'_> {
        Transport {
            scene: &self.problem.scene,
            tracer: &*self.problem.tracer,
            tessellation: &self.problem.tessellation,
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
        (0..chunk_count).into_par_iter().map(|chunk| self.trace_chunk(chunk, rays)).collect()
    }

    fn trace_chunk(&self, chunk: usize, rays: u32) -> Traced {
        let vertices = self.chunk_range(chunk);
        let count = vertices.len();
        let mut traced = Traced {
            rows: RowChunk::default(),
            direct: Vec::with_capacity(count),
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
        traced.buried.resize(count, false);
        traced
    }

    fn trace_vertices(&self, vertices: std::ops::Range<u32>, rays: u32, traced: &mut Traced) {
        let direct_light = DirectContext {
            scene: &self.problem.scene,
            tracer: &*self.problem.tracer,
            lights: &self.lights,
            sampler: self.settings().sampler,
            seed: self.settings().seed,
            light_rays: self.settings().light_rays,
            finders: self.finders(rays),
            is_cancelled: &|| self.monitor.is_cancelled(),
        };
        let started = Instant::now();
        let Traced { rows, direct, buried, shadow_rays, direct_seconds, .. } = traced;
        self.transport(rays).trace(vertices, rows, &|| self.monitor.is_cancelled(), |vertex, usable, found| {
            let since = Instant::now();
            let irradiance = found + direct_light.irradiance(vertex, usable, shadow_rays);
            self.monitor.add_live(vertex as usize, irradiance);
            direct.push(irradiance);
            buried.push(usable.is_empty() && !self.origins.elements_around(vertex).is_empty());
            *direct_seconds += since.elapsed().as_secs_f64();
        });
        traced.gather_seconds = started.elapsed().as_secs_f64() - traced.direct_seconds;
    }

    /// The bounces from direct light on, until the settings' limit or the stop rule.
    fn bounce_on(
        &self,
        direct: Vec<Vec3>,
        rows: &[RowChunk],
        buried: &[bool],
        weights: &VertexWeights,
        report: &mut SolveReport,
    ) -> Vec<Arc<Vec<Vec3>>> {
        let mut bounces = vec![Arc::new(direct)];
        loop {
            let index = bounces.len() as u32 - 1;
            let last = &bounces[index as usize];
            report.energy.enter(last, weights);
            self.monitor.announce_bounce(index, last, report.energy.bounces[index as usize]);
            let unabsorbed = report.energy.unabsorbed();
            let limit = self.settings().bounces;
            let is_done = match limit {
                Some(limit) => index >= limit,
                None => unabsorbed <= f64::from(self.settings().unabsorbed) || index >= MOST_BOUNCES,
            };
            if is_done || self.lights.is_empty() || self.monitor.is_cancelled() {
                return bounces;
            }
            self.monitor.enter_stage(Stage::Bouncing, index + 1, self.vertex_count() as u64, unabsorbed);
            let mut next = self.next_bounce(last, rows, report);
            if self.monitor.is_cancelled() {
                return bounces; // a bounce that is missing at some vertices would darken the sum: leave it out
            }
            self.fill(&mut next, buried);
            bounces.push(Arc::new(next));
        }
    }

    /// E_{n+1} = T E_n over the kept rows, or over rows traced anew.
    fn next_bounce(&self, previous: &[Vec3], rows: &[RowChunk], report: &mut SolveReport) -> Vec<Vec3> {
        let transport = self.transport(self.settings().rays);
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
                    transport.apply(kept, previous, |index, value| {
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

    /// Gives buried vertices their neighbours' values, in the field and on the screen.
    fn fill(&self, field: &mut [Vec3], buried: &[bool]) {
        for (vertex, value) in fill_buried(&self.problem.tessellation.mesh, &self.origins, field, buried) {
            field[vertex] = value;
            self.monitor.add_live(vertex, value);
        }
    }

    fn info(&self) -> SolutionInfo {
        SolutionInfo {
            scene_name: self.problem.scene.name.clone(),
            scene_hash: self.problem.scene.hash(),
            tessellation_hash: self.problem.tessellation.hash(),
            load: self.problem.load.clone(),
            settings: self.settings().clone(),
            light: self.problem.light,
            program_version: String::from(env!("CARGO_PKG_VERSION")),
            complete: !self.monitor.is_cancelled(),
        }
    }
}

impl SolveReport {
    fn of_traced(traced: &[Traced], emitted: DVec3) -> Self {
        let sum = |value: fn(&Traced) -> u64| traced.iter().map(value).sum();
        Self {
            seconds: 0.0,
            gather_thread_seconds: traced.iter().map(|chunk| chunk.gather_seconds).sum(),
            direct_thread_seconds: traced.iter().map(|chunk| chunk.direct_seconds).sum(),
            bounce_seconds: 0.0,
            gather_rays: sum(|chunk| chunk.rows.rays),
            gather_rays_skipped: sum(|chunk| chunk.rows.skipped),
            shadow_rays: sum(|chunk| chunk.shadow_rays.traced),
            shadow_rays_skipped: sum(|chunk| chunk.shadow_rays.skipped),
            row_bytes: sum(|chunk| chunk.rows.bytes() as u64),
            buried_vertices: 0,
            unabsorbed: 1.0,
            energy: Ledger::new(emitted),
        }
    }
}
