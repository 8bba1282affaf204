//! The window's panel of the assignment.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use common::*;
use egui_kittest::kittest::Queryable as _;
use glam::DVec3;
use radiosity::{
    check::tasks::{Status, TASKS},
    solver::Engine,
};

#[test]
fn a_button_a_task_tests_it_and_shows_what_the_function_does() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    window.get_by_label("Assignment").click();
    window.run_steps(4);
    window.get_by_label("Test disk").click_accesskit();
    run_until(&mut window, "the tests of the disk", |app| !app.assignment.reports.is_empty());
    let assignment = &window.state().assignment;
    assert_eq!(assignment.reports.len(), 1);
    assert_eq!((assignment.reports[0].task, &assignment.reports[0].status), ("disk", &Status::Done));
    let (task, picture) = &assignment.pictures[0];
    assert_eq!(*task, "disk");
    assert!(picture.points.len() > 1000 && picture.points.iter().all(|[x, y]| x * x + y * y <= 1.0 + 1e-6));

    window.get_by_label("Test all tasks").click_accesskit();
    run_until(&mut window, "the tests of all tasks", |app| app.assignment.reports.len() == TASKS.len());
    assert!(window.state().assignment.reports.iter().all(|report| report.status == Status::Done));
    assert!(errors(window.state()).is_empty());
}

#[test]
fn the_switch_runs_the_students_functions_and_a_click_shows_a_vertexs_rays() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    window.get_by_label("Assignment").click();
    window.run_steps(4);
    if cfg!(feature = "reference") {
        window.get_by_label("Solve with src/student").click();
        window.run_steps(2);
    }
    solve(&mut window);
    assert_eq!(window.state().results.as_ref().unwrap().input.settings.engine, Engine::Student);

    let place = on_screen(&window, DVec3::new(0.42, 0.0, 0.12));
    window.hover_at(place);
    window.run_steps(2);
    window.drag_at(place);
    window.drop_at(place);
    window.run_steps(3);
    window.state_mut().assignment.rays.show = true;
    window.run_steps(3);
    let rays = window.state().assignment.rays.rays.clone().unwrap();
    let results = window.state().results.as_ref().unwrap();
    assert_eq!(rays.irradiance.unwrap(), results.bounces[0][rays.vertex as usize]);
    let light_rays = results.input.settings.light_rays as usize;
    assert!((1..=light_rays).contains(&rays.rays.len()), "{} shadow rays", rays.rays.len());
    let picture = window.render().unwrap();
    if let Some(path) = std::env::var_os("RADIOSITY_PICTURE") {
        picture.save(path).unwrap();
    }
}
