//! Elements that follow the light, from a scene as it comes, and the bounces on them.
//!
//! Direct and indirect light have needs of their own. Fine elements follow direct light (`direct`): each is cut until
//! direct light at two points inside is near what its corners say. Coarse elements follow indirect light (`indirect`):
//! gather rays are traced at their vertices alone, and they are cut until the first bounce at a new vertex is near what
//! a smooth field through the others says. In the end the fine elements are cut where the smooth field needs it, and
//! take its values: they cost no ray. All bounces are then sums over the rows (`solver::kept`).
//!
//! The finer a difference, the less it counts: what is held to the tolerance is the difference times the length of the
//! edge, so that all elements share the error evenly.

mod direct;
mod indirect;

use std::{sync::Arc, time::Instant};

use glam::Vec3;

use self::{direct::DirectElements, indirect::IndirectElements};
use super::{
    kept::{Coarse, Context, Kept, KeptRows},
    monitor::Monitor,
    solve::{Computed, Problem, SolveReport},
};
use crate::{
    scene::{
        Tessellation,
        tessellate::{MAX_ELEMENTS, Refinement},
    },
    transport::{
        Lights,
        lights::{DirectMethod, FinderCounts},
    },
};

/// Edges longer than this are cut in any case, in local units (a scene's half-extent is between 1/2 and 1): what lies
/// within one element unseen cannot be followed.
const COARSEST_EDGE: f32 = 0.3;

/// Edges shorter than this are not cut.
const FINEST_EDGE: f32 = 2e-4;

/// Where direct light must be sampled, edges shorter than this are not cut: noise would be taken for shadows.
const FINEST_SAMPLED_EDGE: f32 = 0.02;

/// Differences that are allowed, times edge length in local units, for a target error of 1: of direct light, of the
/// first bounce, and of the smooth field from the fine elements; all relative to mean direct light. Found by experiment
/// on the Cornell box.
const DIRECT_TOLERANCE: f32 = 0.06;
const INDIRECT_TOLERANCE: f32 = 0.12;
const SMOOTH_TOLERANCE: f32 = 0.01;

/// The estimated noise of rays that is allowed, relative to mean light, for a target error of 1. The estimate is some two or
/// three times too large, as blocks of Sobol points scatter more than their mean errs.
const NOISE_TOLERANCE: f32 = 4.0;

/// Standard errors that a difference must be larger than, for what may be noise of the samples cuts nothing.
const NOISE: f32 = 2.0;

/// Cuts a scene's triangles to follow its light, to the error that the settings ask for, and bounces on.
pub(super) fn solve(problem: &Problem, monitor: &Monitor, lights: &Lights, report: &mut SolveReport) -> Computed {
    let is_cancelled = || monitor.is_cancelled();
    let finders = finders(problem, lights);
    let context = Context { problem, monitor, lights, finders, is_cancelled: &is_cancelled };
    let (kept, direct) = adapt(&context, report);
    let started = Instant::now();
    let computed = kept.solve(&context, direct, report);
    report.bounce_seconds = started.elapsed().as_secs_f64();
    computed
}

/// Where emissive triangles are taken as lamps, gather rays have no share in its light: they would bring noise.
fn finders(problem: &Problem, lights: &Lights) -> FinderCounts {
    let settings = &problem.settings;
    let is_exact = settings.direct != DirectMethod::Sampled && lights.emitters.lamps().is_some();
    let gather = if is_exact || settings.bounces == Some(0) { 0 } else { settings.rays };
    FinderCounts { gather, light: settings.light_rays }
}

