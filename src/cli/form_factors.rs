//! `radiosity form-factors`: form factors between patches, by rays or by item buffers, and the solution that
//! Gauss-Seidel finds with them.

use std::{
    cell::Cell,
    path::PathBuf,
    sync::{Mutex, atomic::Ordering::Relaxed},
    time::Instant,
};

use anyhow::bail;
use clap::{ArgMatches, Args};
use glam::Vec3;
use serde::Serialize;

#[cfg(feature = "gpu")]
use super::item_buffers;
use super::{
    Outcome, files,
    progress::{Progress, cancelled_by_interrupt, seconds_left},
    scene_args::{LightArgs, LoadedScene, SceneArgs},
};
use crate::{
    lightmap::{FormFactorMethod, FormFactorSettings},
    scene::{Scene, Tessellation, area_light::AreaLightState},
    solver::{
        Solution, SolutionInfo, SolveSettings,
        form_factors::{FormFactorQuality, FormFactors, gauss_seidel},
        patches::Patches,
    },
};
#[cfg(feature = "reference")]
use crate::{
    solver::patch_rays::{PatchRays, memory_problem},
    trace::Tracer,
};

/// Arguments of `radiosity form-factors`.
#[derive(Clone, Debug, Args)]
pub struct FormFactorsArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// Patches, and what lies between them.
    #[command(flatten)]
    pub settings: FormFactorSettings,
    /// A part of the device's name, as `radiosity devices` lists it; else the best one.
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// Where the solution goes (safetensors).
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Compare hemicubes of 32 to 512 pixels and both kinds of weights, row by row, instead of solving.
    #[cfg(feature = "gpu")]
    #[arg(long)]
    pub table: bool,
    /// Print a report to standard output as JSON, and no progress.
    #[arg(long)]
    pub json: bool,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct FormFactorsReport {
    /// How they were found.
    pub settings: FormFactorSettings,
    /// Patches.
    pub patches: usize,
    /// Rays between patches.
    pub rays: u64,
    /// Row sums and reciprocity.
    pub quality: FormFactorQuality,
    /// Seconds to cut the patches, and for the ray tracer's tree.
    pub build_seconds: f64,
    /// Seconds for all form factors, and for direct light.
    pub factor_seconds: f64,
    /// Seconds for all sweeps.
    pub sweep_seconds: f64,
    /// The largest change of each sweep, relative to the mean radiosity.
    pub changes: Vec<f64>,
}

/// What is to be solved, and how.
pub(super) struct Task<'a> {
    pub(super) loaded: &'a LoadedScene,
    pub(super) light: Option<AreaLightState>,
    pub(super) settings: &'a FormFactorSettings,
    /// A part of the name of the device for item buffers.
    #[cfg(feature = "gpu")]
    pub(super) device: Option<&'a str>,
}

/// The patches of a scene.
pub(super) struct Elements<'a> {
    pub(super) scene: &'a Scene,
    pub(super) tessellation: Tessellation,
    pub(super) patches: Patches,
}

/// Form factors, and what else Gauss-Seidel takes.
pub(super) struct Found {
    pub(super) patches: Patches,
    pub(super) tessellation: Tessellation,
    pub(super) factors: FormFactors,
    /// Irradiance of the lights that are no patches [W/m²].
    pub(super) direct: Vec<Vec3>,
    /// Rays between patches.
    pub(super) rays: u64,
    /// Seconds for the ray tracer's tree.
    pub(super) tree_seconds: f64,
}

/// Gets the part of a stage that is done, and what it is, from any thread; stops the work by returning false.
pub(super) type Watch<'a> = dyn Fn(f32, &str) -> bool + Sync + 'a;

/// Runs the command.
pub fn run(args: &FormFactorsArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    if let Some(problem) = args.settings.problem() {
        bail!("{problem}");
    }
    if let Some(path) = &args.output {
        files::check_writable(path)?;
    }
    let loaded = args.scene.load(matches)?;
    #[cfg(feature = "gpu")]
    if args.table {
        return item_buffers::print_table(&Elements::new(&loaded.scene, &args.settings)?, args.device.as_deref());
    }
    let task = Task {
        loaded: &loaded,
        light: args.light.over(loaded.state.light)?,
        settings: &args.settings,
        #[cfg(feature = "gpu")]
        device: args.device.as_deref(),
    };
    let (cancelled, progress) = (cancelled_by_interrupt(), Mutex::new(Progress::new(args.json)));
    let watch = |done: f32, line: &str| {
        if let Ok(mut progress) = progress.lock() {
            progress.update(done, line);
        }
        !cancelled.load(Relaxed)
    };
    let solved = solve(&task, &watch)?;
    let finish = |line: &str| progress.into_inner().into_iter().for_each(|progress| progress.finish(line));
    let Some((report, solution)) = solved else {
        finish("cancelled: there is nothing to keep yet");
        return Ok(Outcome::Cancelled);
    };
    let is_complete = solution.info.complete;
    finish(if is_complete { "done" } else { "cancelled: what was computed is kept" });
    if let Some(path) = &args.output {
        files::write_solution(path, &solution)?;
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print_summary(&report);
    }
    Ok(if is_complete { Outcome::Done } else { Outcome::Cancelled })
}

