//! What a solve keeps: its elements with direct light, and the gather rays as sparse rows. All bounces are sums over
//! them; and they can be lit again by another light (`relight`).
//!
//! With even elements every vertex gathers. Of elements that follow the light those of a coarser set do, and the field
//! between them is smooth (`coarse`).

mod coarse;
mod direct;
mod iteration;
mod krylov;
mod relight;
mod rows;
mod smooth;

use std::sync::Arc;

use glam::{DVec3, Vec3};

pub(super) use self::{
    coarse::Coarse,
    direct::{DirectAtVertices, in_the_middle, mean},
    rows::{KeptRows, Rows, Sources},
    smooth::{SmoothField, SmoothValues},
};
use self::{iteration::Sweeps, krylov::Known};
use super::{
    SolutionInfo,
    buried::fill_buried,
    energy::VertexWeights,
    least_squares,
    monitor::{Monitor, Stage},
    reconstruct::point_context,
    settings::Iteration,
    solve::{Computed, EndedBy, MOST_BOUNCES, Problem, SolveReport, bounce_on},
};
use crate::{
    scene::Tessellation,
    transport::{
        Lights, Transport, VertexOrigins,
        direct::{DirectContext, DirectLight},
        lights::FinderCounts,
        star::HatRow,
    },
};

/// What light is found with: direct light at vertices, and rows.
pub(super) struct Context<'a> {
    pub(super) problem: &'a Problem,
    pub(super) monitor: &'a Monitor,
    pub(super) lights: &'a Lights,
    /// How light from emissive triangles is split between samples and gather rays.
    pub(super) finders: FinderCounts,
    pub(super) is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl Context<'_> {
    pub(super) fn is_cancelled(&self) -> bool {
        (self.is_cancelled)()
    }

    pub(super) fn direct(&self) -> DirectContext<'_> {
        let context = point_context(&self.problem.scene, &*self.problem.tracer, self.lights, &self.problem.settings);
        DirectContext { finders: self.finders, is_cancelled: self.is_cancelled, ..context }
    }

    /// Rows from the vertices of `sources` to the elements `targets`.
    pub(super) fn transport<'t>(&'t self, sources: &'t Sources, targets: &'t Tessellation) -> Transport<'t> {
        let Problem { scene, tracer, settings, .. } = self.problem;
        Transport {
            scene,
            tracer: &**tracer,
            tessellation: &sources.tessellation,
            targets,
            origins: &sources.origins,
            values: settings.vertex_values_in_use(),
            lights: self.lights,
            finders: self.finders,
            sampler: settings.sampler,
            seed: settings.seed,
            rays: settings.rays,
            rays_of: sources.rays.as_deref(),
        }
    }
}

/// A solve's elements, with what is known on them.
pub struct Kept {
    /// What was solved.
    problem: Problem,
    /// The vertices' weights at their sample points, and at those of direct light, for least squares.
    hats: [Vec<HatRow>; 2],
    /// For averages: the vertices with sample points that are buried, and with others, whose mean is the value.
    partly_buried: Vec<bool>,
    /// The elements in the end, and those around each of their vertices.
    tessellation: Arc<Tessellation>,
    origins: VertexOrigins,
    direct: DirectAtVertices,
    /// Vertices that see next to nothing but back faces.
    buried: Vec<bool>,
    rows: KeptRows,
    /// The elements whose vertices gather, if they are others.
    coarse: Option<Coarse>,
    weights: VertexWeights,
    /// What is known of the rows: where other light starts from.
    known: Known,
    /// What the solution was computed from.
    info: Option<SolutionInfo>,
}

impl Kept {
    pub(super) fn new(
        problem: &Problem,
        tessellation: Arc<Tessellation>,
        (direct, buried): (DirectAtVertices, Vec<bool>),
        rows: KeptRows,
        coarse: Option<Coarse>,
    ) -> Self {
        let origins = VertexOrigins::new(&tessellation);
        let weights = VertexWeights::new(&problem.scene, &tessellation);
        Self {
            problem: problem.clone(),
            tessellation,
            origins,
            direct,
            buried,
            rows,
            coarse,
            weights,
            known: Known::default(),
            info: None,
            hats: Default::default(),
            partly_buried: Vec::new(),
        }
    }

    pub(super) fn rows(&self) -> &KeptRows {
        &self.rows
    }

    /// The same of averages: the vertices that are buried in part; and for least squares, which bring the vertices' values
    /// nearest to the light on the elements, their weights at the sample points.
    pub(super) fn with_samples(self, hats: [Vec<HatRow>; 2], partly_buried: Vec<bool>) -> Self {
        Self { hats, partly_buried, ..self }
    }

    /// Direct irradiance [W/m²] at the elements' vertices.
    pub(super) fn direct_field(&self) -> Vec<Vec3> {
        self.direct_values(self.direct.light.iter().map(DirectLight::irradiance).collect())
    }

