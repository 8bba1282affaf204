//! The help: all keys.

use egui::{Align2, RichText};

use super::keys::{HELP, RULE};

/// Draws the help over the window. False once it is to be closed.
pub(super) fn ui(context: &egui::Context) -> bool {
    let mut stays = true;
    let window = egui::Window::new("Help").collapsible(false).resizable(false).open(&mut stays);
    window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        let height = context.content_rect().height() - 120.0;
        egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            egui::Grid::new("keys").num_columns(2).spacing([16.0, 4.0]).striped(true).show(ui, |ui| {
                for (keys, action) in HELP {
                    ui.label(RichText::new(keys).strong().monospace());
                    ui.label(action);
                    ui.end_row();
                }
            });
            ui.separator();
            ui.set_max_width(460.0);
            ui.label(RULE);
        });
    });
    stays
}
