//! Form factors by item buffers, and Gauss-Seidel sweeps with them, while the window goes on: a thread that shares the
//! window's device. The field is told after every sweep. And the part of the panel that starts it.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
        mpsc,
    },
    time::{Duration, Instant},
};

use egui::{Slider, Ui};
use glam::Vec3;

use super::{
    command::Command,
    controls::{choice_row, flag_help, row, rows},
    elements::{Elements, elements_for},
    results::Results,
    solving::SolveInput,
};
use crate::{
    gpu::lightmap::item_buffer::{ItemBuffers, Viewpoint, weights_of},
    lightmap::FormFactorSettings,
    solver::{
        SolveSettings,
        form_factors::{FormFactors, gauss_seidel},
        patches::Patches,
    },
};

/// Each sweep can be seen for so long: they take a moment only.
const SWEEP_SHOWN: Duration = Duration::from_millis(120);

/// All that decides them.
#[derive(Clone)]
pub struct FactorsInput {
    /// The window's device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The elements that are shown: their scene is taken.
    pub shown: Elements,
    /// The settings that those were made with.
    pub made_with: SolveSettings,
    /// Light, materials, and how the patches are cut.
    pub input: SolveInput,
    /// How they are found.
    pub settings: FormFactorSettings,
}

/// News from form factors, in order.
pub enum FactorsEvent {
    /// What it does.
    Status(String),
    /// A sweep was made (the first is none: direct light alone), with a line about it: a solution of two bounces, direct
    /// light and all other.
    Sweep(String, Box<Results>),
    /// It has ended, or could not be done.
    Ended(Result<(), String>),
}

/// Form factors on their way. Dropping it ends it.
pub struct FactorsJob {
    events: mpsc::Receiver<FactorsEvent>,
    stopped: Arc<AtomicBool>,
}

impl FactorsJob {
    /// Starts it; `wake` is called when there is news.
    ///
    /// # Errors
    /// If no thread can be made.
    pub fn start(input: FactorsInput, wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let (sender, events) = mpsc::channel();
        let stopped = Arc::new(AtomicBool::new(false));
        let work = Work { input, stopped: Arc::clone(&stopped), sender, wake: Box::new(wake) };
        std::thread::Builder::new().name(String::from("form factors")).spawn(move || {
            let outcome = work.run();
            work.send(FactorsEvent::Ended(outcome));
        })?;
        Ok(Self { events, stopped })
    }

    /// News since the last call.
    pub fn events(&self) -> impl Iterator<Item = FactorsEvent> + '_ {
        self.events.try_iter()
    }
}

impl Drop for FactorsJob {
    fn drop(&mut self) {
        self.stopped.store(true, Relaxed);
    }
}

struct Work {
    input: FactorsInput,
    stopped: Arc<AtomicBool>,
    sender: mpsc::Sender<FactorsEvent>,
    wake: Box<dyn Fn() + Send>,
}

