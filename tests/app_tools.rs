//! The window: steps, comparisons with a truth, curves to save, errors of sampling, sizes and dropped files.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use common::*;
use egui::{Key, vec2};
use egui_kittest::{Harness, kittest::Queryable as _};
use glam::DVec3;
use radiosity::{
    app::{App, command::Command, view_settings::Shown},
    check::{
        surface_points::{area_uniform_points, truth_point},
        truth_file::{self, TruthFile, TruthValue},
    },
};

#[test]
fn the_key_n_goes_on_by_one_bounce_and_p_to_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    for bounces in 1..=3 {
        press(&mut window, Key::N);
        run_until(&mut window, "the next bounce", |app| {
            app.status().paused && app.results.as_ref().is_some_and(|results| results.bounces.len() == bounces)
        });
        std::thread::sleep(std::time::Duration::from_millis(50));
        window.run_steps(2);
        let app = window.state();
        assert!(app.status().running && app.results.as_ref().unwrap().bounces.len() == bounces, "it waits");
    }
    press(&mut window, Key::P);
    run_until(&mut window, "the end of the solve", |app| is_solved(app) && !app.status().running);
    let stepped = window.state().results.as_ref().unwrap().total.clone();
    solve(&mut window);
    assert_eq!(window.state().results.as_ref().unwrap().total, stepped, "the same bits as in one go");
}

/// A truth file that holds the window's own solution, times a factor, at 200 points.
fn write_truth(app: &App, path: &Path, factor: f64) {
    let results = app.results.as_ref().unwrap();
    let elements = &results.elements;
    let places = area_uniform_points(&elements.scene, 200, 1);
    let at = |field: &[glam::Vec3], (triangle, place)| {
        factor * elements.tessellation.interpolate(field, triangle, place).as_dvec3()
    };
    let values = places.iter().map(|&place| TruthValue {
        direct: at(&results.bounces[0], place),
        total: at(&results.total, place),
        ..TruthValue::default()
    });
    let points = places.iter().map(|&place| truth_point(&elements.scene, place)).collect();
    let truth = TruthFile { comments: Vec::new(), points, values: Some(values.collect()) };
    truth_file::write(&truth, std::fs::File::create(path).unwrap()).unwrap();
}

#[test]
fn a_truth_of_known_distance_is_told_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let path = folder.path().join("truth.csv");
    window.state_mut().fulfil(Command::CompareWithTruth(path.clone()));
    window.run_steps(2);
    assert_eq!(errors(window.state()).len(), 1, "there is nothing to compare yet");
    solve(&mut window);
    write_truth(window.state(), &path, 0.8);
    window.state_mut().fulfil(Command::CompareWithTruth(path.clone()));
    run_until(&mut window, "the comparison", |app| !app.is_busy());
    let truth = window.state().results.as_ref().unwrap().truth.clone().unwrap();
    let all = truth.comparison.errors.all;
    assert!((all.total.bias - 0.25).abs() < 1e-3, "1 / 0.8 - 1, not {}", all.total.bias);
    assert!(all.point_count + truth.comparison.off_surface == 200 && truth.comparison.off_surface < 5);
    let total = &window.state().results.as_ref().unwrap().total;
    let most = total.iter().map(|value| value.max_element()).fold(0.0, f32::max);
    let worst = truth.field.iter().map(|value| value.max_element()).fold(0.0, f32::max);
    assert!(worst > 0.05 * most && worst < 0.3 * most, "a fifth of the brightest at most: {worst} of {most}");
    let before = window.render().unwrap();
    window.state_mut().layout.views[0].shown = Shown::TruthError;
    window.get_by_label("Solution").click();
    window.run_steps(3);
    window.get_by_label_contains("Against truth.csv");
    assert_ne!(window.render().unwrap(), before);

    std::fs::write(&path, "px,py,pz,nx,ny,nz\n").unwrap();
    window.state_mut().fulfil(Command::CompareWithTruth(path));
    run_until(&mut window, "the refusal", |app| !app.is_busy());
    assert!(window.state().notices.last_error().unwrap().contains("points alone"));
}

#[test]
fn curves_are_saved_as_a_table_and_as_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let [table, picture] = ["curves.csv", "curves.png"].map(|name| folder.path().join(name));
    window.state_mut().fulfil(Command::SavePlots(table.clone()));
    assert_eq!(errors(window.state()).len(), 1, "there are no curves yet");
    solve(&mut window);
    window.state_mut().fulfil(Command::SavePlots(table.clone()));
    window.state_mut().fulfil(Command::SavePlots(picture.clone()));
    run_until(&mut window, "the files", |app| !app.is_busy());
    let text = std::fs::read_to_string(table).unwrap();
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 1 + 4, "a head, direct light and three bounces");
    let number = |line: usize, column: &str| -> f64 {
        lines[line][lines[0].iter().position(|name| *name == column).unwrap()].parse().unwrap()
    };
    let powers = &window.state().results.as_ref().unwrap().powers;
    for (bounce, power) in powers.iter().enumerate() {
        assert_eq!(
            DVec3::new(
                number(bounce + 1, "arriving_r"),
                number(bounce + 1, "arriving_g"),
                number(bounce + 1, "arriving_b")
            ),
            power.arriving
        );
        assert!(number(bounce + 1, "estimated_error") >= number(bounce + 1, "missing"));
    }
    assert!(number(4, "missing") < number(1, "missing") && number(4, "seconds") > number(1, "seconds"));
    let picture = image::open(picture).unwrap();
    assert!(picture.width() > 500 && picture.height() > 60 && picture.height() < 400, "the plots alone");
}

