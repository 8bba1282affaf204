//! The panel of the placed area light.

use egui::{DragValue, Slider, Ui};
use glam::{DQuat, DVec3};

use super::{
    command::Command,
    controls::{decimals_for, row, rows, vector_row},
    document::{Document, LightPreset},
};
use crate::scene::area_light::AreaLightState;

/// Colours to choose from, as linear RGB of blackbodies of the named temperature, in K (Rec. 709 primaries).
const COLOURS: [(&str, [f32; 3]); 4] = [
    ("candle", [1.0, 0.42, 0.09]),
    ("lamp", [1.0, 0.65, 0.31]),
    ("daylight", [1.0, 0.95, 0.91]),
    ("blue sky", [0.62, 0.76, 1.0]),
];

/// Draws the panel and edits the document's light.
pub(super) fn ui(ui: &mut Ui, document: &mut Document) -> Option<Command> {
    let mut command = None;
    let size = document.size();
    match &mut document.edit.light {
        None => {
            ui.weak("No area light is placed.");
        }
        Some(light) => edit_light(ui, light, size),
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("Presets:");
        for preset in LightPreset::ALL {
            if ui.small_button(preset.name()).on_hover_text(preset.explanation()).clicked() {
                document.edit.light = Some(document.preset_light(preset));
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        if ui.button("At the camera").on_hover_text("SPACE: put it at the camera, shining where it looks").clicked() {
            command = Some(Command::PlaceLight);
        }
        let original = document.original.light;
        if ui.add_enabled(original != document.edit.light, egui::Button::new("Reset light")).clicked() {
            document.edit.light = original;
        }
        if ui.add_enabled(document.edit.light.is_some(), egui::Button::new("Remove")).clicked() {
            document.edit.light = None;
        }
    });
    command
}

fn edit_light(ui: &mut Ui, light: &mut AreaLightState, size: f64) {
    let step = 0.002 * size;
    rows(ui, "light", |ui| {
        vector_row(ui, "Centre [m]", "Where the middle of the light is", &mut light.centre, step);
        for (name, vector) in [("Width", &mut light.u), ("Height", &mut light.v)] {
            let length = DVec3::from_array(*vector).length();
            let mut side = 2.0 * length;
            let control = DragValue::new(&mut side).range(1e-6 * size..=10.0 * size).speed(step);
            let control = control.max_decimals(decimals_for(step)).suffix(" m");
            if row(ui, name, "Length of the light's side", control).changed() && length > 0.0 {
                *vector = (DVec3::from_array(*vector) * (0.5 * side / length)).to_array();
            }
        }
        direction_rows(ui, light);
        radiance_rows(ui, light);
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("Colour:");
        for (name, colour) in COLOURS {
            if ui.small_button(name).on_hover_text("Keeps the brightest band as bright as it is").clicked() {
                let peak = light.radiance.into_iter().fold(0.0, f32::max);
                light.radiance = colour.map(|band| band * peak);
            }
        }
    });
}

/// Heading and tilt of the direction it shines in; turning it turns the whole rectangle.
fn direction_rows(ui: &mut Ui, light: &mut AreaLightState) {
    let (u, v) = (DVec3::from_array(light.u), DVec3::from_array(light.v));
    let Some(normal) = u.cross(v).try_normalize() else { return };
    let before = [normal.z.atan2(normal.x).to_degrees(), normal.y.clamp(-1.0, 1.0).asin().to_degrees()];
    let [mut heading, mut tilt] = before;
    let angle = |value| DragValue::new(value).speed(0.5).suffix("°").max_decimals(1);
    let turned = row(ui, "Heading", "Direction it shines in, about the vertical", angle(&mut heading)).changed();
    let tilted =
        row(ui, "Tilt", "Direction it shines in: -90° is down", angle(&mut tilt).range(-90.0..=90.0)).changed();
    if turned || tilted {
        let turn = DQuat::from_rotation_y((before[0] - heading).to_radians());
        let axis = (turn * normal).cross(DVec3::Y).try_normalize();
        // Straight up or down there is no heading; it tips about a side of its own.
        let axis = axis.or_else(|| v.try_normalize()).unwrap_or(DVec3::X);
        let tip = DQuat::from_axis_angle(axis, (tilt - before[1]).to_radians());
        light.u = (tip * (turn * u)).to_array();
        light.v = (tip * (turn * v)).to_array();
    }
}

fn radiance_rows(ui: &mut Ui, light: &mut AreaLightState) {
    let peak = light.radiance.into_iter().fold(0.0, f32::max);
    let tint = light.radiance.map(|band| if peak > 0.0 { band / peak } else { 1.0 });
    let mut scale = peak;
    let control = Slider::new(&mut scale, 0.0..=10_000.0).logarithmic(true).smallest_positive(0.01);
    let tooltip = "Radiance of the brightest band [W/(m² sr)]";
    if row(ui, "Radiance", tooltip, control).changed() {
        light.radiance = tint.map(|band| band * scale);
    }
    let label = ui.label("Tint").on_hover_text("Colour of the light, linear RGB");
    let mut colour = tint;
    let button = ui.color_edit_button_rgb(&mut colour);
    if button.changed() {
        light.radiance = colour.map(|band| band * peak);
    }
    button.labelled_by(label.id);
    ui.end_row();
}
