//! What all engines share: the problem, the report, the bounces' stop rule and the making of the solution.

use std::{
    fmt::{self, Display, Formatter},
    sync::Arc,
    time::Instant,
};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

#[cfg(feature = "reference")]
use super::{adapt, gather, kept::Kept};
use super::{
    buried::fill_buried,
    energy::{Ledger, VertexWeights},
    faults::Fault,
    monitor::{Monitor, Stage},
    settings::{Engine, Iteration, SolveSettings},
    skipped::SecondsSaved,
    solution::{Solution, SolutionInfo},
    student_engine,
};
use crate::{
    scene::{LoadOptions, Scene, Tessellation, area_light::AreaLightState},
    student::{FUNCTIONS, Functions},
    trace::RayTracer,
    transport::{
        Lights, VertexOrigins,
        facing::{Facing, facing},
        lights::Emitters,
        visible_light::ShadowRays,
    },
};

/// What is to be solved.
#[derive(Clone)]
pub struct Problem {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its ray tracer.
    pub tracer: Arc<dyn RayTracer>,
    /// Its elements; of those that follow the light, the ones to begin with.
    pub tessellation: Arc<Tessellation>,
    /// How the scene was read: kept with the solution, so that it can be read so again.
    pub load: LoadOptions,
    /// The placed area light, if any.
    pub light: Option<AreaLightState>,
    /// The settings.
    pub settings: SolveSettings,
}

impl Problem {
    /// Cuts a scene as the settings ask for. Elements that follow the light are cut further by the solve.
    ///
    /// # Errors
    /// One line: settings out of range, or too many elements.
    pub fn new(
        scene: Arc<Scene>,
        tracer: Arc<dyn RayTracer>,
        load: LoadOptions,
        light: Option<AreaLightState>,
        settings: SolveSettings,
    ) -> Result<Self, String> {
        if let Some(problem) = settings.problem() {
            return Err(problem);
        }
        let tessellation = Arc::new(Tessellation::new(&scene, &settings.tessellation())?);
        Ok(Self { scene, tracer, tessellation, load, light, settings })
    }
}

impl Problem {
    /// What should be said before it is solved, if anything.
    pub fn remark(&self) -> Option<&'static str> {
        let has_emitters = || self.scene.emissive_triangles().next().is_some();
        (self.settings.engine == Engine::Student && has_emitters()).then_some(
            "src/student lights a scene by the placed area light alone: its emissive materials give no light with \
             the engine `student`",
        )
    }

    /// What should be said of the sides that light meets, if anything.
    pub fn facing(&self) -> Option<Facing> {
        let light = self.light.map(|light| light.to_local(&self.scene.frame));
        facing(&self.scene, &*self.tracer, light.as_ref(), &self.load)
    }
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
    /// Wall-clock seconds until the elements followed the light, and their gather rays were traced.
    pub seconds_adapting: f64,
    /// Of that, until they followed direct light.
    pub seconds_following_direct: f64,
    /// Vertices whose indirect light was gathered; at all others of elements that follow the light it is interpolated.
    pub gathered_vertices: u64,
    /// Those others.
    pub interpolated_vertices: u64,
    /// Gather rays traced.
    pub gather_rays: u64,
    /// Gather rays that needed no tracing.
    pub gather_rays_skipped: u64,
    /// Shadow rays traced.
    pub shadow_rays: u64,
    /// Shadow rays that needed no tracing.
    pub shadow_rays_skipped: u64,
    /// The same by what was known without them.
    pub shadow_rays_by_sight: ShadowRays,
    /// Gather rays that bounces took from kept rows instead of tracing them again.
    pub gather_rays_reused: u64,
    /// Why no more bounces or sweeps were run.
    pub ended_by: EndedBy,
    /// Bounces that the limit asked for, but that had nothing to reflect.
    pub bounces_skipped: u32,
    /// Textures of the scene that no gather ray met.
    pub textures_untouched: u64,
    /// What the skipped work would have taken, where that is known.
    pub seconds_saved: SecondsSaved,
    /// What other solves have to do and this one had not.
    pub stages_skipped: Vec<Stage>,
    /// Bounces or, of other iterations than Neumann's, sweeps, the last gather included.
    pub iterations: u32,
    /// Bytes of the kept rows; 0 if they were traced anew at each bounce.
    pub row_bytes: u64,
    /// Vertices that see next to nothing but back faces.
    pub buried_vertices: u64,
    /// Fraction of the emitted power that is still unabsorbed.
    pub unabsorbed: f64,
    /// Where the power went.
    pub energy: Ledger,
    /// What functions of `student` did that they must not do: the first time of each.
    pub faults: Vec<Fault>,
    /// The vertices that have no value for that.
    pub holes: Vec<u32>,
}

