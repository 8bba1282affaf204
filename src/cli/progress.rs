//! How far a long command is, on standard error; and how Ctrl-C ends it.

#[cfg(any(feature = "gpu", feature = "reference"))]
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering::Relaxed},
};
use std::{
    io::{IsTerminal as _, stderr},
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};

/// Steps of the bar.
const STEPS: u64 = 1000;
/// Lines are no closer than this.
const LINE_INTERVAL: Duration = Duration::from_secs(1);
/// Lines are written only after this much of the work.
const LINE_FRACTION: f32 = 0.05;

/// A bar on a terminal, a few plain lines elsewhere, or nothing.
pub struct Progress {
    shown: Shown,
}

enum Shown {
    Nothing,
    Bar(ProgressBar),
    Lines(LinePace),
}

/// When a line is due.
struct LinePace {
    last_time: Instant,
    last_fraction: f32,
}

impl Progress {
    /// Progress from 0; `quiet` shows nothing.
    pub fn new(quiet: bool) -> Self {
        let shown = if quiet {
            Shown::Nothing
        } else if stderr().is_terminal() {
            let style = ProgressStyle::with_template("{bar:24} {percent:>3} % {wide_msg}");
            Shown::Bar(ProgressBar::new(STEPS).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())))
        } else {
            Shown::Lines(LinePace { last_time: Instant::now(), last_fraction: 0.0 })
        };
        Self { shown }
    }

    /// Says how much is done, in [0, 1], and what is being done.
    pub fn update(&mut self, fraction: f32, message: &str) {
        match &mut self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => {
                bar.set_position((fraction.clamp(0.0, 1.0) * STEPS as f32) as u64);
                bar.set_message(String::from(message));
            }
            Shown::Lines(pace) => {
                if pace.is_due(Instant::now(), fraction) {
                    eprintln!("{:3.0} % {message}", 100.0 * fraction);
                }
            }
        }
    }

    /// Writes a line that stays.
    pub fn line(&mut self, message: &str) {
        match &self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => bar.println(message),
            Shown::Lines(_) => eprintln!("{message}"),
        }
    }

    /// Ends the bar and says how it ended.
    pub fn finish(self, message: &str) {
        match self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => {
                bar.finish_and_clear();
                eprintln!("{message}");
            }
            Shown::Lines(_) => eprintln!("{message}"),
        }
    }
}

/// Seconds that the rest will take, if it goes on as since `started`.
#[cfg(any(feature = "gpu", feature = "reference"))]
pub fn seconds_left(started: Instant, fraction: f32) -> f64 {
    started.elapsed().as_secs_f64() * (1.0 / f64::from(fraction.max(1e-3)) - 1.0)
}

/// Set by Ctrl-C; a second one ends the program.
#[cfg(any(feature = "gpu", feature = "reference"))]
pub fn cancelled_by_interrupt() -> Arc<AtomicBool> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancelled);
    let installed = ctrlc::set_handler(move || {
        if flag.swap(true, Relaxed) {
            std::process::exit(130);
        }
    });
    if let Err(problem) = installed {
        eprintln!("warning: Ctrl-C will end the program without keeping the result: {problem}");
    }
    cancelled
}

impl LinePace {
    fn is_due(&mut self, now: Instant, fraction: f32) -> bool {
        let due = now - self.last_time >= LINE_INTERVAL && fraction - self.last_fraction >= LINE_FRACTION;
        if due {
            *self = Self { last_time: now, last_fraction: fraction };
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_wait_for_a_second_and_for_a_twentieth_of_the_work() {
        let start = Instant::now();
        let after = |millis| start + Duration::from_millis(millis);
        let mut pace = LinePace { last_time: start, last_fraction: 0.0 };
        assert!(!pace.is_due(after(900), 0.5), "too soon");
        assert!(!pace.is_due(after(2000), 0.04), "too little");
        assert!(pace.is_due(after(2100), 0.06));
        assert!(!pace.is_due(after(3000), 0.9), "too soon after the first");
        assert!(!pace.is_due(after(9000), 0.1), "too little since the first");
        assert!(pace.is_due(after(9100), 0.2));
    }
}