    /// The same from what was found at the vertices, or around them.
    fn direct_values(&self, found: Vec<Vec3>) -> Vec<Vec3> {
        // Beside a sharp shadow the nearest field swings below 0.
        cut_off(self.filled(least_squares::from_averages(&self.hats[1], found)))
    }

    /// The vertices that are buried, altogether or, where they are averages, in part: a point beside them may be, too.
    fn buried_in_part(&self) -> Vec<bool> {
        let mut buried = self.buried.clone();
        buried.iter_mut().zip(&self.partly_buried).for_each(|(buried, partly)| *buried |= *partly);
        buried
    }

    /// Gives buried vertices their neighbours' values.
    fn filled(&self, mut field: Vec<Vec3>) -> Vec<Vec3> {
        for (vertex, value) in fill_buried(&self.tessellation.mesh, &self.origins, &field, &self.buried) {
            field[vertex] = value;
        }
        field
    }

    /// A field [W/m²] at the elements' vertices, from its values at those that gather. Linear in the values.
    pub(super) fn spread(&self, values: Vec<Vec3>) -> Vec<Vec3> {
        if let Some(coarse) = &self.coarse {
            return coarse.spread(values);
        }
        self.filled(least_squares::from_averages(&self.hats[0], values))
    }

    /// The same as it is shown: a smooth field may swing below 0 where light falls steeply. Bounces go on from what is
    /// not cut off, so that they stay linear, and all iterations lead to one field.
    pub(super) fn spread_light(&self, values: Vec<Vec3>) -> Vec<Vec3> {
        cut_off(self.spread(values))
    }

    /// What rays gather of a field at the elements' vertices [W/m²].
    fn gather(&self, context: &Context, field: &[Vec3], report: &mut SolveReport) -> Vec<Vec3> {
        self.rows.apply(context, &self.tessellation, field, &|_, _| (), report)
    }

    /// All bounces from direct light on, which is [`Self::direct_field`].
    pub(super) fn solve(mut self, context: &Context, direct: Vec<Vec3>, report: &mut SolveReport) -> Computed {
        let (bounces, known) = if context.problem.settings.iteration == Iteration::Neumann {
            self.bounces(context, direct, &self.weights, report)
        } else {
            self.sweeps(context, direct, report)
        };
        let monitor = context.monitor;
        if monitor.is_watched() && !monitor.is_cancelled() {
            monitor.announce_sampling_error(self.sampling_error(context, &bounces));
        }
        self.known = known;
        let (buried, tessellation) = (self.buried_in_part(), Arc::clone(&self.tessellation));
        let needs_rows = context.problem.settings.bounces != Some(0);
        let is_whole = self.rows.are_all_kept() || !needs_rows;
        Computed { bounces, buried, tessellation, kept: (is_whole && !context.lights.is_empty()).then_some(self) }
    }

    /// Bounce by bounce; and what they tell of the rows: of what one gathered, the next gathers its product.
    fn bounces(
        &self,
        context: &Context,
        direct: Vec<Vec3>,
        weights: &VertexWeights,
        report: &mut SolveReport,
    ) -> (Vec<Arc<Vec<Vec3>>>, Known) {
        let Context { problem, monitor, lights, .. } = *context;
        let mut total = direct.clone();
        // What bounces have cut off below 0 so far: the next ones owe it, so that their sum is the field cut off.
        let mut owed = vec![Vec3::ZERO; direct.len()];
        let mut last = direct.clone();
        let (mut known, mut before) = (Known::default(), None::<Vec<Vec3>>);
        let bounces = bounce_on(problem, weights, monitor, lights, direct, report, |_, report| {
            let show = |vertex: u32, value| monitor.add_live(vertex as usize, value);
            let receive: &(dyn Fn(u32, Vec3) + Sync) = if self.coarse.is_none() { &show } else { &|_, _| () };
            let gathered = self.rows.apply(context, &self.tessellation, &last, receive, report);
            if let Some(before) = before.take().filter(|_| known.has_room()) {
                let product = before.iter().zip(&gathered).map(|(before, now)| *before - *now).collect();
                known.add(before, product);
            }
            before = Some(gathered.clone());
            last = self.spread(gathered);
            let next: Vec<Vec3> =
                last.iter().zip(&owed).map(|(bounce, owed)| (*bounce - *owed).max(Vec3::ZERO)).collect();
            owed.iter_mut().zip(&next).zip(&last).for_each(|((owed, next), bounce)| *owed += *next - *bounce);
            total.iter_mut().zip(&next).for_each(|(sum, value)| *sum += *value);
            if !monitor.is_cancelled() {
                monitor.set_live(&total);
            }
            next
        });
        (bounces, known)
    }