/// The elements with their rows, and direct irradiance [W/m²] on them.
fn adapt(context: &Context, report: &mut SolveReport) -> (Kept, Vec<Vec3>) {
    let Context { problem, monitor, .. } = *context;
    let started = Instant::now();
    let error = problem.settings.adaptive;
    let mut fine = DirectElements::new(context);
    fine.follow_light(DIRECT_TOLERANCE * error);
    report.seconds_following_direct = started.elapsed().as_secs_f64();
    let mut coarse = IndirectElements::new(context, &fine);
    coarse.follow_light(INDIRECT_TOLERANCE * error, NOISE_TOLERANCE * error);
    report.gather_thread_seconds = coarse.seconds;
    let IndirectElements { rows, first_bounce, found_emission, buried, sources, smooth, refinement, .. } = coarse;
    drop(refinement); // large, and of no more use
    let mut coarse = Coarse { sources, buried, smooth, places: Vec::new() };
    let targets = Arc::clone(&fine.tessellation);
    let nodes_before: Vec<u32> = fine.refinement.nodes().collect();
    let field: Vec<Vec3> = first_bounce.iter().zip(&found_emission).map(|(bounce, found)| *bounce + *found).collect();
    fine.follow_smooth_field(&coarse, &field, SMOOTH_TOLERANCE * error);
    let DirectElements { tessellation, mut direct, buried, shadow_rays, nanoseconds, refinement, .. } = fine;
    report.direct_thread_seconds = 1e-9 * nanoseconds.into_inner() as f64;
    coarse.locate(&tessellation);
    if context.finders.gather > 0 {
        let found = coarse.spread(found_emission);
        direct.light.iter_mut().zip(found).for_each(|(direct, found)| direct.emitters += found.max(Vec3::ZERO));
    }
    let rows = KeptRows::new(rows, targets, Some((nodes_before, refinement)), first_bounce.len());
    report.seconds_adapting = started.elapsed().as_secs_f64();
    report.gathered_vertices = first_bounce.len() as u64;
    report.interpolated_vertices = tessellation.mesh.positions.len().saturating_sub(first_bounce.len()) as u64;
    report.enter_shadow_rays(&shadow_rays);
    rows.enter(&problem.scene, report);
    let kept = Kept::new(problem, Arc::clone(&tessellation), (direct, buried), rows, Some(coarse));
    let direct = kept.direct_field();
    if monitor.is_watched() {
        let bounce = kept.spread_light(first_bounce);
        let shown: Vec<Vec3> = direct.iter().zip(bounce).map(|(direct, bounce)| *direct + bounce).collect();
        monitor.show_elements(&tessellation, &shown);
    } else {
        monitor.show_elements(&tessellation, &direct);
    }
    (kept, direct)
}

/// Cuts; false if nothing was cut: nothing is wanted, there would be too many, or it is cancelled.
fn cut(context: &Context, refinement: &mut Refinement, wanted: &[u32]) -> bool {
    // A triangulated surface has about twice as many triangles as vertices.
    let most = (2 * u64::from(context.problem.settings.max_vertices)).min(MAX_ELEMENTS);
    if wanted.is_empty() || context.is_cancelled() || refinement.count_after_cut(wanted) > most {
        return false;
    }
    refinement.cut(wanted)
}

/// How much work rounds of cutting are, for the progress.
struct Rounds<'a> {
    monitor: &'a Monitor,
    done: u64,
    last: u64,
}

/// The next round is taken for no more than this part of the present one, or their sum would have no end.
const LARGEST_RATIO: f64 = 0.8;

impl<'a> Rounds<'a> {
    fn new(monitor: &'a Monitor) -> Self {
        Self { monitor, done: 0, last: 0 }
    }

    /// A round of so much work begins. Those after it are taken for a geometric series of the last ratio.
    fn begin(&mut self, work: u64) {
        let ratio = (work as f64 / self.last.max(1) as f64).min(LARGEST_RATIO);
        let rest = work as f64 * ratio / (1.0 - ratio);
        self.monitor.expect_work(self.done + work + rest as u64);
        self.done += work;
        self.last = work;
    }
}

fn edge_length(tessellation: &Tessellation, [a, b]: [u32; 2]) -> f32 {
    tessellation.mesh.positions[a as usize].distance(tessellation.mesh.positions[b as usize])
}
