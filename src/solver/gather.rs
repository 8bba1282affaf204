//! The program's own engine for the assignment's method: direct light, then bounces of gathering, `E_{n+1} = T E_n`.
//!
//! Every vertex traces its gather rays once, and its direct light from the origins that turned out not to be buried.
//! The bounces are then sums over the rows (`solver::kept`).

use std::{sync::Arc, time::Instant};

use rayon::prelude::*;

use super::{
    kept::{Context, DirectAtVertices, Kept, KeptRows, Rows, Sources},
    monitor::{Monitor, Stage},
    settings::SolveSettings,
    solve::{Computed, Problem, SolveReport},
};
use crate::transport::{
    Lights, RowChunk, Transport, bytes_per_ray,
    direct::{DirectLight, ShadowRays},
    lights::FinderCounts,
    visible_light::Scratch,
};

/// Gather rays that one task traces: some 10 ms of work, and 128 KiB of rows.
const RAYS_PER_TASK: usize = 1 << 14;

/// Rays that tell whether a vertex is buried when no bounce is asked for.
const RAYS_FOR_BURIAL: u32 = 64;

/// Everything that the tasks share.
struct Tracing<'a> {
    context: &'a Context<'a>,
    sources: Arc<Sources>,
    /// Memory for rows.
    row_bytes: u64,
}

/// What one task of the first stage brings home.
struct Traced {
    rows: RowChunk,
    direct: DirectAtVertices,
    buried: Vec<bool>,
    shadow_rays: ShadowRays,
    gather_seconds: f64,
    direct_seconds: f64,
}

/// Traces and bounces.
pub(super) fn solve(problem: &Problem, monitor: &Monitor, lights: &Lights, report: &mut SolveReport) -> Computed {
    let settings = &problem.settings;
    let rays = if settings.bounces == Some(0) { settings.rays.min(RAYS_FOR_BURIAL) } else { settings.rays };
    let is_cancelled = || monitor.is_cancelled();
    let finders = FinderCounts { gather: rays, light: settings.light_rays };
    let context = Context { problem, monitor, lights, finders, is_cancelled: &is_cancelled };
    let sources = Arc::new(Sources::new(Arc::clone(&problem.tessellation)));
    let tracing = Tracing { context: &context, sources, row_bytes: settings.row_bytes() };
    let traced = tracing.trace_all();
    let bounces_started = Instant::now();
    enter_traced(&traced, report);
    let kept = tracing.keep(traced);
    kept.rows().enter(&problem.scene, report);
    let direct = kept.direct_field();
    monitor.set_live(&direct);
    let computed = kept.solve(&context, direct, report);
    report.bounce_seconds = bounces_started.elapsed().as_secs_f64();
    computed
}

impl Tracing<'_> {
    fn settings(&self) -> &SolveSettings {
        &self.context.problem.settings
    }

    fn vertex_count(&self) -> usize {
        self.sources.tessellation.mesh.positions.len()
    }

    /// True if traced rows fit the memory budget, and will be used.
    fn keeps_rows(&self) -> bool {
        let bytes_per_ray = bytes_per_ray(&self.context.problem.scene) as f64;
        let bytes = bytes_per_ray * self.vertex_count() as f64 * f64::from(self.settings().rays);
        self.settings().bounces != Some(0) && bytes <= self.row_bytes as f64
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

    /// Rows, which vertices are buried, and direct light, all in one pass over the vertices.
    fn trace_all(&self) -> Vec<Traced> {
        self.context.monitor.enter_stage(Stage::Tracing, 0, self.vertex_count() as u64, 1.0);
        let chunk_count = self.vertex_count().div_ceil(self.chunk_size());
        // Neighbours have numbers near each other; taken far apart, a picture is whole long before it is done.
        let order = spread_order(chunk_count);
        let traced: Vec<Traced> = order.par_iter().map(|&chunk| self.trace_chunk(chunk)).collect();
        let mut in_place: Vec<Option<Traced>> = order.iter().map(|_| None).collect();
        for (chunk, traced) in order.into_iter().zip(traced) {
            in_place[chunk] = Some(traced);
        }
        in_place.into_iter().flatten().collect()
    }

    fn trace_chunk(&self, chunk: usize) -> Traced {
        let vertices = self.chunk_range(chunk);
        let count = vertices.len();
        let mut traced = Traced {
            rows: RowChunk::default(),
            direct: DirectAtVertices::default(),
            buried: Vec::with_capacity(count),
            shadow_rays: ShadowRays::default(),
            gather_seconds: 0.0,
            direct_seconds: 0.0,
        };
        let Context { monitor, lights, .. } = *self.context;
        monitor.wait_while_paused();
        if !lights.is_empty() && !monitor.is_cancelled() {
            self.trace_vertices(vertices, &mut traced);
        }
        if !self.keeps_rows() {
            traced.rows.forget_rows();
        }
        monitor.advance(count as u64, traced.rows.rays + traced.shadow_rays.traced);
        (traced.direct.light.len()..count).for_each(|_| traced.direct.push(DirectLight::default(), &[]));
        traced.buried.resize(count, false);
        traced
    }

    fn trace_vertices(&self, vertices: std::ops::Range<u32>, traced: &mut Traced) {
        let Self { context, sources, .. } = self;
        let transport = context.transport(sources, &sources.tessellation);
        let transport = Transport { rays: context.finders.gather, ..transport };
        let direct_light = context.direct();
        let keeps_rows = self.keeps_rows();
        let started = Instant::now();
        let mut scratch = Scratch::default();
        let Traced { rows, direct, buried, shadow_rays, direct_seconds, .. } = traced;
        transport.trace(vertices, rows, context.is_cancelled, |vertex, usable, found| {
            let since = Instant::now();
            let light = direct_light.at_vertex(vertex, usable, found, &mut scratch, shadow_rays);
            context.monitor.add_live(vertex as usize, light.irradiance());
            direct.push(light, if keeps_rows { usable } else { &[] });
            buried.push(usable.is_empty() && !sources.origins.elements_around(vertex).is_empty());
            *direct_seconds += since.elapsed().as_secs_f64();
        });
        traced.gather_seconds = started.elapsed().as_secs_f64() - traced.direct_seconds;
    }

    fn keep(self, traced: Vec<Traced>) -> Kept {
        let tessellation = Arc::clone(&self.sources.tessellation);
        let sources = (!self.keeps_rows()).then(|| Arc::clone(&self.sources));
        let (mut direct, mut buried, mut rows) = (DirectAtVertices::default(), Vec::new(), Vec::new());
        let (mut hats, mut partly_buried) = ([Vec::new(), Vec::new()], Vec::new());
        for (index, mut chunk) in traced.into_iter().enumerate() {
            for [of_gather, of_direct] in chunk.rows.take_hat_rows() {
                hats[0].push(of_gather);
                hats[1].push(of_direct);
            }
            direct.append(&chunk.direct);
            partly_buried.extend(chunk.rows.partly_buried());
            buried.extend(chunk.buried);
            let vertices = self.chunk_range(index).collect();
            rows.push(Rows { vertices, chunk: chunk.rows, sources: sources.clone() });
        }
        let rows = KeptRows::new(rows, Arc::clone(&tessellation), None, self.vertex_count());
        Kept::new(self.context.problem, tessellation, (direct, buried), rows, None).with_samples(hats, partly_buried)
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
        report.enter_shadow_rays(&chunk.shadow_rays);
    }
}
