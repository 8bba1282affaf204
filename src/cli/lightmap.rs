//! `radiosity lightmap`: a scene's lightmap, solved on the graphics card, as files for other programs.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    time::Instant,
};

use anyhow::bail;
use clap::{ArgMatches, Args};
use serde::Serialize;

use super::{
    Outcome,
    progress::{Progress, cancelled_by_interrupt, seconds_left},
    scene_args::{LightArgs, LoadedScene, SceneArgs},
};
use crate::{
    files::{
        atlas_cache::AtlasCache,
        lightmap_export::{SOLUTION_NAME, write_lightmap},
    },
    gpu::{
        device::{self, FoundDevice},
        lightmap::{GpuSolver, timing::PassTime},
    },
    lightmap::{Atlas, GpuSettings, LightmapSettings, pages_of},
    scene::area_light::AreaLightState,
    solver::{LightmapSolution, lightmap_solution::LightmapInfo},
    trace::Tracer,
    transport::facing::facing,
};

/// Arguments of `radiosity lightmap`.
#[derive(Clone, Debug, Args)]
pub struct LightmapArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// How fine the map is.
    #[command(flatten, next_help_heading = "Lightmap")]
    pub map: LightmapSettings,
    /// How it is solved.
    #[command(flatten, next_help_heading = "Solving")]
    pub settings: GpuSettings,
    /// A part of the device's name, as `radiosity devices` lists it; else the best one.
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// Unwrap and measure anew, and keep nothing for the next time.
    #[arg(long)]
    pub no_cache: bool,
    /// The folder that the files go to: the solution, each page as EXR and PNG, the scene as OBJ.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Print a report to standard output as JSON, and no progress.
    #[arg(long)]
    pub json: bool,
}

/// What a solve reports.
#[derive(Clone, Debug, Serialize)]
pub struct LightmapReport {
    /// What was solved.
    pub info: LightmapInfo,
    /// The device.
    pub device: String,
    /// Texels along a page's sides.
    pub page_size: [u32; 2],
    /// Pages.
    pub pages: u32,
    /// Texels that light arrives at.
    pub texels: usize,
    /// Groups of them that shoot as one.
    pub groups: usize,
    /// Shooters in all.
    pub shooters: u64,
    /// Batches of shooters that were chosen together.
    pub batches: u64,
    /// Submissions to the device.
    pub submissions: u64,
    /// Memory on the device, in MiB.
    pub device_mebibytes: u64,
    /// Seconds to unwrap and measure the texels.
    pub atlas_seconds: f64,
    /// Seconds to solve.
    pub solve_seconds: f64,
    /// The longest submission, in seconds.
    pub longest_submission_seconds: f64,
    /// What each pass took on the device, if that has a clock.
    pub passes: Option<Vec<PassTime>>,
    /// Fraction of the emitted power that is unabsorbed.
    pub unabsorbed: f64,
    /// Fraction that left the scene.
    pub escaped: f64,
    /// Fraction that met back faces.
    pub on_backs: f64,
    /// (absorbed + escaped + on backs + unabsorbed) / emitted - 1.
    pub balance: f64,
}

/// Runs the command.
pub fn run(args: &LightmapArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    if let Some(problem) = args.map.problem().or_else(|| args.settings.problem()) {
        bail!("{problem}");
    }
    check_folder(&args.output)?;
    let device = device::choose(args.device.as_deref()).map_err(anyhow::Error::msg)?;
    let loaded = args.scene.load(matches)?;
    let light = args.light.over(loaded.state.light)?;
    let cancelled = cancelled_by_interrupt();
    let mut progress = Progress::new(args.json);
    let tracer = Tracer::new(Arc::clone(&loaded.scene));
    let local_light = light.map(|light| light.to_local(&loaded.scene.frame));
    if let Some(facing) = facing(&loaded.scene, &tracer, local_light.as_ref(), &loaded.load) {
        eprintln!("warning: {}", facing.text);
    }
    let started = Instant::now();
    let Some(atlas) = unwrap_with_progress(&loaded, &tracer, args, &cancelled)? else {
        eprintln!("cancelled: there is nothing to keep yet");
        return Ok(Outcome::Cancelled);
    };
    let atlas_seconds = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let opened = device.open().map_err(anyhow::Error::msg)?;
    let solver = GpuSolver::new((&opened.0, &opened.1), &loaded.scene, &atlas, local_light.as_ref(), &args.settings);
    let mut solver = solver.map_err(anyhow::Error::msg)?;
    while !solver.is_done() && !cancelled.load(Relaxed) {
        solver.submit().map_err(anyhow::Error::msg)?;
        show(&mut progress, &solver, started);
    }
    let complete = solver.is_done();
    progress.finish(if complete { "done" } else { "cancelled: what was computed is kept" });
    let solution = solution(&loaded, args, light, &atlas, &solver, complete)?;
    let solve_seconds = started.elapsed().as_secs_f64();
    write_lightmap(&args.output, &loaded.scene, &solution, &loaded.tone_map)?;
    let ledger = *solver.ledger();
    let (size, (submissions, longest)) = (solver.size(), solver.submissions());
    let report = LightmapReport {
        info: solution.info,
        device: name(&device),
        page_size: solution.charts.page_size,
        pages: solution.charts.page_count,
        texels: size.texels,
        groups: size.groups,
        shooters: ledger.shooters,
        batches: ledger.batches,
        submissions,
        device_mebibytes: size.bytes.div_ceil(1 << 20),
        atlas_seconds,
        solve_seconds,
        longest_submission_seconds: longest.as_secs_f64(),
        passes: solver.pass_times(),
        unabsorbed: ledger.unabsorbed(),
        escaped: ledger.escaped_part(),
        on_backs: ledger.part_on_backs(),
        balance: ledger.balance(),
    };
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print_summary(&report, &args.output);
    }
    Ok(if complete { Outcome::Done } else { Outcome::Cancelled })
}

