//! The window's lightmap, solved on the graphics card beside the ray tracer's solution.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use common::*;
use egui_kittest::Harness;
use radiosity::{
    app::{App, command::Command, view_settings::Source},
    gpu::{device, lightmap::Stage},
    lightmap::{Ambient, PageUpdate},
};

/// Mean over the area of what two solutions hold, and of how far they are apart, over the mean of the first.
fn means(app: &App) -> (f32, f32) {
    let (present, other) = (app.results.as_ref().unwrap(), app.other.as_ref().unwrap());
    let areas = present.elements.tessellation.vertex_areas();
    let (mut sum, mut other_sum, mut apart) = (0.0, 0.0, 0.0);
    for ((a, b), area) in present.total.iter().zip(other.total.iter()).zip(areas) {
        sum += area * a.element_sum();
        other_sum += area * b.element_sum();
        apart += area * (*a - *b).abs().element_sum();
    }
    (other_sum / sum, apart / sum)
}

/// Begins a lightmap that takes its time, and waits for its first light.
fn begin_long_lightmap(window: &mut Harness<'_, App>) {
    let app = window.state_mut();
    app.lightmap.map.texels = 20_000;
    app.lightmap.settings.unabsorbed = 1e-3;
    app.fulfil(Command::SolveLightmap);
    run_until(window, "light", |app| app.lightmap.status.contains("unabsorbed"));
}

#[test]
fn the_lightmap_is_shown_beside_the_solution_and_agrees_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    {
        let app = window.state_mut();
        app.document.edit.settings.subdivide = 3;
        app.document.edit.settings.bounces = None;
        app.lightmap.map.texels = 3000;
        app.fulfil(Command::SolveLightmap);
    }
    // Alone first: the right view reads its pages, and nothing is read back before it rests.
    let wait_or_go_on = |window: &Harness<'_, App>| window.state().lightmap.job.as_ref().unwrap().toggle_pause();
    wait_or_go_on(&window);
    run_until(&mut window, "the map", |app| app.lightmap.shown.is_some());
    assert!(window.state().layout.second_view && window.state().layout.views[1].source == Source::Lightmap);
    let dark = window.render().unwrap();
    wait_or_go_on(&window);
    run_until(&mut window, "the end of the lightmap", rests);
    let lit = window.render().unwrap();
    let right = |x, y| [&dark, &lit].map(|picture| colour_at(picture, &window, x, y)[1]);
    let [before, after] = right(0.75, 0.75);
    assert!(after > before + 15.0, "{before} and {after}");
    assert!(window.state().lightmap.status.contains("texels"), "{}", window.state().lightmap.status);
    // The window's device has its clock, where it has one at all.
    let has_clock = device::headless().unwrap().0.features().contains(wgpu::Features::TIMESTAMP_QUERY);
    let times = window.state().lightmap.times.clone();
    assert_eq!(times.is_some(), has_clock);
    assert!(times.iter().flatten().all(|pass| pass.runs > 0 && pass.seconds > 0.0), "{times:?}");
    let alone = window.render().unwrap();
    solve(&mut window);
    // Both views show the same light.
    window.state_mut().layout.antialias = true;
    window.run_steps(2);
    let side_by_side = window.render().unwrap();
    for (x, y) in [(0.25, 0.3), (0.2, 0.75), (0.35, 0.8)] {
        let [left, right] = [x, x + 0.5].map(|x| colour_at(&side_by_side, &window, x, y));
        let apart = left.iter().zip(right).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 16.0, "{left:?} and {right:?} at {x}, {y}");
    }
    let app = window.state();
    assert!(errors(app).is_empty(), "{:?}", errors(app));
    let (ratio, apart) = means(app);
    assert!((ratio - 1.0).abs() < 0.06, "means differ by {:.1} %", 100.0 * (ratio - 1.0)); // 8 segments a wall by rays
    assert!(apart < 0.12, "{:.1} % apart", 100.0 * apart);
    let both = window.render().unwrap();
    assert!(alone.pixels().zip(both.pixels()).filter(|(a, b)| a != b).count() > 10_000);
}

#[test]
fn a_lightmap_stops_within_a_moment_and_keeps_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    // What arrived can only grow; what is guessed for the light that waits may be too much.
    window.state_mut().lightmap.settings.ambient = Ambient::Off;
    begin_long_lightmap(&mut window);
    assert!(window.state().other.is_none(), "read back while it runs");
    window.state().lightmap.job.as_ref().unwrap().stop();
    let asked = std::time::Instant::now();
    run_until(&mut window, "the end of the lightmap", rests);
    assert!(asked.elapsed().as_secs_f32() < 5.0, "{:?}", asked.elapsed());
    let stopped = shooters(window.state());
    // It goes on from there when it is told to, down to what is asked for then.
    window.state_mut().lightmap.settings.unabsorbed = 0.3;
    let before = mean_of(window.state());
    window.state().lightmap.job.as_ref().unwrap().go_on(0.02);
    run_until(&mut window, "more light", |app| rests(app) && shooters(app) > stopped);
    assert!(mean_of(window.state()) > before);
}

