//! The real window, on a real screen.

use std::{
    cell::RefCell,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    path::Path,
    rc::Rc,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::anyhow;
use eframe::egui_wgpu::WgpuSetupCreateNew;

use super::{App, device_loss::Shown, loader::OpenedScene};
use crate::{files::atlas_cache::AtlasCache, gpu::device};

/// A device that is lost in less time does not bear the window.
const SHORT_LIFE: Duration = Duration::from_secs(20);
/// So many losses in a row are borne.
const MOST_LOSSES: u32 = 3;

/// Opens the window and stays until it is closed. When its device is lost, it is opened anew with all that it held.
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
    let shown: Rc<RefCell<Option<Rc<RefCell<App>>>>> = Rc::default();
    let mut opened = Some(opened);
    let mut losses = 0;
    loop {
        let started = Instant::now();
        let kept = Rc::clone(&shown);
        let scene = opened.take();
        let create: eframe::AppCreator<'_> = Box::new(move |creation| {
            let mut kept = kept.borrow_mut();
            if let Some(scene) = scene {
                let mut app = App::new(creation, scene, Path::new("."));
                app.lightmap.cache = AtlasCache::of_user();
                *kept = Some(Rc::new(RefCell::new(app)));
            } else if let Some(app) = &*kept {
                app.borrow_mut().attach(creation);
            }
            let app = kept.as_ref().map(Rc::clone).ok_or("there is no scene")?;
            Ok(Box::new(Shown(app)) as Box<dyn eframe::App>)
        });
        // Where nothing can be drawn, egui's renderer may panic before the window has closed.
        let run = AssertUnwindSafe(|| eframe::run_native("radiosity", options(&title), create));
        let ended = catch_unwind(run);
        let is_lost = shown.borrow().as_ref().is_some_and(|app| app.borrow_mut().heeds_loss());
        losses = if started.elapsed() < SHORT_LIFE { losses + 1 } else { 1 };
        if is_lost && losses <= MOST_LOSSES {
            continue;
        }
        return match ended {
            _ if is_lost => {
                Err(anyhow!("the graphics device was lost again and again; `radiosity devices` lists what there is"))
            }
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) => Err(anyhow!("the window could not be opened: {error}")),
            Err(panic) => resume_unwind(panic),
        };
    }
}

fn options(title: &str) -> eframe::NativeOptions {
    let viewport = egui::ViewportBuilder::default().with_title(title).with_app_id("radiosity");
    let mut options = eframe::NativeOptions {
        viewport: viewport
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([480.0, 320.0])
            .with_drag_and_drop(true),
        persist_window: false,
        dithering: false,
        ..Default::default()
    };
    options.wgpu_options.wgpu_setup = wgpu_setup().into();
    options
}

/// How the window's device is opened: so that lightmaps can be solved on it, by OpenGL too, and their passes timed.
pub fn wgpu_setup() -> WgpuSetupCreateNew {
    WgpuSetupCreateNew {
        device_descriptor: Arc::new(device::descriptor),
        ..WgpuSetupCreateNew::without_display_handle()
    }
}
