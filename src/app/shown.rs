//! What the views show, and what a person does in them.

use std::f32::consts::PI;

use egui::Ui;
use glam::Vec3;

use super::{
    App,
    panes::Pane,
    picked::Picked,
    view,
    view_settings::{Source, ViewSettings},
};
use crate::{
    gpu::{self, ViewFrame},
    scene::area_light::AreaLightState,
};

/// Ambient light for looking round: radiance of white surfaces, as a part of what is shown as white.
const AMBIENT: f32 = 0.4;
/// The same while a solve has not yet lit all vertices, so that one sees where one is.
const DIM_AMBIENT: f32 = 0.015;
impl App {
    pub(super) fn view_ui(&mut self, ui: &mut Ui) {
        for (field, settings) in self.fields.iter_mut().zip(&self.layout.views) {
            match self.results.as_ref().or(self.other.as_ref()) {
                Some(results) => field.update(settings, results, self.other.as_ref()),
                None => field.clear(),
            }
        }
        let remark = if self.is_tracing() { " (dim ambient light until all is traced)" } else { "" };
        let scenery = view::Scenery {
            frames: [0, 1].map(|number| self.frame(number)),
            fields: [&self.fields[0], &self.fields[1]],
            titles: [0, 1].map(|number| self.view_title(number) + remark),
            picked: self.picked.map(|picked| (picked, self.elements())),
            rays: self.assignment.rays.rays.as_ref().filter(|_| self.assignment.rays.show && self.picked.is_some()),
        };
        // The layout is lent out apart, as the scenery borrows from the rest.
        let mut layout = self.layout.clone();
        let gestures = view::ui(ui, &mut layout, &scenery);
        self.layout = layout;
        if let Some(drag) = gestures.look {
            self.camera.look(drag.x, drag.y);
        }
        if gestures.wheel != 0.0 {
            let size = self.document.size();
            let faster = f64::from(gestures.wheel / 200.0).exp2();
            self.camera.speed = (self.camera.speed * faster).clamp(1e-4 * size, 10.0 * size);
        }
        if let Some(light) = gestures.light {
            let frame = &self.elements().scene.frame;
            self.document.edit.light = Some(AreaLightState {
                centre: frame.point_to_metres(light.centre).to_array(),
                u: frame.vector_to_metres(light.half_extent_u).to_array(),
                v: frame.vector_to_metres(light.half_extent_v).to_array(),
                radiance: light.radiance.to_array(),
            });
        }
        if let Some((point, aspect)) = gestures.click {
            let camera = self.camera.state().to_local(&self.elements().scene.frame);
            self.picked = Picked::new(self.elements(), &camera, point, aspect);
            self.layout.to_front = self.picked.map(|_| Pane::Point);
        }
    }

    /// What a view shows, in words.
    pub fn view_title(&self, number: usize) -> String {
        let settings = ViewSettings { source: self.source_shown(number), ..self.layout.views[number].clone() };
        let buffer = self.screen.shown.as_ref().map(|shown| shown.buffer);
        match buffer.filter(|buffer| settings.source == Source::Screen && !buffer.is_light()) {
            Some(buffer) => {
                let layer = if self.screen.layer == 1 { " of the second layer" } else { "" };
                format!("{}{layer}, screen space", buffer.name())
            }
            None => settings.title(),
        }
    }

    /// What is asked of a view, or the present solution while that is not there.
    fn source_shown(&self, number: usize) -> Source {
        let source = self.layout.views[number].source;
        let is_there = match source {
            Source::Present => true,
            Source::Other | Source::Difference => self.other.is_some(),
            Source::Lightmap | Source::LightmapDifference => self.lightmap.shown.is_some(),
            Source::Screen | Source::ScreenDifference => self.screen.shown.is_some(),
        };
        if is_there { source } else { Source::Present }
    }

    /// What a view shows now, but for its field.
    fn frame(&self, number: usize) -> ViewFrame {
        let shows_other = self.layout.views[number].source == Source::Other;
        let other = self.other.as_ref().filter(|_| shows_other);
        let results = other.or(self.results.as_ref()).or(self.other.as_ref());
        let map = self.map_of_view(number);
        let solved = results.map_or(&self.document.elements, |results| &results.elements);
        let elements = map.as_ref().map_or(solved, |(shown, _)| &shown.elements);
        let tone_map = self.document.edit.tone_map;
        let ambient = if self.layout.ambient {
            AMBIENT
        } else if self.is_tracing() {
            DIM_AMBIENT
        } else {
            0.0
        };
        let screen = self.screen_of_view(number);
        let shows_colours = match &screen {
            Some((shown, ..)) => !shown.buffer.is_light(),
            None => map.is_some() && !self.lightmap.filled.is_light(),
        };
        let shading = if shows_colours { gpu::Shading::Plain } else { gpu::Shading::Radiosity };
        let frame = &elements.scene.frame;
        let ambient = if screen.is_some() { 0.0 } else { ambient };
        let camera = screen.as_ref().map_or_else(|| self.camera.state().to_local(frame), |(.., camera)| *camera);
        let has_screen = screen.is_some();
        let buried = results.filter(|_| map.is_none() && !has_screen).and_then(|results| results.buried.clone());
        ViewFrame {
            view: number as u64,
            geometry: elements.geometry.clone(),
            materials: self.document.edit.materials.clone(),
            field: Default::default(),
            field_version: 0,
            map: screen.map(|(_, map, _)| map).or(map.map(|(_, frame)| frame)),
            buried,
            camera,
            size: [0; 2],
            shading,
            tone_map,
            wireframe: false,
            ambient: Vec3::splat(ambient * PI * tone_map.white / tone_map.exposure.exp2()),
            light: self.document.edit.light.map(|light| light.to_local(frame)),
            light_outline: None,
            antialias: self.layout.antialias && !self.saves_time() && !has_screen,
            saves_time: self.saves_time(),
            gradual: self.software_driver,
        }
    }
}
