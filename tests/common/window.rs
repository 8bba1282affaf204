//! A window without a screen, drawn by real wgpu (a software driver will do), and what tests do with it.
#![allow(dead_code, reason = "which parts are unused differs from one test program to the next")]

use std::{
    path::Path,
    time::{Duration, Instant},
};

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use glam::DVec3;
use image::RgbaImage;
use radiosity::{
    app::{self, App, loader, notices::Level},
    files::loaded_scene::{self, LoadedScene},
    gpu::device,
};

pub(crate) const SIZE: [f32; 2] = [1000.0, 640.0];

/// The window with a small Cornell box, or nothing where no graphics driver is installed.
pub(crate) fn window(folder: &Path) -> Option<Harness<'static, App>> {
    window_at_scale(folder, 1.0)
}

/// The same on a screen with so many pixels a point.
pub(crate) fn window_at_scale(folder: &Path, scale: f32) -> Option<Harness<'static, App>> {
    if let Err(reason) = device::headless() {
        println!("skipped: {reason}");
        return None;
    }
    Some(window_of(Path::new("cornell"), folder, SIZE, scale))
}

/// The window with a scene at small settings.
pub(crate) fn window_of(scene: &Path, folder: &Path, size: [f32; 2], scale: f32) -> Harness<'static, App> {
    let (mut state, warnings) = loaded_scene::read_state(scene, None).unwrap();
    let settings = state.settings.get_or_insert_default();
    (settings.rays, settings.light_rays, settings.subdivide, settings.bounces) = (32, 8, 2, Some(3));
    let options = state.load.clone().unwrap_or_default();
    let loaded = LoadedScene::load(scene, state, options).unwrap();
    let opened = loader::prepare(loaded, warnings).unwrap();
    let folder = folder.to_path_buf();
    let builder = Harness::builder().with_size(size).with_pixels_per_point(scale);
    let mut harness =
        builder.wgpu_setup(app::wgpu_setup().into()).build_eframe(|creation| App::new(creation, opened, &folder));
    harness.run_steps(4);
    harness
}

pub(crate) fn press(window: &mut Harness<'_, App>, key: Key) {
    window.key_press(key);
    window.run_steps(2);
}

pub(crate) fn press_with(window: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(2);
}

pub(crate) fn run_until(window: &mut Harness<'_, App>, what: &str, mut is_done: impl FnMut(&App) -> bool) {
    let started = Instant::now();
    while !is_done(window.state()) {
        assert!(started.elapsed() < Duration::from_secs(60), "waited a minute for: {what}");
        std::thread::sleep(Duration::from_millis(5));
        window.run_steps(1);
    }
    window.run_steps(1);
}

pub(crate) fn solve(window: &mut Harness<'_, App>) {
    press(window, Key::Enter);
    run_until(window, "the end of the solve", |app| is_solved(app) && !app.status().running);
}

pub(crate) fn is_solved(app: &App) -> bool {
    app.results.as_ref().is_some_and(|results| results.solution.is_some())
}

pub(crate) fn errors(app: &App) -> Vec<&str> {
    app.notices.lines.iter().filter(|line| line.level == Level::Error).map(|line| line.text.as_str()).collect()
}

/// Mean colour of a part of the view; x and y go from 0 to 1 over the view's area beside the panels.
pub(crate) fn colour_at(picture: &RgbaImage, window: &Harness<'_, App>, x: f32, y: f32) -> [f32; 3] {
    let area = window.state().view_area;
    let (column, row) = (area.left() + x * area.width(), area.top() + y * area.height());
    let mut sum = [0.0; 3];
    for (dx, dy) in (0..25).map(|index| (index % 5, index / 5)) {
        let pixel = picture.get_pixel(column as u32 + dx - 2, row as u32 + dy - 2);
        for (total, value) in sum.iter_mut().zip(pixel.0) {
            *total += f32::from(value) / 25.0;
        }
    }
    sum
}

/// Where a point [m] appears in the window with one view.
pub(crate) fn on_screen(window: &Harness<'_, App>, point: DVec3) -> egui::Pos2 {
    let app = window.state();
    let frame = &app.elements().scene.frame;
    let area = app.view_area;
    let camera = app.camera.state().to_local(frame);
    let place = radiosity::gpu::project(&camera, area.aspect_ratio(), frame.point_to_local(point)).unwrap();
    area.min + egui::vec2(place.x, place.y) * area.size()
}

pub(crate) fn drag(window: &mut Harness<'_, App>, from: egui::Pos2, to: egui::Pos2) {
    window.hover_at(from);
    window.run_steps(2);
    window.drag_at(from);
    window.run_steps(2);
    for step in 1..=4 {
        window.hover_at(from + 0.25 * step as f32 * (to - from));
        window.run_steps(1);
    }
    window.drop_at(to);
    window.run_steps(2);
}
