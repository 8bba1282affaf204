//! Curves of convergence: power by bounce, and what is still unabsorbed by time.

use egui::{Color32, Ui};
use egui_plot::{Line, MarkerShape, Plot, PlotPoints, Points};

use super::results::Results;
use crate::math::ratio_or_zero;

const BANDS: [(&str, Color32); 3] = [
    ("red", Color32::from_rgb(235, 90, 80)),
    ("green", Color32::from_rgb(90, 200, 100)),
    ("blue", Color32::from_rgb(100, 150, 250)),
];

/// The curves as a table (CSV): a line for each complete bounce.
pub(super) fn table(results: &Results) -> String {
    let mut text = String::from(
        "bounce,seconds,arriving_r,arriving_g,arriving_b,unabsorbed,missing,sampling_error,estimated_error\n",
    );
    let sampling = results.relative_sampling_error.map_or_else(String::new, |error| error.to_string());
    // The history begins before bounce 0.
    let rows = results.powers.iter().zip(results.history.iter().skip(1)).zip(&results.missing);
    for (bounce, ((power, [seconds, unabsorbed]), [_, missing])) in rows.enumerate() {
        let [red, green, blue] = power.arriving.to_array();
        let error = results.relative_sampling_error.map_or_else(String::new, |error| missing.hypot(error).to_string());
        text += &format!("{bounce},{seconds},{red},{green},{blue},{unabsorbed},{missing},{sampling},{error}\n");
    }
    text
}

/// Draws both plots beside each other. True if they are to be saved.
pub(super) fn ui(ui: &mut Ui, results: Option<&Results>) -> bool {
    let mut saves = false;
    ui.set_min_height(ui.available_height());
    ui.columns(2, |columns| {
        // Relighting tells all reflected light as one.
        let relit = results.is_some_and(|results| results.relit);
        let by = if relit { ": direct, all reflected" } else { " by bounce" };
        columns[0].label(format!("Power arriving [% of the emitted]{by}"));
        power_plot(&mut columns[0], results);
        columns[1].horizontal(|ui| {
            ui.label("Estimated error [%] by seconds").on_hover_text(
                "Yellow: emitted power that is still unabsorbed. White: estimate of the error relative to the mean \
                 irradiance: what later bounces would add, and the error of sampling once it is known (dashed).",
            );
            let text = "Saves the curves as a table (CSV) or a picture (PNG)";
            saves = ui.add_enabled(results.is_some(), egui::Button::new("Save…").small()).on_hover_text(text).clicked();
        });
        if relit {
            columns[1].weak("Relit on the rays of the solve: its curve is told by ENTER, which solves anew.");
        } else {
            error_plot(&mut columns[1], results);
        }
    });
    saves
}

/// A plot that fills what is left of its column.
fn plot<'a>(ui: &Ui, name: &'static str) -> Plot<'a> {
    let height = ui.available_height() - 4.0;
    Plot::new(name)
        .show_background(false)
        // Fewer faint lines than egui's own 8 points apart, which a software driver feels.
        .grid_spacing(egui::Rangef::new(20.0, 300.0))
        .height(height.max(60.0))
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
}

/// A line through dots. It is drawn piece by piece: joined, egui makes wedges of pieces shorter than the line is wide.
fn curve(plot: &mut egui_plot::PlotUi<'_>, name: &'static str, colour: Color32, points: Vec<[f64; 2]>) {
    for piece in points.windows(2) {
        plot.line(Line::new(name, PlotPoints::from(piece.to_vec())).color(colour));
    }
    plot.points(Points::new(name, PlotPoints::from(points)).color(colour).radius(2.5).shape(MarkerShape::Circle));
}

fn power_plot(ui: &mut Ui, results: Option<&Results>) {
    plot(ui, "power").include_y(0.0).include_x(0.0).include_x(5.0).show(ui, |plot| {
        for (band, (name, colour)) in BANDS.into_iter().enumerate() {
            let powers = results.map_or(&[][..], |results| &results.powers);
            // What is emitted arrives as direct light, or escapes.
            let emitted = powers.first().map_or(0.0, |direct| direct.arriving[band] + direct.escaped[band]);
            let percent = |power: f64| 100.0 * ratio_or_zero(power, emitted);
            let mut arriving: Vec<f64> = powers.iter().map(|power| power.arriving[band]).collect();
            if results.is_some_and(|results| results.relit) && arriving.len() > 1 {
                // The ledger tells the last gather apart from the sweeps before it.
                arriving = vec![arriving[0], arriving[1..].iter().sum()];
            }
            let points = arriving.into_iter().enumerate().map(|(bounce, power)| [bounce as f64, percent(power)]);
            curve(plot, name, colour, points.collect());
        }
    });
}

/// On a logarithmic scale, down to a thousandth of a percent.
fn error_plot(ui: &mut Ui, results: Option<&Results>) {
    let logarithm = |fraction: f64| (100.0 * fraction).max(1e-3).log10();
    let points = |values: Vec<[f64; 2]>| -> Vec<[f64; 2]> {
        values.into_iter().map(|[seconds, fraction]| [seconds, logarithm(fraction)]).collect()
    };
    // As many decades apart that their labels find room.
    let plot = plot(ui, "errors").include_x(0.0).include_y(2.0);
    let plot = plot.y_axis_formatter(|mark, _| format!("{}", 10_f64.powf(mark.value)));
    let plot = plot.y_grid_spacer(egui_plot::uniform_grid_spacer(|_| [1.0, 2.0, 4.0]));
    plot.show(ui, |plot| {
        let Some(results) = results else { return };
        let curves = [
            ("unabsorbed", Color32::from_rgb(240, 190, 80), points(results.history.clone())),
            ("estimated error", Color32::WHITE, points(results.estimated_errors().collect())),
        ];
        for (name, colour, points) in curves {
            curve(plot, name, colour, points);
        }
        if let Some(sampling) = results.relative_sampling_error.filter(|error| *error > 0.0) {
            let line = egui_plot::HLine::new("sampling error", logarithm(sampling)).color(Color32::GRAY);
            plot.hline(line.style(egui_plot::LineStyle::dashed_loose()));
        }
    });
}
