//! The window, without a screen: its panels, keys and pictures, drawn by real wgpu (a software driver will do).
#![cfg(feature = "app")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use egui::{Event, Key, Modifiers};
use egui_kittest::{Harness, kittest::Queryable as _};
use glam::DVec3;
use image::RgbaImage;
use radiosity::{
    app::{App, command::Command, loader, notices::Level, view_settings::Shown},
    files::loaded_scene::{self, LoadedScene},
    gpu::device,
};

const SIZE: [f32; 2] = [1000.0, 640.0];

/// The window with a small Cornell box, or nothing where no graphics driver is installed.
fn window(folder: &Path) -> Option<Harness<'static, App>> {
    if let Err(reason) = device::headless() {
        println!("skipped: {reason}");
        return None;
    }
    let (mut state, warnings) = loaded_scene::read_state(Path::new("cornell"), None).unwrap();
    let settings = state.settings.as_mut().unwrap();
    (settings.rays, settings.light_rays, settings.subdivide, settings.bounces) = (32, 8, 2, Some(3));
    let options = state.load.clone().unwrap_or_default();
    let loaded = LoadedScene::load(Path::new("cornell"), state, options).unwrap();
    let opened = loader::prepare(loaded, warnings).unwrap();
    let folder = folder.to_path_buf();
    let mut harness =
        Harness::builder().with_size(SIZE).wgpu().build_eframe(|creation| App::new(creation, opened, &folder));
    harness.run_steps(4);
    Some(harness)
}

fn press(window: &mut Harness<'_, App>, key: Key) {
    window.key_press(key);
    window.run_steps(2);
}

fn press_with(window: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(2);
}

fn run_until(window: &mut Harness<'_, App>, what: &str, is_done: impl Fn(&App) -> bool) {
    let started = Instant::now();
    while !is_done(window.state()) {
        assert!(started.elapsed() < Duration::from_secs(60), "waited a minute for: {what}");
        std::thread::sleep(Duration::from_millis(5));
        window.run_steps(1);
    }
    window.run_steps(1);
}

fn solve(window: &mut Harness<'_, App>) {
    press(window, Key::Enter);
    run_until(window, "the end of the solve", |app| is_solved(app) && !app.status().running);
}

fn is_solved(app: &App) -> bool {
    app.results.as_ref().is_some_and(|results| results.solution.is_some())
}

fn errors(app: &App) -> Vec<&str> {
    app.notices.lines.iter().filter(|line| line.level == Level::Error).map(|line| line.text.as_str()).collect()
}

/// Mean colour of a part of the view; x and y go from 0 to 1 over the view's area beside the panels.
fn colour_at(picture: &RgbaImage, window: &Harness<'_, App>, x: f32, y: f32) -> [f32; 3] {
    let app = window.state();
    let left = if app.layout.panels { 331.0 } else { 0.0 };
    let bottom = SIZE[1] - if app.layout.plots { 180.0 } else { 26.0 };
    let (column, row) = (left + x * (SIZE[0] - left), y * bottom);
    let mut sum = [0.0; 3];
    for (dx, dy) in (0..25).map(|index| (index % 5, index / 5)) {
        let pixel = picture.get_pixel(column as u32 + dx - 2, row as u32 + dy - 2);
        for (total, value) in sum.iter_mut().zip(pixel.0) {
            *total += f32::from(value) / 25.0;
        }
    }
    sum
}

#[test]
fn the_box_is_seen_at_once_and_solved_after_one_key() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let before = window.render().unwrap();
    let [red, green, blue] = colour_at(&before, &window, 0.24, 0.5);
    assert!(red > 2.0 * green && red > 2.0 * blue, "the left wall is red before any light: {red} {green} {blue}");
    assert!(window.state().results.is_none());

    solve(&mut window);
    let app = window.state();
    assert!(errors(app).is_empty(), "{:?}", errors(app));
    let results = app.results.as_ref().unwrap();
    assert_eq!(results.bounces.len(), 4);
    let mean = results.total.iter().map(|value| value.element_sum()).sum::<f32>() / results.total.len() as f32;
    assert!(mean > 1.0, "mean irradiance {mean} W/m²");
    let after = window.render().unwrap();
    let [red, green, blue] = colour_at(&after, &window, 0.24, 0.5);
    assert!(red > 2.0 * green && red > 2.0 * blue, "the left wall is red in its light: {red} {green} {blue}");
    let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 50_000, "only {changed} pixels changed");
}

