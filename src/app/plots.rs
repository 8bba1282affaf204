//! Curves of convergence: power by bounce, and what is still unabsorbed by time.

use egui::{Color32, Ui};
use egui_plot::{Line, MarkerShape, Plot, PlotPoints, Points};

use super::results::Results;
use crate::{math::ratio_or_zero, solver::energy::BouncePower};

const BANDS: [(&str, Color32); 3] = [
    ("red", Color32::from_rgb(235, 90, 80)),
    ("green", Color32::from_rgb(90, 200, 100)),
    ("blue", Color32::from_rgb(100, 150, 250)),
];

/// Draws both plots beside each other.
pub(super) fn ui(ui: &mut Ui, results: Option<&Results>) {
    let height = ui.available_height();
    ui.set_min_height(height);
    ui.columns(2, |columns| {
        columns[0].label("Power arriving [% of the emitted] by bounce");
        power_plot(&mut columns[0], results, height - 22.0);
        columns[1].label("Unabsorbed power [%] by seconds");
        unabsorbed_plot(&mut columns[1], results, height - 22.0);
    });
}

fn plot<'a>(name: &'static str, height: f32) -> Plot<'a> {
    Plot::new(name).height(height.max(60.0)).include_y(0.0).allow_scroll(false).allow_drag(false).allow_zoom(false)
}

fn power_plot(ui: &mut Ui, results: Option<&Results>, height: f32) {
    plot("power", height).include_x(0.0).include_x(5.0).show(ui, |plot| {
        for (band, (name, colour)) in BANDS.into_iter().enumerate() {
            let powers = results.map_or(&[][..], |results| &results.powers);
            // What is emitted arrives as direct light, or escapes.
            let emitted = powers.first().map_or(0.0, |direct| direct.arriving[band] + direct.escaped[band]);
            let percent = |power: &BouncePower| 100.0 * ratio_or_zero(power.arriving[band], emitted);
            let points: Vec<[f64; 2]> =
                powers.iter().enumerate().map(|(bounce, power)| [bounce as f64, percent(power)]).collect();
            plot.line(Line::new(name, PlotPoints::from(points.clone())).color(colour));
            plot.points(Points::new(name, PlotPoints::from(points)).color(colour).radius(2.5));
        }
    });
}

fn unabsorbed_plot(ui: &mut Ui, results: Option<&Results>, height: f32) {
    plot("unabsorbed", height).include_x(0.0).include_y(100.0).show(ui, |plot| {
        let history = results.into_iter().flat_map(|results| results.history.iter());
        let points: Vec<[f64; 2]> = history.map(|[seconds, fraction]| [*seconds, 100.0 * fraction]).collect();
        let colour = Color32::from_rgb(240, 190, 80);
        plot.line(Line::new("unabsorbed", PlotPoints::from(points.clone())).color(colour));
        let dots = Points::new("unabsorbed", PlotPoints::from(points)).color(colour).radius(3.0);
        plot.points(dots.shape(MarkerShape::Circle));
    });
}
