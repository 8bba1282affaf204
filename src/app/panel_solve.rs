//! The panel of the solver: one control for each field of the settings.

use egui::{DragValue, Slider, Ui};

use super::controls::{choice_row, flag_help, longest_edge_row, optional_row, row, rows};
use crate::solver::{Engine, SolveSettings};

/// Row memory to begin with where it is limited, in MiB.
const USUAL_ROW_MEMORY: u32 = 2048;

/// What the panel has to know of the solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolveStatus {
    /// It runs.
    pub running: bool,
    /// It is told to wait.
    pub paused: bool,
    /// The light, a material or a setting differs from what is being or was solved.
    pub changed: bool,
}

/// The text of each field of the settings, by its name: the help of its flag, so that there is one source.
pub fn setting_help(field: &str) -> String {
    flag_help::<SolveSettings>(field)
}

/// The controls of how elements are cut; of following the light and cutting evenly, those of what is chosen.
fn elements_ui(ui: &mut Ui, settings: &mut SolveSettings) {
    let help = setting_help;
    if settings.engine == Engine::Reference {
        let mut follows = settings.adaptive > 0.0;
        optional_row(ui, "Follow light", &help("adaptive"), &mut follows, |ui, label| {
            ui.add(DragValue::new(&mut settings.adaptive).range(0.002..=0.5).speed(0.001)).labelled_by(label);
        });
        if follows != (settings.adaptive > 0.0) {
            settings.adaptive = if follows { SolveSettings::default().adaptive } else { 0.0 };
        }
    }
    if settings.follows_light() {
        row(ui, "Most vertices", &help("max_vertices"), DragValue::new(&mut settings.max_vertices));
        return;
    }
    if settings.engine == Engine::Reference {
        choice_row(ui, "Vertex values", &help("vertex_values"), &mut settings.vertex_values);
    }
    row(ui, "Subdivide", &help("subdivide"), Slider::new(&mut settings.subdivide, 0..=8));
    longest_edge_row(ui, &help("max_edge"), &mut settings.max_edge);
}

/// The controls.
pub fn ui(ui: &mut Ui, settings: &mut SolveSettings) {
    rows(ui, "solver settings", |ui| {
        let help = setting_help;
        choice_row(ui, "Engine", &help("engine"), &mut settings.engine);
        let rays = Slider::new(&mut settings.rays, 1..=16384).logarithmic(true);
        row(ui, "Rays", &help("rays"), rays);
        choice_row(ui, "Direct light", &help("direct"), &mut settings.direct);
        let light_rays = Slider::new(&mut settings.light_rays, 1..=4096).logarithmic(true);
        row(ui, "Light rays", &help("light_rays"), light_rays);
        let mut limited = settings.bounces.is_some();
        optional_row(ui, "Bounces", &help("bounces"), &mut limited, |ui, label| {
            let bounces = settings.bounces.get_or_insert(3);
            ui.add(DragValue::new(bounces).range(0..=1000).speed(0.05)).labelled_by(label);
        });
        settings.bounces = settings.bounces.or(limited.then_some(3)).filter(|_| limited);
        let mut percent = 100.0 * settings.unabsorbed;
        let unabsorbed = Slider::new(&mut percent, 0.001..=50.0).logarithmic(true).suffix(" %");
        if row(ui, "Unabsorbed", &help("unabsorbed"), unabsorbed).changed() {
            settings.unabsorbed = 0.01 * percent;
        }
        if settings.engine == Engine::Reference {
            choice_row(ui, "Iteration", &help("iteration"), &mut settings.iteration);
        }
        choice_row(ui, "Sampler", &help("sampler"), &mut settings.sampler);
        row(ui, "Seed", &help("seed"), DragValue::new(&mut settings.seed));
        elements_ui(ui, settings);
        let mut limited = settings.row_memory.is_some();
        optional_row(ui, "Row memory", &help("row_memory"), &mut limited, |ui, label| {
            let memory = settings.row_memory.get_or_insert(USUAL_ROW_MEMORY);
            ui.add(Slider::new(memory, 0..=65536).logarithmic(true).suffix(" MiB")).labelled_by(label);
        });
        settings.row_memory = settings.row_memory.or(limited.then_some(USUAL_ROW_MEMORY)).filter(|_| limited);
    });
    if ui.button("Reset settings").on_hover_text("Back to the program's own settings").clicked() {
        *settings = SolveSettings::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_of_the_settings_has_a_help_text() -> Result<(), serde_json::Error> {
        let settings = serde_json::to_value(SolveSettings::default())?;
        for (name, _) in settings.as_object().into_iter().flatten() {
            assert!(setting_help(name).len() > 10, "{name}: {:?}", setting_help(name));
        }
        assert!(setting_help("rays").contains("Hemisphere rays"));
        Ok(())
    }
}
