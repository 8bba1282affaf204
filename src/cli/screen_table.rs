//! The table of `radiosity screen-space`: what each setting errs by, and what it costs.

use std::sync::Arc;

use serde::Serialize;

use super::screen_space::ScreenReport;
use crate::{
    check::picture_errors::{PictureErrors, PictureTruth},
    gpu::screen_space::{Pass, ScreenRenderer, ScreenSettings, ScreenView, SecondLayer, Weights},
};

/// One setting.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What differs from the settings that were asked for.
    pub name: String,
    /// Errors of the first frame.
    pub first: PictureErrors,
    /// Errors of a frame that follows one from beside it.
    pub moving: PictureErrors,
    /// Errors of the mean of all frames.
    pub mean: PictureErrors,
    /// Milliseconds of a frame after the camera moved, the median of several: the shadow maps are kept then.
    pub frame_ms: f64,
    /// Milliseconds of a frame after camera and light moved, the median of several.
    pub light_moved_ms: f64,
    /// Milliseconds of a still frame, the median: lamps move about, so that shadow maps are drawn anew.
    pub rest_ms: f64,
    /// Of these, the G-buffer's.
    pub g_buffer_ms: f64,
    /// Of these, direct light's.
    pub direct_ms: f64,
    /// Of these, the bounces'.
    pub gather_ms: f64,
    /// Of these, the filter's.
    pub filter_ms: f64,
    /// Milliseconds to draw the shadow maps, of the frame after camera and light moved.
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
    for unseen in [0.0, 0.25, 0.5] {
        add(format!("unseen {unseen}"), ScreenSettings { unseen, ..base() });
    }
    for taps in [11, 23, 37] {
        add(format!("{taps} taps"), ScreenSettings { taps, ..base() });
    }
    for bounces in [1, 2, 5] {
        add(format!("{bounces} bounces"), ScreenSettings { bounces, ..base() });
    }
    for radius in [0.25, 0.5, 0.7, 1.0] {
        add(format!("radius {radius}"), ScreenSettings { radius, ..base() });
    }
    for surround in [1.0, 2.0, 3.0] {
        let name =
            if surround > 1.0 { format!("{surround} times as wide around") } else { String::from("nothing around") };
        add(name, ScreenSettings { surround, ..base() });
    }
    for filter in [0, 4, 8] {
        add(format!("filter {filter}"), ScreenSettings { filter, ..base() });
    }
    for every in [1, 2, 3] {
        add(format!("every {every} pixels"), ScreenSettings { every, ..base() });
    }
    add(String::from("with obscurance"), ScreenSettings { obscurance: 16, ..base() });
    found
}

/// Frames that are timed.
const TIMED: usize = 5;
/// How far beside it, in local units, the camera was before the frame that is judged while it moves.
const BESIDE: f32 = 0.02;

/// What a frame took, and each pass of it [ms].
struct FrameTime {
    all: f64,
    passes: Vec<f64>,
}

impl FrameTime {
    /// What a pass took [ms].
    fn of(&self, pass: Pass) -> f64 {
        self.passes[pass as usize]
    }
}

/// Draws frames and takes the median; `change` makes each view out of the one before.
fn timed(
    renderer: &mut ScreenRenderer,
    view: &ScreenView,
    settings: &ScreenSettings,
    change: impl Fn(&mut ScreenView),
) -> Result<FrameTime, String> {
    let mut view = view.clone();
    let mut times = Vec::new();
    for number in 0..=TIMED {
        change(&mut view);
        let before = renderer.pass_times();
        renderer.draw(&view, settings)?;
        let after = renderer.pass_times();
        let passes = after.iter().zip(before).map(|(now, before)| 1e3 * (now.seconds - before.seconds)).collect();
        // The first one makes what the others have.
        if number > 0 {
            times.push(FrameTime { all: 1e3 * renderer.frame_time().as_secs_f64(), passes });
        }
    }
    times.sort_by(|a, b| a.all.total_cmp(&b.all));
    Ok(times.swap_remove(TIMED / 2))
}

