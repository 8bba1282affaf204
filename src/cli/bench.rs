//! `radiosity bench`: seconds against error, for ways to solve a scene whose truth is known.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use anyhow::Context as _;
use clap::{ArgMatches, Args, ValueEnum};
use serde::Serialize;

use super::{
    Outcome,
    files::{
        self,
        error_plot::{Curve, write_error_plot},
        truth_comparison::compare_with_truth,
    },
    scene_args::{LightArgs, LoadedScene, SceneArgs},
};
use crate::{
    check::{
        metrics::PartErrors,
        truth_file::{self, TruthFile},
    },
    scene::area_light::AreaLightState,
    solver::{Engine, Monitor, Problem, Reconstruction, Reconstructor, SolveSettings, Solved, solve},
    trace::Tracer,
};

/// A way to solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The program's engine on elements that follow the light.
    Follow,
    /// The program's engine on triangles that are cut evenly.
    Even,
    /// The assignment's engine, by the functions of `src/student`, eight bounces.
    Student,
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Self::Follow => "elements that follow the light",
            Self::Even => "even elements",
            Self::Student => "the assignment's method",
        }
    }

    /// Settings from cheap to dear: what each is called, and what it is.
    fn budgets(self) -> Vec<(String, SolveSettings)> {
        let base = SolveSettings { unabsorbed: 1e-3, ..SolveSettings::even() };
        let even = |engine: Engine, bounces: Option<u32>| {
            move |(subdivide, rays): (u32, u32)| {
                let settings = SolveSettings { subdivide, rays, bounces, engine, ..base.clone() };
                (format!("subdivide {subdivide}, {rays} rays"), settings)
            }
        };
        match self {
            Self::Follow => {
                let follow = |(error, rays)| {
                    let settings = SolveSettings { adaptive: error, rays, unabsorbed: 1e-3, ..Default::default() };
                    (format!("error {error}, {rays} rays"), settings)
                };
                [(0.2, 64), (0.1, 64), (0.05, 128), (0.03, 256), (0.02, 512)].map(follow).into()
            }
            Self::Even => [(2, 64), (3, 128), (4, 256), (4, 1024), (5, 1024)].map(even(Engine::Reference, None)).into(),
            Self::Student => [(2, 64), (3, 64), (4, 64), (4, 256)].map(even(Engine::Student, Some(8))).into(),
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
#[derive(Clone, Debug, Serialize)]
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
        for (budget, settings) in method.budgets() {
            let runs =
                (0..args.repeat).map(|_| line(&loaded, light, (method, &budget, &settings), (&truth, &args.truth)));
            let mut runs = runs.collect::<anyhow::Result<Vec<Line>>>()?;
            runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
            let median = runs.swap_remove(runs.len() / 2);
            println!("{}", row(&median));
            lines.push(median);
        }
    }
    write_table(&table, &lines)?;
    write_error_plot(&args.output.join("bench"), &args.scene.scene.display().to_string(), &curves(&lines))?;
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

/// Solves once.
fn line(
    loaded: &LoadedScene,
    light: Option<AreaLightState>,
    (method, budget, settings): (Method, &str, &SolveSettings),
    truth: (&TruthFile, &Path),
) -> anyhow::Result<Line> {
    let started = Instant::now();
    let tracer = Arc::new(Tracer::new(Arc::clone(&loaded.scene)));
    let scene = Arc::clone(&loaded.scene);
    let problem = Problem::new(scene, tracer.clone(), loaded.load.clone(), light, settings.clone());
    let problem = problem.map_err(anyhow::Error::msg)?;
    let seconds_tree_and_elements = started.elapsed().as_secs_f64();
    let Solved { solution, report, tessellation, .. } = solve(&problem, &Monitor::new(&problem.tessellation, None));
    let seconds = started.elapsed().as_secs_f64();
    let lit = |reconstruction| -> anyhow::Result<PartErrors> {
        let field = Reconstructor::new(&loaded.scene, &*tracer, &tessellation, &solution, reconstruction);
        let at = |triangle, place| field.direct_and_total(triangle, place);
        Ok(compare_with_truth(&loaded.scene, &tracer, at, truth)?.errors.lit)
    };
    let (vertex, point) = (lit(Reconstruction::Vertex)?, lit(Reconstruction::PointDirect)?);
    Ok(Line {
        method,
        budget: budget.into(),
        vertices: solution.buried.len(),
        elements: tessellation.mesh.triangles.len(),
        gathered_vertices: report.gathered_vertices,
        seconds,
        seconds_tree_and_elements,
        seconds_following: report.seconds_adapting,
        seconds_bounces: report.bounce_seconds,
        gather_rays: report.gather_rays,
        shadow_rays: report.shadow_rays,
        rays_skipped: report.gather_rays_skipped + report.shadow_rays_skipped,
        row_bytes: report.row_bytes,
        error_vertex: vertex.total.relative_l2,
        bias_vertex: vertex.total.bias,
        error_point_direct: point.total.relative_l2,
        bias_point_direct: point.total.bias,
        threads: rayon::current_num_threads(),
        processor: std::env::consts::ARCH,
        version: env!("CARGO_PKG_VERSION"),
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
