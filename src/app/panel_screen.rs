//! The panel of the screen-space view.

use clap::ValueEnum as _;
use egui::{Slider, Ui};

use super::{
    controls::{choice_row, flag_help, row, rows},
    layout::Layout,
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
        self.buffers_ui(ui, settings);
        if let Some(shown) = self.shown.as_ref().filter(|_| self.job.is_some()) {
            shown_ui(ui, shown);
        }
        ui.separator();
        rows(ui, "screen space", |ui| settings_ui(ui, settings));
        ui.checkbox(&mut settings.no_tail, "No later bounces").on_hover_text(help("no_tail"));
        if ui.button("Reset settings").on_hover_text("Back to the program's own settings").clicked() {
            *settings = Layout::default().screen;
        }
    }

    /// Which buffer is shown, and of which layer.
    fn buffers_ui(&mut self, ui: &mut Ui, settings: &ScreenSettings) {
        ui.horizontal_wrapped(|ui| {
            for buffer in ShownBuffer::ALL {
                let value = buffer.to_possible_value();
                let explanation = value.and_then(|value| value.get_help().map(ToString::to_string));
                let choice = ui.selectable_value(&mut self.buffer, buffer, buffer.name());
                choice.on_hover_text(explanation.unwrap_or_default());
            }
        });
        let has_second = settings.layers() == 2 && self.buffer.has_layers();
        let mut second = self.layer == 1;
        let check = ui.add_enabled(has_second, egui::Checkbox::new(&mut second, "Of the second layer"));
        check.on_hover_text("Shows this buffer of what lies behind the nearest surfaces");
        self.layer = u32::from(second);
        if self.buffer == ShownBuffer::Obscurance && settings.obscurance == 0 {
            ui.weak("It is off: set obscurance taps below.");
        }
    }
}

/// What the last frame took, and how far it is from the solution.
fn shown_ui(ui: &mut Ui, shown: &ShownScreen) {
    let [width, height] = shown.size;
    let milliseconds = 1e3 * shown.frame_time.as_secs_f64();
    let frames = if shown.still == 1 { String::from("one frame") } else { format!("mean of {} frames", shown.still) };
    ui.label(format!("{width} × {height} pixels, {milliseconds:.0} ms a frame, {frames}"));
    if let Some(errors) = shown.errors {
        let percent = |part: f64| 100.0 * part;
        let bias = if errors.bias < 0.0 { "dark" } else { "bright" };
        ui.label(format!(
            "Error against the present solution: {:.1} % (indirect light {:.1} %); {:.1} % too {bias}",
            percent(errors.total),
            percent(errors.indirect),
            percent(errors.bias.abs()),
        ))
        .on_hover_text(
            "Root mean square over the pixels, relative to the mean light; told after 8 and after 64 frames",
        );
    }
    egui::CollapsingHeader::new("Passes").show(ui, |ui| {
        rows(ui, "passes", |ui| {
            for pass in &shown.times {
                ui.label(pass.pass);
                ui.label(format!("{:.1} ms", 1e3 * pass.seconds))
                    .on_hover_text("Of this frame, without waiting for the window");
                ui.end_row();
            }
        });
    });
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