/// Judges and times one setting.
pub(super) fn measure(
    renderer: &mut ScreenRenderer,
    view: &ScreenView,
    (name, settings): (&str, &ScreenSettings),
    truth: &PictureTruth,
    frames: u32,
) -> Result<Row, String> {
    renderer.forget();
    // By so little that nothing else is seen.
    let camera_moves = |view: &mut ScreenView| view.camera.position.x += 1e-5;
    let time = timed(renderer, view, settings, camera_moves)?;
    let with_light = timed(renderer, view, settings, |view| {
        camera_moves(view);
        // Other materials may be other lights.
        view.materials = Arc::new(Vec::clone(&view.materials));
    })?;
    let errors =
        |renderer: &ScreenRenderer| renderer.fields().map(|fields| truth.errors(&fields.direct, &fields.total));
    renderer.forget();
    let mut beside = view.clone();
    beside.camera.position += BESIDE * view.camera.right;
    renderer.draw(&beside, settings)?;
    renderer.draw(view, settings)?;
    let moving = errors(renderer)?;
    renderer.forget();
    let mut rest = Vec::new();
    let mut first = PictureErrors::default();
    for frame in 0..frames {
        renderer.draw(view, settings)?;
        if frame == 0 {
            first = errors(renderer)?;
        } else {
            rest.push(1e3 * renderer.frame_time().as_secs_f64());
        }
    }
    rest.sort_by(f64::total_cmp);
    Ok(Row {
        name: String::from(name),
        first,
        moving,
        mean: errors(renderer)?,
        frame_ms: time.all,
        light_moved_ms: with_light.all,
        rest_ms: rest.get(rest.len() / 2).copied().unwrap_or_default(),
        g_buffer_ms: time.of(Pass::FirstLayer) + time.of(Pass::SecondLayer) + time.of(Pass::Around),
        direct_ms: time.of(Pass::Light),
        gather_ms: time.of(Pass::Gather),
        filter_ms: time.of(Pass::Filter),
        shadow_ms: with_light.of(Pass::Shadows),
    })
}

/// Prints the table.
pub(super) fn print(report: &ScreenReport) {
    let [width, height] = report.size;
    println!("scene      {}, {width} × {height} pixels, {}", report.scene, report.device);
    println!(
        "errors     relative L2 over the pixels, in % of the mean light: total and indirect of the first frame, total of one"
    );
    println!(
        "           that follows one from beside it, total, indirect and bias of the mean of {} still frames",
        report.frames
    );
    println!(
        "times      ms of a frame after the camera moved, after the light did, too, and at rest; then parts of the first,"
    );
    println!("           and shadow maps, of the second");
    println!(
        "{:28} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} | {:>6} {:>6} {:>6} {:>8} {:>6} {:>6} {:>6} {:>6}",
        "",
        "first",
        "indir.",
        "moving",
        "mean",
        "indir.",
        "bias",
        "camera",
        "light",
        "rest",
        "G-buffer",
        "direct",
        "gather",
        "filter",
        "shadow"
    );
    for row in &report.rows {
        println!(
            "{:28} {:6.2} {:6.2} {:6.2} {:6.2} {:6.2} {:+6.2} | {:6.1} {:6.1} {:6.1} {:8.1} {:6.1} {:6.1} {:6.1} {:6.1}",
            row.name,
            100.0 * row.first.total,
            100.0 * row.first.indirect,
            100.0 * row.moving.total,
            100.0 * row.mean.total,
            100.0 * row.mean.indirect,
            100.0 * row.mean.bias,
            row.frame_ms,
            row.light_moved_ms,
            row.rest_ms,
            row.g_buffer_ms,
            row.direct_ms,
            row.gather_ms,
            row.filter_ms,
            row.shadow_ms
        );
    }
}
