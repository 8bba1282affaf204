//! The window: its keys, panels and pictures.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use common::*;
use egui::{Event, Key, Modifiers};
use egui_kittest::{Harness, kittest::Queryable as _};
use glam::DVec3;
use image::RgbaImage;
use radiosity::app::{
    App,
    command::Command,
    notices::Level,
    panes::Pane,
    view_settings::{Shown, Source},
};

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
    let problem = radiosity::solver::Problem::new(
        results.elements.scene.clone(),
        results.elements.tracer.clone(),
        window.state().document.loaded.load.clone(),
        results.input.light,
        results.input.settings.clone(),
    );
    let problem = problem.unwrap();
    let monitor = radiosity::solver::Monitor::new(&problem.tessellation, None);
    let solution = radiosity::solver::solve(&problem, &monitor).solution;
    assert_eq!(solution, *results.solution.clone().unwrap());
}

#[test]
fn the_keys_of_panels_and_views_do_what_the_help_says() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    type IsOn = fn(&App) -> bool;
    let toggles: [(Key, IsOn); 8] = [
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
    window.state_mut().layout.relight_live = false;
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
    let panels = [
        ("Solver", "Follow light"),
        ("Assignment", "Test all tasks"),
        ("Lightmap", "Solve lightmap"),
        ("View", "Exposure"),
        ("Light", "Centre"),
        ("Scene", "Materials"),
        ("Solution", "Keep to compare"),
        ("Log", "a line for the log"),
    ];
    window.state_mut().notices.say(Level::Note, "a line for the log");
    for (panel, held) in panels {
        window.get_by_label(panel).click();
        window.run_steps(3);
        assert!(window.query_all_by_label_contains(held).next().is_some(), "{panel} shows no {held:?}");
    }
    assert!(errors(window.state()).is_empty());
}

#[test]
fn panels_are_hidden_brought_back_and_dragged_to_other_places() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    window.state_mut().layout.hidden.push(Pane::Light);
    window.run_steps(3);
    assert!(window.query_by_label("Light").is_none(), "a hidden panel has no tab");
    window.get_by_label("Panels").click();
    window.run_steps(3);
    window.get_by_label("Light").click();
    window.run_steps(3);
    press(&mut window, Key::Escape);
    assert!(window.state().layout.hidden.is_empty());
    assert!(window.query_all_by_label_contains("Centre").next().is_some(), "it comes back in front");

    // Its tab, dragged to the right edge of the views.
    let before = window.state().view_area;
    let tab = window.get_by_label("Light").rect().center();
    let aim = before.right_center() - egui::vec2(10.0, 0.0);
    drag(&mut window, tab, aim);
    window.run_steps(2);
    assert!(window.state().view_area.right() < before.right() - 50.0, "it takes its place from the views");
    assert!(window.get_by_label("Light").rect().left() > window.state().view_area.right());
    window.state_mut().layout.reset_panes();
    window.run_steps(3);
    assert_eq!(window.state().view_area, before);
}

#[test]
fn the_light_is_moved_and_turned_by_its_handles() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let light = |window: &Harness<'_, App>| window.state().document.edit.light.unwrap();
    let normal = |window: &Harness<'_, App>| {
        let light = light(window);
        DVec3::from_array(light.u).cross(DVec3::from_array(light.v)).normalize()
    };
    let before = light(&window);
    let camera = window.state().camera;
    let centre = on_screen(&window, DVec3::from_array(before.centre));
    drag(&mut window, centre, centre + egui::vec2(40.0, 30.0));
    let moved = DVec3::from_array(light(&window).centre) - DVec3::from_array(before.centre);
    assert!(moved.dot(camera.right()) > 0.01 && moved.y < -0.01, "right and down: {moved}");
    assert!(moved.dot(camera.forward).abs() < 1e-6 && window.state().camera.forward == camera.forward);

    let old = normal(&window);
    let length = 0.5 * (DVec3::from_array(before.u).length() + DVec3::from_array(before.v).length());
    let tip = on_screen(&window, DVec3::from_array(light(&window).centre) + length * old);
    drag(&mut window, tip, tip + egui::vec2(40.0, 0.0));
    assert!(normal(&window).dot(camera.right()) > old.dot(camera.right()) + 0.1);
    assert!((DVec3::from_array(light(&window).u).length() - DVec3::from_array(before.u).length()).abs() < 1e-6);
}

#[test]
fn a_changed_reflectance_shows_at_once_and_is_solved_at_the_next_enter() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    window.state_mut().layout.relight_live = false;
    solve(&mut window);
    let first = window.state().results.as_ref().unwrap().total.clone();
    let before = window.render().unwrap();
    let edit = &mut window.state_mut().document.edit;
    let mut materials = edit.materials.to_vec();
    for material in &mut materials {
        material.reflectance = glam::Vec3::new(0.1, 0.1, 0.9);
    }
    edit.materials = materials.into();
    window.run_steps(3);
    let after = window.render().unwrap();
    let [red, _, blue] = colour_at(&after, &window, 0.24, 0.5);
    assert!(blue > red, "the red wall is blue now");
    assert_ne!(before, after);
    assert!(window.state().status().changed);
    solve(&mut window);
    assert_ne!(window.state().results.as_ref().unwrap().total, first);
    assert!(!window.state().status().changed);
}

#[test]
fn the_second_view_shows_a_kept_solution_and_the_difference() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    window.state_mut().fulfil(Command::KeepForComparison);
    window.state_mut().document.edit.light.as_mut().unwrap().radiance = [1.0, 1.0, 40.0];
    solve(&mut window);
    press(&mut window, Key::X);
    let views = &mut window.state_mut().layout.views;
    (views[1].shown, views[1].source) = (Shown::Radiosity, Source::Other);
    window.run_steps(3);
    let other = window.render().unwrap();
    let area = window.state().view_area;
    let differing = |picture: &RgbaImage| {
        let [left, middle] = [area.left(), area.center().x].map(|column| column as u32 + 4);
        let pairs = (0..middle - left - 8).flat_map(|x| (60..area.bottom() as u32 - 4).map(move |y| (x, y)));
        pairs.filter(|&(x, y)| picture.get_pixel(left + x, y) != picture.get_pixel(middle + x, y)).count()
    };
    assert!(differing(&other) > 20_000, "the kept solution has another light: {}", differing(&other));
    window.state_mut().layout.views[1].source = Source::Difference;
    window.run_steps(3);
    assert_ne!(window.render().unwrap(), other);
    window.get_by_label("Solution").click();
    window.run_steps(3);
    window.get_by_label_contains("From the other solution");
}