    /// Sweep by sweep. Returns direct light and all that rays gathered, as two bounces: sweeps are none.
    fn sweeps(&self, context: &Context, direct: Vec<Vec3>, report: &mut SolveReport) -> (Vec<Arc<Vec<Vec3>>>, Known) {
        let mut shown = vec![Vec3::ZERO; direct.len()];
        self.enter(context.monitor, &direct, 0, report);
        if context.lights.is_empty() || context.problem.settings.bounces == Some(0) {
            return (vec![Arc::new(direct)], Known::default());
        }
        let mut show = |gathered: Vec<Vec3>, report: &mut SolveReport| {
            let indirect = self.spread_light(gathered);
            let change: Vec<Vec3> = indirect.iter().zip(&shown).map(|(now, before)| *now - *before).collect();
            let total: Vec<Vec3> = indirect.iter().zip(&direct).map(|(indirect, direct)| *indirect + *direct).collect();
            context.monitor.set_live(&total);
            report.iterations += 1;
            self.enter(context.monitor, &change, report.iterations, report);
            shown = indirect;
        };
        let known = self.converge(context, &direct, None, &mut show, report).unwrap_or_default();
        (vec![Arc::new(direct), Arc::new(shown)], known)
    }

    /// Enters what a sweep changed [W/m²] into the ledger, and announces it.
    fn enter(&self, monitor: &Monitor, change: &[Vec3], index: u32, report: &mut SolveReport) {
        report.energy.enter(change, &self.weights);
        monitor.announce_bounce(index, &Arc::new(change.to_vec()), report.energy.bounces[index as usize]);
    }

    /// Sweeps until no more than the settings allow is left. What rays have gathered goes to `show` after each; nothing
    /// is returned once it is cancelled.
    fn converge(
        &self,
        context: &Context,
        direct: &[Vec3],
        known: Option<&Known>,
        show: &mut dyn FnMut(Vec<Vec3>, &mut SolveReport),
        report: &mut SolveReport,
    ) -> Option<Known> {
        let Context { problem, monitor, .. } = *context;
        let settings = &problem.settings;
        let mut sweeps = Sweeps::begin(self, context, direct, settings.iteration, known, report);
        let mut left = sweeps.left();
        let mut sweep = 0;
        while left > f64::from(settings.unabsorbed) && sweep < settings.bounces.unwrap_or(MOST_BOUNCES) {
            monitor.pause_if_stepping();
            monitor.wait_while_paused();
            sweep += 1;
            monitor.enter_stage(Stage::Bouncing, sweep, direct.len() as u64, left.min(1.0));
            left = sweeps.sweep(report);
            if monitor.is_cancelled() {
                return None; // light that is missing at some vertices would darken the rest
            }
            show(sweeps.gathered(), report);
        }
        if sweep == 0 {
            show(sweeps.gathered(), report);
        }
        let is_converged = left <= f64::from(settings.unabsorbed);
        report.ended_by = if is_converged { EndedBy::Unabsorbed } else { EndedBy::Limit };
        let (gathered, known) = sweeps.end(report);
        if monitor.is_cancelled() {
            return None;
        }
        show(gathered, report);
        Some(known)
    }

    fn gather_part(
        &self,
        context: &Context,
        field: &[Vec3],
        part: (usize, usize),
        gathered: &mut [Vec3],
        report: &mut SolveReport,
    ) {
        self.rows.apply_to_part(context, &self.tessellation, field, part, gathered, report);
    }

    fn reflecting_areas(&self) -> &[DVec3] {
        self.weights.reflecting_area()
    }

    /// The same with what it was computed from.
    pub(super) fn named(self, info: &SolutionInfo) -> Self {
        Self { info: Some(info.clone()), ..self }
    }

    /// The standard error of the sum of all bounces at each vertex [W/m²], the root of its mean square over the bands:
    /// that of the samples on the lights, and that of one gather of the light of all bounces. Not in it is light of
    /// emissive triangles that gather rays found, and the error of what they saw, which is a mean of many others. Of least
    /// squares it is that of the means that they fit.
    fn sampling_error(&self, context: &Context, bounces: &[Arc<Vec<Vec3>>]) -> Vec<f32> {
        let mut total = vec![Vec3::ZERO; self.buried.len()];
        for bounce in &bounces[..bounces.len() - 1] {
            total.iter_mut().zip(bounce.iter()).for_each(|(sum, value)| *sum += *value);
        }
        let gathered = self.rows.squared_errors(context, &self.tessellation, &total);
        let gathered = match &self.coarse {
            Some(coarse) => cut_off(coarse.spread(gathered)),
            None => self.filled(gathered),
        };
        let root =
            |(direct, gathered): (&DirectLight, Vec3)| ((direct.squared_error + gathered).element_sum() / 3.0).sqrt();
        self.direct.light.iter().zip(gathered).map(root).collect()
    }
}

/// A field with 0 where it lies below.
fn cut_off(mut field: Vec<Vec3>) -> Vec<Vec3> {
    field.iter_mut().for_each(|value| *value = value.max(Vec3::ZERO));
    field
}
