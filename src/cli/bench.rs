//! `radiosity bench`: seconds against error, for ways to solve a scene whose truth is known.

use std::{
    ops::RangeInclusive,
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use anyhow::{Context as _, ensure};
use clap::{ArgMatches, Args, ValueEnum};
use serde::Serialize;

use super::{
    Outcome,
    files::{
        self,
        error_plot::{Curve, write_error_plot},
        truth_comparison::compare_with_truth,
    },
    form_factors::{self, Task},
    scene_args::{LightArgs, LoadedScene, SceneArgs},
};
use crate::{
    check::{
        metrics::PartErrors,
        truth_file::{self, TruthFile},
    },
    lightmap::{FormFactorMethod, FormFactorSettings},
    scene::{Scene, Tessellation, area_light::AreaLightState},
    solver::{Engine, Monitor, Problem, Reconstruction, Reconstructor, Solution, SolveSettings, Solved, solve},
    trace::Tracer,
};

/// A way to solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The program's engine on elements that follow the light.
    #[default]
    Follow,
    /// The program's engine on triangles that are cut evenly.
    Even,
    /// The assignment's engine, by the functions of `src/student`, eight bounces.
    Student,
    /// Constant patches, cut by their longest edge; form factors by one ray a pair; Gauss-Seidel: the oldest way.
    Patches,
}

/// The longest edges of the patches, as parts of the scene's largest extent. Cut so, the Cornell box has 196, 344, 464,
/// 784, 1,600, 3,136 and 6,400 patches.
const PATCH_EDGES: [f64; 7] = [0.45, 0.35, 0.28, 0.23, 0.16, 0.11, 0.08];

/// Even elements that a budget may ask for: fewer show nothing, more take minutes.
const EVEN_ELEMENTS: RangeInclusive<u64> = 400..=2_000_000;

/// What a method is run with.
enum Budget {
    /// By the solver.
    Solve(SolveSettings),
    /// By patches.
    Patches(FormFactorSettings),
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Self::Follow => "elements that follow the light",
            Self::Even => "even elements",
            Self::Student => "the assignment's method",
            Self::Patches => "patches, one ray a pair",
        }
    }

    /// Settings from cheap to dear: what each is called, and what it is.
    fn budgets(self, scene: &Scene) -> Vec<(String, Budget)> {
        let base = SolveSettings { unabsorbed: 1e-3, ..SolveSettings::even() };
        let even = |engine: Engine, bounces: Option<u32>| {
            move |(subdivide, rays): (u32, u32)| {
                let settings = SolveSettings { subdivide, rays, bounces, engine, ..base.clone() };
                (format!("subdivide {subdivide}, {rays} rays"), Budget::Solve(settings))
            }
        };
        let triangles = scene.mesh.triangles.len() as u64;
        let suits = |&(subdivide, _): &(u32, u32)| EVEN_ELEMENTS.contains(&(triangles << (2 * subdivide)));
        let follow = |(error, rays)| {
            let settings = SolveSettings { adaptive: error, rays, unabsorbed: 1e-3, ..Default::default() };
            (format!("error {error}, {rays} rays"), Budget::Solve(settings))
        };
        let (least, greatest) = scene.bounds_in_metres();
        let patches = |part: f64| {
            let metres = part * (greatest - least).max_element();
            let settings = FormFactorSettings {
                by: FormFactorMethod::Rays,
                subdivide: 0,
                max_edge: Some(metres),
                sweeps: 100,
                ..Default::default()
            };
            (format!("edges up to {metres:.3} m"), Budget::Patches(settings))
        };
        match self {
            Self::Follow => {
                [(0.2, 64), (0.1, 64), (0.05, 128), (0.03, 256), (0.02, 512), (0.01, 512)].map(follow).into()
            }
            Self::Even => {
                let cuts = [(0, 64), (0, 256), (1, 256), (2, 64), (3, 128), (4, 256), (4, 1024), (5, 1024)];
                cuts.into_iter().filter(suits).map(even(Engine::Reference, None)).collect()
            }
            Self::Student => {
                let cuts = [(0, 64), (0, 256), (2, 64), (3, 64), (4, 64), (4, 256)];
                cuts.into_iter().filter(suits).map(even(Engine::Student, Some(8))).collect()
            }
            Self::Patches => PATCH_EDGES.map(patches).into(),
        }
    }
}

