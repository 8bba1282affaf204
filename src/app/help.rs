//! The help: all keys.

use egui::{Align2, RichText};

use super::keys::{HELP, RULE};

/// Draws the help over the window. False once it is to be closed.
pub(super) fn ui(context: &egui::Context) -> bool {
    let mut stays = true;
    let window = egui::Window::new("Help").collapsible(false).resizable(false).open(&mut stays);
    window.default_width(500.0).anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        let height = context.content_rect().height() - 120.0;
        egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            ui.add(egui::Label::new(RULE).wrap());
            ui.separator();
            egui::Grid::new("keys").num_columns(2).spacing([16.0, 2.0]).striped(true).show(ui, |ui| {
                for (keys, action) in HELP {
                    ui.label(RichText::new(keys).strong().monospace());
                    ui.label(action);
                    ui.end_row();
                }
            });
        });
    });
    stays
}
