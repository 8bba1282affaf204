//! The window's lightmap, solved on the graphics card beside the ray tracer's solution.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use common::*;
use radiosity::app::{App, command::Command, view_settings::Source};

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
    // Alone first: both views show it, growing.
    run_until(&mut window, "light", |app| app.other.is_some());
    assert!(window.state().layout.second_view && window.state().layout.views[1].source == Source::Other);
    run_until(&mut window, "the end of the lightmap", |app| app.lightmap.job.is_none());
    assert!(window.state().lightmap.status.contains("texels"), "{}", window.state().lightmap.status);
    let alone = window.render().unwrap();
    solve(&mut window);
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
    {
        let app = window.state_mut();
        app.lightmap.map.texels = 20_000;
        app.lightmap.settings.unabsorbed = 1e-3;
        app.fulfil(Command::SolveLightmap);
    }
    run_until(&mut window, "light", |app| app.other.is_some());
    window.state().lightmap.job.as_ref().unwrap().stop();
    let asked = std::time::Instant::now();
    run_until(&mut window, "the end of the lightmap", |app| app.lightmap.job.is_none());
    assert!(asked.elapsed().as_secs_f32() < 5.0, "{:?}", asked.elapsed());
    assert!(window.state().other.is_some());
}
