//! `radiosity solve`: from a scene to a solution file.

use std::{
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context as _, bail};
use clap::{ArgMatches, Args};
use serde::Serialize;

use super::{
    Outcome, files, only_vertex,
    progress::Progress,
    scene_args::{LightArgs, LoadedScene, SceneArgs},
};
use crate::{
    scene::{Tessellation, area_light::AreaLightState},
    solver::{self, Iteration, Job, Message, Problem, Solution, SolutionInfo, SolveReport, SolveSettings, Stage},
    trace::Tracer,
};

/// Arguments of `radiosity solve`.
#[derive(Clone, Debug, Args)]
pub struct SolveArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// The settings.
    #[command(flatten, next_help_heading = "Solving")]
    pub settings: SolveSettings,
    /// Print every ray that the functions of src/student trace for this vertex (in the bounce of `--bounce`), and no more.
    #[arg(long, value_name = "VERTEX", conflicts_with_all = ["output", "report", "json"])]
    pub only_vertex: Option<u32>,
    /// The bounce of `--only-vertex`; 0 is direct light.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "only_vertex")]
    pub bounce: u32,
    /// Threads to use; 0 for all cores. Any number gives the same bits.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Where the solution goes (safetensors).
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Where a report goes (JSON): seconds by stage, rays, skipped work, the energy ledger.
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Print the report to standard output as JSON, and no progress.
    #[arg(long)]
    pub json: bool,
}

/// What a solve reports to people and machines.
#[derive(Serialize)]
pub struct FullReport<'a> {
    /// What was solved.
    pub info: &'a SolutionInfo,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Elements and vertices that carry the solution.
    pub elements: usize,
    /// Vertices.
    pub vertices: usize,
    /// Threads.
    pub threads: usize,
    /// Seconds to build the tree and the elements.
    pub build_seconds: f64,
    /// Bounces, direct light included.
    pub bounces: usize,
    /// What is to be said of the sides that light meets.
    pub facing: Option<&'a str>,
    /// What the solver did.
    pub solve: &'a SolveReport,
}

/// A solve that has ended, with what it was made of.
pub struct Solved {
    /// The ray tracer.
    pub tracer: Arc<Tracer>,
    /// The elements.
    pub tessellation: Arc<Tessellation>,
    /// The solution, whole or partial.
    pub solution: Solution,
    /// What the solver did.
    pub report: SolveReport,
    /// Seconds to build the tree and the elements.
    pub build_seconds: f64,
    /// What is to be said of the sides that light meets.
    pub facing: Option<String>,
}

/// Runs the command.
pub fn run(args: &SolveArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    for path in args.output.iter().chain(&args.report) {
        files::check_writable(path)?;
    }
    if args.output.is_none() && !args.json && args.only_vertex.is_none() {
        eprintln!("note: the solution will not be saved; give -o FILE to save it");
    }
    let (loaded, settings) = args.scene.load_for_solve(&args.settings, matches)?;
    let light = args.light.over(loaded.state.light)?;
    if let Some(vertex) = args.only_vertex {
        return only_vertex::run(&loaded, light, settings, vertex, args.bounce);
    }
    let solved = solve_with_progress(&loaded, light, settings, args.threads, args.json)?;
    if let Some(path) = &args.output {
        files::write_solution(path, &solved.solution)?;
    }
    let report = full_report(&loaded, &solved, args.threads);
    let json = serde_json::to_string_pretty(&report).context("the report")?;
    if let Some(path) = &args.report {
        files::write_atomically(path, |writer| Ok(writer.write_all(json.as_bytes())?))?;
    }
    if args.json {
        println!("{json}");
    } else {
        print_summary(&report);
        if let Some(path) = &args.output {
            println!("solution   {}", path.display());
        }
    }
    Ok(if solved.solution.info.complete { Outcome::Done } else { Outcome::Cancelled })
}

/// The report of a solve.
pub fn full_report<'a>(loaded: &LoadedScene, solved: &'a Solved, threads: usize) -> FullReport<'a> {
    FullReport {
        info: &solved.solution.info,
        triangles: loaded.scene.mesh.triangles.len(),
        elements: solved.tessellation.mesh.triangles.len(),
        vertices: solved.tessellation.mesh.positions.len(),
        threads: if threads == 0 { rayon::current_num_threads() } else { threads },
        build_seconds: solved.build_seconds,
        bounces: solved.solution.bounces.len(),
        facing: solved.facing.as_deref(),
        solve: &solved.report,
    }
}

