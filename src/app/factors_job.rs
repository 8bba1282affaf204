//! Form factors by item buffers or by rays, and Gauss-Seidel sweeps with them, while the window goes on: a thread that
//! shares the window's device. The field is told after every sweep. And the part of the panel that starts it.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
        mpsc,
    },
    time::{Duration, Instant},
};

use egui::{Slider, Ui};
use glam::Vec3;

use super::{
    command::Command,
    controls::{choice_row, flag_help, longest_edge_row, row, rows},
    elements::{Elements, elements_for},
    results::Results,
    solving::SolveInput,
};
#[cfg(feature = "reference")]
use crate::solver::patch_rays::{PatchRays, memory_problem};
use crate::{
    gpu::lightmap::item_buffer::{ItemBuffers, Viewpoint, weights_of},
    lightmap::{FormFactorMethod, FormFactorSettings},
    scene::AreaLight,
    solver::{
        SolveSettings,
        form_factors::{FormFactors, gauss_seidel},
        patches::Patches,
    },
};

/// Each sweep can be seen for so long: they take a moment only.
const SWEEP_SHOWN: Duration = Duration::from_millis(120);

/// How far they are is told no more often.
const TELL_EVERY: Duration = Duration::from_millis(100);

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
    pub fn start(input: FactorsInput, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
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

/// Patches, form factors between them, and irradiance of the lights that are no patches [W/m²].
type Found = (Patches, FormFactors, Vec<Vec3>);

struct Work {
    input: FactorsInput,
    stopped: Arc<AtomicBool>,
    sender: mpsc::Sender<FactorsEvent>,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Work {
    fn run(&self) -> Result<(), String> {
        let FactorsInput { shown, made_with, input, settings, .. } = &self.input;
        if let Some(problem) = settings.problem() {
            return Err(problem);
        }
        let elements = elements_for(shown, made_with, input)?;
        let patches = Patches::new(&elements.scene, &elements.tessellation);
        let light = input.light.map(|light| light.to_local(&elements.scene.frame));
        let found = match settings.by {
            #[cfg(feature = "reference")]
            FormFactorMethod::Rays => self.by_rays(&elements, patches, light)?,
            FormFactorMethod::ItemBuffers => self.by_item_buffers(&elements, patches, light.as_ref())?,
        };
        let is_stopped = || self.stopped.load(Relaxed);
        let Some((patches, factors, placed)) = found else { return Ok(()) };
        let Some(quality) = factors.quality(&is_stopped) else { return Ok(()) };
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
        let watch = |sweep, radiosity: &[Vec3], change| {
            std::thread::sleep(SWEEP_SHOWN.saturating_sub(told.elapsed()));
            told = Instant::now();
            if !is_stopped() {
                tell(&format!("sweep {sweep}, change {change:.1e}"), radiosity);
            }
            !is_stopped() && settings.goes_on(sweep, change)
        };
        gauss_seidel(&factors, &patches.emission, &patches.reflectance, &placed, &is_stopped, watch).map(|_| ())
    }

    /// Form factors by the window's device, and direct light of the placed light; none if it was stopped.
    fn by_item_buffers(
        &self,
        elements: &Elements,
        patches: Patches,
        light: Option<&AreaLight>,
    ) -> Result<Option<Found>, String> {
        let FactorsInput { device, queue, settings, .. } = &self.input;
        let weights = weights_of(settings.weights, settings.resolution);
        let drawn = (&*elements.scene, &*elements.tessellation);
        let buffers = ItemBuffers::of_elements((device, queue), drawn, settings.resolution, &weights)?;
        let Some(factors) = self.factors(&buffers, &patches)? else { return Ok(None) };
        let direct = buffers.direct_irradiance(light, &patches.areas)?;
        Ok(Some((patches, factors, direct)))
    }

    /// Form factors by rays, and direct light of all lights: the patches carry indirect light alone. None if it was stopped.
    #[cfg(feature = "reference")]
    fn by_rays(
        &self,
        elements: &Elements,
        mut patches: Patches,
        light: Option<AreaLight>,
    ) -> Result<Option<Found>, String> {
        if let Some(problem) = memory_problem(patches.areas.len(), SolveSettings::default().row_bytes()) {
            return Err(problem);
        }
        let Elements { scene, tracer, tessellation, .. } = elements;
        let rays = PatchRays::new(scene, &**tracer, tessellation, &patches, &self.input.settings);
        let direct = rays.direct_irradiance(light, &|| self.stopped.load(Relaxed));
        let tell = self.pace("rays between the patches");
        let Some((factors, _)) = rays.form_factors(&tell) else { return Ok(None) };
        patches.emission.fill(Vec3::ZERO);
        Ok(Some((patches, factors, direct)))
    }

    /// All rows; none if it was stopped.
    fn factors(&self, buffers: &ItemBuffers, patches: &Patches) -> Result<Option<FormFactors>, String> {
        let viewpoints: Vec<Viewpoint> =
            patches.places.iter().map(|(origin, normal)| Viewpoint { origin: *origin, normal: *normal }).collect();
        let tell = self.pace("hemicubes of the patches");
        let rows = buffers.all_rows(&viewpoints, &mut |done| tell(done))?;
        Ok(rows.map(|rows| FormFactors { areas: patches.areas.clone(), rows }))
    }

    /// Tells how far a stage is, some times a second; false once it is stopped.
    fn pace(&self, stage: &'static str) -> impl Fn(f32) -> bool + Sync {
        let (started, told) = (Instant::now(), AtomicU64::new(0));
        move |done: f32| {
            let now = started.elapsed();
            let due = now.as_millis() as u64 / TELL_EVERY.as_millis() as u64 + 1;
            if told.fetch_max(due, Relaxed) < due {
                let left = now.as_secs_f32() * (1.0 / done.max(1e-3) - 1.0);
                self.send(FactorsEvent::Status(format!("{stage}, {:.0} %, {left:.0} s left", 100.0 * done)));
            }
            !self.stopped.load(Relaxed)
        }
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
            choice_row(ui, "Form factors by", &help("by"), &mut settings.by);
            row(ui, "Cuts of patches", &help("subdivide"), Slider::new(&mut settings.subdivide, 0..=5));
            longest_edge_row(ui, &help("max_edge"), &mut settings.max_edge);
            #[cfg(feature = "reference")]
            if settings.by == FormFactorMethod::Rays {
                row(
                    ui,
                    "Rays a pair",
                    &help("pair_rays"),
                    Slider::new(&mut settings.pair_rays, 1..=64).logarithmic(true),
                );
                choice_row(ui, "Kernel", &help("kernel"), &mut settings.kernel);
            }
            row(ui, "Pixels", &help("resolution"), Slider::new(&mut settings.resolution, 16..=512).step_by(2.0));
            choice_row(ui, "Weights", &help("weights"), &mut settings.weights);
            row(ui, "Sweeps", &help("sweeps"), Slider::new(&mut settings.sweeps, 1..=100));
        });
        let name = if self.job.is_some() { "Stop them" } else { "Find form factors" };
        let tooltip = "Draws the hemicube of each patch with the patches' numbers, or traces rays between them, then sweeps \
                       with Gauss-Seidel; the right view shows the field after each sweep";
        let clicked = ui.button(name).on_hover_text(tooltip).clicked();
        if !self.status.is_empty() {
            ui.label(&self.status);
        }
        clicked.then_some(Command::FormFactors)
    }
}
