//! What the window has to say: for a few seconds over the view, and for good in the log.

use std::time::{Duration, Instant};

use egui::{Align2, Color32, RichText};

/// How long a notice stays over the view.
const SHOWN_FOR: Duration = Duration::from_secs(8);

/// How serious a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Something was done.
    Note,
    /// Something was mended or left out.
    Warning,
    /// Something could not be done.
    Error,
}

impl Level {
    /// Its colour on a dark ground.
    pub fn colour(self) -> Color32 {
        match self {
            Self::Note => Color32::from_gray(200),
            Self::Warning => Color32::from_rgb(240, 190, 80),
            Self::Error => Color32::from_rgb(255, 120, 110),
        }
    }
}

/// One line.
pub struct Line {
    /// How serious.
    pub level: Level,
    /// The text.
    pub text: String,
    /// When it was said.
    pub since: Instant,
    /// True once it was clicked away.
    pub dismissed: bool,
}

/// All lines, oldest first.
#[derive(Default)]
pub struct Notices {
    /// The log.
    pub lines: Vec<Line>,
}

impl Notices {
    /// Says something.
    pub fn say(&mut self, level: Level, text: impl Into<String>) {
        self.lines.push(Line { level, text: text.into(), since: Instant::now(), dismissed: false });
    }

    /// The last error, if any.
    pub fn last_error(&self) -> Option<&str> {
        self.lines.iter().rev().find(|line| line.level == Level::Error).map(|line| line.text.as_str())
    }

    /// The newest lines over the view; a click puts one away.
    pub fn ui(&mut self, context: &egui::Context, below: egui::Pos2) {
        let fresh = |line: &&mut Line| !line.dismissed && line.since.elapsed() < SHOWN_FOR;
        let mut recent: Vec<&mut Line> = self.lines.iter_mut().rev().take(4).filter(fresh).collect();
        if recent.is_empty() {
            return;
        }
        context.request_repaint_after(Duration::from_millis(500));
        let area = egui::Area::new(egui::Id::unique("notices")).pivot(Align2::CENTER_TOP).fixed_pos(below);
        area.order(egui::Order::Foreground).show(context, |ui| {
            for line in recent.iter_mut().rev() {
                let frame = egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_max_width(520.0);
                    ui.label(RichText::new(line.text.as_str()).color(line.level.colour()));
                });
                line.dismissed |= frame.response.interact(egui::Sense::click()).clicked();
            }
        });
    }
}
