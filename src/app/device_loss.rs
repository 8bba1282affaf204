//! What the window does when its graphics device fails or is lost: it is opened anew, on another device if need be, with
//! all that it held. A solve goes on meanwhile.

use std::{cell::RefCell, rc::Rc, time::Duration};

use super::{App, notices::Level, theme};
use crate::{
    gpu,
    gpu::trouble::{Trouble, Troubles},
};

/// How often a window that was opened anew looks for news of what was begun before, which would wake the old window.
const LOOK_AGAIN: Duration = Duration::from_millis(100);

/// An [`App`] that outlives the window it is shown in.
pub struct Shown(pub Rc<RefCell<App>>);

impl eframe::App for Shown {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.0.borrow_mut().ui(ui, frame);
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        self.0.borrow().clear_color(visuals)
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.0.borrow_mut().save(storage);
    }
}

impl App {
    /// Draws in a window that was just made, on its device.
    pub fn attach(&mut self, creation: &eframe::CreationContext<'_>) {
        self.context = creation.egui_ctx.clone();
        self.title.clear();
        if let Some(render_state) = &creation.wgpu_render_state {
            gpu::install(render_state);
            let context = self.context.clone();
            self.troubles = Troubles::watch(&render_state.device, move || context.request_repaint());
        }
        self.device = creation.wgpu_render_state.as_ref().map(|state| (state.device.clone(), state.queue.clone()));
        self.software_driver = creation.wgpu_render_state.as_ref().is_some_and(gpu::is_software);
        theme::install(&self.context, self.software_driver);
        if std::mem::take(&mut self.is_lost) {
            self.is_attached_again = true;
            (self.lightmap.job, self.lightmap.shown) = (None, None);
            (self.screen.job, self.screen.shown) = (None, None);
        }
    }

    /// Says what happened to the device, and closes the window if it is gone, to be opened anew: true then.
    pub fn heeds_loss(&mut self) -> bool {
        if let Some((device, _)) = &self.device {
            // Lets the driver speak; that the device is gone is heard by the callback.
            let _ = device.poll(wgpu::PollType::Poll);
        }
        for trouble in self.troubles.take() {
            match trouble {
                Trouble::Lost(words) => {
                    let line = format!("The graphics device was lost ({words}); the window was opened anew");
                    self.notices.say(Level::Error, line);
                    self.is_lost = true;
                }
                // What fails on a device that is gone is no news.
                Trouble::Failed(line) if !self.is_lost => {
                    self.notices.say(Level::Error, format!("The graphics driver failed: {line}"));
                }
                Trouble::Failed(_) => {}
            }
        }
        if self.is_lost {
            self.context.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        if self.is_attached_again && (self.solving.is_some() || self.loader.is_busy()) {
            self.context.request_repaint_after(LOOK_AGAIN);
        }
        self.is_lost
    }
}