/// Finds form factors and sweeps; none if it was stopped before the first sweep.
pub(super) fn solve(task: &Task<'_>, watch: &Watch<'_>) -> anyhow::Result<Option<(FormFactorsReport, Solution)>> {
    let settings = task.settings;
    let started = Instant::now();
    let elements = Elements::new(&task.loaded.scene, settings)?;
    let element_seconds = started.elapsed().as_secs_f64();
    let with_time =
        |done: f32, stage: &str| watch(done, &format!("{stage}, {:.0} s left", seconds_left(started, done)));
    let found = match settings.by {
        #[cfg(feature = "reference")]
        FormFactorMethod::Rays => by_rays(task, elements, &with_time)?,
        #[cfg(feature = "gpu")]
        FormFactorMethod::ItemBuffers => item_buffers::find(task, elements, &with_time)?,
        #[cfg(not(feature = "gpu"))]
        FormFactorMethod::ItemBuffers => bail!("this program was built without graphics; take --by rays"),
    };
    let Some(Found { patches, tessellation, factors, direct, rays, tree_seconds }) = found else { return Ok(None) };
    let build_seconds = element_seconds + tree_seconds;
    let factor_seconds = started.elapsed().as_secs_f64() - build_seconds;
    let part = Cell::new(0.0);
    let is_cancelled = || !watch(part.get(), "sweeps");
    let Some(quality) = factors.quality(&is_cancelled) else { return Ok(None) };
    let started = Instant::now();
    let mut changes = Vec::new();
    let after_sweep = |sweep, _: &[Vec3], change| {
        changes.push(change);
        part.set(sweep as f32 / settings.sweeps as f32);
        watch(part.get(), &format!("sweep {sweep}: change {change:.2e}")) && settings.goes_on(sweep, change)
    };
    let radiosity =
        gauss_seidel(&factors, &patches.emission, &patches.reflectance, &direct, &is_cancelled, after_sweep);
    let radiosity = radiosity.map_err(anyhow::Error::msg)?;
    let sweep_seconds = started.elapsed().as_secs_f64();
    let fields = patches.irradiance_at_vertices(&tessellation, &factors, &direct, &radiosity);
    let report = FormFactorsReport {
        settings: settings.clone(),
        patches: patches.areas.len(),
        rays,
        quality,
        build_seconds,
        factor_seconds,
        sweep_seconds,
        changes,
    };
    let solution = solution(task, &tessellation, fields, !is_cancelled());
    Ok(Some((report, solution)))
}

/// Rays between all pairs. The lights shine on the patches' centres, so that patches carry indirect light alone.
#[cfg(feature = "reference")]
fn by_rays(task: &Task<'_>, elements: Elements<'_>, watch: &Watch<'_>) -> anyhow::Result<Option<Found>> {
    let Elements { scene, tessellation, mut patches } = elements;
    if let Some(problem) = memory_problem(patches.areas.len(), SolveSettings::default().row_bytes()) {
        bail!("{problem}");
    }
    let started = Instant::now();
    let tracer = Tracer::new(std::sync::Arc::clone(&task.loaded.scene));
    let tree_seconds = started.elapsed().as_secs_f64();
    let rays = PatchRays::new(scene, &tracer, &tessellation, &patches, task.settings);
    let light = task.light.map(|light| light.to_local(&scene.frame));
    let direct = rays.direct_irradiance(light, &|| !watch(0.0, "direct light"));
    let found = rays.form_factors(&|done| watch(done, "rays between patches"));
    patches.emission.fill(Vec3::ZERO);
    Ok(found.map(|(factors, rays)| Found { patches, tessellation, factors, direct, rays, tree_seconds }))
}

impl<'a> Elements<'a> {
    pub(super) fn new(scene: &'a Scene, settings: &FormFactorSettings) -> anyhow::Result<Self> {
        let settings = even(settings);
        if let Some(problem) = settings.problem() {
            bail!("{problem}");
        }
        let tessellation = Tessellation::new(scene, &settings.tessellation()).map_err(anyhow::Error::msg)?;
        Ok(Self { patches: Patches::new(scene, &tessellation), scene, tessellation })
    }
}

fn even(settings: &FormFactorSettings) -> SolveSettings {
    SolveSettings { subdivide: settings.subdivide, max_edge: settings.max_edge, ..SolveSettings::even() }
}

/// Direct and all other irradiance at the vertices as a solution.
fn solution(task: &Task<'_>, tessellation: &Tessellation, fields: [Vec<Vec3>; 2], complete: bool) -> Solution {
    let scene = &task.loaded.scene;
    Solution {
        info: SolutionInfo {
            scene_name: scene.name.clone(),
            scene_hash: scene.hash(),
            tessellation_hash: tessellation.hash(),
            load: task.loaded.load.clone(),
            settings: even(task.settings),
            light: task.light,
            program_version: String::from(env!("CARGO_PKG_VERSION")),
            complete,
        },
        bounces: fields.into(),
        buried: vec![false; tessellation.mesh.positions.len()],
        cuts: Vec::new(),
    }
}

fn print_summary(report: &FormFactorsReport) {
    let FormFactorQuality { entries, least_row_sum, mean_row_sum, greatest_row_sum, reciprocity_error } =
        report.quality;
    let found_by = match report.settings.by {
        #[cfg(feature = "reference")]
        FormFactorMethod::Rays => format!("{} rays", report.rays),
        FormFactorMethod::ItemBuffers => format!("{} pixels", report.settings.resolution),
    };
    println!("patches    {} with {entries} form factors, {found_by}", report.patches);
    println!("row sums   {least_row_sum:.4} to {greatest_row_sum:.4}, mean {mean_row_sum:.4} (1 in a closed scene)");
    println!("reciprocity A_i F_ij and A_j F_ji differ by {:.3} %", 100.0 * reciprocity_error);
    println!("sweeps     {}; changes {}", report.changes.len(), changes(&report.changes));
    println!("seconds    {:.3} form factors, {:.3} sweeps", report.factor_seconds, report.sweep_seconds);
}

fn changes(changes: &[f64]) -> String {
    changes.iter().take(6).map(|change| format!("{change:.1e}")).collect::<Vec<_>>().join(", ")
}