/// Why a solve runs no further bounce.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EndedBy {
    /// It was stopped.
    #[default]
    Cancelled,
    /// The settings' limit of bounces.
    Limit,
    /// So little is left that the settings allow it.
    Unabsorbed,
    /// Nothing reflects what arrived last.
    NothingReflects,
    /// Nothing shines.
    NoLight,
}

impl Display for EndedBy {
    fn fmt(&self, formatter: &mut Formatter) -> fmt::Result {
        formatter.write_str(match self {
            Self::Cancelled => "stopped",
            Self::Limit => "as many as asked for",
            Self::Unabsorbed => "no more: little is left",
            Self::NothingReflects => "no more: nothing reflects",
            Self::NoLight => "none: nothing shines",
        })
    }
}

/// What a solve brings home.
#[derive(Clone)]
pub struct Solved {
    /// The solution, whole or as far as it came.
    pub solution: Solution,
    /// What was done for it.
    pub report: SolveReport,
    /// The elements that carry it.
    pub tessellation: Arc<Tessellation>,
    /// Elements and rows, to be lit again; of a complete solve whose rows fit in memory.
    #[cfg(feature = "reference")]
    pub kept: Option<Arc<Kept>>,
}

/// Without a bounce limit, no more than this many.
pub(super) const MOST_BOUNCES: u32 = 1000;

/// What an engine computes.
pub(super) struct Computed {
    /// Irradiance of each bounce alone [W/m²].
    pub(super) bounces: Vec<Arc<Vec<Vec3>>>,
    /// The vertices that see next to nothing but back faces.
    pub(super) buried: Vec<bool>,
    /// The elements that carry the bounces.
    pub(super) tessellation: Arc<Tessellation>,
    #[cfg(feature = "reference")]
    pub(super) kept: Option<Kept>,
}

/// Solves. A cancelled solve returns what it has, with [`SolutionInfo::complete`] false.
pub fn solve(problem: &Problem, monitor: &Monitor) -> Solved {
    solve_with(problem, &FUNCTIONS, monitor)
}

/// Solves; [`Engine::Student`] takes these functions.
pub fn solve_with(problem: &Problem, functions: &Functions, monitor: &Monitor) -> Solved {
    let started = Instant::now();
    let scene = &problem.scene;
    let mut lights = Lights::new(scene, problem.light.map(|light| light.to_local(&scene.frame)));
    if problem.settings.engine == Engine::Student {
        lights.emitters = Emitters::default();
    }
    let mut report = SolveReport::new(&lights, scene, problem.settings.iteration_in_use());
    let computed = own_engine(problem, monitor, &lights, &mut report);
    let computed = computed.unwrap_or_else(|| student_engine::solve(problem, functions, monitor, &lights, &mut report));
    let info = info(problem, &computed.tessellation, monitor);
    computed.into_solved(info, report, (monitor, started))
}

/// What the program's own engine computes, if it is the one that is wanted.
#[cfg(feature = "reference")]
fn own_engine(problem: &Problem, monitor: &Monitor, lights: &Lights, report: &mut SolveReport) -> Option<Computed> {
    match problem.settings.engine {
        Engine::Student => None,
        Engine::Reference if problem.settings.follows_light() => Some(adapt::solve(problem, monitor, lights, report)),
        Engine::Reference => Some(gather::solve(problem, monitor, lights, report)),
    }
}

#[cfg(not(feature = "reference"))]
fn own_engine(_: &Problem, _: &Monitor, _: &Lights, _: &mut SolveReport) -> Option<Computed> {
    None
}

impl Computed {
    /// With what it was computed from, and what was done since `started`.
    pub(super) fn into_solved(
        self,
        info: SolutionInfo,
        mut report: SolveReport,
        (monitor, started): (&Monitor, Instant),
    ) -> Solved {
        let Self { bounces, buried, tessellation, .. } = self;
        report.stages_skipped = monitor.stages_skipped();
        report.buried_vertices = buried.iter().filter(|&&is_buried| is_buried).count() as u64;
        report.unabsorbed = report.energy.unabsorbed();
        report.seconds = started.elapsed().as_secs_f64();
        report.seconds_saved = SecondsSaved::of(&report);
        let bounces = bounces.into_iter().map(Arc::unwrap_or_clone).collect();
        #[cfg(feature = "reference")]
        let kept = self.kept.filter(|_| info.complete).map(|kept| Arc::new(kept.named(&info)));
        Solved {
            solution: Solution { info, bounces, buried, cuts: tessellation.cuts.clone() },
            report,
            tessellation,
            #[cfg(feature = "reference")]
            kept,
        }
    }
}

