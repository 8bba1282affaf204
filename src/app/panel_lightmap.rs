//! The panel of the lightmap that the graphics card solves.

use std::sync::Arc;

use egui::{Rect, Sense, Slider, Ui};

use super::{
    command::Command,
    controls::{choice_row, flag_help, row, rows},
    factors_job::FactorsPanel,
    lightmap_job::{LightmapJob, ShownMap},
    results::{Field, Results},
};
use crate::{
    files::atlas_cache::AtlasCache,
    gpu::{
        lightmap::{Stage, timing::PassTime},
        map_picture::{MapPictureFrame, Pictured},
        picture_callback,
    },
    lightmap::{GpuSettings, LightmapSettings},
    math::{color::ToneMap, ratio_or_zero},
};

/// The lightmap in the window.
pub struct LightmapPanel {
    /// How fine the next map is.
    pub map: LightmapSettings,
    /// How the next map is solved.
    pub settings: GpuSettings,
    /// The one on its way, or at rest.
    pub job: Option<LightmapJob>,
    /// What views show of it.
    pub shown: Option<ShownMap>,
    /// What its pages are to hold.
    pub stage: Stage,
    /// What its pages hold now.
    pub filled: Stage,
    /// What it does, or how it ended.
    pub status: String,
    /// Form factors by item buffers, and their radiosity.
    pub factors: FactorsPanel,
    /// What its passes took.
    pub times: Option<Vec<PassTime>>,
    /// The nearest texel is shown, and not a mean of four.
    pub nearest: bool,
    /// Where maps are kept from run to run; none unless somebody says so.
    pub cache: Option<AtlasCache>,
    picture: Picture,
    page: u32,
    outlines: bool,
    comparison: Option<(Field, Field, Comparison)>,
}

/// What the picture in the panel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Picture {
    Page,
    Hemicubes,
    Items,
}

impl Default for LightmapPanel {
    fn default() -> Self {
        Self {
            map: LightmapSettings::default(),
            settings: GpuSettings::default(),
            job: None,
            shown: None,
            stage: Stage::default(),
            filled: Stage::default(),
            status: String::new(),
            factors: FactorsPanel::default(),
            times: None,
            nearest: false,
            cache: None,
            picture: Picture::Page,
            page: 0,
            outlines: true,
            comparison: None,
        }
    }
}

/// Two fields of irradiance at the same vertices, in numbers [W/m²].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mean of the present solution.
    pub present: f64,
    /// Mean of the lightmap.
    pub lightmap: f64,
    /// Mean absolute difference.
    pub difference: f64,
}

impl Comparison {
    /// By area, over all bands; none if the elements differ.
    pub fn new(present: &Results, other: &Results) -> Option<Self> {
        let areas = present.elements.tessellation.vertex_areas();
        if present.total.len() != other.total.len() || areas.len() != other.total.len() {
            return None;
        }
        let (mut sums, mut whole) = ([0.0; 3], 0.0);
        for ((a, b), area) in present.total.iter().zip(other.total.iter()).zip(areas) {
            let parts = [a.element_sum(), b.element_sum(), (*a - *b).abs().element_sum()];
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += f64::from(area * part) / 3.0);
            whole += f64::from(area);
        }
        let [present, lightmap, difference] = sums.map(|sum| ratio_or_zero(sum, whole));
        Some(Self { present, lightmap, difference })
    }
}

/// The help of a flag of `radiosity lightmap`, by its field.
fn help(field: &str) -> String {
    let help = flag_help::<GpuSettings>(field);
    if help.is_empty() { flag_help::<LightmapSettings>(field) } else { help }
}

impl LightmapPanel {
    /// True while it takes the device's time.
    pub(super) fn is_working(&self) -> bool {
        self.job.as_ref().is_some_and(|job| !job.rests() && !job.is_paused())
    }

