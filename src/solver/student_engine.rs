//! The engine that runs on a student's functions: the same solve, bounce by bounce, with [`Functions`] called for every
//! vertex on all cores. Each bounce traces its rays anew, as the assignment has it.
//!
//! What the functions must not do (panic, return a number that is not finite or a negative one) costs a vertex, not the
//! solve: the vertex becomes a hole and the [`Fault`] is told.

use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use glam::Vec3;
use rayon::prelude::*;

use super::{
    energy::VertexWeights,
    faults::{self, Fault},
    monitor::{Monitor, Stage, locked},
    solve::{Computed, Problem, SolveReport, bounce_on, fill},
};
use crate::{
    student::{Functions, PLACEHOLDERS, Receiver, World},
    trace::{Hit, Ray, RayTracer, SurfacePoint},
    transport::{Lights, VertexOrigins},
};

/// What a hole is shown as while it is solved: bright magenta under any exposure. The solution itself has 0 there.
pub const HOLE_COLOUR: Vec3 = Vec3::new(1e6, 0.0, 1e6);

/// Time that a solve takes at least while direct light is not written, so that one sees the vertices fill in.
const UNWRITTEN_TIME: Duration = Duration::from_secs(4);

/// Most vertices that one task handles.
const VERTICES_PER_TASK: usize = 64;

/// A shorter wait than this is left out: a large mesh takes its time anyway.
const SHORTEST_PACE: Duration = Duration::from_micros(100);

/// The problem's tracer as a student's functions see it: rays are counted, and once the solve is cancelled the next one
/// unwinds out of the function, which may have many more to go.
struct StudentTracer<'a> {
    tracer: &'a dyn RayTracer,
    monitor: &'a Monitor,
    closest: AtomicU64,
    occluded: AtomicU64,
}

impl RayTracer for StudentTracer<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.closest.fetch_add(1, Relaxed);
        self.leave_if_cancelled();
        self.tracer.closest_hit(ray)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.occluded.fetch_add(1, Relaxed);
        self.leave_if_cancelled();
        self.tracer.occluded(ray)
    }
}

impl StudentTracer<'_> {
    fn leave_if_cancelled(&self) {
        if self.monitor.is_cancelled() {
            std::panic::resume_unwind(Box::new("cancelled"));
        }
    }
}

/// One function called for every vertex.
pub(super) struct Pass<'a> {
    name: &'static str,
    /// How many of its vertex's samples a receiver takes.
    share: &'a (dyn Fn(&World, &Receiver) -> usize + Sync),
    function: &'a (dyn Fn(&World, &Receiver) -> Vec3 + Sync),
    /// How long to wait after each vertex.
    pace: Duration,
}

/// What all passes share.
pub(super) struct StudentSolve<'a> {
    problem: &'a Problem,
    functions: &'a Functions,
    /// The student's, if one is written.
    own_tracer: Option<Box<dyn RayTracer>>,
    monitor: &'a Monitor,
    lights: &'a Lights,
    origins: VertexOrigins,
    /// The first fault of each function.
    faults: Mutex<Vec<Fault>>,
}

/// Which of a vertex's origins are not buried, one bit each.
pub(super) type Usable = u8;

/// Solves with a student's functions.
pub(super) fn solve(
    problem: &Problem,
    functions: &Functions,
    monitor: &Monitor,
    lights: &Lights,
    report: &mut SolveReport,
) -> Computed {
    let solve = StudentSolve::new(problem, functions, monitor, lights);
    let work = problem.tessellation.mesh.positions.len() as u64;
    monitor.enter_stage(Stage::Tracing, 0, work, 1.0);
    let usable = solve.usable_origins();
    let buried: Vec<bool> = (0..).zip(&usable).map(|(vertex, usable)| solve.is_buried(vertex, *usable)).collect();
    let mut holes = vec![false; usable.len()];

    let started = Instant::now();
    let mut direct = solve.run(&Pass { pace: solve.pace(), ..direct_pass() }, &usable, &mut holes, report);
    report.direct_thread_seconds = started.elapsed().as_secs_f64() * rayon::current_num_threads() as f64;
    fill(&problem.tessellation, monitor, &solve.origins, &mut direct, &buried);
    let weights = VertexWeights::new(&problem.scene, &problem.tessellation);
    let bounces_started = Instant::now();
    let bounces = bounce_on(problem, &weights, monitor, lights, direct, report, |bounces, report| {
        let fields: Vec<&[Vec3]> = bounces.iter().map(|bounce| bounce.as_slice()).collect();
        let mut next = indirect_pass(&fields, |pass| solve.run(pass, &usable, &mut holes, report));
        fill(&problem.tessellation, monitor, &solve.origins, &mut next, &buried);
        next
    });
    report.bounce_seconds = bounces_started.elapsed().as_secs_f64();
    report.gather_thread_seconds = report.bounce_seconds * rayon::current_num_threads() as f64;
    report.faults = solve.faults.into_inner().unwrap_or_else(PoisonError::into_inner);
    report.holes = (0..).zip(&holes).filter_map(|(vertex, is_hole)| is_hole.then_some(vertex)).collect();
    Computed {
        bounces,
        buried,
        tessellation: Arc::clone(&problem.tessellation),
        #[cfg(feature = "reference")]
        kept: None,
    }
}

