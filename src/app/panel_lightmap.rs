//! The panel of the lightmap that the graphics card solves.

use egui::{ColorImage, Slider, TextureHandle, TextureOptions, Ui};

use super::{
    command::Command,
    controls::{row, rows},
    lightmap_job::LightmapJob,
};
use crate::lightmap::{GpuSettings, LightmapSettings};

/// The lightmap in the window.
#[derive(Default)]
pub struct LightmapPanel {
    /// How fine the next map is.
    pub map: LightmapSettings,
    /// How the next map is solved.
    pub settings: GpuSettings,
    /// The one on its way.
    pub job: Option<LightmapJob>,
    /// What it does, or how it ended.
    pub status: String,
    page: Option<TextureHandle>,
}

impl LightmapPanel {
    /// Takes the newest picture of the map.
    pub(super) fn set_page(&mut self, context: &egui::Context, page: ColorImage) {
        match &mut self.page {
            Some(texture) => texture.set(page, TextureOptions::NEAREST),
            None => self.page = Some(context.load_texture("lightmap", page, TextureOptions::NEAREST)),
        }
    }

    /// Draws the panel.
    pub(super) fn ui(&mut self, ui: &mut Ui) -> Option<Command> {
        let mut command = None;
        rows(ui, "lightmap", |ui| {
            let texels = Slider::new(&mut self.map.texels, 500..=1_000_000).logarithmic(true);
            row(ui, "Map texels", "Texels on all surfaces together, about", texels);
            let side = Slider::new(&mut self.settings.group, 1..=16).custom_formatter(|value, _| format!("{value}"));
            row(ui, "Group side", "Texels along the side of a group that shoots as one", side);
            self.settings.group = self.settings.group.next_power_of_two();
            let left = Slider::new(&mut self.settings.unabsorbed, 0.0005..=0.2).logarithmic(true);
            row(ui, "Light left", "Stop when this part of the emitted power is still unabsorbed", left);
        });
        ui.horizontal(|ui| {
            let name = if self.job.is_some() { "Restart lightmap" } else { "Solve lightmap" };
            let tooltip = "Shoots light on the graphics card; the right view shows it, beside the present solution";
            if ui.button(name).on_hover_text(tooltip).clicked() {
                command = Some(Command::SolveLightmap);
            }
            if let Some(job) = &self.job {
                if ui.button(if job.is_paused() { "Go on with it" } else { "Let it wait" }).clicked() {
                    job.toggle_pause();
                }
                if ui.button("Stop it").on_hover_text("Keeps what it has").clicked() {
                    job.stop();
                }
            }
        });
        if !self.status.is_empty() {
            ui.label(&self.status);
        }
        if let Some(page) = &self.page {
            let scale = (ui.available_width() / page.size_vec2().x).min(4.0);
            let picture = egui::Image::new((page.id(), page.size_vec2() * scale)).alt_text("The lightmap's first page");
            ui.add(picture).on_hover_text("The first page of the map: irradiance; each patch of colour is a chart");
        }
        command
    }
}