fn name(device: &FoundDevice) -> String {
    format!("{} [{}]", device.info.name, device.info.backend)
}

/// Fails now if the files could not be written later.
fn check_folder(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|problem| anyhow::anyhow!("{}: the folder cannot be made: {problem}", folder.display()))?;
    super::files::check_writable(&folder.join(SOLUTION_NAME))
}

/// The atlas; `None` if it was cancelled.
fn unwrap_with_progress(
    loaded: &LoadedScene,
    tracer: &Tracer,
    args: &LightmapArgs,
    cancelled: &AtomicBool,
) -> anyhow::Result<Option<Atlas>> {
    let progress = std::sync::Mutex::new(Progress::new(args.json));
    let report = |stage: &str, fraction: Option<f32>| {
        if let Ok(mut progress) = progress.lock() {
            progress.update(fraction.unwrap_or(0.0), stage);
        }
        !cancelled.load(Relaxed)
    };
    let cache = AtlasCache::of_user().filter(|_| !args.no_cache);
    let found = match cache {
        Some(cache) => cache.atlas(&loaded.scene, tracer, &args.map, &report),
        None => Atlas::new(&loaded.scene, tracer, &args.map, &report).map(|made| made.map(|atlas| (atlas, false))),
    };
    let found = found.map_err(anyhow::Error::msg)?;
    if let Ok(progress) = progress.into_inner() {
        progress.finish(match &found {
            Some((_, true)) => "lightmap coordinates and texels were kept from last time",
            Some((_, false)) => "lightmap coordinates and texels are ready",
            None => "",
        });
    }
    Ok(found.map(|(atlas, _)| atlas))
}

fn show(progress: &mut Progress, solver: &GpuSolver, started: Instant) {
    let (ledger, fraction) = (solver.ledger(), solver.fraction());
    let seconds = started.elapsed().as_secs_f64();
    let left = seconds_left(started, fraction);
    let text = format!(
        "{} shooters, {:.0} a second, {left:.0} s left, {:.2} % unabsorbed",
        ledger.shooters,
        ledger.shooters as f64 / seconds,
        100.0 * ledger.unabsorbed()
    );
    progress.update(fraction, &text);
}

fn solution(
    loaded: &LoadedScene,
    args: &LightmapArgs,
    light: Option<AreaLightState>,
    atlas: &Atlas,
    solver: &GpuSolver,
    complete: bool,
) -> anyhow::Result<LightmapSolution> {
    let fields = solver.fields().map_err(anyhow::Error::msg)?;
    let pages = |values: &[glam::Vec3]| pages_of(&atlas.charts, &atlas.texels, values);
    Ok(LightmapSolution {
        info: LightmapInfo {
            scene_name: loaded.scene.name.clone(),
            scene_hash: loaded.scene.hash(),
            load: loaded.load.clone(),
            map: args.map.clone(),
            settings: args.settings.clone(),
            light,
            program_version: String::from(env!("CARGO_PKG_VERSION")),
            complete,
        },
        charts: atlas.charts.clone(),
        direct: pages(&fields.direct),
        total: pages(&fields.total),
    })
}

fn print_summary(report: &LightmapReport, folder: &Path) {
    let [width, height] = report.page_size;
    println!("lightmap   {} texels on {} pages of {width} × {height}", report.texels, report.pages);
    println!("device     {}", report.device);
    println!("memory     {} MiB on the device", report.device_mebibytes);
    println!("shooters   {} in {} batches; {} groups of texels", report.shooters, report.batches, report.groups);
    println!(
        "seconds    {:.3} atlas, {:.3} solve; the longest of {} submissions {:.3}",
        report.atlas_seconds, report.solve_seconds, report.submissions, report.longest_submission_seconds
    );
    for PassTime { pass, runs, seconds } in report.passes.iter().flatten() {
        println!("           {seconds:.3} {pass}, {runs} times");
    }
    println!(
        "power      {:.2} % unabsorbed, {:.2} % escaped, {:.2} % on back faces, balance {:+.3} %",
        100.0 * report.unabsorbed,
        100.0 * report.escaped,
        100.0 * report.on_backs,
        100.0 * report.balance
    );
    println!("files      {}", folder.join(SOLUTION_NAME).display());
}