/// Direct light.
pub(super) fn direct_pass() -> Pass<'static> {
    Pass {
        name: "direct_irradiance",
        share: &|world, receiver| world.light_points(receiver).len(),
        function: &|world, receiver| (world.functions.direct_irradiance)(world, receiver),
        pace: Duration::ZERO,
    }
}

/// The bounce after `bounces`, handed to `run`.
pub(super) fn indirect_pass<Output>(bounces: &[&[Vec3]], run: impl FnOnce(&Pass) -> Output) -> Output {
    run(&Pass {
        name: "indirect_irradiance",
        share: &|world, receiver| world.hemisphere_points(receiver).len(),
        function: &|world, receiver| (world.functions.indirect_irradiance)(world, receiver, bounces),
        pace: Duration::ZERO,
    })
}

/// The student's ray tracer, if one is written; a fault if it cannot be made.
fn own_tracer(problem: &Problem, functions: &Functions) -> (Option<Box<dyn RayTracer>>, Option<Fault>) {
    match faults::caught(|| (functions.ray_tracer)(&problem.scene)) {
        Ok(tracer) => (tracer, None),
        Err(message) => {
            let (function, input) = (String::from("ray_tracer"), format!("the scene {}", problem.scene.name));
            let problem = format!("it panics: {message}; the program's own tracer is used");
            (None, Some(Fault { function, vertex: 0, input, problem }))
        }
    }
}

impl<'s> StudentSolve<'s> {
    pub(super) fn new(
        problem: &'s Problem,
        functions: &'s Functions,
        monitor: &'s Monitor,
        lights: &'s Lights,
    ) -> Self {
        let origins = VertexOrigins::new(&problem.tessellation);
        let (own_tracer, fault) = own_tracer(problem, functions);
        let solve = Self { problem, functions, own_tracer, monitor, lights, origins, faults: Mutex::default() };
        fault.iter().for_each(|fault| solve.tell(fault));
        solve
    }

    pub(super) fn tracer(&self) -> &dyn RayTracer {
        self.own_tracer.as_deref().unwrap_or(&*self.problem.tracer)
    }

    pub(super) fn world<'a>(&'a self, tracer: &'a dyn RayTracer) -> World<'a> {
        let settings = &self.problem.settings;
        World {
            scene: &self.problem.scene,
            tracer,
            tessellation: &self.problem.tessellation,
            light: self.lights.area_light,
            functions: self.functions,
            sampler: settings.sampler,
            seed: settings.seed,
            light_rays: settings.light_rays,
            rays: settings.rays,
        }
    }

    fn usable_origins(&self) -> Vec<Usable> {
        let vertices = 0..self.problem.tessellation.mesh.positions.len() as u32;
        vertices.into_par_iter().map_init(Vec::new, |origins, vertex| self.usable_at(vertex, origins)).collect()
    }

    pub(super) fn usable_at(&self, vertex: u32, origins: &mut Vec<SurfacePoint>) -> Usable {
        if self.monitor.is_cancelled() {
            return 0;
        }
        self.collect(vertex, origins);
        let is_free = |origin: &SurfacePoint| !origin.is_buried(&*self.problem.tracer);
        (0..).zip(origins.iter()).map(|(place, origin)| Usable::from(is_free(origin)) << place).sum()
    }

    fn collect(&self, vertex: u32, origins: &mut Vec<SurfacePoint>) {
        let Problem { scene, tracer, tessellation, .. } = self.problem;
        self.origins.collect((scene, &**tracer), tessellation, vertex, origins);
    }

