//! The real window, on a real screen.

use std::path::Path;

use anyhow::anyhow;

use super::{App, loader::OpenedScene};

/// Opens the window and stays until it is closed.
///
/// # Errors
/// One line, if there is no display, or no graphics driver that can draw: nothing was shown then.
pub fn run(opened: OpenedScene) -> anyhow::Result<()> {
    #[cfg(target_os = "linux")]
    {
        let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        if !is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY") {
            return Err(anyhow!("no display was found: neither DISPLAY nor WAYLAND_DISPLAY is set"));
        }
    }
    let title = format!("Radiosity: {}", opened.loaded.scene.name);
    let viewport = egui::ViewportBuilder::default().with_title(title).with_app_id("radiosity");
    let options = eframe::NativeOptions {
        viewport: viewport
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([480.0, 320.0])
            .with_drag_and_drop(true),
        persist_window: false,
        dithering: false,
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> =
        Box::new(|creation| Ok(Box::new(App::new(creation, opened, Path::new("."))) as Box<dyn eframe::App>));
    eframe::run_native("radiosity", options, create).map_err(|error| anyhow!("the window could not be opened: {error}"))
}
