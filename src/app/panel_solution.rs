//! The panel of the solution: save, load, export, compare; and the log.

use egui::{RichText, Ui};

use super::{
    command::Command,
    controls::rows,
    file_dialog::Purpose,
    notices::Notices,
    results::{Results, TruthView},
};
use crate::check::metrics::FieldErrors;

/// Draws the panel.
pub fn ui(ui: &mut Ui, results: Option<&Results>, other: Option<&Results>) -> Option<Command> {
    let mut command = None;
    let solved = results.is_some_and(|results| results.solution.is_some());
    match results {
        None => drop(ui.weak("Nothing is solved yet: press ENTER.")),
        Some(results) => summary_ui(ui, results),
    }
    let mut button = |ui: &mut Ui, enabled: bool, name: &str, tooltip: &str, wish: Command| {
        if ui.add_enabled(enabled, egui::Button::new(name)).on_hover_text(tooltip).clicked() {
            command = Some(wish);
        }
    };
    ui.horizontal_wrapped(|ui| {
        button(ui, solved, "Save…", "All bounces, as a .safetensors file", Command::Ask(Purpose::SaveSolution));
        button(ui, true, "Load…", "A solution of this scene", Command::Ask(Purpose::LoadSolution));
        let tooltip = "O: a mesh with vertex colours (PLY), or a table (CSV)";
        button(ui, solved, "Export mesh…", tooltip, Command::Ask(Purpose::SaveMesh));
    });
    ui.horizontal_wrapped(|ui| {
        let tooltip = "Keeps this solution, to be compared with the next one in the second view";
        button(ui, solved, "Keep to compare", tooltip, Command::KeepForComparison);
        let tooltip = "A solution of this scene, for the second view";
        button(ui, true, "Compare with…", tooltip, Command::Ask(Purpose::LoadOther));
        let tooltip = "True values at points (CSV), as `radiosity truth` writes them";
        button(ui, solved, "Compare with a truth…", tooltip, Command::Ask(Purpose::LoadTruth));
    });
    ui.horizontal_wrapped(|ui| {
        let tooltip = "Camera, light, settings and tone map, as a state file; ALT + number is quicker";
        button(ui, true, "Save state…", tooltip, Command::Ask(Purpose::SaveState));
        button(ui, true, "Load state…", "A number alone is quicker", Command::Ask(Purpose::LoadState));
        button(ui, true, "Screenshot", "F12: a picture of the window to screenshots/", Command::Screenshot);
    });
    if let Some(truth) = results.and_then(|results| results.truth.as_ref()) {
        truth_ui(ui, truth);
    }
    if let (Some(results), Some(other)) = (results, other) {
        compare_ui(ui, results, other);
    }
    command
}

fn summary_ui(ui: &mut Ui, results: &Results) {
    rows(ui, "solution", |ui| {
        let mut line = |name: &str, value: String| {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        };
        line("Vertices", results.total.len().to_string());
        line("Bounces", results.bounces.len().to_string());
        if let Some(report) = &results.report {
            let rays = report.gather_rays + report.shadow_rays;
            line("Seconds", format!("{:.2}", report.seconds));
            line("Rays", format!("{:.1} million", rays as f64 * 1e-6));
            line("Unabsorbed", format!("{:.3} %", 100.0 * report.unabsorbed));
            line("Buried", format!("{} vertices", report.buried_vertices));
            if let Some(error) = results.relative_sampling_error {
                line("Sampling error", format!("{:.2} % at a vertex", 100.0 * error));
            }
            let emitted = report.energy.emitted.element_sum().max(1e-30);
            let absorbed: f64 = report.energy.bounces.iter().map(|bounce| bounce.absorbed.element_sum()).sum();
            line("Absorbed", format!("{:.2} % of {emitted:.3} W", 100.0 * absorbed / emitted));
            line("Ended", report.ended_by.to_string());
        }
    });
    if let Some(report) = &results.report {
        egui::CollapsingHeader::new("Skipped").show(ui, |ui| {
            for line in report.skipped() {
                ui.label(line);
            }
        });
    }
}

/// The errors against a truth.
fn truth_ui(ui: &mut Ui, truth: &TruthView) {
    ui.separator();
    let FieldErrors { all, lit } = truth.comparison.errors;
    ui.label(format!("Against {}: field error", truth.name)).on_hover_text(
        "Root mean square difference over the points, by the mean of the truth. Lit: without points that are unlit, \
         buried or beside an emitter. View “truth error” shows where it lies",
    );
    let percent = |fraction: f64| format!("{:.2} %", 100.0 * fraction);
    egui::Grid::new("truth").num_columns(5).striped(true).show(ui, |ui| {
        for head in ["", "total", "direct", "indirect", "bias"] {
            ui.label(head);
        }
        ui.end_row();
        for (name, part) in [("all", all), ("lit", lit)] {
            ui.label(format!("{name} ({})", part.point_count));
            for value in [part.total.relative_l2, part.direct.relative_l2, part.indirect.relative_l2, part.total.bias] {
                ui.label(percent(value));
            }
            ui.end_row();
        }
    });
    if truth.comparison.off_surface > 0 {
        ui.label(format!("{} points lie on no surface and were left out", truth.comparison.off_surface));
    }
}

/// How far two solutions are apart, over their vertices.
fn compare_ui(ui: &mut Ui, results: &Results, other: &Results) {
    ui.separator();
    let there = results.elements.resampled(&other.total, &other.elements);
    let areas = results.elements.tessellation.vertex_areas();
    let (mut squares, mut sum, mut area) = (0.0_f64, 0.0_f64, 0.0_f64);
    for ((a, b), weight) in results.total.iter().zip(there.iter()).zip(areas) {
        squares += f64::from(weight) * f64::from((*a - *b).length_squared()) / 3.0;
        sum += f64::from(weight) * f64::from(b.element_sum()) / 3.0;
        area += f64::from(weight);
    }
    let relative = if sum > 0.0 { (squares / area).sqrt() / (sum / area) } else { 0.0 };
    ui.label(format!(
        "From the other solution: {:.3} % (root mean square over the area, by its mean)",
        100.0 * relative
    ));
}

/// Draws the log.
pub fn log_ui(ui: &mut Ui, notices: &Notices) {
    if notices.lines.is_empty() {
        ui.weak("Nothing to report.");
    }
    for line in notices.lines.iter().rev() {
        ui.label(RichText::new(&line.text).color(line.level.colour()).small());
    }
}
