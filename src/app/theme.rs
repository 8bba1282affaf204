//! Colours of the window.

use egui::{Color32, Context, Theme};

/// The ground of panels and plots. The window is cleared to it, and nothing is drawn there: on a software driver, filling
/// the panels took longer than drawing the views.
const GROUND: Color32 = Color32::from_gray(27);

/// Sets the colours.
pub(super) fn install(context: &Context) {
    context.set_theme(Theme::Dark);
    context.style_mut_of(Theme::Dark, |style| style.visuals.panel_fill = Color32::TRANSPARENT);
}

/// What the window is cleared to.
pub(super) fn clear_color() -> [f32; 4] {
    GROUND.to_normalized_gamma_f32()
}
