//! Elements that follow the light, from a scene as it comes, and the bounces on them.
//!
//! Direct and indirect light have needs of their own. Fine elements follow direct light (`direct`): each is cut until
//! direct light at two points inside is near what its corners say. Coarse elements follow indirect light (`indirect`):
//! gather rays are traced at their vertices alone, and they are cut until the first bounce at a new vertex is near what
//! a smooth field through the others says (`smooth`). In the end the fine elements are cut where the smooth field needs
//! it, and take its values: they cost no ray. All bounces are then sums over the rows (`kept_rows`).
//!
//! The finer a difference, the less it counts: what is held to the tolerance is the difference times the length of the
//! edge, so that all elements share the error evenly.

mod direct;
mod indirect;
mod kept_rows;
mod smooth;

use std::{sync::Arc, time::Instant};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use self::{
    direct::DirectElements,
    indirect::IndirectElements,
    kept_rows::{KeptRows, Sources},
    smooth::{SmoothField, SmoothValues},
};
use super::{
    buried::fill_buried,
    monitor::Monitor,
    reconstruct::point_context,
    solve::{Computed, Problem, SolveReport, bounce_on},
};
use crate::{
    scene::{
        Tessellation,
        tessellate::{MAX_ELEMENTS, Refinement},
    },
    transport::{
        Lights, Transport, VertexOrigins,
        direct::DirectContext,
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

/// Standard errors that a difference must be larger than, for what may be noise of the samples cuts nothing.
const NOISE: f32 = 2.0;

/// Elements that follow the light, and what is known on them.
struct Adapted {
    /// The fine elements: those of the solution.
    tessellation: Arc<Tessellation>,
    /// Direct irradiance [W/m²] at each vertex, and its squared standard error.
    direct: Vec<Vec3>,
    direct_errors: Vec<Vec3>,
    /// Vertices that see mostly back faces.
    buried: Vec<bool>,
    rows: KeptRows,
    /// The first bounce [W/m²] at the coarse elements' vertices, as far as it was needed to cut them.
    first_bounce: Vec<Vec3>,
    coarse: Coarse,
    /// Where in the coarse elements each vertex lies.
    places: Vec<(u32, Vec2)>,
}

/// The coarse elements in the end.
struct Coarse {
    sources: Arc<Sources>,
    buried: Vec<bool>,
    smooth: SmoothField,
}

/// What both kinds of elements are made with.
struct Making<'a> {
    problem: &'a Problem,
    monitor: &'a Monitor,
    lights: &'a Lights,
    /// How light from emissive triangles is split between samples at the fine and gather rays at the coarse vertices.
    finders: FinderCounts,
    is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Cuts a scene's triangles to follow its light, to the error that the settings ask for, and bounces on.
pub(super) fn solve(problem: &Problem, monitor: &Monitor, lights: &Lights, report: &mut SolveReport) -> Computed {
    let is_cancelled = || monitor.is_cancelled();
    let finders = finders(problem, lights);
    let making = Making { problem, monitor, lights, finders, is_cancelled: &is_cancelled };
    let adapted = adapt(&making, report);
    let started = Instant::now();
    let computed = adapted.bounce_on(&making, report);
    report.bounce_seconds = started.elapsed().as_secs_f64();
    computed
}

/// Where each emissive triangle is taken as a polygon, gather rays have no share in its light: they would bring noise.
fn finders(problem: &Problem, lights: &Lights) -> FinderCounts {
    let settings = &problem.settings;
    let is_exact = settings.direct == DirectMethod::Analytic && lights.emitters.as_polygons(&problem.scene).is_some();
    let gather = if is_exact || settings.bounces == Some(0) { 0 } else { settings.rays };
    FinderCounts { gather, light: settings.light_rays }
}

fn adapt(making: &Making, report: &mut SolveReport) -> Adapted {
    let started = Instant::now();
    let error = making.problem.settings.adaptive;
    let mut fine = DirectElements::new(making);
    fine.follow_light(DIRECT_TOLERANCE * error);
    report.seconds_following_direct = started.elapsed().as_secs_f64();
    let mut coarse = IndirectElements::new(making, &fine);
    coarse.follow_light(INDIRECT_TOLERANCE * error);
    let IndirectElements { rows, first_bounce, found_emission, buried, sources, .. } = coarse;
    let smooth = SmoothField::new(&sources.tessellation, &sources.origins, &buried);
    let coarse = Coarse { sources, buried, smooth };
    let targets = Arc::clone(&fine.tessellation);
    let nodes_before: Vec<u32> = fine.refinement.nodes().collect();
    let field: Vec<Vec3> = first_bounce.iter().zip(&found_emission).map(|(bounce, found)| *bounce + *found).collect();
    fine.follow_smooth_field(&coarse, &field, SMOOTH_TOLERANCE * error);
    let DirectElements { tessellation, mut direct, direct_errors, buried, shadow_rays, refinement, .. } = fine;
    let places = places_in(&coarse.sources.tessellation, &tessellation);
    if making.finders.gather > 0 {
        let found = coarse.spread(&places, found_emission);
        direct.iter_mut().zip(found).for_each(|(direct, found)| *direct += found);
    }
    for (vertex, value) in fill_buried(&tessellation.mesh, &VertexOrigins::new(&tessellation), &direct, &buried) {
        direct[vertex] = value;
    }
    let rows = KeptRows::new(rows, targets, (nodes_before, refinement));
    report.seconds_adapting = started.elapsed().as_secs_f64();
    report.gathered_vertices = first_bounce.len() as u64;
    report.shadow_rays = shadow_rays.traced;
    report.shadow_rays_skipped = shadow_rays.skipped;
    rows.enter(report);
    Adapted { tessellation, direct, direct_errors, buried, rows, first_bounce, coarse, places }
}

/// Where in the coarse elements the vertices of the fine ones lie.
fn places_in(coarse: &Tessellation, fine: &Tessellation) -> Vec<(u32, Vec2)> {
    let mut places = vec![(0, Vec2::ZERO); fine.mesh.positions.len()];
    for (element, corners) in fine.mesh.triangles.iter().enumerate() {
        for (corner, &vertex) in corners.iter().enumerate() {
            let place = fine.corner_barycentrics[element][corner];
            places[vertex as usize] = coarse.locate(fine.scene_triangle[element], place);
        }
    }
    places
}

impl Adapted {
    /// All bounces from direct light on.
    fn bounce_on(self, making: &Making, report: &mut SolveReport) -> Computed {
        let Making { problem, monitor, lights, .. } = *making;
        let Self { tessellation, direct, buried, rows, coarse, places, .. } = &self;
        let mut total = direct.clone();
        if monitor.is_watched() {
            let preview = coarse.spread(places, self.first_bounce.clone());
            let preview: Vec<Vec3> = preview.iter().zip(direct).map(|(bounce, direct)| *bounce + *direct).collect();
            monitor.show_elements(tessellation, &preview);
        } else {
            monitor.show_elements(tessellation, direct);
        }
        let bounces = bounce_on(problem, tessellation, monitor, lights, direct.clone(), report, |bounces, report| {
            let last: &[Vec3] = &bounces[bounces.len() - 1];
            let next = coarse.spread(places, rows.apply(making, tessellation, last, report));
            if !monitor.is_cancelled() {
                total.iter_mut().zip(&next).for_each(|(sum, value)| *sum += *value);
                monitor.set_live(&total);
            }
            next
        });
        if monitor.is_watched() && !monitor.is_cancelled() {
            monitor.announce_sampling_error(self.sampling_error(making, &bounces));
        }
        Computed { bounces, buried: buried.clone(), tessellation: Arc::clone(tessellation) }
    }

    /// The standard error of the sum of all bounces at each vertex [W/m²], as of even elements (`gather`).
    fn sampling_error(&self, making: &Making, bounces: &[Arc<Vec<Vec3>>]) -> Vec<f32> {
        let mut total = vec![Vec3::ZERO; self.direct.len()];
        for bounce in &bounces[..bounces.len() - 1] {
            total.iter_mut().zip(bounce.iter()).for_each(|(sum, value)| *sum += *value);
        }
        let gathered = self.rows.squared_errors(making, &self.tessellation, &total, self.coarse.buried.len());
        let gathered = self.coarse.spread(&self.places, gathered);
        let root = |(direct, gathered): (&Vec3, Vec3)| ((*direct + gathered).element_sum() / 3.0).sqrt();
        self.direct_errors.iter().zip(gathered).map(root).collect()
    }
}

impl Coarse {
    /// A field [W/m²] at the fine elements' vertices, which lie at `places`, from its values at the coarse ones'.
    fn spread(&self, places: &[(u32, Vec2)], mut values: Vec<Vec3>) -> Vec<Vec3> {
        let Sources { tessellation, origins } = &*self.sources;
        for (vertex, value) in fill_buried(&tessellation.mesh, origins, &values, &self.buried) {
            values[vertex] = value;
        }
        let values = SmoothValues::new(&self.smooth, tessellation, &values);
        places.par_iter().with_min_len(256).map(|&place| values.at(place)).collect()
    }
}

impl Making<'_> {
    fn direct_context(&self) -> DirectContext<'_> {
        let context = point_context(&self.problem.scene, &*self.problem.tracer, self.lights, &self.problem.settings);
        DirectContext { finders: self.finders, is_cancelled: self.is_cancelled, ..context }
    }

    /// Rows from the elements that these left from, to the fine ones.
    fn transport<'t>(&'t self, sources: &'t Sources, targets: &'t Tessellation) -> Transport<'t> {
        let Problem { scene, tracer, settings, .. } = self.problem;
        Transport {
            scene,
            tracer: &**tracer,
            tessellation: &sources.tessellation,
            targets,
            origins: &sources.origins,
            lights: self.lights,
            finders: self.finders,
            sampler: settings.sampler,
            seed: settings.seed,
            rays: settings.rays,
        }
    }

    /// Cuts; false if nothing was cut: nothing is wanted, there would be too many, or it is cancelled.
    fn cut(&self, refinement: &mut Refinement, wanted: &[u32]) -> bool {
        // A triangulated surface has about twice as many triangles as vertices.
        let most = (2 * u64::from(self.problem.settings.max_vertices)).min(MAX_ELEMENTS);
        if wanted.is_empty() || (self.is_cancelled)() || refinement.count_after_cut(wanted) > most {
            return false;
        }
        refinement.cut(wanted)
    }
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
