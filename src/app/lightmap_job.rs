//! A lightmap solved on the graphics card while the window goes on: a thread that shares the window's device.
//!
//! While it runs, the views read its pages where they are; only the ledger comes back. Once it rests (done, stopped) its
//! field is read at the vertices, for comparisons.

use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed},
        mpsc,
    },
    time::{Duration, Instant},
};

use glam::{Vec2, Vec3};

use super::{
    elements::{Elements, elements_for},
    results::Results,
    solving::SolveInput,
};
use crate::{
    files::atlas_cache::AtlasCache,
    gpu::{
        ViewGeometry,
        lightmap::{
            GpuSolver, Stage,
            shaders::{SHADER_FOLDER, Shaders},
            timing::PassTime,
        },
    },
    lightmap::{Atlas, Charts, GpuSettings, LightmapSettings, PageUpdate, pages_of},
    solver::monitor::locked,
};

/// Time between two fillings of the pages.
const SHOW_INTERVAL: Duration = Duration::from_millis(150);
/// How far inside an element a vertex's value is read: in the corner itself the map has another chart beside it.
const MOVE_INTO_ELEMENT: f32 = 0.02;

/// All that decides a lightmap.
#[derive(Clone)]
pub struct LightmapInput {
    /// The window's device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The elements that are shown.
    pub shown: Elements,
    /// Light and materials, as ENTER would take them.
    pub input: SolveInput,
    /// How fine the map is.
    pub map: LightmapSettings,
    /// How it is solved.
    pub settings: GpuSettings,
    /// Where maps are kept from run to run.
    pub cache: Option<AtlasCache>,
}

/// A lightmap as views show it: its pages are on the card, and change there.
#[derive(Clone)]
pub struct ShownMap {
    /// The elements, with a geometry that knows their places on the map.
    pub elements: Elements,
    /// The pages.
    pub pages: wgpu::Buffer,
    /// Columns and rows of a page.
    pub page_size: [u32; 2],
    /// Pages.
    pub page_count: u32,
    /// Depth of the groups' hemicubes.
    pub hemicubes: wgpu::TextureView,
    /// Items of the groups' hemispheres, if there are any.
    pub items: Option<wgpu::TextureView>,
    /// Columns and rows that are shown of either.
    pub hemicubes_size: [u32; 2],
}

/// News from a lightmap, in order.
pub enum LightmapEvent {
    /// What it does.
    Status(String),
    /// The solve begins, and can be shown.
    Shown(Box<ShownMap>),
    /// The pages were filled anew.
    Filled(Stage),
    /// What each pass took so far; none if the device has no timestamps.
    Times(Option<Vec<PassTime>>),
    /// It rests, with a line about it, and its field at the vertices: a solution of two bounces, direct light and all
    /// other. It can go on.
    Rests(String, Box<Results>),
    /// Shaders were read again; or the compiler's message.
    Reloaded(Result<(), String>),
    /// It has failed.
    Failed(String),
}

/// What the thread and the window share.
#[derive(Default)]
struct Shared {
    ended: AtomicBool,
    stopped: AtomicBool,
    paused: AtomicBool,
    rests: AtomicBool,
    reload: AtomicBool,
    /// Elements to be shown from now on.
    elements: Mutex<Option<Elements>>,
    stage: Mutex<Stage>,
    /// The stop rule, as the bits of a number.
    unabsorbed: AtomicU32,
    /// Counts how often the pages were filled.
    version: AtomicU64,
}

/// A lightmap on its way, or at rest. Dropping it ends it.
pub struct LightmapJob {
    events: mpsc::Receiver<LightmapEvent>,
    shared: Arc<Shared>,
}

impl LightmapJob {
    /// Starts it; `wake` is called when there is news.
    ///
    /// # Errors
    /// If no thread can be made.
    pub fn start(input: LightmapInput, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let (sender, events) = mpsc::channel();
        let shared = Arc::new(Shared::default());
        shared.unabsorbed.store(input.settings.unabsorbed.to_bits(), Relaxed);
        let work = Work { input, shared: Arc::clone(&shared), sender, wake: Box::new(wake) };
        std::thread::Builder::new().name(String::from("lightmap")).spawn(move || {
            if let Err(problem) = work.run() {
                work.send(LightmapEvent::Failed(problem));
            }
        })?;
        Ok(Self { events, shared })
    }

