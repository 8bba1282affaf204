//! The line at the bottom: how far the solve has come, speed, frame times.

use egui::{ProgressBar, Ui};

use super::{frame_times::Summary, panel_solve::SolveStatus, results::Results};
use crate::solver::Stage;

/// What the line tells.
pub(super) struct Status<'a> {
    /// The solve.
    pub(super) solve: SolveStatus,
    /// Its results so far.
    pub(super) results: Option<&'a Results>,
    /// A file is read or written.
    pub(super) busy: bool,
    /// Flying speed, in m/s.
    pub(super) speed: f64,
    /// Frame times.
    pub(super) frames: Summary,
}

/// Draws the line.
pub(super) fn ui(ui: &mut Ui, status: &Status<'_>) {
    ui.horizontal(|ui| {
        solve_ui(ui, status);
        if status.busy {
            ui.separator();
            ui.spinner();
            ui.label("reading or writing a file");
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let Summary { mean, worst, longest_in_solve, .. } = status.frames;
            let tooltip = "Milliseconds of the thread that draws: mean and worst frame of the last second, and the \
                longest since the last solve began, while it ran. F4 tells the stages";
            let text = format!("frame {mean:.1} / {worst:.1} ms, solving {longest_in_solve:.1} ms");
            ui.label(text).on_hover_text(tooltip);
            ui.separator();
            ui.label(format!("{:.2} m/s", status.speed)).on_hover_text("Flying speed: turn the wheel over the view");
            ui.separator();
            ui.label("F1: help");
        });
    });
}

fn solve_ui(ui: &mut Ui, status: &Status<'_>) {
    let progress = status.results.and_then(|results| results.progress);
    let report = status.results.and_then(|results| results.report.as_ref());
    if !status.solve.running {
        let text = match (report, status.results) {
            (Some(report), Some(results)) if results.relit => format!(
                "Relit in {:.0} ms, {:.2} % unabsorbed; ENTER lets the elements follow the light again",
                1e3 * report.seconds,
                100.0 * report.unabsorbed
            ),
            (Some(report), Some(results)) => {
                let complete = results.solution.as_ref().is_some_and(|solution| solution.info.complete);
                let how = if complete { "Solved" } else { "Cancelled" };
                let (seconds, bounces) = (report.seconds, results.bounces.len());
                let left = 100.0 * report.unabsorbed;
                let name = if bounces == 1 { "bounce" } else { "bounces" };
                format!("{how}: {bounces} {name} in {seconds:.2} s, {left:.2} % unabsorbed")
            }
            (None, Some(_)) => String::from("Solution loaded"),
            _ => String::from("Press ENTER to solve"),
        };
        ui.label(text);
        return;
    }
    let Some(progress) = progress else {
        ui.spinner();
        ui.label("preparing");
        return;
    };
    let stage = match progress.stage {
        Stage::Bouncing => format!("bounce {}", progress.bounce),
        stage => stage.to_string(),
    };
    let stage = if status.solve.paused { format!("{stage}, waiting") } else { stage };
    ui.add(ProgressBar::new(progress.fraction).desired_width(180.0).text(stage));
    let rays = progress.rays_per_second * 1e-6;
    let (left, unabsorbed) = (progress.seconds_left, 100.0 * progress.unabsorbed);
    ui.label(format!("{left:.1} s left · {rays:.2} Mrays/s · {unabsorbed:.2} % unabsorbed"));
}
