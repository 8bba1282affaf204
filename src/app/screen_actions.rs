//! What the window does about its screen-space view.

use std::{sync::Arc, time::Duration};

use super::{
    App,
    notices::Level,
    screen_job::{ScreenInput, ScreenJob, ScreenRequest, ShownScreen},
    view_settings::{Shown, Source},
};
use crate::{
    gpu::{
        MapFrame, Viewer,
        device::missing_limit,
        screen_space::{ScreenView, ShownBuffer},
    },
    scene::Camera,
};

impl App {
    /// Starts, tells or ends the thread that draws in screen space, by what the views show.
    pub(super) fn go_on_with_screen(&mut self, frame: &eframe::Frame) {
        let number =
            (0..=usize::from(self.layout.second_view)).find(|number| self.layout.views[*number].source.is_screen());
        let Some(number) = number else {
            (self.screen.job, self.screen.shown) = (None, None);
            return;
        };
        if let Some(problem) = self.screen.job.as_ref().and_then(ScreenJob::failure) {
            self.stop_screen(problem);
            return;
        }
        let geometry = Arc::clone(&self.elements().geometry);
        if self.screen.job.as_ref().is_none_or(|job| !job.is_for(&geometry)) {
            self.screen.shown = None;
            let Some(state) = frame.wgpu_render_state() else { return };
            if let Some(problem) = missing_limit(&state.device.limits()) {
                self.stop_screen(format!("The window's device {problem}: it cannot draw in screen space"));
                return;
            }
            let mut renderer = state.renderer.write();
            let Some(viewer) = renderer.callback_resources.get_mut::<Viewer>() else { return };
            let mesh = viewer.mesh(&state.device, &state.queue, &geometry);
            let input = ScreenInput { device: state.device.clone(), queue: state.queue.clone(), geometry, mesh };
            drop(renderer);
            let context = self.context.clone();
            match ScreenJob::start(input, move || context.request_repaint_after(Duration::from_millis(1))) {
                Ok(job) => self.screen.job = Some(job),
                Err(error) => self.stop_screen(format!("no thread could be started: {error}")),
            }
        }
        let request = self.screen_request(number);
        let Some(job) = &self.screen.job else { return };
        if request.view.size.iter().all(|pixels| *pixels > 0) && request.settings.problem().is_none() {
            job.request(request);
        }
        self.screen.shown = job.shown().or(self.screen.shown.take());
    }

    fn stop_screen(&mut self, problem: String) {
        (self.screen.job, self.screen.shown) = (None, None);
        self.layout
            .views
            .iter_mut()
            .filter(|view| view.source.is_screen())
            .for_each(|view| view.source = Source::Present);
        self.notices.say(Level::Error, problem);
    }

    fn screen_request(&self, number: usize) -> ScreenRequest {
        let elements = self.elements();
        let part = match (self.layout.second_view, number) {
            (false, _) => 1.0,
            (true, 0) => self.layout.divider,
            (true, _) => 1.0 - self.layout.divider,
        };
        let pixels = self.view_area.size() * self.context.pixels_per_point();
        let buffer = match (self.screen.buffer, self.layout.views[number].shown) {
            (ShownBuffer::Total, Shown::Direct) => ShownBuffer::Direct,
            (ShownBuffer::Total, Shown::Indirect) => ShownBuffer::Indirect,
            (buffer, _) => buffer,
        };
        let judge = self.results.as_ref().filter(|_| !self.is_working()).and_then(|results| {
            let fields = [results.bounces.first()?.clone(), results.total.clone()];
            Some((results.elements.clone(), fields))
        });
        ScreenRequest {
            view: ScreenView {
                camera: self.camera.state().to_local(&elements.scene.frame),
                size: [(part * pixels.x) as u32, pixels.y as u32],
                light: self.document.edit.light.map(|light| light.to_local(&elements.scene.frame)),
                materials: self.document.edit.materials.clone(),
            },
            settings: self.layout.screen.clone(),
            shown: (buffer, self.screen.layer),
            judge,
        }
    }

    /// What a view that shows the scene in screen space reads, and from where it is seen; none if it shows something else.
    pub(super) fn screen_of_view(&self, number: usize) -> Option<(&ShownScreen, MapFrame, Camera)> {
        let source = self.layout.views[number].source;
        let shown = self.screen.shown.as_ref().filter(|_| source.is_screen())?;
        let map = MapFrame {
            pages: shown.page.clone(),
            version: shown.version,
            difference: source == Source::ScreenDifference,
            nearest: true,
            on_screen: Some(shown.size),
        };
        Some((shown, map, shown.camera))
    }
}
