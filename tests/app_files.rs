//! The window: files, the clipboard and undo.
#![cfg(feature = "app")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use std::path::{Path, PathBuf};

use common::*;
use egui::{Event, Key, Modifiers};
use egui_kittest::{Harness, kittest::Queryable as _};
use glam::DVec3;
use radiosity::app::{App, command::Command};

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

/// The inside of a room, wound outwards, with a lamp under its top.
const FLIPPED: &str = "mtllib room.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 1 -1\nv -1 1 -1\nv -1 0 1\nv 1 0 1\nv 1 1 1\nv -1 1 1\n\
                       v -0.3 0.9 -0.3\nv 0.3 0.9 -0.3\nv 0.3 0.9 0.3\nv -0.3 0.9 0.3\nusemtl wall\nf 4 3 2 1\nf 5 6 7 8\n\
                       f 1 2 6 5\nf 8 7 3 4\nf 5 8 4 1\nf 2 3 7 6\nusemtl lamp\nf 12 11 10 9\n";

#[test]
fn a_scene_that_is_inside_out_is_said_and_flipped_by_a_button() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let path = folder.path().join("room.obj");
    std::fs::write(&path, FLIPPED).unwrap();
    std::fs::write(folder.path().join("room.mtl"), "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 1 1 1\n").unwrap();
    window.state_mut().fulfil(Command::OpenScene(path));
    run_until(&mut window, "the scene", |app| !app.is_busy());
    assert!(window.state().notices.lines.iter().any(|line| line.text.contains("first meets back faces")));
    window.get_by_label("Scene").click();
    window.run_steps(2);
    window.get_by_label("Flip").click_accesskit();
    window.run_steps(2);
    run_until(&mut window, "the flipped scene", |app| !app.is_busy());
    let document = &window.state().document;
    assert!(document.loaded.load.flip && document.facing.is_none());
    assert!(window.query_by_label("Flip").is_none());
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
fn undo_takes_back_a_change_and_redo_brings_it_again() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let rays = |window: &Harness<'_, App>| window.state().document.edit.settings.rays;
    // A change counts once it has stood for a second of the window's time.
    window.run_steps(90);
    window.state_mut().document.edit.settings.rays = 99;
    window.run_steps(90);
    press_with(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(rays(&window), 32);
    press_with(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(rays(&window), 99);
}