impl Work {
    fn run(&self) -> Result<(), String> {
        let FactorsInput { device, queue, shown, made_with, input, settings } = &self.input;
        if let Some(problem) = settings.problem() {
            return Err(problem);
        }
        let elements = elements_for(shown, made_with, input)?;
        let patches = Patches::new(&elements.scene, &elements.tessellation);
        let weights = weights_of(settings.weights, settings.resolution);
        let drawn = (&*elements.scene, &*elements.tessellation);
        let buffers = ItemBuffers::of_elements((device, queue), drawn, settings.resolution, &weights)?;
        let Some(factors) = self.factors(&buffers, &patches)? else { return Ok(()) };
        let light = input.light.map(|light| light.to_local(&elements.scene.frame));
        let placed = buffers.direct_irradiance(light.as_ref(), &patches.areas)?;
        let quality = factors.quality();
        let sums = format!(
            "{} patches, row sums {:.3} to {:.3}, reciprocity off by {:.1} %",
            patches.areas.len(),
            quality.least_row_sum,
            quality.greatest_row_sum,
            100.0 * quality.reciprocity_error
        );
        let tell = |line: &str, radiosity: &[Vec3]| {
            let [direct, indirect] =
                patches.irradiance_at_vertices(&elements.tessellation, &factors, &placed, radiosity);
            let total = direct.iter().zip(&indirect).map(|(direct, indirect)| *direct + *indirect).collect();
            let begun = Results::begun(elements.clone(), Arc::new(total), input.clone());
            let results = Results { bounces: vec![Arc::new(direct), Arc::new(indirect)], ..begun };
            self.send(FactorsEvent::Sweep(format!("{line}; {sums}"), Box::new(results)));
        };
        let mut told = Instant::now();
        gauss_seidel(&factors, &patches.emission, &patches.reflectance, &placed, |sweep, radiosity, change| {
            std::thread::sleep(SWEEP_SHOWN.saturating_sub(told.elapsed()));
            told = Instant::now();
            let is_stopped = self.stopped.load(Relaxed);
            if !is_stopped {
                tell(&format!("sweep {sweep}, change {change:.1e}"), radiosity);
            }
            !is_stopped && settings.goes_on(sweep, change)
        });
        Ok(())
    }

    /// All rows; none if it was stopped.
    fn factors(&self, buffers: &ItemBuffers, patches: &Patches) -> Result<Option<FormFactors>, String> {
        let viewpoints: Vec<Viewpoint> =
            patches.places.iter().map(|(origin, normal)| Viewpoint { origin: *origin, normal: *normal }).collect();
        let started = Instant::now();
        let mut report = |done: f32| {
            let left = started.elapsed().as_secs_f32() * (1.0 / done.max(1e-3) - 1.0);
            let percent = 100.0 * done;
            self.send(FactorsEvent::Status(format!("hemicubes of the patches, {percent:.0} %, {left:.0} s left")));
            !self.stopped.load(Relaxed)
        };
        let rows = buffers.all_rows(&viewpoints, &mut report)?;
        Ok(rows.map(|rows| FormFactors { areas: patches.areas.clone(), rows }))
    }

    fn send(&self, event: FactorsEvent) {
        // The window may have closed.
        let _ = self.sender.send(event);
        (self.wake)();
    }
}

/// The form factors in the panel of the lightmap.
#[derive(Default)]
pub struct FactorsPanel {
    /// How the next are found.
    pub settings: FormFactorSettings,
    /// Those on their way.
    pub job: Option<FactorsJob>,
    /// What it does, or how it ended.
    pub status: String,
}

/// The help of a flag of `radiosity form-factors`, by its field.
fn help(field: &str) -> String {
    flag_help::<FormFactorSettings>(field)
}

impl FactorsPanel {
    /// Draws it.
    pub(super) fn ui(&mut self, ui: &mut Ui) -> Option<Command> {
        let settings = &mut self.settings;
        rows(ui, "factors", |ui| {
            row(ui, "Cuts of patches", &help("subdivide"), Slider::new(&mut settings.subdivide, 0..=5));
            row(ui, "Pixels", &help("resolution"), Slider::new(&mut settings.resolution, 16..=512).step_by(2.0));
            choice_row(ui, "Weights", &help("weights"), &mut settings.weights);
            row(ui, "Sweeps", &help("sweeps"), Slider::new(&mut settings.sweeps, 1..=100));
        });
        let name = if self.job.is_some() { "Stop them" } else { "Find form factors" };
        let tooltip = "Draws the hemicube of each patch with the patches' numbers, then sweeps with Gauss-Seidel; the right \
                       view shows the field after each sweep";
        let clicked = ui.button(name).on_hover_text(tooltip).clicked();
        if !self.status.is_empty() {
            ui.label(&self.status);
        }
        clicked.then_some(Command::FormFactors)
    }
}