    /// News since the last call.
    pub fn events(&self) -> impl Iterator<Item = LightmapEvent> + '_ {
        self.events.try_iter()
    }

    /// Asks it to stop and keep what it has.
    pub fn stop(&self) {
        self.shared.stopped.store(true, Relaxed);
    }

    /// Lets it go on after a stop or its end, until so little is unabsorbed.
    pub fn go_on(&self, unabsorbed: f32) {
        self.shared.unabsorbed.store(unabsorbed.to_bits(), Relaxed);
        self.shared.stopped.store(false, Relaxed);
    }

    /// Lets it wait, or go on.
    pub fn toggle_pause(&self) {
        self.shared.paused.fetch_xor(true, Relaxed);
    }

    /// Whether it is told to wait.
    pub fn is_paused(&self) -> bool {
        self.shared.paused.load(Relaxed)
    }

    /// Whether it is done or was stopped.
    pub fn rests(&self) -> bool {
        self.shared.rests.load(Relaxed)
    }

    /// What the pages are to hold.
    pub fn set_stage(&self, stage: Stage) {
        *locked(&self.shared.stage) = stage;
    }

    /// Shows it on these elements from now on: those of the solution that it is seen beside.
    pub fn set_elements(&self, elements: Elements) {
        *locked(&self.shared.elements) = Some(elements);
    }

    /// Counts how often the pages were filled.
    pub fn version(&self) -> u64 {
        self.shared.version.load(Relaxed)
    }

    /// Asks it to read its shaders again from the folder that one works in.
    pub fn reload_shaders(&self) {
        self.shared.reload.store(true, Relaxed);
    }
}

impl Drop for LightmapJob {
    fn drop(&mut self) {
        self.shared.ended.store(true, Relaxed);
        self.stop();
    }
}