#[test]
fn a_lightmap_waits_shows_its_order_and_reads_its_shaders_again() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    begin_long_lightmap(&mut window);
    window.state().lightmap.job.as_ref().unwrap().toggle_pause();
    std::thread::sleep(std::time::Duration::from_millis(400));
    window.run_steps(2);
    let (waiting, version) = (window.state().lightmap.status.clone(), shown_version(window.state()));
    std::thread::sleep(std::time::Duration::from_millis(400));
    window.run_steps(2);
    assert_eq!((&waiting, version), (&window.state().lightmap.status, shown_version(window.state())));
    // Other pages while it waits.
    let light = window.render().unwrap();
    window.state_mut().lightmap.stage = Stage::Order;
    run_until(&mut window, "the order", |app| app.lightmap.filled == Stage::Order);
    let order = window.render().unwrap();
    let [before, after] = [&light, &order].map(|picture| colour_at(picture, &window, 0.75, 0.75));
    assert!(before.iter().zip(after).any(|(a, b)| (a - b).abs() > 20.0), "{before:?} and {after:?}");
    // The tests run in the source tree, so its shaders are found.
    press(&mut window, egui::Key::R);
    run_until(&mut window, "the shaders", |app| {
        app.notices.lines.iter().any(|line| line.text.contains("shaders are read anew"))
    });
    window.state().lightmap.job.as_ref().unwrap().toggle_pause();
    let paused_at = shown_version(window.state());
    run_until(&mut window, "more", |app| shown_version(app) > paused_at + 1);
    assert!(errors(window.state()).is_empty(), "{:?}", errors(window.state()));
}

#[test]
fn updates_by_batches_show_whole_batches_and_end_with_the_same_light() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    const BATCH: u32 = 32;
    let mut solved = |update| {
        let app = window.state_mut();
        app.lightmap.map.texels = 20_000;
        let settings = &mut app.lightmap.settings;
        (settings.update, settings.batch, settings.unabsorbed) = (update, BATCH, 0.1);
        settings.light_side = 8; // two batches
        app.other = None;
        app.lightmap.status.clear();
        app.fulfil(Command::SolveLightmap);
        let mut shown = Vec::new();
        run_until(&mut window, "light", |app| app.lightmap.status.contains("% unabsorbed"));
        while !rests(window.state()) {
            window.run_steps(1);
            shown.push(shooters(window.state()));
        }
        (shown, window.state().other.as_ref().unwrap().total.clone())
    };
    let (by_batch, light) = solved(PageUpdate::Batch);
    let (any, same_light) = solved(PageUpdate::Continuous);
    let is_whole = |count: &u64| count.is_multiple_of(u64::from(BATCH));
    assert!(by_batch.iter().all(is_whole), "{by_batch:?}");
    assert!(!any.iter().all(is_whole), "{any:?}");
    assert_eq!(light, same_light);
}

#[test]
fn form_factors_show_their_field_after_every_sweep_and_end_near_the_ray_tracers() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    {
        let app = window.state_mut();
        let settings = &mut app.document.edit.settings;
        (settings.subdivide, settings.bounces, settings.adaptive) = (2, None, 0.0);
        let factors = &mut app.lightmap.factors.settings;
        (factors.subdivide, factors.resolution, factors.sweeps) = (2, 64, 12);
    }
    solve(&mut window);
    // Stopped on its way it keeps nothing, and does not come back.
    window.state_mut().fulfil(Command::FormFactors);
    window.state_mut().fulfil(Command::FormFactors);
    assert!(window.state().lightmap.factors.job.is_none() && window.state().other.is_none());
    window.state_mut().fulfil(Command::FormFactors);
    assert_eq!(window.state().layout.views[1].source, Source::Other);
    let mut shown: Vec<(String, f32)> = Vec::new();
    run_until(&mut window, "the sweeps", |app| {
        let line = app.lightmap.factors.status.split(';').next().unwrap();
        if app.other.is_some() && shown.last().is_none_or(|(last, _)| last != line) {
            shown.push((String::from(line), mean_of(app)));
        }
        app.lightmap.factors.job.is_none()
    });
    // The mean rises from sweep to sweep, each by less than the one before.
    let steps: Vec<f32> = shown.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
    assert!(shown.len() >= 6 && shown[0].0.starts_with("sweep 1,"), "{shown:?}");
    assert!(steps[..4].windows(2).all(|pair| pair[1] < pair[0] && pair[1] > 0.0), "{shown:?}");
    assert!(window.state().lightmap.factors.status.contains("row sums"));
    let (ratio, _) = means(window.state());
    assert!((ratio - 1.0).abs() < 0.1, "means differ by {:.1} %", 100.0 * (ratio - 1.0)); // 4 segments a wall
    assert!(errors(window.state()).is_empty(), "{:?}", errors(window.state()));
}

fn rests(app: &App) -> bool {
    app.lightmap.job.as_ref().is_none_or(|job| job.rests()) && app.other.is_some()
}

fn shown_version(app: &App) -> u64 {
    app.lightmap.job.as_ref().unwrap().version()
}

/// Of the last field that was read back.
fn mean_of(app: &App) -> f32 {
    let other = app.other.as_ref().unwrap();
    other.total.iter().map(|value| value.element_sum()).sum::<f32>() / other.total.len() as f32
}

/// As the line of a lightmap at rest says.
fn shooters(app: &App) -> u64 {
    let words: Vec<&str> = app.lightmap.status.split(' ').collect();
    let place = words.iter().position(|word| word.starts_with("shooters")).unwrap();
    words[place - 1].parse().unwrap()
}