/// Arguments of `radiosity bench`.
///
/// Each method is run with several budgets, each several times. The folder gets `bench.csv`, with the median's seconds by
/// stage, rays, bytes and errors, and a plot of error against seconds, `bench.svg` and `bench.png`. Seconds are those of
/// tree, elements and solve; reading files is left out, and so is merging flat neighbours, which is done for all methods.
/// Errors are relative L2 over the truth's lit points, as in `compare`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// Irradiance at points: a file by `truth`.
    #[arg(long, value_name = "FILE")]
    pub truth: PathBuf,
    /// Take this method alone; may be given more than once.
    #[arg(long = "method", value_enum)]
    pub methods: Vec<Method>,
    /// How often each is run; the median counts.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeat: u32,
    /// Where the files go; made if it is not there.
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
}

/// One line of the table.
#[derive(Clone, Debug, Default, Serialize)]
struct Line {
    method: Method,
    budget: String,
    vertices: usize,
    elements: usize,
    gathered_vertices: u64,
    seconds: f64,
    seconds_tree_and_elements: f64,
    seconds_following: f64,
    seconds_bounces: f64,
    gather_rays: u64,
    shadow_rays: u64,
    rays_skipped: u64,
    row_bytes: u64,
    error_vertex: f64,
    bias_vertex: f64,
    error_point_direct: f64,
    bias_point_direct: f64,
    threads: usize,
    processor: &'static str,
    version: &'static str,
}

/// Runs the command.
///
/// # Errors
/// Bad input, or files that cannot be written.
pub fn run(args: &BenchArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    let loaded = args.scene.load_merged(matches)?;
    let light = args.light.over(loaded.state.light)?;
    let truth = truth_file::read(&args.truth)?;
    std::fs::create_dir_all(&args.output).with_context(|| format!("{}: cannot be made", args.output.display()))?;
    let table = args.output.join("bench.csv");
    files::check_writable(&table)?;
    let wanted = |method: &Method| args.methods.is_empty() || args.methods.contains(method);
    let mut lines = Vec::new();
    println!("{:60} vertices  seconds    error     bias  error, direct light at the point", "");
    for method in Method::value_variants().iter().copied().filter(wanted) {
        for (budget, settings) in method.budgets(&loaded.scene) {
            let run = |_| match &settings {
                Budget::Solve(settings) => by_solver(&loaded, light, settings),
                Budget::Patches(settings) => by_patches(&loaded, light, settings),
            };
            let mut runs = match (0..args.repeat).map(run).collect::<anyhow::Result<Vec<Run>>>() {
                Ok(runs) => runs,
                Err(problem) => {
                    eprintln!("left out   {}, {budget}: {problem}", method.name());
                    continue;
                }
            };
            runs.sort_by(|a, b| a.line.seconds.total_cmp(&b.line.seconds));
            let median = runs.swap_remove(runs.len() / 2);
            let line = line(&loaded, (method, budget), median, (&truth, &args.truth))?;
            println!("{}", row(&line));
            lines.push(line);
        }
    }
    ensure!(!lines.is_empty(), "{}: no method could be run", args.scene.scene.display());
    write_table(&table, &lines)?;
    write_error_plot(&args.output.join("bench"), &loaded.scene.name, &curves(&lines))?;
    println!("written    {}, bench.svg and bench.png", table.display());
    Ok(Outcome::Done)
}

fn row(line: &Line) -> String {
    format!(
        "{:31} {:28} {:8} {:8.3} {:7.2} % {:+6.2} % {:7.2} %",
        line.method.name(),
        line.budget,
        line.vertices,
        line.seconds,
        100.0 * line.error_vertex,
        100.0 * line.bias_vertex,
        100.0 * line.error_point_direct
    )
}

/// What one run brings home; its line still lacks the errors.
struct Run {
    line: Line,
    solution: Solution,
    tessellation: Arc<Tessellation>,
}