struct Work {
    input: LightmapInput,
    shared: Arc<Shared>,
    sender: mpsc::Sender<LightmapEvent>,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Work {
    fn run(&self) -> Result<(), String> {
        let LightmapInput { shown, input, map, settings, .. } = &self.input;
        if let Some(problem) = settings.problem() {
            return Err(problem);
        }
        let elements = if shown.scene.materials == *input.materials {
            shown.clone()
        } else {
            elements_for(shown, &input.settings, input)?
        };
        let report = |stage: &str, done: Option<f32>| {
            let percent = done.map_or(String::new(), |done| format!(", {:.0} %", 100.0 * done));
            self.send(LightmapEvent::Status(format!("{stage}{percent}")));
            !self.shared.stopped.load(Relaxed)
        };
        let (scene, tracer) = (&elements.scene, &*elements.tracer);
        let found = match &self.input.cache {
            Some(cache) => cache.atlas(scene, tracer, map, &report)?.map(|(atlas, _)| atlas),
            None => Atlas::new(scene, tracer, map, &report)?,
        };
        let Some(atlas) = found else {
            return Err(String::from("the lightmap was stopped before there was light"));
        };
        let light = input.light.map(|light| light.to_local(&elements.scene.frame));
        let device = (&self.input.device, &self.input.queue);
        let mut solver = GpuSolver::new(device, &elements.scene, &atlas, light.as_ref(), settings)?;
        solver.fill_pages(Stage::Irradiance)?;
        self.show_on(&elements, &solver, &atlas.charts)?;
        self.solve(&mut solver, &atlas, elements)
    }

    /// Tells how it is shown on elements.
    fn show_on(&self, elements: &Elements, solver: &GpuSolver, charts: &Charts) -> Result<(), String> {
        let geometry = ViewGeometry::with_map(&elements.scene, &elements.tessellation, charts)?;
        self.send(LightmapEvent::Shown(Box::new(ShownMap {
            elements: Elements { geometry: Arc::new(geometry), ..elements.clone() },
            pages: solver.pages().clone(),
            page_size: charts.page_size,
            page_count: charts.page_count,
            hemicubes: solver.hemicube_depth().0.clone(),
            items: solver.item_buffer().cloned(),
            hemicubes_size: solver.hemicube_depth().1,
        })));
        Ok(())
    }

    /// Until the window lets go of it.
    fn solve(&self, solver: &mut GpuSolver, atlas: &Atlas, mut elements: Elements) -> Result<(), String> {
        let (mut shown, mut shown_stage) = (Instant::now(), Stage::Irradiance);
        let mut busy = Duration::ZERO;
        while !self.shared.ended.load(Relaxed) {
            if self.shared.reload.swap(false, Relaxed) {
                let loaded = Shaders::from_folder(std::path::Path::new(SHADER_FOLDER));
                self.send(LightmapEvent::Reloaded(loaded.and_then(|shaders| solver.reload(&shaders))));
            }
            let others = locked(&self.shared.elements).take();
            if let Some(others) = others.filter(|it| !Arc::ptr_eq(&it.tessellation, &elements.tessellation)) {
                self.show_on(&others, solver, &atlas.charts)?;
                elements = others;
                self.shared.rests.store(false, Relaxed); // its field at their vertices is to be told
            }
            solver.set_unabsorbed(f32::from_bits(self.shared.unabsorbed.load(Relaxed)));
            let stage = *locked(&self.shared.stage);
            let ends = solver.is_done() || self.shared.stopped.load(Relaxed);
            let begins_to_rest = ends && !self.shared.rests.load(Relaxed);
            let is_due = self.is_due(solver, shown.elapsed());
            if begins_to_rest || stage != shown_stage || is_due && !ends && !self.shared.paused.load(Relaxed) {
                self.show(solver, stage)?;
                (shown, shown_stage) = (Instant::now(), stage);
            }
            if begins_to_rest {
                let results = Box::new(self.at_vertices(solver, atlas, &elements)?);
                // Told first, so that who sees that it rests finds the field.
                self.send(LightmapEvent::Rests(summary(solver, busy), results));
                self.shared.rests.store(true, Relaxed);
            }
            if ends || self.shared.paused.load(Relaxed) {
                std::thread::sleep(Duration::from_millis(10));
                continue;
            }
            self.shared.rests.store(false, Relaxed);
            let started = Instant::now();
            solver.submit()?;
            busy += started.elapsed();
        }
        Ok(())
    }

    fn is_due(&self, solver: &GpuSolver, since: Duration) -> bool {
        match self.input.settings.update {
            PageUpdate::Continuous => since >= SHOW_INTERVAL,
            PageUpdate::Batch => solver.is_between_batches() && since >= SHOW_INTERVAL,
        }
    }

    fn show(&self, solver: &mut GpuSolver, stage: Stage) -> Result<(), String> {
        solver.fill_pages(stage)?;
        self.shared.version.fetch_add(1, Relaxed);
        self.send(LightmapEvent::Filled(stage));
        self.send(LightmapEvent::Times(solver.pass_times()));
        let ledger = solver.ledger();
        let text = format!("{} shooters, {:.2} % unabsorbed", ledger.shooters, 100.0 * ledger.unabsorbed());
        self.send(LightmapEvent::Status(text));
        Ok(())
    }

    fn at_vertices(&self, solver: &GpuSolver, atlas: &Atlas, elements: &Elements) -> Result<Results, String> {
        let places = vertex_places(elements);
        let fields = solver.fields()?;
        let [direct, total] =
            [fields.direct, fields.total].map(|values| pages_of(&atlas.charts, &atlas.texels, &values));
        let at_vertices = |pages: &[Vec3]| places.iter().map(|around| mean_at(&atlas.charts, pages, around)).collect();
        let (at_direct, at_total): (Vec<Vec3>, Vec<Vec3>) = (at_vertices(&direct), at_vertices(&total));
        let indirect = at_total.iter().zip(&at_direct).map(|(all, direct)| (*all - *direct).max(Vec3::ZERO)).collect();
        let begun = Results::begun(elements.clone(), Arc::new(at_total), self.input.input.clone());
        Ok(Results { bounces: vec![Arc::new(at_direct), Arc::new(indirect)], ..begun })
    }

    fn send(&self, event: LightmapEvent) {
        // The window may have closed.
        let _ = self.sender.send(event);
        (self.wake)();
    }
}

fn summary(solver: &GpuSolver, busy: Duration) -> String {
    let (ledger, size) = (solver.ledger(), solver.size());
    format!(
        "{} texels, {} MiB, {} shooters in {:.1} s, {:.2} % unabsorbed, {:.2} % on back faces, balance {:+.2} %, \
         mean {:.4} W/m²",
        size.texels,
        size.bytes.div_ceil(1 << 20),
        ledger.shooters,
        busy.as_secs_f64(),
        100.0 * ledger.unabsorbed(),
        100.0 * ledger.part_on_backs(),
        100.0 * ledger.balance(),
        ledger.arrived.element_sum() / 3.0 / size.square_metres
    )
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