    /// Draws the panel.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        tone_map: &ToneMap,
        present: Option<&Results>,
        other: Option<&Results>,
    ) -> Option<Command> {
        rows(ui, "lightmap", |ui| self.settings_ui(ui));
        ui.horizontal_wrapped(|ui| {
            ui.checkbox(&mut self.settings.no_filter, "Nearest depth").on_hover_text(help("no_filter"));
            ui.checkbox(&mut self.map.no_coverage, "No coverage").on_hover_text(help("no_coverage"));
            let tooltip = "The nearest texel of the map is shown, and not a mean of the four around";
            ui.checkbox(&mut self.nearest, "Nearest texel").on_hover_text(tooltip);
        });
        let command = self.buttons_ui(ui);
        if !self.status.is_empty() {
            ui.label(&self.status);
        }
        if let (Some(present), Some(other)) = (present, other) {
            self.comparison_ui(ui, present, other);
        }
        self.picture_ui(ui, tone_map);
        let factors = egui::CollapsingHeader::new("Form factors").show(ui, |ui| self.factors.ui(ui));
        let command = command.or(factors.body_returned.flatten());
        if let Some(times) = self.times.as_ref().filter(|_| self.job.is_some()) {
            egui::CollapsingHeader::new("Passes").show(ui, |ui| times_ui(ui, times));
        }
        command
    }

    fn settings_ui(&mut self, ui: &mut Ui) {
        let Self { map, settings, .. } = self;
        let texels = Slider::new(&mut map.texels, 500..=1_000_000).logarithmic(true);
        row(ui, "Map texels", &help("texels"), texels);
        let side = Slider::new(&mut settings.group, 1..=16).custom_formatter(|value, _| format!("{value}"));
        row(ui, "Group side", &help("group"), side);
        settings.group = settings.group.next_power_of_two();
        let left = Slider::new(&mut settings.unabsorbed, 0.0005..=0.2).logarithmic(true);
        row(ui, "Light left", &help("unabsorbed"), left);
        let far = Slider::new(&mut settings.far_group, 1..=64).custom_formatter(|value, _| format!("{value}"));
        row(ui, "Far group side", &help("far_group"), far);
        settings.far_group = settings.far_group.next_power_of_two();
        choice_row(ui, "Attenuation", &help("attenuation"), &mut settings.attenuation);
        row(ui, "Bias", &help("bias"), Slider::new(&mut settings.bias, 0.0..=8.0));
        choice_row(ui, "Visibility", &help("visibility"), &mut settings.visibility);
        choice_row(ui, "Order", &help("order"), &mut settings.order);
        choice_row(ui, "Unshot light", &help("ambient"), &mut settings.ambient);
        choice_row(ui, "Update", &help("update"), &mut settings.update);
    }

    fn buttons_ui(&mut self, ui: &mut Ui) -> Option<Command> {
        let mut command = None;
        ui.horizontal_wrapped(|ui| {
            let name = if self.job.is_some() { "Restart lightmap" } else { "Solve lightmap" };
            let tooltip = "Shoots light on the graphics card; the right view shows it, beside the present solution";
            if ui.button(name).on_hover_text(tooltip).clicked() {
                command = Some(Command::SolveLightmap);
            }
            let Some(job) = &self.job else { return };
            if job.rests() {
                let tooltip = "Until so little is unabsorbed as \u{201c}Light left\u{201d} says now";
                if ui.button("Continue").on_hover_text(tooltip).clicked() {
                    job.go_on(self.settings.unabsorbed);
                }
                return;
            }
            if ui.button(if job.is_paused() { "Go on with it" } else { "Let it wait" }).clicked() {
                job.toggle_pause();
            }
            if ui.button("Stop it").on_hover_text("Keeps what it has; it can be continued").clicked() {
                job.stop();
            }
        });
        command
    }

    /// The two fields in numbers, once both are there.
    fn comparison_ui(&mut self, ui: &mut Ui, present: &Results, other: &Results) {
        let is_known =
            |(a, b, _): &&(Field, Field, Comparison)| Arc::ptr_eq(a, &present.total) && Arc::ptr_eq(b, &other.total);
        if self.comparison.as_ref().filter(is_known).is_none() {
            let fields = (Arc::clone(&present.total), Arc::clone(&other.total));
            self.comparison = Comparison::new(present, other).map(|found| (fields.0, fields.1, found));
        }
        if let Some((.., Comparison { present, lightmap, difference })) = self.comparison {
            let apart = 100.0 * ratio_or_zero(lightmap - present, present);
            let percent = 100.0 * ratio_or_zero(difference, present);
            ui.label(format!(
                "mean irradiance {present:.4} W/m² at the vertices, {lightmap:.4} on the map ({apart:+.1} %); \
                 mean difference {difference:.4} W/m² ({percent:.1} %)"
            ));
        }
    }

    fn picture_ui(&mut self, ui: &mut Ui, tone_map: &ToneMap) {
        let Some(shown) = &self.shown else { return };
        ui.horizontal_wrapped(|ui| {
            for stage in Stage::ALL {
                let (name, explanation) = stage.name();
                ui.selectable_value(&mut self.stage, stage, name).on_hover_text(explanation);
            }
        });
        ui.horizontal_wrapped(|ui| {
            let tooltip = "Depth of the first hemicubes that shot last: top, then four sides; white is near";
            ui.selectable_value(&mut self.picture, Picture::Page, "Map").on_hover_text("A page of the lightmap");
            ui.selectable_value(&mut self.picture, Picture::Hemicubes, "Hemicubes").on_hover_text(tooltip);
            if shown.items.is_some() {
                let tooltip = "Triangles that the first hemispheres which shot last show, each in a colour of its own";
                ui.selectable_value(&mut self.picture, Picture::Items, "Items").on_hover_text(tooltip);
            }
            ui.checkbox(&mut self.outlines, "Outlines").on_hover_text("Of the charts");
            if shown.page_count > 1 {
                let label = ui.label("Page");
                let page = Slider::new(&mut self.page, 0..=shown.page_count - 1);
                ui.add(page).labelled_by(label.id);
            }
        });
        let (size, pictured) = match (self.picture, &shown.items) {
            (Picture::Items, Some(items)) => {
                (shown.hemicubes_size, Pictured::Items(items.clone(), shown.hemicubes_size))
            }
            (Picture::Hemicubes, _) => {
                (shown.hemicubes_size, Pictured::Hemicubes(shown.hemicubes.clone(), shown.hemicubes_size))
            }
            _ => (
                shown.page_size,
                Pictured::Page {
                    pages: shown.pages.clone(),
                    page: self.page.min(shown.page_count - 1),
                    is_light: self.filled.is_light(),
                    outlines: self.outlines,
                },
            ),
        };
        let size = egui::vec2(size[0] as f32, size[1] as f32);
        let (rect, response) = ui.allocate_exact_size(size * (ui.available_width() / size.x).min(4.0), Sense::hover());
        let name = match self.picture {
            Picture::Page => "A page of the lightmap",
            Picture::Hemicubes => "Depth of hemicubes",
            Picture::Items => "Items of hemispheres",
        };
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
        let whole = Rect::from_min_size(rect.min, rect.size());
        let frame = MapPictureFrame { pictured, tone_map: *tone_map, origin: [0; 2], size: [0; 2] };
        ui.painter().add(picture_callback(whole, ui.ctx().pixels_per_point(), frame));
    }
}

fn times_ui(ui: &mut Ui, times: &[PassTime]) {
    rows(ui, "passes", |ui| {
        for PassTime { pass, runs, seconds } in times {
            ui.label(*pass);
            ui.label(format!(
                "{:.1} ms, {runs} times, {:.2} ms each",
                1e3 * seconds,
                1e3 * seconds / (*runs).max(1) as f64
            ));
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_of_both_settings_has_a_help_text() -> Result<(), serde_json::Error> {
        let (map, solve) = (LightmapSettings::default(), GpuSettings::default());
        for settings in [serde_json::to_value(map)?, serde_json::to_value(solve)?] {
            for (name, _) in settings.as_object().into_iter().flatten() {
                assert!(help(name).len() > 10, "{name}: {:?}", help(name));
            }
        }
        Ok(())
    }
}
