//! A lightmap solved on the graphics card while the window goes on: a thread with a device of its own.
//!
//! The views draw vertices, so the map is read at them; the map itself is shown as a picture in the panel.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
        mpsc,
    },
    time::{Duration, Instant},
};

use egui::ColorImage;
use glam::{Vec2, Vec3};

use super::{
    results::Results,
    solving::{Elements, SolveInput, elements_for},
};
use crate::{
    files::lightmap_export::picture,
    gpu::{device, lightmap::GpuSolver},
    lightmap::{Atlas, Charts, GpuSettings, LightmapSettings, pages_of},
    math::color::ToneMap,
    solver::SolveSettings,
};

/// Time between two looks at the fields.
const SHOW_INTERVAL: Duration = Duration::from_millis(400);
/// How far inside an element a vertex's value is read: in the corner itself the map has another chart beside it.
const MOVE_INTO_ELEMENT: f32 = 0.02;

/// All that decides a lightmap.
#[derive(Clone)]
pub struct LightmapInput {
    /// Elements at hand, used again if the settings still ask for them.
    pub base: Elements,
    /// The settings that they were made with.
    pub made_with: SolveSettings,
    /// Light, materials and elements, as ENTER would take them.
    pub input: SolveInput,
    /// How fine the map is.
    pub map: LightmapSettings,
    /// How it is solved.
    pub settings: GpuSettings,
    /// For the picture of the map.
    pub tone_map: ToneMap,
}

/// News from a lightmap, in order.
pub enum LightmapEvent {
    /// What it does.
    Status(String),
    /// The light so far.
    Field {
        /// At the vertices, as a solution of two bounces: direct light and all other.
        results: Box<Results>,
        /// The first page.
        page: ColorImage,
    },
    /// It has ended, with a line about it.
    Ended(Result<String, String>),
}

/// A lightmap on its way. Dropping it stops it.
pub struct LightmapJob {
    events: mpsc::Receiver<LightmapEvent>,
    stopped: Arc<AtomicBool>,
    paused: Arc<AtomicBool>,
}

impl LightmapJob {
    /// Starts it; `wake` is called when there is news.
    ///
    /// # Errors
    /// If no thread can be made.
    pub fn start(input: LightmapInput, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let (sender, events) = mpsc::channel();
        let (stopped, paused) = <(Arc<AtomicBool>, Arc<AtomicBool>)>::default();
        let work =
            Work { input, stopped: Arc::clone(&stopped), paused: Arc::clone(&paused), sender, wake: Box::new(wake) };
        std::thread::Builder::new().name(String::from("lightmap")).spawn(move || {
            let ended = work.run();
            work.send(LightmapEvent::Ended(ended));
        })?;
        Ok(Self { events, stopped, paused })
    }

    /// News since the last call.
    pub fn events(&self) -> impl Iterator<Item = LightmapEvent> + '_ {
        self.events.try_iter()
    }

    /// Asks it to stop and keep what it has.
    pub fn stop(&self) {
        self.stopped.store(true, Relaxed);
    }

    /// Lets it wait, or go on.
    pub fn toggle_pause(&self) {
        self.paused.fetch_xor(true, Relaxed);
    }

    /// Whether it is told to wait.
    pub fn is_paused(&self) -> bool {
        self.paused.load(Relaxed)
    }
}

impl Drop for LightmapJob {
    fn drop(&mut self) {
        self.stop();
    }
}

