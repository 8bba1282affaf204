//! Pictures of the window with vertices on the left and the lightmap on the right, at several moments. They are left in
//! Cargo's folder for temporary files of tests.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use std::{
    path::Path,
    time::{Duration, Instant},
};

use common::*;
use egui_kittest::{Harness, kittest::Queryable as _};
use radiosity::{
    app::{App, command::Command, fly_camera::FlyCamera, panes::Pane},
    gpu::lightmap::Stage,
    lightmap::Visibility,
    scene::{area_light::AreaLightState, camera::CameraState},
};

/// A minute is too little for a large scene on a software driver.
fn wait_for(window: &mut Harness<'_, App>, is_done: impl Fn(&App) -> bool) {
    let started = Instant::now();
    while !is_done(window.state()) && started.elapsed() < Duration::from_secs(1500) {
        std::thread::sleep(Duration::from_millis(20));
        window.run_steps(1);
    }
    window.run_steps(2);
}

/// Solves at the vertices, then on the map, and takes pictures once so much of the light is unabsorbed.
fn take_pictures(name: &str, window: &mut Harness<'_, App>, moments: &[f32]) {
    window.state_mut().layout.plots = false;
    solve_slowly(window);
    for (number, moment) in moments.iter().enumerate() {
        window.state_mut().lightmap.settings.unabsorbed = *moment;
        match &window.state().lightmap.job {
            Some(job) => {
                job.go_on(*moment);
                std::thread::sleep(Duration::from_millis(100));
            }
            None => window.state_mut().fulfil(Command::SolveLightmap),
        }
        wait_for(window, |app| app.lightmap.job.as_ref().is_none_or(|job| job.rests()));
        println!("{name} {number}: {}", window.state().lightmap.status);
        window.run_steps(100); // large meshes are drawn in parts, one a frame
        let picture = window.render().unwrap();
        picture.save(Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{number}.png"))).unwrap();
    }
    assert!(errors(window.state()).is_empty(), "{:?}", errors(window.state()));
}

fn solve_slowly(window: &mut Harness<'_, App>) {
    press(window, egui::Key::Enter);
    wait_for(window, |app| is_solved(app) && !app.status().running);
}

const LARGE: [f32; 2] = [1500.0, 640.0];
/// All of the panel is seen.
const TALL: [f32; 2] = [1400.0, 1800.0];

#[test]
#[ignore = "pictures, not a test: cargo test --test app_lightmap_pictures -- --ignored --nocapture cornell"]
fn pictures_of_the_cornell_box() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window_of(Path::new("cornell"), folder.path(), LARGE, 1.0);
    let settings = &mut window.state_mut().document.edit.settings;
    (settings.rays, settings.subdivide, settings.bounces) = (256, 4, None);
    window.state_mut().lightmap.map.texels_per_metre = Some(57.6);
    take_pictures("cornell", &mut window, &[0.5, 0.1, 0.005]);
}

#[test]
#[ignore = "pictures, not a test: cargo test --test app_lightmap_pictures -- --ignored --nocapture atrium"]
fn pictures_of_the_atrium() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window_of(Path::new("scenes/atrium/atrium.obj"), folder.path(), LARGE, 1.0);
    let settings = &mut window.state_mut().document.edit.settings;
    (settings.rays, settings.subdivide, settings.adaptive, settings.bounces) = (256, 0, 0.0, None);
    window.state_mut().lightmap.map.texels = 100_000;
    take_pictures("atrium", &mut window, &[0.5, 0.05, 0.005]);
}

#[test]
#[ignore = "pictures, not a test: cargo test --test app_lightmap_pictures -- --ignored --nocapture sponza"]
fn pictures_of_sponza() {
    let shared = std::env::var_os("RADIOSITY_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), std::path::PathBuf::from);
    let path = shared.join("scenes/sponza/sponza.obj");
    if !path.exists() {
        println!("skipped: no {}", path.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut window = window_of(&path, folder.path(), LARGE, 1.0);
    {
        let app = window.state_mut();
        app.document.edit.light = Some(AreaLightState {
            centre: [0.0, 20.0, 0.0],
            u: [5.0, 0.0, 0.0],
            v: [0.0, 0.0, 1.5],
            radiance: [150.0, 140.0, 125.0],
        });
        let camera = CameraState {
            position: [-11.0, 4.0, 0.5],
            target: [5.0, 5.0, -1.0],
            fov_degrees: 70.0,
            ..CameraState::default()
        };
        app.camera = FlyCamera::new(&camera, &app.elements().scene.clone());
        let settings = &mut app.document.edit.settings;
        (settings.rays, settings.subdivide, settings.adaptive, settings.bounces) = (256, 0, 0.0, None);
        app.lightmap.map.texels = 60_000;
        app.document.edit.tone_map.exposure = -3.0;
    }
    take_pictures("sponza", &mut window, &[0.5, 0.2, 0.05]);
}

#[test]
#[ignore = "pictures, not a test: cargo test --test app_lightmap_pictures -- --ignored --nocapture panel"]
fn pictures_of_the_panel() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window_of(Path::new("cornell"), folder.path(), TALL, 1.0);
    {
        let app = window.state_mut();
        (app.layout.plots, app.layout.to_front) = (false, Some(Pane::Lightmap));
        app.lightmap.settings.visibility = Visibility::Hemisphere;
        app.lightmap.settings.hemicube = 128;
        app.lightmap.map.texels = 5000;
        app.fulfil(Command::SolveLightmap);
    }
    wait_for(&mut window, |app| app.lightmap.job.as_ref().is_none_or(|job| job.rests()));
    let save = |window: &mut Harness<'_, App>, name: &str| {
        window.run_steps(3);
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("panel-{name}.png"));
        window.render().unwrap().save(path).unwrap();
    };
    for name in ["Items", "Hemicubes"] {
        window.get_by_label(name).click();
        save(&mut window, name);
    }
    window.get_by_label("Map").click();
    for stage in Stage::ALL {
        window.state_mut().lightmap.stage = stage;
        wait_for(&mut window, |app| app.lightmap.filled == stage);
        save(&mut window, stage.name().0);
    }
    window.state_mut().lightmap.factors.settings.subdivide = 2;
    window.get_by_label("Form factors").click();
    window.state_mut().fulfil(Command::FormFactors);
    wait_for(&mut window, |app| app.lightmap.factors.job.is_none());
    save(&mut window, "factors");
}