    fn is_buried(&self, vertex: u32, usable: Usable) -> bool {
        usable == 0 && !self.origins.elements_around(vertex).is_empty()
    }

    /// One value for every vertex: the mean over its receivers, weighted by their shares of the samples.
    fn run(&self, pass: &Pass, usable: &[Usable], holes: &mut [bool], report: &mut SolveReport) -> Vec<Vec3> {
        let tracer = StudentTracer {
            tracer: self.tracer(),
            monitor: self.monitor,
            closest: AtomicU64::new(0),
            occluded: AtomicU64::new(0),
        };
        let world = self.world(&tracer);
        let per_task = if pass.pace.is_zero() { VERTICES_PER_TASK } else { 1 };
        let mut field = vec![Vec3::ZERO; usable.len()];
        let tasks = field.par_chunks_mut(per_task).zip(holes.par_chunks_mut(per_task)).enumerate();
        tasks.for_each(|(task, (values, holes))| {
            for (place, (value, hole)) in values.iter_mut().zip(holes).enumerate() {
                self.monitor.wait_while_paused();
                if self.monitor.is_cancelled() {
                    return;
                }
                let vertex = (task * per_task + place) as u32;
                let found = if *hole {
                    None
                } else {
                    self.at_vertex(pass, &world, vertex, usable[vertex as usize])
                        .inspect_err(|fault| self.tell(fault))
                        .ok()
                };
                *hole = found.is_none();
                *value = found.unwrap_or(Vec3::ZERO);
                self.monitor.add_live(vertex as usize, found.unwrap_or(HOLE_COLOUR));
                std::thread::sleep(pass.pace);
                self.monitor.advance(1, 0);
            }
        });
        let (closest, occluded) = (tracer.closest.into_inner(), tracer.occluded.into_inner());
        self.monitor.advance(0, closest + occluded);
        report.gather_rays += closest;
        report.shadow_rays += occluded;
        field
    }

    /// The vertex's value, or why there is none.
    pub(super) fn at_vertex(&self, pass: &Pass, world: &World, vertex: u32, usable: Usable) -> Result<Vec3, Fault> {
        let (mut sum, mut samples) = (Vec3::ZERO, 0);
        for receiver in self.receivers(vertex, usable) {
            let irradiance = faults::irradiance(pass.name, world, &receiver, || (pass.function)(world, &receiver))?;
            let share = faults::caught(|| (pass.share)(world, &receiver)).unwrap_or(0);
            sum += irradiance * share as f32;
            samples += share;
        }
        Ok(sum / samples.max(1) as f32)
    }

    pub(super) fn receivers(&self, vertex: u32, usable: Usable) -> impl Iterator<Item = Receiver> {
        let mut points = Vec::new();
        if usable != 0 {
            self.collect(vertex, &mut points);
        }
        let free = (0..).zip(points).filter(move |(place, _)| usable & (1 << place) != 0).map(|(_, point)| point);
        let receiver = move |(place, point)| Receiver { vertex, place: (place, usable.count_ones()), point };
        (0..).zip(free).map(receiver)
    }

    /// How long to wait after each vertex.
    fn pace(&self) -> Duration {
        let world = self.world(self.tracer());
        let vertices = self.problem.tessellation.mesh.positions.len() as u32;
        let first = (0..vertices).find_map(|vertex| self.receivers(vertex, Usable::MAX).next());
        let is_unwritten = first.is_some_and(|receiver| {
            let of = |functions: &Functions| (functions.direct_irradiance)(&world, &receiver);
            faults::caught(|| of(self.functions)) == Ok(of(&PLACEHOLDERS))
        });
        let pace = UNWRITTEN_TIME * rayon::current_num_threads() as u32 / vertices.max(1);
        if is_unwritten && self.monitor.is_watched() && pace >= SHORTEST_PACE { pace } else { Duration::ZERO }
    }

    fn tell(&self, fault: &Fault) {
        let mut faults = locked(&self.faults);
        let is_known = faults.iter().any(|known| known.function == fault.function);
        // A cancelled solve unwinds out of functions that did nothing wrong.
        if !is_known && !self.monitor.is_cancelled() {
            self.monitor.announce_fault(fault);
            faults.push(fault.clone());
        }
    }
}
