//! Rows of a panel: a name, a control, a tooltip on both.

use egui::{DragValue, Response, Ui, Widget};

/// The help of a setting's flag, by its field: so that there is one source.
pub(super) fn flag_help<Settings: clap::Args>(field: &str) -> String {
    let command = Settings::augment_args(clap::Command::new("settings"));
    let argument = command.get_arguments().find(|argument| argument.get_id() == field);
    argument.and_then(clap::Arg::get_help).map(ToString::to_string).unwrap_or_default()
}

/// A row of a two-column grid. The control takes the name, for screen readers and tests.
pub(super) fn row(ui: &mut Ui, name: &str, tooltip: &str, control: impl Widget) -> Response {
    let label = ui.label(name).on_hover_text(tooltip);
    let response = ui.add(control).labelled_by(label.id).on_hover_text(tooltip);
    ui.end_row();
    response
}

/// A row with one of several named values.
pub(super) fn choice_row<Choice: clap::ValueEnum + PartialEq + Copy>(
    ui: &mut Ui,
    name: &str,
    tooltip: &str,
    chosen: &mut Choice,
) {
    let name_of =
        |choice: Choice| choice.to_possible_value().map_or_else(String::new, |value| String::from(value.get_name()));
    let label = ui.label(name).on_hover_text(tooltip);
    let shown = egui::ComboBox::from_id_salt(name).selected_text(name_of(*chosen)).show_ui(ui, |ui| {
        for known in Choice::value_variants() {
            let value = known.to_possible_value();
            let help = value.and_then(|value| value.get_help().map(ToString::to_string)).unwrap_or_default();
            ui.selectable_value(chosen, *known, name_of(*known)).on_hover_text(help);
        }
    });
    shown.response.labelled_by(label.id).on_hover_text(tooltip);
    ui.end_row();
}

/// A row of three numbers.
pub(super) fn vector_row(ui: &mut Ui, name: &str, tooltip: &str, values: &mut [f64; 3], speed: f64) {
    let label = ui.label(name).on_hover_text(tooltip);
    ui.horizontal(|ui| {
        for value in values {
            let digits = decimals_for(speed);
            ui.add(DragValue::new(value).speed(speed).max_decimals(digits))
                .labelled_by(label.id)
                .on_hover_text(tooltip);
        }
    });
    ui.end_row();
}

/// Decimals that show steps of this size.
pub(super) fn decimals_for(step: f64) -> usize {
    (1.0 - step.max(1e-9).log10()).ceil().clamp(0.0, 9.0) as usize
}

/// A row for the length that edges are bisected down to [m].
pub(super) fn longest_edge_row(ui: &mut Ui, tooltip: &str, max_edge: &mut Option<f64>) {
    let mut is_set = max_edge.is_some();
    optional_row(ui, "Longest edge", tooltip, &mut is_set, |ui, label| {
        let length = max_edge.get_or_insert(0.1);
        ui.add(DragValue::new(length).range(1e-4..=1e6).speed(0.005).suffix(" m")).labelled_by(label);
    });
    *max_edge = max_edge.or(is_set.then_some(0.1)).filter(|_| is_set);
}

/// A grid of rows.
pub(super) fn rows(ui: &mut Ui, name: &str, contents: impl FnOnce(&mut Ui)) {
    egui::Grid::new(name).num_columns(2).spacing([8.0, 5.0]).show(ui, contents);
}

/// A row for a value that may be left to the program: a box to tick, and the value if it is.
pub(super) fn optional_row(
    ui: &mut Ui,
    name: &str,
    tooltip: &str,
    is_set: &mut bool,
    control: impl FnOnce(&mut Ui, egui::Id),
) {
    let label = ui.label(name).on_hover_text(tooltip);
    ui.horizontal(|ui| {
        ui.checkbox(is_set, "").labelled_by(label.id).on_hover_text(tooltip);
        if *is_set {
            control(ui, label.id);
        } else {
            ui.weak("automatic");
        }
    });
    ui.end_row();
}
