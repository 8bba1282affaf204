//! The line at the top: the solve's buttons, and the menu of panels.

use egui::{Button, Ui};

use super::{command::Command, layout::Layout, notices::Level, panel_solve::SolveStatus, panes::Pane};

/// Height of the buttons, in points.
const HEIGHT: f32 = 24.0;

/// Draws the bar; what was clicked.
pub(super) fn ui(ui: &mut Ui, status: SolveStatus, layout: &mut Layout) -> Option<Command> {
    let mut command = None;
    ui.horizontal(|ui| {
        let mut button = |enabled: bool, text: &str, help: &str, clicked: Command| {
            let button = ui.add_enabled(enabled, Button::new(text).min_size([64.0, HEIGHT].into()));
            if button.on_hover_text(help).clicked() {
                command = Some(clicked);
            }
        };
        let solve = if status.running { "Restart" } else { "Solve" };
        button(true, solve, "ENTER: solve with what is set now", Command::Solve);
        button(status.running, "Stop", "ESC: stop and keep the result", Command::Cancel);
        let pause = if status.paused { "Go on" } else { "Pause" };
        button(status.running, pause, "P: let the solve wait, or go on", Command::PauseOrResume);
        button(true, "Step", "N: one bounce more, then wait", Command::Step);
        #[cfg(feature = "reference")]
        ui.checkbox(&mut layout.relight_live, "Relight live").on_hover_text(super::relighting::RELIGHT_LIVE);
        if status.changed {
            ui.colored_label(Level::Warning.colour(), "Settings changed: ENTER to restart");
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.menu_button("Panels", |ui| menu_ui(ui, layout)).response.on_hover_text("Which panels are shown");
        });
    });
    command
}

fn menu_ui(ui: &mut Ui, layout: &mut Layout) {
    ui.checkbox(&mut layout.panels, "Panels").on_hover_text("F2: all of them");
    ui.checkbox(&mut layout.plots, "Plots").on_hover_text("F3");
    ui.separator();
    for pane in Pane::panels() {
        let mut shown = !layout.hidden.contains(&pane);
        if ui.add_enabled(layout.panels, egui::Checkbox::new(&mut shown, pane.title())).changed() {
            layout.hidden.retain(|hidden| *hidden != pane);
            if shown {
                layout.to_front = Some(pane);
            } else {
                layout.hidden.push(pane);
            }
        }
    }
    ui.separator();
    if ui.button("As at first").on_hover_text("Everything where it stood at first").clicked() {
        layout.reset_panes();
    }
}
