//! How long frames take, stage by stage, and how long the thread that draws was held up while a solve ran.

use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

use egui::Ui;

/// The stages of a frame, in order, and what they do.
pub const STAGES: [(&str, &str); 6] = [
    ("listen", "takes in what the solver and the readers of files have to tell, and the keys"),
    ("panels", "lays out panels and plots"),
    ("views", "makes the fields that are shown; gestures, handles and legends"),
    ("rest", "notices, dialogs, and what keys and buttons ask for"),
    ("upload", "uploads fields and materials, and records the views' passes"),
    ("draw", "egui's triangles, the driver, and handing the picture to the screen"),
];

/// A frame's time and its stages', in milliseconds.
#[derive(Clone, Copy)]
struct Frame {
    ended: Instant,
    whole: f32,
    stages: [f32; STAGES.len()],
}

/// Frames of the last second.
#[derive(Default)]
pub struct FrameTimes {
    frames: VecDeque<Frame>,
    longest_in_solve: f32,
    /// When this frame's last stage ended, and the stages so far.
    mark: Option<Instant>,
    stages: [f32; STAGES.len()],
    /// The stages of the frame before, whose drawing is known only now.
    before: Option<[f32; STAGES.len()]>,
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
    /// Mean and longest of each of [`STAGES`].
    pub stages: [[f32; 2]; STAGES.len()],
}

impl FrameTimes {
    /// A frame begins. `drawing` is what the frame before took with its drawing, in seconds, and `upload` what of that
    /// its views took.
    pub fn begin(&mut self, drawing: Option<f32>, upload: Duration, solving: bool) {
        if let Some(mut stages) = self.before.take() {
            let own: f32 = stages.iter().sum();
            stages[4] = 1e3 * upload.as_secs_f32();
            stages[5] = (1e3 * drawing.unwrap_or_default() - own - stages[4]).max(0.0);
            self.enter(stages, solving);
        }
        self.stages = Default::default();
        self.mark = Some(Instant::now());
    }

    /// The stage of this number in [`STAGES`], or a part of it, has ended.
    pub fn end_stage(&mut self, stage: usize) {
        if let Some(mark) = self.mark {
            self.stages[stage] += 1e3 * mark.elapsed().as_secs_f32();
            self.mark = Some(Instant::now());
        }
    }

    /// A frame's own work has ended.
    pub fn end(&mut self) {
        self.before = self.mark.take().map(|_| self.stages);
    }

    fn enter(&mut self, stages: [f32; STAGES.len()], solving: bool) {
        let now = Instant::now();
        let whole = stages.iter().sum();
        self.frames.push_back(Frame { ended: now, whole, stages });
        while self.frames.front().is_some_and(|frame| now - frame.ended > Duration::from_secs(1)) {
            self.frames.pop_front();
        }
        if solving {
            self.longest_in_solve = self.longest_in_solve.max(whole);
        }
    }

    /// A solve begins: its longest frame is still to come.
    pub fn solve_begins(&mut self) {
        self.longest_in_solve = 0.0;
    }

    /// The last second.
    pub fn summary(&self) -> Summary {
        let mean_and_worst = |value: &dyn Fn(&Frame) -> f32| {
            let values = || self.frames.iter().map(value);
            [values().sum::<f32>() / self.frames.len().max(1) as f32, values().fold(0.0, f32::max)]
        };
        let [mean, worst] = mean_and_worst(&|frame| frame.whole);
        let stages = std::array::from_fn(|stage| mean_and_worst(&|frame| frame.stages[stage]));
        Summary { frames: self.frames.len(), mean, worst, longest_in_solve: self.longest_in_solve, stages }
    }
}

/// Draws the table of stages. False once it is to be closed.
pub(super) fn ui(context: &egui::Context, summary: &Summary) -> bool {
    let mut stays = true;
    let window = egui::Window::new("Frame times").resizable(false).open(&mut stays);
    let corner = context.content_rect().right_bottom() - egui::vec2(8.0, 36.0);
    window.pivot(egui::Align2::RIGHT_BOTTOM).default_pos(corner).show(context, |ui| {
        ui.label(format!("{} frames in the last second; milliseconds of the thread that draws", summary.frames));
        egui::Grid::new("stages").num_columns(3).striped(true).show(ui, |ui| {
            row(ui, "", "", ["mean", "worst"].map(String::from));
            for ((name, tooltip), times) in STAGES.into_iter().zip(summary.stages) {
                row(ui, name, tooltip, times.map(|time| format!("{time:.2}")));
            }
            row(ui, "whole", "", [summary.mean, summary.worst].map(|time| format!("{time:.2}")));
        });
    });
    stays
}

fn row(ui: &mut Ui, name: &str, tooltip: &str, values: [String; 2]) {
    let name = ui.label(name);
    if !tooltip.is_empty() {
        name.on_hover_text(tooltip);
    }
    for value in values {
        ui.label(value);
    }
    ui.end_row();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_counts_with_its_drawing_and_the_longest_of_a_solve_is_kept() {
        let mut times = FrameTimes::default();
        times.begin(None, Duration::ZERO, false);
        times.end_stage(0);
        times.end();
        times.begin(Some(0.050), Duration::from_millis(20), true);
        let summary = times.summary();
        assert_eq!(summary.frames, 1);
        assert!((summary.worst - 50.0).abs() < 0.1 && (summary.longest_in_solve - 50.0).abs() < 0.1, "{summary:?}");
        assert!((summary.stages[4][1] - 20.0).abs() < 1e-3 && (summary.stages[5][1] - 30.0).abs() < 0.1);
        times.solve_begins();
        assert_eq!(times.summary().longest_in_solve, 0.0);
    }
}
