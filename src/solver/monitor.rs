//! What a solve shares with those who watch it: progress, the live field, and the wish to pause or cancel.

use std::{
    fmt::{self, Display, Formatter},
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock,
        atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed},
        mpsc::Sender,
    },
    time::{Duration, Instant},
};

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{energy::BouncePower, faults::Fault};
use crate::scene::Tessellation;

/// Locks what threads share. It is always whole, so that a thread which panicked with it does no harm to the others.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a solve is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// Cutting elements where direct light bends.
    FollowingDirect,
    /// Tracing gather rays, and cutting elements where indirect light bends.
    FollowingIndirect,
    /// Tracing gather rays, and direct light.
    Tracing,
    /// Summing bounces.
    Bouncing,
}

impl Stage {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::FollowingDirect, Self::FollowingIndirect, Self::Tracing, Self::Bouncing];
}

impl Display for Stage {
    fn fmt(&self, formatter: &mut Formatter) -> fmt::Result {
        formatter.write_str(match self {
            Self::FollowingDirect => "following direct light",
            Self::FollowingIndirect => "following indirect light",
            Self::Tracing => "tracing",
            Self::Bouncing => "bouncing",
        })
    }
}

/// How far a solve has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// What it is doing.
    pub stage: Stage,
    /// The bounce being computed; 0 is direct light.
    pub bounce: u32,
    /// The part of the stage that is done, 0 to 1.
    pub fraction: f32,
    /// Rays traced so far.
    pub rays: u64,
    /// Rays a second since the start, pauses left out.
    pub rays_per_second: f64,
    /// Estimate of the seconds left in this stage.
    pub seconds_left: f64,
    /// Fraction of the emitted power that is still unabsorbed; 1 until bounce 0 is done.
    pub unabsorbed: f64,
}

/// News from a solve, in order.
#[derive(Clone, Debug)]
pub enum Message {
    /// The elements were cut: the live field and all bounces are from now on those of their vertices.
    Elements(Arc<Tessellation>),
    /// Sent some twenty times a second.
    Progress(Progress),
    /// A bounce is complete.
    Bounce {
        /// Its number; 0 is direct light.
        index: u32,
        /// Irradiance of this bounce alone at each vertex [W/m²].
        irradiance: Arc<Vec<Vec3>>,
        /// Its power.
        power: BouncePower,
    },
    /// A student's function failed, for the first time.
    Fault(Fault),
    /// All bounces are done; how far the sum may be off by its sampling.
    SamplingError(Arc<Vec<f32>>),
}

/// Time between two progress messages.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// The bits of a value that is not known yet: no number that is computed has them.
const UNKNOWN: u32 = u32::MAX;

/// Shared between a solve and its watchers.
#[derive(Debug)]
pub struct Monitor {
    cancelled: AtomicBool,
    paused: Mutex<bool>,
    unpaused: Condvar,
    stepping: AtomicBool,
    sender: Option<Sender<Message>>,
    started: Instant,
    paused_nanos: AtomicU64,
    last_message: Mutex<Instant>,
    stage: Mutex<StageState>,
    /// One bit for each stage that was entered.
    entered: AtomicU32,
    work_done: AtomicU64,
    rays: AtomicU64,
    live: RwLock<Live>,
}

/// The live field on the elements that are shown.
#[derive(Debug)]
struct Live {
    tessellation: Arc<Tessellation>,
    /// Three values a vertex: the total irradiance as far as it is known, as the bits of an f32.
    total: Vec<AtomicU32>,
}

/// The field as far as it is known at some moment.
#[derive(Clone, Debug)]
pub struct LiveField {
    /// The elements.
    pub tessellation: Arc<Tessellation>,
    /// The total irradiance [W/m²] at each vertex; 0 where it is not known yet.
    pub total: Vec<Vec3>,
    /// Which vertices have a value by now.
    pub known: Vec<bool>,
}

#[derive(Clone, Copy, Debug)]
struct StageState {
    stage: Stage,
    bounce: u32,
    work: u64,
    started: Instant,
    unabsorbed: f64,
}

