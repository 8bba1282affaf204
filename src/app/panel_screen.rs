//! The panel of the screen-space view.

use clap::ValueEnum as _;
use egui::{Slider, Ui};

use super::{
    controls::{choice_row, flag_help, row, rows},
    panel_lightmap::times_ui,
    screen_job::{ScreenJob, ShownScreen},
};
use crate::gpu::screen_space::{ScreenSettings, ShownBuffer};

/// The screen-space view in the window.
#[derive(Default)]
pub struct ScreenPanel {
    /// The thread that draws it, while a view shows it.
    pub job: Option<ScreenJob>,
    /// Its last finished frame.
    pub shown: Option<ShownScreen>,
    /// Which buffer is shown: `Total` for what the view asks for.
    pub buffer: ShownBuffer,
    /// Its layer: 0 or 1.
    pub layer: u32,
}

/// The help of a flag of `radiosity screen-space`, by its field.
fn help(field: &str) -> String {
    flag_help::<ScreenSettings>(field)
}

impl ScreenPanel {
    /// Draws the panel and edits the settings.
    pub(super) fn ui(&mut self, ui: &mut Ui, settings: &mut ScreenSettings) {
        if self.job.is_none() {
            ui.label("Choose \u{201c}screen space\u{201d} for a view (panel View) to see what is set here.");
        }
        rows(ui, "screen space", |ui| settings_ui(ui, settings));
        ui.checkbox(&mut settings.no_tail, "No later bounces").on_hover_text(help("no_tail"));
        ui.horizontal_wrapped(|ui| {
            for buffer in ShownBuffer::ALL {
                let value = buffer.to_possible_value();
                let name = value.as_ref().map_or("", |value| value.get_name());
                let explanation = value.as_ref().and_then(|value| value.get_help()).map(ToString::to_string);
                ui.selectable_value(&mut self.buffer, buffer, name).on_hover_text(explanation.unwrap_or_default());
            }
            let mut second = self.layer == 1;
            ui.checkbox(&mut second, "Second layer").on_hover_text("Of the buffer that is shown");
            self.layer = u32::from(second);
        });
        let Some(shown) = self.shown.as_ref().filter(|_| self.job.is_some()) else { return };
        let [width, height] = shown.size;
        let milliseconds = 1e3 * shown.frame_time.as_secs_f64();
        ui.label(format!("{width} × {height} pixels in {milliseconds:.1} ms, the mean of {} frames", shown.still));
        if let Some(errors) = shown.errors {
            ui.label(format!(
                "against the present solution: total errs by {:.1} %, indirect light by {:.1} % of the mean; {:+.1} % too bright",
                100.0 * errors.total,
                100.0 * errors.indirect,
                100.0 * errors.bias
            ));
        }
        egui::CollapsingHeader::new("Passes").show(ui, |ui| times_ui(ui, &shown.times));
    }
}

fn settings_ui(ui: &mut Ui, settings: &mut ScreenSettings) {
    choice_row(ui, "Second layer", &help("second_layer"), &mut settings.second_layer);
    let separation = Slider::new(&mut settings.separation, 0.0..=0.2);
    row(ui, "Separation", &help("separation"), separation);
    row(ui, "Reflections", &help("bounces"), Slider::new(&mut settings.bounces, 0..=8));
    row(ui, "Taps", &help("taps"), Slider::new(&mut settings.taps, 1..=128));
    row(ui, "Turns", &help("turns"), Slider::new(&mut settings.turns, 0..=60));
    row(ui, "Radius", &help("radius"), Slider::new(&mut settings.radius, 0.01..=1.0));
    row(ui, "Surround", &help("surround"), Slider::new(&mut settings.surround, 1.0..=5.0));
    row(ui, "Every", &help("every"), Slider::new(&mut settings.every, 1..=4).suffix(" pixels"));
    let thickness = Slider::new(&mut settings.thickness, 1e-3..=1.0).logarithmic(true);
    row(ui, "Thickness", &help("thickness"), thickness);
    choice_row(ui, "Weights", &help("weights"), &mut settings.weights);
    row(ui, "Unseen", &help("unseen"), Slider::new(&mut settings.unseen, 0.0..=1.0));
    row(ui, "Light samples", &help("light_samples"), Slider::new(&mut settings.light_samples, 1..=64));
    let size = Slider::new(&mut settings.shadow_map, 16..=1024).step_by(2.0);
    row(ui, "Shadow map", &help("shadow_map"), size);
    row(ui, "Shadow bias", &help("shadow_bias"), Slider::new(&mut settings.shadow_bias, 0.0..=8.0));
    row(ui, "Filter", &help("filter"), Slider::new(&mut settings.filter, 0..=32));
    let depth = Slider::new(&mut settings.filter_depth, 1e-4..=1.0).logarithmic(true);
    row(ui, "Filter depth", &help("filter_depth"), depth);
    row(ui, "Obscurance taps", &help("obscurance"), Slider::new(&mut settings.obscurance, 0..=64));
    let radius = Slider::new(&mut settings.obscurance_radius, 1e-3..=1.0).logarithmic(true);
    row(ui, "Obscurance radius", &help("obscurance_radius"), radius);
    row(
        ui,
        "Obscurance strength",
        &help("obscurance_strength"),
        Slider::new(&mut settings.obscurance_strength, 0.0..=8.0),
    );
    row(ui, "Frame budget", &help("frame_budget"), Slider::new(&mut settings.frame_budget, 0..=500).suffix(" ms"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_has_a_help_text() -> Result<(), serde_json::Error> {
        for (name, _) in serde_json::to_value(ScreenSettings::default())?.as_object().into_iter().flatten() {
            assert!(help(name).len() > 10, "{name}: {:?}", help(name));
        }
        Ok(())
    }
}
