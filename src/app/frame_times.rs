//! How long frames take, and how long the thread that draws was held up while a solve ran.

use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

/// Frames of the last second.
#[derive(Default)]
pub struct FrameTimes {
    frames: VecDeque<(Instant, f32)>,
    longest_in_solve: f32,
    began: Option<Instant>,
}

/// What the last second was like, in milliseconds of work on the thread that draws.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Frames in the last second.
    pub frames: usize,
    /// Mean work of a frame.
    pub mean: f32,
    /// The longest.
    pub worst: f32,
    /// The longest since the last solve began, while it ran.
    pub longest_in_solve: f32,
}

impl FrameTimes {
    /// A frame begins.
    pub fn begin(&mut self) {
        self.began = Some(Instant::now());
    }

    /// A frame's own work has ended; `cpu_usage` is what drawing took in the frame before, in seconds.
    pub fn end(&mut self, drawing: Option<f32>, solving: bool) {
        let Some(began) = self.began.take() else { return };
        let own = began.elapsed().as_secs_f32();
        // The framework's figure includes this function's caller and the handing over to the card.
        let milliseconds = 1e3 * drawing.map_or(own, |drawing| drawing.max(own));
        let now = Instant::now();
        self.frames.push_back((now, milliseconds));
        while self.frames.front().is_some_and(|(when, _)| now - *when > Duration::from_secs(1)) {
            self.frames.pop_front();
        }
        if solving {
            self.longest_in_solve = self.longest_in_solve.max(milliseconds);
        }
    }

    /// A solve begins: its longest frame is still to come.
    pub fn solve_begins(&mut self) {
        self.longest_in_solve = 0.0;
    }

    /// The last second.
    pub fn summary(&self) -> Summary {
        let frames = self.frames.len();
        let sum: f32 = self.frames.iter().map(|(_, milliseconds)| milliseconds).sum();
        let worst = self.frames.iter().map(|(_, milliseconds)| *milliseconds).fold(0.0, f32::max);
        let mean = sum / frames.max(1) as f32;
        Summary { frames, mean, worst, longest_in_solve: self.longest_in_solve }
    }
}