#[test]
fn the_window_solves_to_the_bits_of_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let results = window.state().results.as_ref().unwrap();
    let problem = radiosity::solver::Problem {
        scene: results.elements.scene.clone(),
        tracer: results.elements.tracer.clone(),
        tessellation: results.elements.tessellation.clone(),
        load: window.state().document.loaded.load.clone(),
        light: results.input.light,
        settings: results.input.settings.clone(),
    };
    let monitor = radiosity::solver::Monitor::new(results.total.len(), None);
    let (solution, _) = radiosity::solver::solve(&problem, &monitor);
    assert_eq!(solution, *results.solution.clone().unwrap());
}

#[test]
fn the_keys_of_panels_and_views_do_what_the_help_says() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let toggles: [(Key, fn(&App) -> bool); 8] = [
        (Key::F1, |app| app.layout.help),
        (Key::F2, |app| app.layout.panels),
        (Key::F3, |app| app.layout.plots),
        (Key::B, |app| app.layout.views[0].wireframe),
        (Key::F, |app| app.layout.views[0].false_colour),
        (Key::U, |app| app.layout.ambient),
        (Key::X, |app| app.layout.second_view),
        (Key::Questionmark, |app| app.layout.help),
    ];
    for (key, is_on) in toggles {
        let before = is_on(window.state());
        press(&mut window, key);
        assert_ne!(is_on(window.state()), before, "{key:?}");
        press(&mut window, key);
        assert_eq!(is_on(window.state()), before, "{key:?} again");
    }
    press(&mut window, Key::V);
    assert_eq!(window.state().layout.views[0].shown, Shown::Irradiance);
    press(&mut window, Key::F1);
    window.get_by_label("Help");
    press(&mut window, Key::Escape);
    assert!(!window.state().layout.help);
}

#[test]
fn keys_fly_dragging_looks_and_the_wheel_sets_the_speed() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    for (key, direction) in [
        (Key::W, DVec3::Z),
        (Key::S, DVec3::NEG_Z),
        (Key::A, DVec3::X),
        (Key::D, DVec3::NEG_X),
        (Key::E, DVec3::Y),
        (Key::Q, DVec3::NEG_Y),
    ] {
        // The box is seen along +z, so its +x is to the left.
        let before = window.state().camera.position;
        window.key_down(key);
        window.run_steps(3);
        window.key_up(key);
        window.run_steps(1);
        let moved = window.state().camera.position - before;
        assert!(moved.length() > 0.0 && moved.normalize().dot(direction) > 0.99, "{key:?}: {moved}");
    }
    let before = window.state().camera.forward;
    window.drag_at(egui::pos2(600.0, 200.0));
    window.run_steps(1);
    window.hover_at(egui::pos2(660.0, 200.0));
    window.run_steps(1);
    window.drop_at(egui::pos2(660.0, 200.0));
    window.run_steps(1);
    assert!(window.state().camera.forward.distance(before) > 0.01);
    let before = window.state().camera.speed;
    window.hover_at(egui::pos2(600.0, 200.0));
    window.event(Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, 100.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
        source: egui::MouseWheelSource::Wheel,
    });
    window.run_steps(12);
    assert!(window.state().camera.speed > 1.1 * before);
}

#[test]
fn space_places_the_light_and_the_change_waits_for_enter() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let first = window.state().results.as_ref().unwrap().total.clone();
    press(&mut window, Key::Space);
    let app = window.state();
    let light = app.document.edit.light.unwrap();
    assert_eq!(light.centre, app.camera.position.to_array());
    let normal = DVec3::from_array(light.u).cross(DVec3::from_array(light.v)).normalize();
    assert!(normal.distance(app.camera.forward) < 1e-6);
    assert!(app.status().changed);
    assert_eq!(app.results.as_ref().unwrap().total, first, "the solution stays until ENTER");
    window.get_by_label("Settings changed: ENTER to restart");
    solve(&mut window);
    assert!(!window.state().status().changed);
    assert_ne!(window.state().results.as_ref().unwrap().total, first);
}

#[test]
fn escape_stops_a_solve_and_keeps_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let settings = &mut window.state_mut().document.edit.settings;
    (settings.rays, settings.subdivide) = (4096, 6);
    press(&mut window, Key::Enter);
    run_until(&mut window, "some light", |app| {
        app.results.as_ref().is_some_and(|results| results.total.iter().any(|value| value.max_element() > 0.0))
    });
    press(&mut window, Key::P);
    assert!(window.state().status().paused);
    press(&mut window, Key::P);
    assert!(!window.state().status().paused);
    press(&mut window, Key::Escape);
    run_until(&mut window, "the end of the solve", |app| !app.status().running);
    let solution = window.state().results.as_ref().unwrap().solution.clone().unwrap();
    assert!(!solution.info.complete);
    assert!(solution.total().iter().any(|value| value.max_element() > 0.0));
}

