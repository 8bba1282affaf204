//! The panel of the scene: counts, bounds, and materials to edit.

use std::sync::Arc;

use egui::{DragValue, RichText, Ui};
use glam::Vec3;

use super::{
    command::Command,
    controls::{flag_help, rows},
    document::Document,
    file_dialog::Purpose,
    notices::Level,
};
use crate::{
    scene::{LoadOptions, Material},
    transport::facing::Remedy,
};

/// Draws the panel and edits the document's materials.
pub(super) fn ui(ui: &mut Ui, document: &mut Document) -> Option<Command> {
    let mut command = None;
    let report = &document.report;
    ui.horizontal(|ui| {
        ui.strong(&report.name);
        if ui.button("Open…").on_hover_text("M: open an OBJ file; or drop one on the window").clicked() {
            command = Some(Command::Ask(Purpose::OpenScene));
        }
    });
    rows(ui, "scene", |ui| {
        let mut line = |name: &str, value: String| {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        };
        let mesh = &document.elements.tessellation.mesh;
        line("Triangles", report.triangles.to_string());
        line("Elements", format!("{} with {} vertices", mesh.triangles.len(), mesh.positions.len()));
        let [low, high] = [report.minimum, report.maximum];
        let sides: Vec<String> = (0..3).map(|axis| format!("{:.3}", high[axis] - low[axis])).collect();
        line("Size [m]", sides.join(" × "));
        line("Area", format!("{:.3} m²", report.area));
        line("Textures", report.textures.len().to_string());
        let repairs = if report.warnings.is_empty() { String::from("none") } else { report.warnings.len().to_string() };
        line("Repairs", repairs);
    });
    let load = &document.loaded.load;
    let mut faceted = load.faceted;
    let tooltip = format!("{} The scene is read again", flag_help::<LoadOptions>("faceted"));
    if ui.checkbox(&mut faceted, "Faceted").on_hover_text(tooltip).changed() {
        command = Some(Command::ReadAgain(LoadOptions { faceted, ..load.clone() }));
    }
    let mut as_read = load.faces_as_read;
    let tooltip = format!("{} The scene is read again", flag_help::<LoadOptions>("faces_as_read"));
    if ui.checkbox(&mut as_read, "Faces as read").on_hover_text(tooltip).changed() {
        command = Some(Command::ReadAgain(LoadOptions { faces_as_read: as_read, ..load.clone() }));
    }
    if let Some(facing) = &document.facing {
        ui.label(RichText::new(&facing.text).color(Level::Warning.colour()));
        let (name, remedied) = match facing.remedy {
            Remedy::Flip => ("Flip", LoadOptions { flip: !load.flip, ..load.clone() }),
            Remedy::TwoSided => ("Make two-sided", LoadOptions { two_sided: true, ..load.clone() }),
        };
        if ui.button(name).on_hover_text("Reads the scene again").clicked() {
            command = Some(Command::ReadAgain(remedied));
        }
    }
    egui::CollapsingHeader::new("Materials").show(ui, |ui| materials_ui(ui, document));
    command
}

fn materials_ui(ui: &mut Ui, document: &mut Document) {
    let mut changed: Option<(usize, Material)> = None;
    egui::ScrollArea::vertical().max_height(260.0).id_salt("materials").show(ui, |ui| {
        for (index, material) in document.edit.materials.iter().enumerate() {
            let mut edited = material.clone();
            ui.push_id(index, |ui| material_ui(ui, &mut edited));
            if edited != *material {
                changed = Some((index, edited));
            }
        }
    });
    if let Some((index, material)) = changed {
        let mut materials = document.edit.materials.to_vec();
        materials[index] = material;
        document.edit.materials = Arc::new(materials);
    }
    let is_edited = document.edit.materials != document.original.materials;
    if ui.add_enabled(is_edited, egui::Button::new("Reset materials")).clicked() {
        document.edit.materials = Arc::clone(&document.original.materials);
    }
}

fn material_ui(ui: &mut Ui, material: &mut Material) {
    ui.horizontal(|ui| {
        let mut reflectance = material.reflectance.to_array();
        let label = ui.label(RichText::new(&material.name).strong());
        let tooltip = "Reflectance, linear RGB; a texture is multiplied with it";
        let colour = ui.color_edit_button_rgb(&mut reflectance).labelled_by(label.id).on_hover_text(tooltip);
        if colour.changed() {
            material.reflectance = Vec3::from_array(reflectance).clamp(Vec3::ZERO, Vec3::splat(0.95));
        }
        if material.reflectance_texture.is_some() {
            ui.weak("textured");
        }
        let mut emission = material.emitted_radiance.max_element();
        let tooltip = "Emitted radiance of the brightest band [W/(m² sr)]";
        let drag = DragValue::new(&mut emission).range(0.0..=1e6).speed(0.1).prefix("emits ");
        if ui.add(drag).labelled_by(label.id).on_hover_text(tooltip).changed() {
            let before = material.emitted_radiance;
            let tint = if before.max_element() > 0.0 { before / before.max_element() } else { Vec3::ONE };
            material.emitted_radiance = emission * tint;
        }
    });
}
