//! A solve as the window runs it: a thread of its own makes the elements, starts the job and listens to it, so that
//! the thread that draws never waits.

use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
        mpsc,
    },
    time::{Duration, Instant},
};

use glam::Vec3;

use super::{
    elements::{Elements, elements_for},
    fill_unknown::fill_unknown,
};
#[cfg(feature = "reference")]
use crate::solver::Kept;
use crate::{
    math::ratio_or_zero,
    scene::{Material, Tessellation, area_light::AreaLightState},
    solver::{
        Engine, Job, LiveField, Message, Monitor, Progress, Solution, SolveReport, SolveSettings, Solved,
        energy::BouncePower, faults::Fault, monitor::locked, student_engine::HOLE_COLOUR,
    },
};

/// The least and the greatest time between two looks at the live field, in milliseconds.
const LIVE_INTERVALS: [f32; 2] = [50.0, 90.0];
/// Drawing may take one part in this many of the time, before the live field is looked at less often: a software driver
/// takes it from the solver.
const DRAWING_SHARE: f32 = 8.0;

/// All that decides a solution: what ENTER takes from the panels.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveInput {
    /// The placed light.
    pub light: Option<AreaLightState>,
    /// The settings.
    pub settings: SolveSettings,
    /// The materials, as edited.
    pub materials: Arc<Vec<Material>>,
}

/// News from a solve, in order.
pub enum SolveEvent {
    /// The elements, at first and whenever they were cut, with the total irradiance as far as it is known, in W/m².
    Elements(Elements, Arc<Vec<Vec3>>),
    /// How far it has come.
    Progress(Progress),
    /// A bounce is complete.
    Bounce {
        /// Irradiance of the bounce alone, in W/m².
        irradiance: Arc<Vec<Vec3>>,
        /// Its power.
        power: BouncePower,
        /// Seconds since the start.
        seconds: f64,
    },
    /// Something to be said before it begins.
    Remark(String),
    /// A student's function failed, for the first time.
    Fault(Fault),
    /// How far the sum of all bounces may be off by its sampling.
    SamplingError {
        /// The standard error at each vertex, in W/m², the same in all bands.
        field: Arc<Vec<Vec3>>,
        /// The root of its mean square over the area, relative to the mean irradiance.
        relative: f64,
    },
    /// It has ended: complete, or cancelled with what it had.
    Finished {
        /// The solution.
        solution: Arc<Solution>,
        /// The sum of its bounces, in W/m².
        total: Arc<Vec<Vec3>>,
        /// What it did.
        report: Box<SolveReport>,
        /// Its rows, to be lit again.
        #[cfg(feature = "reference")]
        kept: Option<Arc<Kept>>,
    },
    /// The rows of the solution that is shown were lit again: all of it at once.
    #[cfg(feature = "reference")]
    Relit {
        /// The elements, in the scene with its materials as they are now.
        elements: Elements,
        /// The solution.
        solution: Arc<Solution>,
        /// What it did.
        report: Box<SolveReport>,
    },
    /// It could not be done; one line.
    Failed(String),
}

/// The total irradiance as far as it is known, in W/m², and the elements that it is on.
type LiveView = (Arc<Tessellation>, Arc<Vec<Vec3>>);

/// What the solve's thread and the window share.
#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    paused: AtomicBool,
    /// The wish to wait or to go on, until the job is told.
    wish: Mutex<Option<bool>>,
    stepping: AtomicBool,
    live: Mutex<Option<LiveView>>,
    /// Whether there ever was one.
    was_live: AtomicBool,
    /// Time between two looks at the live field, in milliseconds.
    live_interval: AtomicU64,
}

/// A running solve. Dropping it cancels the solve.
pub struct Solving {
    /// What it was started with.
    pub input: SolveInput,
    /// It lights kept rows again: what is shown stays until it is done.
    pub relights: bool,
    events: mpsc::Receiver<SolveEvent>,
    shared: Arc<Shared>,
}

impl Solving {
    /// Starts a solve of `base`'s scene; its elements are used again if the settings still ask for them. `wake` is
    /// called when there is news.
    ///
    /// # Errors
    /// If no thread can be made.
    pub fn start(
        base: Elements,
        made_with: SolveSettings,
        input: SolveInput,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        Self::spawn(base, input, false, move |work| {
            work.run(&made_with, &wake);
            wake();
        })
    }

    /// Starts lighting the kept rows of `base` again.
    ///
    /// # Errors
    /// If no thread can be made.
    #[cfg(feature = "reference")]
    pub fn relight(
        base: Elements,
        kept: Arc<Kept>,
        input: SolveInput,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        Self::spawn(base, input, true, move |work| {
            work.relight(kept, &wake);
            wake();
        })
    }