fn by_solver(loaded: &LoadedScene, light: Option<AreaLightState>, settings: &SolveSettings) -> anyhow::Result<Run> {
    let started = Instant::now();
    let tracer = Arc::new(Tracer::new(Arc::clone(&loaded.scene)));
    let scene = Arc::clone(&loaded.scene);
    let problem = Problem::new(scene, tracer, loaded.load.clone(), light, settings.clone());
    let problem = problem.map_err(anyhow::Error::msg)?;
    let seconds_tree_and_elements = started.elapsed().as_secs_f64();
    let Solved { solution, report, tessellation, .. } = solve(&problem, &Monitor::new(&problem.tessellation, None));
    let line = Line {
        seconds: started.elapsed().as_secs_f64(),
        seconds_tree_and_elements,
        seconds_following: report.seconds_adapting,
        seconds_bounces: report.bounce_seconds,
        gathered_vertices: report.gathered_vertices,
        gather_rays: report.gather_rays,
        shadow_rays: report.shadow_rays,
        rays_skipped: report.gather_rays_skipped + report.shadow_rays_skipped,
        row_bytes: report.row_bytes,
        ..Default::default()
    };
    Ok(Run { line, solution, tessellation })
}

fn by_patches(
    loaded: &LoadedScene,
    light: Option<AreaLightState>,
    settings: &FormFactorSettings,
) -> anyhow::Result<Run> {
    let task = Task {
        loaded,
        light,
        settings,
        #[cfg(feature = "gpu")]
        device: None,
    };
    let (report, solution) = form_factors::solve(&task, &|_, _| true)?.context("it was stopped")?;
    let tessellation = Tessellation::new(&loaded.scene, &solution.info.settings.tessellation());
    let line = Line {
        seconds: report.build_seconds + report.factor_seconds + report.sweep_seconds,
        seconds_tree_and_elements: report.build_seconds,
        seconds_bounces: report.sweep_seconds,
        gather_rays: report.rays,
        row_bytes: report.quality.entries as u64 * size_of::<(u32, f32)>() as u64,
        ..Default::default()
    };
    Ok(Run { line, solution, tessellation: Arc::new(tessellation.map_err(anyhow::Error::msg)?) })
}

/// The line of a run, with its errors.
fn line(
    loaded: &LoadedScene,
    (method, budget): (Method, String),
    run: Run,
    truth: (&TruthFile, &Path),
) -> anyhow::Result<Line> {
    let tracer = Tracer::new(Arc::clone(&loaded.scene));
    let lit = |reconstruction| -> anyhow::Result<PartErrors> {
        let field = Reconstructor::new(&loaded.scene, &tracer, &run.tessellation, &run.solution, reconstruction);
        let at = |triangle, place| field.direct_and_total(triangle, place);
        Ok(compare_with_truth(&loaded.scene, &tracer, at, truth)?.errors.lit)
    };
    let (vertex, point) = (lit(Reconstruction::Vertex)?, lit(Reconstruction::PointDirect)?);
    Ok(Line {
        method,
        budget,
        vertices: run.solution.buried.len(),
        elements: run.tessellation.mesh.triangles.len(),
        error_vertex: vertex.total.relative_l2,
        bias_vertex: vertex.total.bias,
        error_point_direct: point.total.relative_l2,
        bias_point_direct: point.total.bias,
        threads: rayon::current_num_threads(),
        processor: std::env::consts::ARCH,
        version: env!("CARGO_PKG_VERSION"),
        ..run.line
    })
}

fn write_table(path: &Path, lines: &[Line]) -> anyhow::Result<()> {
    files::write_atomically(path, |writer| {
        let mut table = csv::Writer::from_writer(writer);
        for line in lines {
            table.serialize(line)?;
        }
        Ok(table.flush()?)
    })
}

/// Each method by interpolation between vertices, and with direct light at the point.
fn curves(lines: &[Line]) -> Vec<Curve> {
    let curve = |method: Method, name: String, error: fn(&Line) -> f64| {
        let of_method = lines.iter().filter(|line| line.method == method);
        let points = of_method.map(|line| (line.seconds, 100.0 * error(line))).filter(|(_, error)| *error > 0.0);
        Curve { name, points: points.collect() }
    };
    let both = Method::value_variants().iter().flat_map(|&method| {
        [
            curve(method, method.name().into(), |line| line.error_vertex),
            curve(method, format!("{}, direct light at the point", method.name()), |line| line.error_point_direct),
        ]
    });
    both.filter(|curve| !curve.points.is_empty()).collect()
}
