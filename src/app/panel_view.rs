//! The panel of the views and the tone map.

use egui::{DragValue, Slider, Ui};

use super::{
    command::Command,
    controls::{row, rows},
    layout::Layout,
    view_settings::{Shown, Source, ViewSettings},
};
use crate::math::color::{ToneCurve, ToneMap};

/// What the panel has to know of the solutions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Available {
    /// Complete bounces of the present solution.
    pub(super) bounces: usize,
    /// There is a solution to compare with.
    pub(super) other: bool,
    /// There is a lightmap.
    pub(super) lightmap: bool,
}

/// Draws the panel and edits the views.
pub(super) fn ui(ui: &mut Ui, layout: &mut Layout, tone_map: &mut ToneMap, available: Available) -> Option<Command> {
    let mut command = None;
    ui.checkbox(&mut layout.second_view, "Second view").on_hover_text("X: another view of the same camera beside it");
    if layout.second_view {
        ui.strong("Left view");
    }
    view_ui(ui, 0, &mut layout.views[0], available);
    if layout.second_view {
        ui.separator();
        ui.strong("Right view");
        view_ui(ui, 1, &mut layout.views[1], available);
    }
    ui.separator();
    tone_ui(ui, tone_map);
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut layout.ambient, "Ambient light").on_hover_text("U: light from everywhere, for looking round");
        ui.checkbox(&mut layout.antialias, "Smooth edges").on_hover_text("Four samples a pixel");
    });
    ui.horizontal_wrapped(|ui| {
        let play = ui.add_enabled(available.bounces > 1, egui::Button::new("Play bounces"));
        if play.on_hover_text("Light after none, one, two, ... reflections").clicked() {
            command = Some(Command::Play);
        }
        if ui.button("Reset views").on_hover_text("Both views show what they showed at first").clicked() {
            layout.views = Layout::default().views;
        }
        if ui.button("Reset camera").on_hover_text("Back to where the scene's state looks from").clicked() {
            command = Some(Command::ResetCamera);
        }
        if ui.button("Copy view").on_hover_text("CTRL + C: camera and light as one line of text").clicked() {
            command = Some(Command::CopyView);
        }
    });
    command
}

fn view_ui(ui: &mut Ui, number: usize, view: &mut ViewSettings, available: Available) {
    ui.push_id(number, |ui| {
        ui.horizontal_wrapped(|ui| {
            for shown in Shown::ALL {
                ui.selectable_value(&mut view.shown, shown, shown.name()).on_hover_text(shown.explanation());
            }
        });
        let last = available.bounces.saturating_sub(1).max(view.bounce);
        if view.shown.has_bounce() {
            rows(ui, "bounce", |ui| {
                let tooltip = "0 is direct light";
                row(ui, "Bounce", tooltip, Slider::new(&mut view.bounce, 0..=last));
            });
        }
        ui.horizontal_wrapped(|ui| {
            ui.checkbox(&mut view.wireframe, "Wireframe").on_hover_text("B: edges of the elements");
            ui.checkbox(&mut view.false_colour, "False colours").on_hover_text("F: with a legend in W/m²");
            let tooltip = "Hatches the elements around vertices that see next to nothing but back faces";
            ui.checkbox(&mut view.buried, "Buried").on_hover_text(tooltip);
        });
        if view.has_legend() {
            range_ui(ui, view);
        }
        {
            ui.horizontal_wrapped(|ui| {
                for (source, name, is_there) in [
                    (Source::Present, "present", true),
                    (Source::Other, "other", available.other),
                    (Source::Difference, "difference", available.other),
                    (Source::Lightmap, "lightmap", available.lightmap),
                    (Source::LightmapDifference, "difference to it", available.lightmap),
                    (Source::Screen, "screen space", true),
                    (Source::ScreenDifference, "difference to screen space", true),
                ] {
                    if is_there {
                        ui.selectable_value(&mut view.source, source, name);
                    }
                }
            });
        }
    });
}

fn range_ui(ui: &mut Ui, view: &mut ViewSettings) {
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut view.logarithmic, "Logarithmic").on_hover_text("Equal steps of colour are equal ratios");
        let mut fixed = view.maximum.is_some();
        let label = ui.checkbox(&mut fixed, "Highest value").on_hover_text("Else it follows the field");
        view.maximum = if fixed { view.maximum.or(Some(1.0)) } else { None };
        if let Some(maximum) = &mut view.maximum {
            let drag = DragValue::new(maximum).range(1e-6..=1e9).speed(0.02).suffix(" W/m²");
            ui.add(drag).labelled_by(label.id);
        }
    });
}

fn tone_ui(ui: &mut Ui, tone_map: &mut ToneMap) {
    rows(ui, "tone", |ui| {
        let exposure = Slider::new(&mut tone_map.exposure, -10.0..=10.0).suffix(" stops").max_decimals(2);
        row(ui, "Exposure", "Radiance is multiplied by 2 to this power", exposure);
        let white = Slider::new(&mut tone_map.white, 0.05..=100.0).logarithmic(true);
        row(ui, "White", "The radiance, after exposure, that is shown as white", white);
        let gamma = Slider::new(&mut tone_map.gamma, 0.2..=4.0);
        row(ui, "Gamma", "On top of sRGB's own coding; 1 leaves it alone", gamma);
    });
    ui.horizontal(|ui| {
        ui.label("Curve:");
        ui.radio_value(&mut tone_map.curve, ToneCurve::Plain, "plain").on_hover_text("Clipped at white");
        ui.radio_value(&mut tone_map.curve, ToneCurve::Filmic, "filmic").on_hover_text("Rolls off towards white");
        if ui.button("Reset tone map").clicked() {
            *tone_map = ToneMap::default();
        }
    });
}