#[test]
fn states_are_saved_by_alt_and_number_and_loaded_by_the_number() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    press_with(&mut window, Modifiers::ALT, Key::Num3);
    assert!(folder.path().join("states/3.toml").is_file());
    let saved = window.state().state();
    press(&mut window, Key::Space);
    let app = window.state_mut();
    app.camera.look(50.0, 20.0);
    app.document.edit.settings.rays = 77;
    app.document.edit.tone_map.exposure = -2.0;
    press(&mut window, Key::Num3);
    let loaded = window.state().state();
    assert_eq!((loaded.light, &loaded.settings, loaded.tone_map), (saved.light, &saved.settings, saved.tone_map));
    let [eye, target] = [loaded.camera, saved.camera].map(|camera| DVec3::from_array(camera.unwrap().target));
    assert!(eye.distance(target) < 1e-9);
    press(&mut window, Key::Num7);
    assert!(window.state().notices.lines.last().unwrap().text.contains("7.toml"));
}

#[test]
fn a_bad_scene_is_a_notice_and_a_good_one_replaces_the_old() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let bad = folder.path().join("bad.obj");
    std::fs::write(&bad, "this is no mesh\n").unwrap();
    window.state_mut().fulfil(Command::OpenScene(bad));
    run_until(&mut window, "the error", |app| !app.is_busy());
    assert!(errors(window.state())[0].contains("bad.obj"));
    assert_eq!(window.state().document.loaded.scene.name, "cornell");

    let good: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tests/furnace-50.obj");
    press(&mut window, Key::M);
    assert!(window.state().dialog.is_some());
    window.event(Event::Text(good.display().to_string()));
    window.run_steps(2);
    press(&mut window, Key::Enter);
    run_until(&mut window, "the scene", |app| !app.is_busy());
    assert_eq!(window.state().document.loaded.scene.name, "furnace-50");
    assert!(window.state().results.is_none() && window.state().dialog.is_none());
}

#[test]
fn a_mesh_and_a_solution_are_saved_and_the_solution_is_loaded_again() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    press(&mut window, Key::O);
    assert!(window.state().dialog.is_some());
    press(&mut window, Key::Escape);
    assert!(window.state().dialog.is_none());
    solve(&mut window);
    let [mesh, solution] = ["mesh.ply", "solution.safetensors"].map(|name| folder.path().join(name));
    window.state_mut().fulfil(Command::SaveMesh(mesh.clone()));
    window.state_mut().fulfil(Command::SaveSolution(solution.clone()));
    run_until(&mut window, "the files", |app| !app.is_busy());
    assert!(std::fs::read(mesh).unwrap().starts_with(b"ply\n"));
    let saved = window.state().results.as_ref().unwrap().total.clone();
    window.state_mut().document.edit.light = None;
    window.state_mut().fulfil(Command::LoadSolution(solution));
    run_until(&mut window, "the solution", |app| !app.is_busy());
    let app = window.state();
    assert!(errors(app).is_empty(), "{:?}", errors(app));
    assert_eq!(app.results.as_ref().unwrap().total, saved);
    assert!(app.document.edit.light.is_some() && !app.status().changed);
}

#[test]
fn camera_and_light_go_through_a_line_of_text() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    window.event(Event::Copy);
    window.run_steps(2);
    let line = window.state().copied.clone().unwrap();
    assert_eq!(line.lines().count(), 1);
    let before = window.state().camera;
    press(&mut window, Key::Space);
    window.state_mut().camera.look(80.0, 10.0);
    window.event(Event::Paste(line));
    window.run_steps(2);
    let app = window.state();
    assert!(app.camera.forward.distance(before.forward) < 1e-9 && app.camera.position == before.position);
    assert_eq!(app.document.edit.light, app.document.original.light);
    window.event(Event::Paste(String::from("not a view")));
    window.run_steps(2);
    assert_eq!(errors(window.state()).len(), 1);
}

#[test]
fn a_click_tells_about_the_surface_and_every_panel_opens() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let middle = egui::pos2(660.0, 200.0);
    window.drag_at(middle);
    window.run_steps(1);
    window.drop_at(middle);
    window.run_steps(3);
    assert!(window.state().picked.is_some());
    window.get_by_label("Its vertices");
    for section in ["Solver", "View", "Light", "Scene", "Solution", "Log"] {
        window.get_by_label(section).click();
        window.run_steps(12);
    }
    assert!(errors(window.state()).is_empty());
}
