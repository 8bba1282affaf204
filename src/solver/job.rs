//! A solve on a thread of its own. The window and the command line see a solve only through this.

use std::{
    sync::{Arc, mpsc},
    thread::JoinHandle,
};

use super::{
    monitor::{Message, Monitor},
    solve::{Problem, Solved, solve},
};
use crate::scene::Tessellation;
#[cfg(feature = "reference")]
use crate::{
    scene::{Scene, area_light::AreaLightState},
    solver::Kept,
};

/// A running solve. Dropping it cancels the solve and waits for its thread.
pub struct Job {
    monitor: Arc<Monitor>,
    messages: mpsc::Receiver<Message>,
    thread: Option<JoinHandle<Solved>>,
}

impl Job {
    /// Starts solving on `threads` threads (all cores if 0). Fails if the threads cannot be made.
    pub fn start(problem: Problem, threads: usize) -> std::io::Result<Self> {
        let tessellation = Arc::clone(&problem.tessellation);
        Self::spawn(&tessellation, threads, move |monitor| solve(&problem, monitor))
    }

    /// Starts lighting kept rows again, by another light and in a scene of other materials: see [`Kept::relight`].
    #[cfg(feature = "reference")]
    pub fn relight(
        kept: Arc<Kept>,
        scene: Arc<Scene>,
        light: Option<AreaLightState>,
        threads: usize,
    ) -> std::io::Result<Self> {
        let tessellation = Arc::clone(kept.tessellation());
        Self::spawn(&tessellation, threads, move |monitor| kept.relight(&scene, light, monitor))
    }

    fn spawn(
        tessellation: &Arc<Tessellation>,
        threads: usize,
        work: impl FnOnce(&Monitor) -> Solved + Send + 'static,
    ) -> std::io::Result<Self> {
        let (sender, messages) = mpsc::channel();
        let monitor = Arc::new(Monitor::new(tessellation, Some(sender)));
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("solver {index}"))
            .build()
            .map_err(std::io::Error::other)?;
        let watched = Arc::clone(&monitor);
        let thread =
            std::thread::Builder::new().name(String::from("solve")).spawn(move || pool.install(|| work(&watched)))?;
        Ok(Self { monitor, messages, thread: Some(thread) })
    }

    /// What the job shares: progress, the live field, pause and cancel.
    pub fn monitor(&self) -> &Arc<Monitor> {
        &self.monitor
    }

    /// News since the last call, in order. Does not wait.
    pub fn messages(&self) -> impl Iterator<Item = Message> + '_ {
        self.messages.try_iter()
    }

    /// Waits up to `timeout` for the next message.
    pub fn next_message(&self, timeout: std::time::Duration) -> Option<Message> {
        self.messages.recv_timeout(timeout).ok()
    }

    /// True once the solve has ended.
    pub fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the end. `None` if the solver panicked (in a ray tracer from outside, say).
    pub fn finish(mut self) -> Option<Solved> {
        self.thread.take()?.join().ok()
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        self.monitor.cancel();
        if let Some(thread) = self.thread.take() {
            // Its result is not wanted, and its panic was printed.
            let _ = thread.join();
        }
    }
}