    fn spawn(
        base: Elements,
        input: SolveInput,
        relights: bool,
        run: impl FnOnce(Work) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (sender, events) = mpsc::channel();
        let shared = Arc::new(Shared::default());
        let work = Work { started: Instant::now(), base, input: input.clone(), shared: Arc::clone(&shared), sender };
        std::thread::Builder::new().name(String::from("solve watcher")).spawn(move || run(work))?;
        Ok(Self { input, relights, events, shared })
    }

    /// News since the last call.
    pub fn events(&self) -> impl Iterator<Item = SolveEvent> + '_ {
        self.events.try_iter()
    }

    /// The total irradiance on these elements as far as it is known, if there is a newer one than at the last call.
    pub fn take_live(&self, elements: &Elements) -> Option<Arc<Vec<Vec3>>> {
        let live = locked(&self.shared.live).take();
        live.filter(|(tessellation, _)| Arc::ptr_eq(tessellation, &elements.tessellation)).map(|(_, field)| field)
    }

    /// Whether any of its light was known on its way.
    #[cfg(feature = "reference")]
    pub fn was_shown(&self) -> bool {
        self.shared.was_live.load(Relaxed)
    }

    /// Tells how long a frame takes to draw, in milliseconds, which decides how often the live field is looked at.
    pub fn set_frame_time(&self, milliseconds: f32) {
        let interval = (DRAWING_SHARE * milliseconds).clamp(LIVE_INTERVALS[0], LIVE_INTERVALS[1]);
        self.shared.live_interval.store(interval as u64, Relaxed);
    }

    /// Asks the solve to stop and keep what it has.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Relaxed);
    }

    /// Whether the solve is told to wait.
    pub fn is_paused(&self) -> bool {
        self.shared.paused.load(Relaxed)
    }

    /// Tells the solve to wait, or to go on.
    pub fn set_paused(&self, paused: bool) {
        *locked(&self.shared.wish) = Some(paused);
        self.shared.paused.store(paused, Relaxed);
    }

    /// Tells the solve to wait by itself before each bounce.
    pub fn set_stepping(&self, stepping: bool) {
        self.shared.stepping.store(stepping, Relaxed);
    }
}

impl Drop for Solving {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// A field as it is shown: holes in magenta.
fn with_holes(mut field: Vec<Vec3>, holes: &[u32]) -> Vec<Vec3> {
    for &hole in holes {
        field[hole as usize] = HOLE_COLOUR;
    }
    field
}

/// What the thread works on.
struct Work {
    started: Instant,
    base: Elements,
    input: SolveInput,
    shared: Arc<Shared>,
    sender: mpsc::Sender<SolveEvent>,
}

impl Work {
    fn run(self, made_with: &SolveSettings, wake: &impl Fn()) {
        let started = elements_for(&self.base, made_with, &self.input).and_then(|elements| {
            let problem = elements.problem(&self.input);
            let darkness = vec![Vec3::ZERO; elements.tessellation.mesh.positions.len()];
            self.send(SolveEvent::Elements(elements.clone(), Arc::new(darkness)));
            let remark = problem.remark().map(String::from);
            for remark in remark.into_iter().chain(problem.facing().map(|facing| facing.text)) {
                self.send(SolveEvent::Remark(remark));
            }
            let job =
                Job::start(problem, 0).map_err(|error| format!("the solver's threads could not be started: {error}"));
            Ok((job?, elements))
        });
        match started.and_then(|(job, elements)| self.watch(job, elements, wake)) {
            Ok(solved) => {
                let Solved { solution, report, .. } = solved;
                self.send(SolveEvent::Finished {
                    total: Arc::new(with_holes(solution.total(), &report.holes)),
                    solution: Arc::new(solution),
                    report: Box::new(report),
                    #[cfg(feature = "reference")]
                    kept: solved.kept,
                });
            }
            Err(problem) => self.send(SolveEvent::Failed(problem)),
        }
    }

    #[cfg(feature = "reference")]
    fn relight(self, kept: Arc<Kept>, wake: &impl Fn()) {
        let elements = self.base.with_materials(&self.input.materials);
        let job = Job::relight(kept, Arc::clone(&elements.scene), self.input.light, 0);
        let job = job.map_err(|error| format!("the solver's threads could not be started: {error}"));
        match job.and_then(|job| self.watch(job, elements.clone(), wake)) {
            Ok(Solved { solution, report, .. }) => {
                self.send(SolveEvent::Relit { elements, solution: Arc::new(solution), report: Box::new(report) });
            }
            Err(problem) => self.send(SolveEvent::Failed(problem)),
        }
    }

