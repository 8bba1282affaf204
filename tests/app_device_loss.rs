//! What becomes of the window when its graphics device is lost.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use std::{cell::RefCell, rc::Rc};

use common::*;
use egui::{Key, ViewportCommand};
use egui_kittest::Harness;
use radiosity::app::{App, device_loss::Shown};

/// A window that shows an app which may have been shown before, and the window's device.
fn shown(app: &Rc<RefCell<App>>) -> (Harness<'static, Shown>, wgpu::Device) {
    let device = Rc::new(RefCell::new(None));
    let (kept, app) = (Rc::clone(&device), Rc::clone(app));
    let mut window = Harness::builder().with_size(SIZE).wgpu().build_eframe(move |creation| {
        app.borrow_mut().attach(creation);
        *kept.borrow_mut() = creation.wgpu_render_state.as_ref().map(|state| state.device.clone());
        Shown(app)
    });
    window.run_steps(4);
    let device = device.borrow().clone().unwrap();
    (window, device)
}

#[test]
fn a_lost_device_closes_the_window_and_the_next_one_shows_all_that_it_held_while_the_solve_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    // The window in which the app is made is left at once.
    let Some(first) = window(folder.path()) else { return };
    let app = Rc::new(RefCell::new(first.into_state()));
    let (mut before, device) = shown(&app);
    app.borrow_mut().document.edit.settings.rays = 400;
    before.key_press(Key::Enter);
    before.run_steps(2);
    assert!(app.borrow().status().running);
    let drawn = before.render().unwrap();

    device.destroy();
    before.run_steps(1);
    assert!(app.borrow_mut().heeds_loss());
    let commands = &before.output().viewport_output[&egui::ViewportId::ROOT].commands;
    assert!(commands.contains(&ViewportCommand::Close), "{commands:?}");
    drop(before);

    let (mut after, _) = shown(&app);
    assert!(!app.borrow_mut().heeds_loss());
    assert!(errors(&app.borrow()).iter().any(|line| line.contains("lost")), "{:?}", errors(&app.borrow()));
    let started = std::time::Instant::now();
    while app.borrow().status().running {
        assert!(started.elapsed().as_secs() < 60, "the solve goes on");
        std::thread::sleep(std::time::Duration::from_millis(5));
        after.run_steps(1);
    }
    assert!(is_solved(&app.borrow()));
    assert!(app.borrow().results.as_ref().unwrap().solution.as_ref().unwrap().info.complete);
    let picture = after.render().unwrap();
    let changed = drawn.pixels().zip(picture.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 20_000, "the solved box is seen on the new device: {changed} pixels changed");
}

#[test]
fn an_error_of_the_driver_is_a_notice_and_not_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let Some(first) = window(folder.path()) else { return };
    let app = Rc::new(RefCell::new(first.into_state()));
    let (mut window, device) = shown(&app);
    let _too_large = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("larger than any card allows"),
        size: 1 << 60,
        usage: wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    });
    window.run_steps(2);
    assert!(!app.borrow_mut().heeds_loss());
    assert!(errors(&app.borrow()).iter().any(|line| line.contains("larger than any card allows")));
}