impl Monitor {
    /// For a solve that starts on these elements; messages go to `sender`, if there is one.
    pub fn new(tessellation: &Arc<Tessellation>, sender: Option<Sender<Message>>) -> Self {
        let now = Instant::now();
        let stage = StageState { stage: Stage::Tracing, bounce: 0, work: 1, started: now, unabsorbed: 1.0 };
        Self {
            cancelled: AtomicBool::new(false),
            paused: Mutex::new(false),
            unpaused: Condvar::new(),
            stepping: AtomicBool::new(false),
            sender,
            started: now,
            paused_nanos: AtomicU64::new(0),
            last_message: Mutex::new(now),
            stage: Mutex::new(stage),
            entered: AtomicU32::new(0),
            work_done: AtomicU64::new(0),
            rays: AtomicU64::new(0),
            live: RwLock::new(Live::unknown(tessellation)),
        }
    }

    /// Asks the solve to stop; it keeps what it has.
    pub fn cancel(&self) {
        self.cancelled.store(true, Relaxed);
        self.resume();
    }

    /// True once [`Monitor::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Relaxed)
    }

    /// Asks the solve to wait before its next piece of work.
    pub fn pause(&self) {
        *locked(&self.paused) = true;
    }

    /// Lets a paused solve go on.
    pub fn resume(&self) {
        *locked(&self.paused) = false;
        self.unpaused.notify_all();
    }

    /// True while the solve is asked to wait.
    pub fn is_paused(&self) -> bool {
        *locked(&self.paused)
    }

    /// Asks the solve to pause by itself before each bounce after the direct light.
    pub fn set_stepping(&self, stepping: bool) {
        self.stepping.store(stepping, Relaxed);
    }

    /// The field as far as it is known now.
    pub fn live(&self) -> LiveField {
        let live = self.live.read().unwrap_or_else(PoisonError::into_inner);
        let value = |bits: &[AtomicU32]| Vec3::from_array([0, 1, 2].map(|band| load(&bits[band])));
        LiveField {
            tessellation: Arc::clone(&live.tessellation),
            total: live.total.chunks_exact(3).map(value).collect(),
            known: live.total.chunks_exact(3).map(|bits| bits[0].load(Relaxed) != UNKNOWN).collect(),
        }
    }

    /// Waits while the solve is paused.
    pub(super) fn wait_while_paused(&self) {
        let guard = locked(&self.paused);
        if !*guard {
            return;
        }
        let since = Instant::now();
        let guard = self.unpaused.wait_while(guard, |paused| *paused && !self.is_cancelled());
        drop(guard);
        self.paused_nanos.fetch_add(since.elapsed().as_nanos() as u64, Relaxed);
    }

    pub(super) fn pause_if_stepping(&self) {
        if self.stepping.load(Relaxed) && !self.is_cancelled() {
            self.pause();
        }
    }

    pub(super) fn enter_stage(&self, stage: Stage, bounce: u32, work: u64, unabsorbed: f64) {
        let state = StageState { stage, bounce, work: work.max(1), started: Instant::now(), unabsorbed };
        *locked(&self.stage) = state;
        self.entered.fetch_or(1 << stage as u32, Relaxed);
        self.work_done.store(0, Relaxed);
    }

    /// The stages that were not entered.
    pub(super) fn stages_skipped(&self) -> Vec<Stage> {
        let entered = self.entered.load(Relaxed);
        Stage::ALL.into_iter().filter(|&stage| entered & (1 << stage as u32) == 0).collect()
    }

    /// Corrects the work of the present stage, as far as it can be told by now.
    #[cfg(feature = "reference")]
    pub(super) fn expect_work(&self, work: u64) {
        locked(&self.stage).work = work.max(1);
    }

    /// Adds to the work done and to the rays traced, and sends a progress message if one is due.
    pub(super) fn advance(&self, work: u64, rays: u64) {
        self.work_done.fetch_add(work, Relaxed);
        self.rays.fetch_add(rays, Relaxed);
        let Some(sender) = &self.sender else { return };
        let Ok(mut last) = self.last_message.try_lock() else { return };
        if last.elapsed() >= PROGRESS_INTERVAL {
            *last = Instant::now();
            // A watcher that went away is no reason to stop.
            let _ = sender.send(Message::Progress(self.progress()));
        }
    }

    pub(super) fn announce_bounce(&self, index: u32, irradiance: &Arc<Vec<Vec3>>, power: BouncePower) {
        if let Some(sender) = &self.sender {
            let _ = sender.send(Message::Bounce { index, irradiance: Arc::clone(irradiance), power });
        }
    }

    pub(super) fn announce_fault(&self, fault: &Fault) {
        if let Some(sender) = &self.sender {
            let _ = sender.send(Message::Fault(fault.clone()));
        }
    }

    /// True if somebody listens.
    pub(super) fn is_watched(&self) -> bool {
        self.sender.is_some()
    }

    #[cfg(feature = "reference")]
    pub(super) fn announce_sampling_error(&self, error: Vec<f32>) {
        if let Some(sender) = &self.sender {
            let _ = sender.send(Message::SamplingError(Arc::new(error)));
        }
    }

    /// How far the solve has come.
    pub fn progress(&self) -> Progress {
        let state = *locked(&self.stage);
        let rays = self.rays.load(Relaxed);
        let fraction = (self.work_done.load(Relaxed) as f64 / state.work as f64).min(1.0);
        let paused = Duration::from_nanos(self.paused_nanos.load(Relaxed)).as_secs_f64();
        let seconds = (self.started.elapsed().as_secs_f64() - paused).max(1e-9);
        let in_stage = state.started.elapsed().as_secs_f64();
        Progress {
            stage: state.stage,
            bounce: state.bounce,
            fraction: fraction as f32,
            rays,
            rays_per_second: rays as f64 / seconds,
            seconds_left: if fraction > 0.0 { in_stage * (1.0 - fraction) / fraction } else { 0.0 },
            unabsorbed: state.unabsorbed,
        }
    }

    /// Shows other elements from now on, of whose first vertices the field is known.
    #[cfg(feature = "reference")]
    pub(super) fn show_elements(&self, tessellation: &Arc<Tessellation>, known: &[Vec3]) {
        let live = Live::unknown(tessellation);
        live.set(known);
        *self.live.write().unwrap_or_else(PoisonError::into_inner) = live;
        if let Some(sender) = &self.sender {
            let _ = sender.send(Message::Elements(Arc::clone(tessellation)));
        }
    }

    /// Shows this total irradiance at the vertices.
    #[cfg(feature = "reference")]
    pub(super) fn set_live(&self, total: &[Vec3]) {
        self.live.read().unwrap_or_else(PoisonError::into_inner).set(total);
    }

    /// Adds a bounce's irradiance at a vertex to the live field. Only one thread at a time writes a vertex. One that
    /// the elements that are shown have not is left out.
    pub(super) fn add_live(&self, vertex: usize, irradiance: Vec3) {
        let live = self.live.read().unwrap_or_else(PoisonError::into_inner);
        let slots = live.total.get(3 * vertex..).unwrap_or_default();
        for (slot, band) in slots.iter().zip(irradiance.to_array()) {
            slot.store((load(slot) + band).to_bits(), Relaxed);
        }
    }
}

impl Live {
    fn unknown(tessellation: &Arc<Tessellation>) -> Self {
        let count = 3 * tessellation.mesh.positions.len();
        Self { tessellation: Arc::clone(tessellation), total: (0..count).map(|_| AtomicU32::new(UNKNOWN)).collect() }
    }

    #[cfg(feature = "reference")]
    fn set(&self, known: &[Vec3]) {
        for (slot, band) in self.total.iter().zip(known.iter().flat_map(Vec3::to_array)) {
            slot.store(band.to_bits(), Relaxed);
        }
    }
}

fn load(bits: &AtomicU32) -> f32 {
    match bits.load(Relaxed) {
        UNKNOWN => 0.0,
        known => f32::from_bits(known),
    }
}