/// The bounces from direct light on, until the settings' limit or the stop rule. `next_bounce` gets the bounces so far.
pub(super) fn bounce_on(
    problem: &Problem,
    weights: &VertexWeights,
    monitor: &Monitor,
    lights: &Lights,
    direct: Vec<Vec3>,
    report: &mut SolveReport,
    mut next_bounce: impl FnMut(&[Arc<Vec<Vec3>>], &mut SolveReport) -> Vec<Vec3>,
) -> Vec<Arc<Vec<Vec3>>> {
    let work = direct.len() as u64;
    let mut bounces = vec![Arc::new(direct)];
    loop {
        let index = bounces.len() as u32 - 1;
        let last = &bounces[index as usize];
        report.energy.enter(last, weights);
        monitor.announce_bounce(index, last, report.energy.bounces[index as usize]);
        let unabsorbed = report.energy.unabsorbed();
        // A student's bounces are run all: who writes a function wants to see what it does.
        let nothing_reflects = problem.settings.engine == Engine::Reference
            && report.energy.bounces[index as usize].reflected == DVec3::ZERO;
        let ended_by = match problem.settings.bounces {
            _ if monitor.is_cancelled() => Some(EndedBy::Cancelled),
            _ if lights.is_empty() => Some(EndedBy::NoLight),
            Some(limit) if index >= limit => Some(EndedBy::Limit),
            limit if nothing_reflects => {
                report.bounces_skipped = limit.map_or(0, |limit| limit - index);
                Some(EndedBy::NothingReflects)
            }
            None if unabsorbed <= f64::from(problem.settings.unabsorbed) => Some(EndedBy::Unabsorbed),
            None if index >= MOST_BOUNCES => Some(EndedBy::Limit),
            _ => None,
        };
        if let Some(ended_by) = ended_by {
            report.ended_by = ended_by;
            return bounces;
        }
        monitor.pause_if_stepping();
        monitor.wait_while_paused();
        monitor.enter_stage(Stage::Bouncing, index + 1, work, unabsorbed);
        let next = next_bounce(&bounces, report);
        if monitor.is_cancelled() {
            return bounces; // a bounce that is missing at some vertices would darken the sum: leave it out
        }
        bounces.push(Arc::new(next));
        report.iterations = index + 1;
    }
}

/// Gives buried vertices their neighbours' values, in the field and on the screen.
pub(super) fn fill(
    tessellation: &Tessellation,
    monitor: &Monitor,
    origins: &VertexOrigins,
    field: &mut [Vec3],
    buried: &[bool],
) {
    for (vertex, value) in fill_buried(&tessellation.mesh, origins, field, buried) {
        field[vertex] = value;
        monitor.add_live(vertex, value);
    }
}

pub(super) fn info(problem: &Problem, tessellation: &Tessellation, monitor: &Monitor) -> SolutionInfo {
    SolutionInfo {
        scene_name: problem.scene.name.clone(),
        scene_hash: problem.scene.hash(),
        tessellation_hash: tessellation.hash(),
        load: problem.load.clone(),
        settings: problem.settings.clone(),
        light: problem.light,
        program_version: String::from(env!("CARGO_PKG_VERSION")),
        complete: !monitor.is_cancelled(),
    }
}

impl SolveReport {
    /// Enters shadow rays that were traced or not.
    #[cfg(feature = "reference")]
    pub(super) fn enter_shadow_rays(&mut self, rays: &ShadowRays) {
        self.shadow_rays += rays.traced;
        self.shadow_rays_skipped += rays.skipped();
        self.shadow_rays_by_sight.add(rays);
    }

    pub(super) fn new(lights: &Lights, scene: &Scene, iteration: Iteration) -> Self {
        let emitted = lights.emitted_power(scene).as_dvec3() * scene.frame.square_metres_per_unit();
        Self {
            energy: Ledger::new(emitted, iteration),
            iterations: 0,
            seconds: 0.0,
            gather_thread_seconds: 0.0,
            direct_thread_seconds: 0.0,
            bounce_seconds: 0.0,
            seconds_adapting: 0.0,
            seconds_following_direct: 0.0,
            gathered_vertices: 0,
            interpolated_vertices: 0,
            shadow_rays_by_sight: ShadowRays::default(),
            gather_rays_reused: 0,
            ended_by: EndedBy::default(),
            bounces_skipped: 0,
            textures_untouched: 0,
            seconds_saved: SecondsSaved::default(),
            stages_skipped: Vec::new(),
            gather_rays: 0,
            gather_rays_skipped: 0,
            shadow_rays: 0,
            shadow_rays_skipped: 0,
            row_bytes: 0,
            buried_vertices: 0,
            unabsorbed: 1.0,
            faults: Vec::new(),
            holes: Vec::new(),
        }
    }
}