#[test]
fn the_sampling_error_is_a_view_and_falls_with_the_rays() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    let mut relative = Vec::new();
    for rays in [32, 128] {
        let settings = &mut window.state_mut().document.edit.settings;
        // An error so large that no rays are added for it.
        (settings.rays, settings.adaptive) = (rays, 0.2);
        solve(&mut window);
        relative.push(window.state().results.as_ref().unwrap().relative_sampling_error.unwrap());
    }
    assert!(relative[0] < 0.2 && relative[1] < 0.7 * relative[0], "{relative:?}");
    let before = window.render().unwrap();
    while window.state().layout.views[0].shown != Shown::SamplingError {
        press(&mut window, Key::V);
    }
    window.run_steps(2);
    assert_ne!(window.render().unwrap(), before);
}

#[test]
fn a_clicked_point_tells_where_its_light_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let left_wall = window.state().view_area.left_center() + vec2(0.24 * window.state().view_area.width(), 0.0);
    window.drag_at(left_wall);
    window.run_steps(1);
    window.drop_at(left_wall);
    window.run_steps(3);
    let app = window.state();
    let (picked, results) = (app.picked.unwrap(), app.results.as_ref().unwrap());
    let shares = picked.shares(app.elements(), results);
    assert!((shares.iter().map(|(_, part)| part).sum::<f32>() - 1.0).abs() < 1e-5, "{shares:?}");
    let part = |name: &str| shares.iter().find(|(known, _)| known.contains(name)).map_or(0.0, |(_, part)| *part);
    assert!(part("directly") > 0.3, "most of it comes straight from the light: {shares:?}");
    // The direct part is what the bounces say, too.
    let element = app.elements().tessellation.interpolate(&results.bounces[0], picked.triangle, picked.barycentric);
    let whole = app.elements().tessellation.interpolate(&results.total, picked.triangle, picked.barycentric);
    assert!((part("directly") - element.y / whole.y).abs() < 0.1, "{} of {}", element.y, whole.y);
    window.get_by_label("Its light comes from");
}

#[test]
fn frame_times_are_told_by_stage() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    press(&mut window, Key::F4);
    window.run_steps(4);
    for stage in ["listen", "panels", "views", "upload", "draw"] {
        window.get_by_label(stage);
    }
    let summary = window.state().frame_times.summary();
    assert!(summary.frames > 3 && summary.stages[1][0] > 0.0 && summary.stages[1][1] <= summary.worst);
    press(&mut window, Key::F4);
    assert!(!window.state().layout.frame_times);
}

#[test]
fn any_size_and_scale_of_the_window_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    press(&mut window, Key::X);
    for size in [[480.0, 320.0], [40.0, 30.0], [1.0, 1.0], [2560.0, 1440.0]] {
        window.set_size(size.into());
        window.run_steps(3);
        let picture = window.render().unwrap();
        assert_eq!([picture.width(), picture.height()], size.map(|side| side as u32));
    }
    let mut window = window_at_scale(folder.path(), 2.0).unwrap();
    let picture = window.render().unwrap();
    assert_eq!([picture.width(), picture.height()], SIZE.map(|side| 2 * side as u32));
    let area = window.state().view_area;
    let at = |x: f32, y: f32| {
        let place = area.min + vec2(x * area.width(), y * area.height());
        picture.get_pixel((2.0 * place.x) as u32, (2.0 * place.y) as u32).0
    };
    let [red, green, ..] = at(0.24, 0.5);
    assert!(red > 2 * green, "the left wall is red, and where it is at scale 1: {:?}", at(0.24, 0.5));
}

/// A file as the system hands it over.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

fn dropped(window: &mut Harness<'_, App>, path: &Path) {
    window.input_mut().dropped_files.push(Arc::new(Dropped(path.to_path_buf())));
    window.run_steps(2);
    run_until(window, "the dropped file", |app| !app.is_busy());
}

#[test]
fn a_dropped_scene_opens_and_a_bad_one_leaves_the_old_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    solve(&mut window);
    let solved = window.state().results.as_ref().unwrap().total.clone();
    let bad = folder.path().join("bad.obj");
    std::fs::write(&bad, "v 0 0 0\nf 1 2 3\n").unwrap();
    dropped(&mut window, &bad);
    dropped(&mut window, &folder.path().join("picture.jpg"));
    let app = window.state();
    assert_eq!(errors(app).len(), 2);
    assert!(app.document.loaded.scene.name == "cornell" && app.results.as_ref().unwrap().total == solved);
    dropped(&mut window, &Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tests/furnace-50.obj"));
    assert_eq!(window.state().document.loaded.scene.name, "furnace-50");
    assert!(window.state().results.is_none());
}