/// Builds, solves and shows progress. Ctrl-C ends the solve and keeps what it has; a second one ends the program.
pub fn solve_with_progress(
    loaded: &LoadedScene,
    light: Option<AreaLightState>,
    settings: SolveSettings,
    threads: usize,
    quiet: bool,
) -> anyhow::Result<Solved> {
    if let Some(problem) = settings.problem() {
        bail!("{problem}");
    }
    let started = Instant::now();
    let tracer = Arc::new(Tracer::new(Arc::clone(&loaded.scene)));
    if light.is_none() && loaded.scene.emissive_triangles().next().is_none() {
        eprintln!("warning: nothing shines in this scene; place a light with --light-centre and the like, or --state");
    }
    let (scene, load) = (Arc::clone(&loaded.scene), loaded.load.clone());
    let problem = Problem::new(scene, tracer.clone(), load, light, settings).map_err(anyhow::Error::msg)?;
    let build_seconds = started.elapsed().as_secs_f64();
    if let Some(remark) = problem.remark() {
        eprintln!("warning: {remark}");
    }
    let facing = problem.facing().map(|facing| facing.text);
    if let Some(text) = &facing {
        eprintln!("warning: {text}");
    }
    let job = Job::start(problem, threads).context("the solver's threads could not be started")?;
    cancel_on_interrupt(&job);
    let mut progress = Progress::new(quiet);
    while !job.is_finished() {
        if let Some(message) = job.next_message(Duration::from_millis(50)) {
            show(&message, &mut progress);
        }
    }
    job.messages().for_each(|message| show(&message, &mut progress));
    let solved = job.finish().context("the solver stopped by an error of its own; please report it")?;
    let solver::Solved { solution, report, tessellation, .. } = solved;
    progress.finish(if solution.info.complete { "done" } else { "cancelled: what was computed is kept" });
    Ok(Solved { tracer, tessellation, solution, report, build_seconds, facing })
}

fn cancel_on_interrupt(job: &Job) {
    let monitor = Arc::clone(job.monitor());
    let installed = ctrlc::set_handler(move || {
        if monitor.is_cancelled() {
            std::process::exit(130);
        }
        monitor.cancel();
    });
    if let Err(problem) = installed {
        eprintln!("warning: Ctrl-C will end the program without keeping the result: {problem}");
    }
}

fn show(message: &Message, progress: &mut Progress) {
    match message {
        Message::Progress(state) => {
            let stage = match state.stage {
                Stage::Bouncing => format!("bounce {}", state.bounce),
                stage => stage.to_string(),
            };
            let text = format!(
                "{stage}, {:.2} Mrays/s, {:.0} s left, {:.2} % unabsorbed",
                state.rays_per_second * 1e-6,
                state.seconds_left,
                100.0 * state.unabsorbed
            );
            progress.update(state.fraction, &text);
        }
        Message::Bounce { index, power, .. } => {
            let [red, green, blue] = power.arriving.to_array();
            progress.line(&format!("bounce {index:2}: {red:.4} {green:.4} {blue:.4} W arriving"));
        }
        Message::Fault(fault) => progress.line(&format!("src/student: {fault}")),
        Message::Elements(_) | Message::SamplingError(_) => {}
    }
}

/// What was not done, as far as there is something.
fn print_skipped(solve: &SolveReport) {
    for (number, line) in solve.skipped().into_iter().enumerate() {
        println!("{}{line}", if number == 0 { "skipped    " } else { "           " });
    }
}

/// Prints the summary that a person reads.
pub fn print_summary(report: &FullReport) {
    let solve = report.solve;
    let thread_seconds = solve.gather_thread_seconds + solve.direct_thread_seconds;
    println!("scene      {}: {} triangles", report.info.scene_name, report.triangles);
    println!("elements   {} with {} vertices, {} buried", report.elements, report.vertices, solve.buried_vertices);
    if !solve.holes.is_empty() {
        println!("holes      {} vertices, for want of a usable value from src/student", solve.holes.len());
    }
    if solve.gathered_vertices > 0 {
        println!(
            "following  {:.3} s to follow the light, {:.3} of it direct light; rays gathered at {} vertices",
            solve.seconds_adapting, solve.seconds_following_direct, solve.gathered_vertices
        );
    }
    let (count, kind) = match solve.energy.iteration {
        Iteration::Neumann => (report.bounces as u32, "(bounce 0 is direct light)"),
        _ => (solve.iterations, "sweeps"),
    };
    println!("bounces    {count} {kind}, {:.3} % unabsorbed; {}", 100.0 * solve.unabsorbed, solve.ended_by);
    println!(
        "rays       {} gather, {} shadow; {} and {} needed no tracing",
        solve.gather_rays, solve.shadow_rays, solve.gather_rays_skipped, solve.shadow_rays_skipped
    );
    print_skipped(solve);
    println!(
        "seconds    {:.3} build, {:.3} solve on {} threads ({:.0} % gather, {:.0} % direct; bounces {:.3})",
        report.build_seconds,
        solve.seconds,
        report.threads,
        100.0 * solve.gather_thread_seconds / thread_seconds.max(1e-9),
        100.0 * solve.direct_thread_seconds / thread_seconds.max(1e-9),
        solve.bounce_seconds
    );
    let emitted = solve.energy.emitted.element_sum();
    let absorbed: f64 = solve.energy.bounces.iter().map(|bounce| bounce.absorbed.element_sum()).sum();
    let escaped: f64 = solve.energy.bounces.iter().map(|bounce| bounce.escaped.element_sum()).sum();
    println!(
        "power      {emitted:.4} W emitted (all bands): {:.2} % absorbed, {:.2} % escaped",
        100.0 * absorbed / emitted.max(1e-30),
        100.0 * escaped / emitted.max(1e-30)
    );
    if let Some(text) = report.facing {
        println!("           {text}");
    }
}
