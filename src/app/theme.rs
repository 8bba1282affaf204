//! Colours of the window.

use egui::{Color32, Context, CornerRadius, Theme, Visuals};

/// The ground of panels and plots. The window is cleared to it, and nothing is drawn there: on a software driver, filling
/// the panels took longer than drawing the views.
const GROUND: Color32 = Color32::from_gray(27);

/// Sets the colours. A software driver gets square corners: round ones are fans of slivers, and cost it three times as much.
pub(super) fn install(context: &Context, software_driver: bool) {
    context.set_theme(Theme::Dark);
    context.style_mut_of(Theme::Dark, |style| {
        style.visuals.panel_fill = Color32::TRANSPARENT;
        // Scrolled panels fade out in the colour of their ground: that is nothing here, but would be drawn.
        style.spacing.scroll.fade.strength = 0.0;
        if software_driver {
            square_corners(&mut style.visuals);
        }
    });
}

fn square_corners(visuals: &mut Visuals) {
    let widgets = &mut visuals.widgets;
    for widget in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        widget.corner_radius = CornerRadius::ZERO;
    }
    visuals.window_corner_radius = CornerRadius::ZERO;
    visuals.menu_corner_radius = CornerRadius::ZERO;
}

/// Smooth edges of widgets, or hard ones, which a software driver draws in two thirds of the time.
pub(super) fn set_soft_edges(context: &Context, soft: bool) {
    context.tessellation_options_mut(|options| options.feathering = soft);
}

/// What the window is cleared to.
pub(super) fn clear_color() -> [f32; 4] {
    GROUND.to_normalized_gamma_f32()
}
