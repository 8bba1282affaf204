//! The table of `radiosity screen-space`: what each setting errs by, and what it costs.

use serde::Serialize;

use super::screen_space::ScreenReport;
use crate::{
    check::picture_errors::{PictureErrors, PictureTruth},
    gpu::screen_space::{ScreenRenderer, ScreenSettings, ScreenView, SecondLayer, Weights},
};

/// One setting.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What differs from the settings that were asked for.
    pub name: String,
    /// Errors of the first frame.
    pub first: PictureErrors,
    /// Errors of the mean of all frames.
    pub mean: PictureErrors,
    /// Milliseconds of a frame after the camera moved, the median of several: the shadow maps are kept then.
    pub frame_ms: f64,
    /// Of these, the G-buffer's.
    pub g_buffer_ms: f64,
    /// Of these, direct light's.
    pub direct_ms: f64,
    /// Of these, the bounces'.
    pub gather_ms: f64,
    /// Of these, the filter's.
    pub filter_ms: f64,
    /// Milliseconds to draw the shadow maps, after a light moved.
    pub shadow_ms: f64,
}

/// The settings as they are, and with one thing changed each.
pub(super) fn variants(settings: &ScreenSettings) -> Vec<(String, ScreenSettings)> {
    let mut found: Vec<(String, ScreenSettings)> = vec![(String::from("as asked for"), settings.clone())];
    let mut add = |name: String, changed: ScreenSettings| {
        if changed != *settings {
            found.push((name, changed));
        }
    };
    let base = || settings.clone();
    for (name, second_layer) in [
        ("one layer", SecondLayer::Off),
        ("second layer peeled", SecondLayer::Peel),
        ("second layer by last frame", SecondLayer::LastFrame),
    ] {
        add(String::from(name), ScreenSettings { second_layer, ..base() });
    }
    add(String::from("the source's weights"), ScreenSettings { weights: Weights::Source, ..base() });
    let one_layer = SecondLayer::Off;
    let weights = Weights::Source;
    add(String::from("source's, one layer"), ScreenSettings { weights, second_layer: one_layer, ..base() });
    add(String::from("source's, no tail"), ScreenSettings { weights, no_tail: true, ..base() });
    add(String::from("no tail"), ScreenSettings { no_tail: true, ..base() });
    for unseen in [0.0, 0.5, 1.0] {
        add(format!("unseen {unseen}"), ScreenSettings { unseen, ..base() });
    }
    for taps in [11, 23, 37] {
        add(format!("{taps} taps"), ScreenSettings { taps, ..base() });
    }
    for bounces in [1, 2, 5] {
        add(format!("{bounces} bounces"), ScreenSettings { bounces, ..base() });
    }
    for radius in [0.25, 0.5, 1.0] {
        add(format!("radius {radius}"), ScreenSettings { radius, ..base() });
    }
    for filter in [0, 4, 8] {
        add(format!("filter {filter}"), ScreenSettings { filter, ..base() });
    }
    found
}

/// Frames that are timed.
const TIMED: usize = 5;

/// Judges and times one setting.
pub(super) fn measure(
    renderer: &mut ScreenRenderer,
    view: &ScreenView,
    (name, settings): (&str, &ScreenSettings),
    truth: &PictureTruth,
    frames: u32,
) -> Result<Row, String> {
    renderer.forget();
    let mut moved = view.clone();
    let mut times = Vec::new();
    let mut shadow_ms = 0.0;
    for number in 0..=TIMED {
        // By so little that nothing else is seen.
        moved.camera.position.x += 1e-5;
        let before = renderer.pass_times();
        renderer.draw(&moved, settings)?;
        let passes: Vec<f64> = renderer
            .pass_times()
            .iter()
            .zip(before)
            .map(|(now, before)| 1e3 * (now.seconds - before.seconds))
            .collect();
        if number == 0 {
            shadow_ms = passes[0];
        } else {
            times.push((1e3 * renderer.frame_time().as_secs_f64(), passes));
        }
    }
    times.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let (frame_ms, passes) = times.swap_remove(TIMED / 2);
    renderer.forget();
    let mut errors = [PictureErrors::default(); 2];
    for frame in 0..frames {
        renderer.draw(view, settings)?;
        if frame == 0 || frame + 1 == frames {
            let fields = renderer.fields()?;
            errors[usize::from(frame > 0)] = truth.errors(&fields.direct, &fields.total);
        }
    }
    let [first, mean] = if frames == 1 { [errors[0]; 2] } else { errors };
    Ok(Row {
        name: String::from(name),
        first,
        mean,
        frame_ms,
        g_buffer_ms: passes[1] + passes[2],
        direct_ms: passes[3],
        gather_ms: passes[4],
        filter_ms: passes[6],
        shadow_ms,
    })
}

/// Prints the table.
pub(super) fn print(report: &ScreenReport) {
    let [width, height] = report.size;
    println!("scene      {}, {width} × {height} pixels, {}", report.scene, report.device);
    println!(
        "errors     relative L2 over the pixels, in % of the mean light: first frame, and mean of {}",
        report.frames
    );
    println!("times      ms of a frame after the camera moved; shadow maps are drawn anew when a light moves");
    println!(
        "{:28} {:>7} {:>8} {:>7} {:>8} {:>7} | {:>6} {:>8} {:>6} {:>6} {:>6} {:>6}",
        "",
        "total",
        "indirect",
        "total",
        "indirect",
        "bias",
        "frame",
        "G-buffer",
        "direct",
        "gather",
        "filter",
        "shadow"
    );
    for row in &report.rows {
        println!(
            "{:28} {:7.2} {:8.2} {:7.2} {:8.2} {:+7.2} | {:6.1} {:8.1} {:6.1} {:6.1} {:6.1} {:6.1}",
            row.name,
            100.0 * row.first.total,
            100.0 * row.first.indirect,
            100.0 * row.mean.total,
            100.0 * row.mean.indirect,
            100.0 * row.mean.bias,
            row.frame_ms,
            row.g_buffer_ms,
            row.direct_ms,
            row.gather_ms,
            row.filter_ms,
            row.shadow_ms
        );
    }
}