struct Work {
    input: LightmapInput,
    stopped: Arc<AtomicBool>,
    paused: Arc<AtomicBool>,
    sender: mpsc::Sender<LightmapEvent>,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Work {
    fn run(&self) -> Result<String, String> {
        let LightmapInput { base, made_with, input, map, settings, .. } = &self.input;
        if let Some(problem) = settings.problem() {
            return Err(problem);
        }
        let elements = elements_for(base, made_with, input, &|| self.stopped.load(Relaxed))?;
        let report = |stage: &str, done: Option<f32>| {
            let percent = done.map_or(String::new(), |done| format!(", {:.0} %", 100.0 * done));
            self.send(LightmapEvent::Status(format!("{stage}{percent}")));
            !self.stopped.load(Relaxed)
        };
        let Some(atlas) = Atlas::new(&elements.scene, &*elements.tracer, map, &report)? else {
            return Ok(String::from("stopped before there was light"));
        };
        let places = vertex_places(&elements);
        let opened = device::choose(None)?.open()?;
        let light = input.light.map(|light| light.to_local(&elements.scene.frame));
        let mut solver = GpuSolver::new((&opened.0, &opened.1), &elements.scene, &atlas, light.as_ref(), settings)?;
        let (started, mut shown) = (Instant::now(), Instant::now());
        while !solver.is_done() && !self.stopped.load(Relaxed) {
            if self.paused.load(Relaxed) {
                std::thread::sleep(Duration::from_millis(20));
                continue;
            }
            solver.submit()?;
            if shown.elapsed() >= SHOW_INTERVAL {
                self.show(&solver, &atlas, &elements, &places)?;
                shown = Instant::now();
            }
        }
        self.show(&solver, &atlas, &elements, &places)?;
        let ledger = solver.ledger();
        Ok(format!(
            "{} texels, {} shooters in {:.1} s, {:.2} % unabsorbed, balance {:+.2} %",
            solver.size().texels,
            ledger.shooters,
            started.elapsed().as_secs_f64(),
            100.0 * ledger.unabsorbed(),
            100.0 * ledger.balance()
        ))
    }

    fn show(
        &self,
        solver: &GpuSolver,
        atlas: &Atlas,
        elements: &Elements,
        places: &[Vec<(u32, Vec2)>],
    ) -> Result<(), String> {
        let fields = solver.fields()?;
        let [direct, total] =
            [fields.direct, fields.total].map(|values| pages_of(&atlas.charts, &atlas.texels, &values));
        let at_vertices = |pages: &[Vec3]| places.iter().map(|around| mean_at(&atlas.charts, pages, around)).collect();
        let (at_direct, at_total): (Vec<Vec3>, Vec<Vec3>) = (at_vertices(&direct), at_vertices(&total));
        let indirect = at_total.iter().zip(&at_direct).map(|(all, direct)| (*all - *direct).max(Vec3::ZERO)).collect();
        let begun = Results::begun(elements.clone(), self.input.input.clone());
        let results =
            Results { total: Arc::new(at_total), bounces: vec![Arc::new(at_direct), Arc::new(indirect)], ..begun };
        let [width, height] = atlas.charts.page_size;
        let first = &total[..width as usize * height as usize];
        let page = picture(first, width, height, &self.input.tone_map);
        let page = ColorImage::from_rgba_unmultiplied([width as usize, height as usize], page.as_raw());
        self.send(LightmapEvent::Field { results: Box::new(results), page });
        let ledger = solver.ledger();
        let text = format!("{} shooters, {:.2} % unabsorbed", ledger.shooters, 100.0 * ledger.unabsorbed());
        self.send(LightmapEvent::Status(text));
        Ok(())
    }

    fn send(&self, event: LightmapEvent) {
        // The window may have closed.
        let _ = self.sender.send(event);
        (self.wake)();
    }
}

/// Where each vertex is read on the scene's triangles: a little inside each element around it.
fn vertex_places(elements: &Elements) -> Vec<Vec<(u32, Vec2)>> {
    let tessellation = &elements.tessellation;
    let mut places = vec![Vec::new(); tessellation.mesh.positions.len()];
    for (element, corners) in tessellation.mesh.triangles.iter().enumerate() {
        let inside = tessellation.corner_barycentrics[element];
        let middle = inside.iter().sum::<Vec2>() / 3.0;
        for (corner, vertex) in inside.iter().zip(corners) {
            let place = corner.lerp(middle, MOVE_INTO_ELEMENT);
            places[*vertex as usize].push((tessellation.scene_triangle[element], place));
        }
    }
    places
}

fn mean_at(charts: &Charts, pages: &[Vec3], around: &[(u32, Vec2)]) -> Vec3 {
    let values = around.iter().map(|(triangle, place)| charts.interpolate(pages, *triangle, *place));
    values.sum::<Vec3>() / around.len().max(1) as f32
}
