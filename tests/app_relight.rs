//! The window relights: a dragged light, a changed reflectance, live on the rows of the last solve.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use common::*;
use egui::Key;
use egui_kittest::{Harness, kittest::Queryable as _};
use glam::{DVec3, Vec3};
use radiosity::{
    app::App,
    solver::{Kept, Monitor},
};

fn total(window: &Harness<'_, App>) -> Vec<Vec3> {
    window.state().results.as_ref().unwrap().total.to_vec()
}

/// Until what is shown is what is set.
fn wait_for_relight(window: &mut Harness<'_, App>) {
    let is_lit = |app: &App| {
        let results = app.results.as_ref().unwrap();
        results.relit && results.input == app.document.edit.solve_input()
    };
    run_until(window, "the relit field", is_lit);
}

/// Expected: what the kept rows give without a window.
#[test]
fn a_light_is_dragged_and_the_solution_follows_without_enter() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let before = total(&window);
    let kept = window.state().results.as_ref().unwrap().kept.clone().unwrap();
    let light = window.state().document.edit.light.unwrap();
    let centre = on_screen(&window, DVec3::from_array(light.centre));
    drag(&mut window, centre, centre + egui::vec2(60.0, 40.0));
    wait_for_relight(&mut window);
    let app = window.state();
    assert!(errors(app).is_empty(), "{:?}", errors(app));
    assert_ne!(total(&window), before);
    let expected = relit(&kept, app);
    assert_eq!(total(&window), expected);
    assert!(!app.status().changed && !app.status().running);
    window.get_by_label_contains("Relit in");
    // ENTER solves anew, as ever.
    solve(&mut window);
    assert!(!window.state().results.as_ref().unwrap().relit);
}

fn relit(kept: &Kept, app: &App) -> Vec<Vec3> {
    let results = app.results.as_ref().unwrap();
    let monitor = Monitor::new(kept.tessellation(), None);
    kept.relight(&results.elements.scene, app.document.edit.light, &monitor).solution.total()
}

/// Expected: less light on every wall that others shine on, where all reflect less.
#[test]
fn a_darker_paint_shows_its_light_at_once_and_undo_takes_it_back() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let before = total(&window);
    let materials = window.state().document.edit.materials.clone();
    let mut darker = materials.to_vec();
    darker.iter_mut().for_each(|material| material.reflectance *= 0.5);
    window.state_mut().document.edit.materials = darker.into();
    window.run_steps(1);
    wait_for_relight(&mut window);
    let sum = |field: &[Vec3]| field.iter().map(|value| value.element_sum()).sum::<f32>();
    assert!(sum(&total(&window)) < 0.95 * sum(&before));
    window.state_mut().document.edit.materials = materials;
    window.run_steps(1);
    wait_for_relight(&mut window);
    let back = total(&window);
    for (back, before) in back.iter().zip(&before) {
        assert!(back.abs_diff_eq(*before, 1e-3 * before.max_element().max(0.1)), "{back}, not {before}");
    }
}

#[test]
fn switched_off_or_with_other_settings_changes_wait_for_enter() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let before = total(&window);
    window.get_by_label("Relight live").click();
    window.run_steps(2);
    assert!(!window.state().layout.relight_live);
    press(&mut window, Key::Space);
    window.run_steps(10);
    assert!(window.state().status().changed);
    window.get_by_label("Relight live").click();
    window.state_mut().document.edit.settings.rays *= 2;
    window.run_steps(10);
    assert!(window.state().status().changed);
    assert_eq!(total(&window), before, "other settings are another solve");
}

/// With as many bounces as the settings ask for, a field that is lit again has as many as the solve.
#[test]
fn bounces_of_a_relight_are_not_added_to_those_of_the_solution_that_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let bounces = |app: &App| app.results.as_ref().unwrap().bounces.len();
    let solved = bounces(window.state());
    let limit = window.state().document.edit.settings.bounces.unwrap();
    assert_eq!(solved, limit as usize + 1);
    let mut frames = 0;
    for step in 1..=20 {
        let light = window.state_mut().document.edit.light.as_mut().unwrap();
        light.centre[0] += 1e-3 * f64::from(step);
        let is_lit = |app: &App| app.results.as_ref().unwrap().input == app.document.edit.solve_input();
        while !is_lit(window.state()) {
            assert_eq!(bounces(window.state()), solved, "after {frames} frames");
            std::thread::sleep(std::time::Duration::from_millis(1));
            window.run_steps(1);
            frames += 1;
            assert!(frames < 5000, "it is never lit again");
        }
        assert_eq!(bounces(window.state()), solved);
    }
}