    /// Passes on what the job tells, until it has ended.
    fn watch(&self, job: Job, mut elements: Elements, wake: &impl Fn()) -> Result<Solved, String> {
        let mut last_live = Instant::now();
        while !job.is_finished() {
            self.pass_on_wishes(job.monitor());
            if let Some(message) = job.next_message(Duration::from_millis(5)) {
                self.forward(&job, &mut elements, message)?;
            }
            if last_live.elapsed() >= Duration::from_millis(self.shared.live_interval.load(Relaxed)) {
                let (view, is_known) = self.live_view(&job, &elements);
                if is_known {
                    *locked(&self.shared.live) = Some(view);
                    self.shared.was_live.store(true, Relaxed);
                }
                last_live = Instant::now();
                wake();
            }
        }
        for message in job.messages() {
            self.forward(&job, &mut elements, message)?;
        }
        let panicked = || String::from("the solver stopped by an error of its own; please report it");
        job.finish().ok_or_else(panicked)
    }

    fn pass_on_wishes(&self, monitor: &Monitor) {
        monitor.set_stepping(self.shared.stepping.load(Relaxed));
        if self.shared.cancelled.load(Relaxed) {
            monitor.cancel();
        }
        let mut wish = locked(&self.shared.wish);
        match wish.take() {
            Some(true) => monitor.pause(),
            Some(false) => monitor.resume(),
            None => self.shared.paused.store(monitor.is_paused(), Relaxed),
        }
    }

    /// What is known now, and whether anything is.
    fn live_view(&self, job: &Job, elements: &Elements) -> (LiveView, bool) {
        let LiveField { tessellation, total: mut field, known } = job.monitor().live();
        let is_known = known.contains(&true);
        // A student sees each vertex come in.
        if self.input.settings.engine == Engine::Reference {
            let is_drawn = Arc::ptr_eq(&tessellation, &elements.tessellation);
            let coarse = elements.geometry.coarse.as_ref().filter(|_| is_drawn);
            fill_unknown(&mut field, known, &tessellation.mesh.triangles, coarse);
        }
        ((tessellation, Arc::new(field)), is_known)
    }

    fn forward(&self, job: &Job, elements: &mut Elements, message: Message) -> Result<(), String> {
        self.send(match message {
            // Of elements that were cut further meanwhile the field is no longer known.
            Message::Elements(tessellation) if !Arc::ptr_eq(&tessellation, &job.monitor().live().tessellation) => {
                return Ok(());
            }
            Message::Elements(tessellation) => {
                if !Arc::ptr_eq(&tessellation, &elements.tessellation) {
                    *elements = elements.cut_as(&tessellation)?;
                }
                let ((shown, field), _) = self.live_view(job, elements);
                if !Arc::ptr_eq(&tessellation, &shown) {
                    return Ok(());
                }
                SolveEvent::Elements(elements.clone(), field)
            }
            Message::Progress(progress) => SolveEvent::Progress(progress),
            Message::SamplingError(errors) => SolveEvent::SamplingError {
                relative: relative_error(&elements.tessellation, &errors, &job.monitor().live().total),
                field: Arc::new(errors.iter().map(|error| Vec3::splat(*error)).collect()),
            },
            Message::Bounce { irradiance, power, .. } => {
                SolveEvent::Bounce { irradiance, power, seconds: self.started.elapsed().as_secs_f64() }
            }
            Message::Fault(fault) => SolveEvent::Fault(fault),
        });
        Ok(())
    }

    /// A window that no longer listens is no reason to stop: it has cancelled the solve, too.
    fn send(&self, event: SolveEvent) {
        let _ = self.sender.send(event);
    }
}

/// Root mean square over the area of an error at the vertices, by the mean of a field.
fn relative_error(tessellation: &Tessellation, errors: &[f32], field: &[Vec3]) -> f64 {
    let (mut squares, mut sum, mut area) = (0.0, 0.0, 0.0);
    for ((error, value), weight) in errors.iter().zip(field).zip(tessellation.vertex_areas()) {
        let weight = f64::from(weight);
        squares += weight * f64::from(*error).powi(2);
        sum += weight * f64::from(value.element_sum()) / 3.0;
        area += weight;
    }
    ratio_or_zero(ratio_or_zero(squares, area).sqrt(), ratio_or_zero(sum, area))
}
