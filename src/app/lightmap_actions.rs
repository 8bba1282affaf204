//! What the window does about its lightmap.

use std::time::Duration;

use super::{
    App,
    factors_job::{FactorsEvent, FactorsInput, FactorsJob},
    lightmap_job::{LightmapEvent, LightmapInput, LightmapJob, ShownMap},
    notices::Level,
    solving::SolveInput,
    view_settings::Source,
};
use crate::{gpu, gpu::MapFrame, lightmap::FormFactorSettings, solver::SolveSettings};

impl App {
    /// Takes the news of the lightmap.
    pub(super) fn listen_to_lightmap(&mut self) {
        let Some(job) = &self.lightmap.job else { return };
        let events: Vec<LightmapEvent> = job.events().collect();
        for event in events {
            match event {
                LightmapEvent::Status(text) => self.lightmap.status = text,
                LightmapEvent::Shown(shown) => self.lightmap.shown = Some(*shown),
                LightmapEvent::Filled(stage) => self.lightmap.filled = stage,
                LightmapEvent::Times(times) => self.lightmap.times = times,
                LightmapEvent::Rests(line, results) => {
                    self.lightmap.status = line;
                    self.other = Some(*results);
                }
                LightmapEvent::Reloaded(Ok(())) => {
                    self.notices.say(Level::Note, "The lightmap's shaders are read anew");
                }
                LightmapEvent::Reloaded(Err(problem)) => self.notices.say(Level::Error, problem),
                LightmapEvent::Failed(problem) => {
                    self.lightmap.job = None;
                    self.lightmap.status.clone_from(&problem);
                    self.notices.say(Level::Error, problem);
                }
            }
        }
        if let Some(job) = &self.lightmap.job {
            job.set_stage(self.lightmap.stage);
        }
    }

    /// Shaders of the lightmap, from the folder that one works on them in.
    pub(super) fn reload_shaders(&mut self) {
        match &self.lightmap.job {
            Some(job) => job.reload_shaders(),
            None => self.notices.say(Level::Note, "There is no lightmap whose shaders could be read anew"),
        }
    }

    /// What a view that shows the lightmap reads; none if it shows something else.
    pub(super) fn map_of_view(&self, number: usize) -> Option<(&ShownMap, MapFrame)> {
        let source = self.layout.views[number].source;
        let shown = self.lightmap.shown.as_ref().filter(|_| source.is_lightmap())?;
        let version = self.lightmap.job.as_ref().map_or(0, LightmapJob::version);
        let difference = source == Source::LightmapDifference;
        let map = MapFrame {
            pages: shown.pages.clone(),
            version,
            difference,
            nearest: self.lightmap.nearest,
            on_screen: None,
        };
        Some((shown, map))
    }

    /// The window's device, if it can do more than draw; else says why it cannot.
    fn device_that_solves(&mut self) -> Option<(wgpu::Device, wgpu::Queue)> {
        let Some((device, queue)) = self.device.clone() else {
            self.notices.say(Level::Error, "The window does not draw on a device that could solve a lightmap");
            return None;
        };
        if let Some(problem) = gpu::device::missing_limit(&device.limits()) {
            let line =
                format!("The window's device {problem}: it cannot solve a lightmap; `radiosity devices` lists others");
            self.notices.say(Level::Error, line);
            return None;
        }
        Some((device, queue))
    }

    /// Form factors and sweeps, in the right view as the other solution; or the end of those on their way.
    pub(super) fn start_or_stop_factors(&mut self) {
        if self.lightmap.factors.job.take().is_some() {
            self.lightmap.factors.status.push_str(": stopped");
            return;
        }
        let Some((device, queue)) = self.device_that_solves() else { return };
        let edit = self.document.edit.solve_input();
        let (shown, made_with) = self.elements_at_hand();
        let settings = self.lightmap.factors.settings.clone();
        let FormFactorSettings { subdivide, max_edge, .. } = settings;
        let even = SolveSettings { subdivide, max_edge, ..SolveSettings::even() };
        let input =
            FactorsInput { device, queue, shown, made_with, input: SolveInput { settings: even, ..edit }, settings };
        self.layout.ambient = false;
        self.layout.second_view = true;
        self.layout.views[1].shown = self.layout.views[0].shown;
        self.layout.views[1].source = Source::Other;
        let context = self.context.clone();
        match FactorsJob::start(input, move || context.request_repaint_after(Duration::from_millis(1))) {
            Ok(job) => self.lightmap.factors.job = Some(job),
            Err(error) => self.notices.say(Level::Error, format!("no thread could be started: {error}")),
        }
    }

    /// Takes the news of the form factors.
    pub(super) fn listen_to_factors(&mut self) {
        let Some(job) = &self.lightmap.factors.job else { return };
        let events: Vec<FactorsEvent> = job.events().collect();
        for event in events {
            match event {
                FactorsEvent::Status(text) => self.lightmap.factors.status = text,
                FactorsEvent::Sweep(text, results) => {
                    self.lightmap.factors.status = text;
                    self.other = Some(*results);
                }
                FactorsEvent::Ended(outcome) => {
                    self.lightmap.factors.job = None;
                    if let Err(problem) = outcome {
                        self.lightmap.factors.status.clone_from(&problem);
                        self.notices.say(Level::Error, problem);
                    }
                }
            }
        }
    }

    /// The lightmap, in the right view as the other solution.
    pub(super) fn solve_lightmap(&mut self) {
        if !self.document.shines() {
            self.notices.say(Level::Error, "Nothing shines in this scene: press SPACE to put a light at the camera");
            return;
        }
        let Some((device, queue)) = self.device_that_solves() else { return };
        let input = LightmapInput {
            device,
            queue,
            shown: self.elements().clone(),
            input: self.document.edit.solve_input(),
            map: self.lightmap.map.clone(),
            settings: self.lightmap.settings.clone(),
            cache: self.lightmap.cache.clone(),
        };
        self.layout.ambient = false;
        self.layout.second_view = true;
        self.layout.views[1].shown = self.layout.views[0].shown;
        self.layout.views[1].source = Source::Lightmap;
        (self.lightmap.shown, self.lightmap.times) = (None, None);
        let context = self.context.clone();
        match LightmapJob::start(input, move || context.request_repaint_after(Duration::from_millis(1))) {
            Ok(job) => self.lightmap.job = Some(job),
            Err(error) => self.notices.say(Level::Error, format!("no thread could be started: {error}")),
        }
    }
}
