//! What the window does about its lightmap.

use std::time::Duration;

use super::{
    App,
    lightmap_job::{LightmapEvent, LightmapInput, LightmapJob},
    notices::Level,
    view_settings::Source,
};

impl App {
    /// Takes the news of the lightmap.
    pub(super) fn listen_to_lightmap(&mut self) {
        let Some(job) = &self.lightmap.job else { return };
        let events: Vec<LightmapEvent> = job.events().collect();
        for event in events {
            match event {
                LightmapEvent::Status(text) => self.lightmap.status = text,
                LightmapEvent::Field { results, page } => {
                    self.other = Some(*results);
                    self.lightmap.set_page(&self.context, page);
                }
                LightmapEvent::Ended(ended) => {
                    self.lightmap.job = None;
                    match ended {
                        Ok(line) => self.lightmap.status = line,
                        Err(problem) => {
                            self.lightmap.status = problem.clone();
                            self.notices.say(Level::Error, problem);
                        }
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
        let (base, made_with) = self.elements_at_hand();
        let input = LightmapInput {
            base,
            made_with,
            input: self.document.edit.solve_input(),
            map: self.lightmap.map.clone(),
            settings: self.lightmap.settings.clone(),
            tone_map: self.document.edit.tone_map,
        };
        self.layout.ambient = false;
        self.layout.second_view = true;
        self.layout.views[1].shown = self.layout.views[0].shown;
        self.layout.views[1].source = Source::Other;
        let context = self.context.clone();
        match LightmapJob::start(input, move || context.request_repaint_after(Duration::from_millis(1))) {
            Ok(job) => self.lightmap.job = Some(job),
            Err(error) => self.notices.say(Level::Error, format!("no thread could be started: {error}")),
        }
    }
}
