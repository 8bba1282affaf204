//! Bounces on elements that follow the light (`adapt`): rows at the coarse elements' vertices, and a smooth field to the
//! fine ones.

use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use super::{
    adapt::Adapted,
    monitor::Monitor,
    solve::{Computed, Problem, SolveReport, bounce_on, fill},
};
use crate::transport::{Lights, Transport, VertexOrigins, lights::FinderCounts};

/// Bounces on, from the direct light and the rows that are known.
pub(super) fn solve(
    problem: &Problem,
    adapted: &Adapted,
    monitor: &Monitor,
    lights: &Lights,
    report: &mut SolveReport,
) -> Computed {
    let started = Instant::now();
    let origins = VertexOrigins::new(&adapted.tessellation);
    let transport = Transport {
        scene: &problem.scene,
        tracer: &*problem.tracer,
        tessellation: &adapted.tessellation,
        targets: &adapted.tessellation,
        origins: &origins,
        lights,
        finders: FinderCounts { gather: 0, light: problem.settings.light_rays },
        sampler: problem.settings.sampler,
        seed: problem.settings.seed,
        rays: problem.settings.rays,
    };
    enter_adapted(adapted, report);
    let add_live =
        |field: &[Vec3]| field.iter().enumerate().for_each(|(vertex, value)| monitor.add_live(vertex, *value));
    let mut direct = adapted.direct.clone();
    add_live(&direct);
    fill(problem, monitor, &origins, &mut direct, &adapted.buried);
    let bounces = bounce_on(problem, monitor, lights, direct, report, |bounces, _| {
        let outgoing = transport.outgoing(&bounces[bounces.len() - 1]);
        let parts: Vec<Vec<Vec3>> = adapted
            .rows
            .par_iter()
            .map(|(vertices, chunk)| {
                let mut values = vec![Vec3::ZERO; vertices.len()];
                transport.apply(chunk, &outgoing, |index, value| values[index] = value);
                values
            })
            .collect();
        monitor.advance(adapted.direct.len() as u64, 0);
        let mut coarse = vec![Vec3::ZERO; adapted.gathered_vertices()];
        for ((vertices, _), values) in adapted.rows.iter().zip(parts) {
            for (&vertex, value) in vertices.iter().zip(values) {
                coarse[vertex as usize] = value;
            }
        }
        let next = adapted.spread(coarse);
        add_live(&next);
        next
    });
    report.bounce_seconds = started.elapsed().as_secs_f64();
    Computed { bounces, buried: adapted.buried.clone() }
}

fn enter_adapted(adapted: &Adapted, report: &mut SolveReport) {
    report.seconds_adapting = adapted.seconds;
    report.seconds_following_direct = adapted.direct_seconds;
    report.gathered_vertices = adapted.gathered_vertices() as u64;
    report.shadow_rays = adapted.shadow_rays.traced;
    report.shadow_rays_skipped = adapted.shadow_rays.skipped;
    for (_, chunk) in &adapted.rows {
        report.gather_rays += chunk.rays;
        report.gather_rays_skipped += chunk.skipped;
        report.row_bytes += chunk.bytes() as u64;
    }
}
