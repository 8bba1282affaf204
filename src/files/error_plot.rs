//! Plots of error against seconds, as SVG and PNG.

use std::path::Path;

use anyhow::{Context as _, anyhow, bail};
use image::{DynamicImage, RgbImage};
use plotters::{
    coord::{Shift, combinators::WithKeyPoints},
    prelude::{
        BLACK, BindKeyPoints as _, BitMapBackend, ChartBuilder, Circle, Color as _, DrawingArea, DrawingBackend,
        IntoDrawingArea as _, IntoLogRange as _, LineSeries, LogCoord, Palette as _, Palette99, PathElement,
        SVGBackend, SeriesLabelPosition, WHITE,
    },
    style::{FontStyle, register_font},
};

use super::{write_atomically, write_picture};

/// A curve: pairs of seconds and error in percent, both above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// Its points, in the order in which they are joined.
    pub points: Vec<(f64, f64)>,
}

const SIZE: (u32, u32) = (960, 640);
const FONT: &str = "sans-serif";

/// An axis over more powers of ten has no marks between them.
const MOST_POWERS_IN_STEPS: usize = 4;

/// Writes `STEM.svg` and `STEM.png`; both axes are logarithmic.
///
/// # Errors
/// No curve has a point, or a file cannot be written.
pub fn write_error_plot(stem: &Path, title: &str, curves: &[Curve]) -> anyhow::Result<()> {
    // Once more is no error.
    register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .map_err(|_| anyhow!("the font of plots cannot be read"))?;
    let mut text = String::new();
    draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area(), title, curves)?;
    write_atomically(&stem.with_extension("svg"), |writer| Ok(writer.write_all(text.as_bytes())?))?;
    let mut pixels = vec![0; 3 * SIZE.0 as usize * SIZE.1 as usize];
    draw(&BitMapBackend::with_buffer(&mut pixels, SIZE).into_drawing_area(), title, curves)?;
    let picture = RgbImage::from_raw(SIZE.0, SIZE.1, pixels).context("the plot's pixels")?;
    write_picture(&stem.with_extension("png"), &DynamicImage::from(picture).into_rgba8())
}

fn draw<Backend: DrawingBackend>(
    area: &DrawingArea<Backend, Shift>,
    title: &str,
    curves: &[Curve],
) -> anyhow::Result<()> {
    let problem = |error: &dyn std::fmt::Display| anyhow!("the plot cannot be drawn: {error}");
    let all = || curves.iter().flat_map(|curve| &curve.points);
    if all().next().is_none() {
        bail!("there is nothing to plot");
    }
    area.fill(&WHITE).map_err(|error| problem(&error))?;
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 22))
        .margin(16)
        .x_label_area_size(44)
        .y_label_area_size(60)
        .build_cartesian_2d(axis(all().map(|(seconds, _)| *seconds)), axis(all().map(|(_, percent)| *percent)))
        .map_err(|error| problem(&error))?;
    let number = |value: &f64| format!("{value}");
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("seconds").y_desc("error [%]").max_light_lines(1).label_style((FONT, 15)).x_label_formatter(&number);
    mesh.y_label_formatter(&number).draw().map_err(|error| problem(&error))?;
    for (index, curve) in curves.iter().enumerate() {
        let color = Palette99::pick(index).to_rgba();
        let line = LineSeries::new(curve.points.iter().copied(), color.stroke_width(2));
        let drawn = chart.draw_series(line).map_err(|error| problem(&error))?;
        drawn.label(&*curve.name).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(2)));
        let marks = curve.points.iter().map(|point| Circle::new(*point, 3, color.filled()));
        chart.draw_series(marks).map_err(|error| problem(&error))?;
    }
    let mut labels = chart.configure_series_labels();
    // Where seconds and error are both large: no method that is worth plotting ends there.
    labels.position(SeriesLabelPosition::UpperRight).border_style(BLACK).background_style(WHITE).label_font((FONT, 15));
    labels.draw().map_err(|error| problem(&error))?;
    area.present().map_err(|error| problem(&error))
}

/// A logarithmic axis that holds the values, with some room around, and marks 1, 2 and 5 of each power of ten; of many
/// powers 1 alone.
fn axis(values: impl Iterator<Item = f64> + Clone) -> WithKeyPoints<LogCoord<f64>> {
    let (smallest, largest) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(0.0, f64::max));
    let range = 0.7 * smallest..1.4 * largest;
    let powers = range.start.log10().floor() as i32..=range.end.log10().floor() as i32;
    let steps = if powers.clone().count() > MOST_POWERS_IN_STEPS { &[1.0][..] } else { &[1.0, 2.0, 5.0] };
    let marks = powers.flat_map(|power| steps.iter().map(move |step| step * 10_f64.powi(power)));
    let marks: Vec<f64> = marks.filter(|mark| range.contains(mark)).collect();
    range.log_scale().with_key_points(marks)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    #[test]
    fn axes_have_marks_to_read_them_by_however_much_they_span() {
        let marks = |values: [f64; 2]| axis(values.into_iter()).bold_points().to_vec();
        assert_eq!(marks([16.0, 70.0]), [20.0, 50.0]);
        assert_eq!(marks([0.004, 0.02]), [0.005, 0.01, 0.02]);
        assert_eq!(marks([0.004, 200.0]), [0.01, 0.1, 1.0, 10.0, 100.0]);
    }

    #[test]
    fn a_plot_names_its_curves_and_puts_a_better_point_lower_and_a_slower_one_further_right() {
        let folder = tempfile::tempdir().unwrap();
        let stem = folder.path().join("plot");
        let curve = |name: &str, points: &[(f64, f64)]| Curve { name: name.into(), points: points.to_vec() };
        write_error_plot(&stem, "box", &[curve("fast", &[(0.01, 10.0), (1.0, 0.1)]), curve("slow", &[(0.1, 10.0)])])
            .unwrap();
        let text = std::fs::read_to_string(stem.with_extension("svg")).unwrap();
        assert!(["fast", "slow", "box", "seconds"].iter().all(|word| text.contains(word)), "{text}");
        let value = |line: &str, name: &str| {
            let after = line.split(&format!(" {name}=\"")).nth(1).unwrap();
            after.split('"').next().unwrap().parse::<f64>().unwrap()
        };
        let circles: Vec<_> = text.lines().filter(|line| line.starts_with("<circle")).collect();
        let places: Vec<_> = circles.iter().map(|line| (value(line, "cx"), value(line, "cy"))).collect();
        assert_eq!(places.len(), 3, "{text}");
        assert!(places[1].0 > places[2].0 && places[2].0 > places[0].0, "{places:?}");
        assert!(places[1].1 > places[0].1 && places[2].1 == places[0].1, "{places:?}");
        let picture = image::open(stem.with_extension("png")).unwrap().into_rgb8();
        assert!(picture.pixels().any(|pixel| pixel.0 != [255; 3]) && picture.dimensions() == SIZE);
        assert!(write_error_plot(&stem, "none", &[]).is_err());
    }
}
