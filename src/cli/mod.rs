//! The command line: words in, words and files out.
//!
//! Each command is a file with its clap arguments and a `run` function that returns an [`Outcome`].

#[cfg(feature = "reference")]
pub mod bench;
pub mod check;
pub mod compare;
pub mod demo;
#[cfg(feature = "gpu")]
pub mod devices;
pub mod export;
#[cfg(any(feature = "gpu", feature = "reference"))]
pub mod form_factors;
#[cfg(feature = "reference")]
pub mod grade;
pub mod handin;
#[cfg(feature = "reference")]
pub mod handout;
pub mod inspect;
#[cfg(feature = "gpu")]
mod item_buffers;
#[cfg(feature = "gpu")]
pub mod lightmap;
pub mod only_vertex;
pub mod probe;
pub mod progress;
#[cfg(feature = "reference")]
pub mod rays;
pub mod render;
pub mod scene_args;
#[cfg(feature = "gpu")]
mod screen_pictures;
#[cfg(feature = "gpu")]
pub mod screen_space;
#[cfg(feature = "gpu")]
pub mod screen_table;
pub mod solve;
pub mod solved_scene;
#[cfg(feature = "reference")]
pub mod stress;
#[cfg(feature = "reference")]
pub mod truth;
#[cfg(feature = "app")]
pub mod window;

use std::process::ExitCode;

use crate::files;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

/// How a command ended; errors (bad input) end with exit status 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit status 0.
    Done,
    /// A check found something wrong or not done: exit status 1.
    Unfinished,
    /// Stopped by Ctrl-C, with the partial result kept: exit status 130.
    Cancelled,
}

const EXAMPLES: &str = "\
Examples:
  radiosity                                    open the window on the built-in Cornell box
  radiosity window scenes/atrium/atrium.obj    open the window on a scene
  radiosity inspect scenes/atrium/atrium.obj   what is in a scene, and what was repaired
  radiosity solve cornell --subdivide 5 --rays 1024 -o cornell.safetensors
  radiosity lightmap cornell --texels 20000 -o cornell-lightmap
  radiosity render cornell cornell.safetensors --view indirect -o indirect.png
  radiosity screen-space cornell -o screen.png --report screen.json
  radiosity truth cornell --sample 256 -o truth.csv
  radiosity compare cornell.safetensors truth.csv --scene cornell
  radiosity check                              test the functions of src/student

Exit status: 0 done, 1 `check` found something wrong or not done, 2 bad input, 130 cancelled by Ctrl-C with the partial result kept.";

/// Learn, compute and compare diffuse global illumination.
#[derive(Debug, Parser)]
#[command(version, about, after_long_help = EXAMPLES, after_help = "`--help` shows examples.")]
struct Cli {
    /// Without a command, the window opens on the built-in Cornell box; where there is no display, the box is solved and
    /// a picture of it written.
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Open the window on a scene.
    #[cfg(feature = "app")]
    Window(window::WindowArgs),
    /// Solve a scene: direct light, then bounces of gathering, per vertex.
    Solve(Box<solve::SolveArgs>),
    /// Solve a scene on a lightmap by shooting light on the graphics card, and write the map for other programs.
    #[cfg(feature = "gpu")]
    Lightmap(Box<lightmap::LightmapArgs>),
    /// Find form factors between patches, by rays or by item buffers on the graphics card, and solve with them by
    /// Gauss-Seidel.
    #[cfg(any(feature = "gpu", feature = "reference"))]
    FormFactors(Box<form_factors::FormFactorsArgs>),
    /// Draw a picture in screen space, as real-time renderers do, and judge it by a solution.
    #[cfg(feature = "gpu")]
    ScreenSpace(Box<screen_space::ScreenArgs>),
    /// List the graphics cards and drivers that were found.
    #[cfg(feature = "gpu")]
    Devices(devices::DevicesArgs),
    /// Draw a solution as a picture, by ray casting on the CPU.
    Render(render::RenderArgs),
    /// Read irradiance from a solution at surface points.
    Probe(probe::ProbeArgs),
    /// Path trace irradiance at surface points: the reference, with standard errors.
    #[cfg(feature = "reference")]
    Truth(truth::TruthArgs),
    /// Write rays and triangles to a file, to time other ray tracers on the same work.
    #[cfg(feature = "reference")]
    Rays(rays::RaysArgs),
    /// Time methods of solving against their error, and plot it.
    #[cfg(feature = "reference")]
    Bench(Box<bench::BenchArgs>),
    /// Solve scenes at the edges of what can be given, and hold the answers to what must be true of them.
    #[cfg(feature = "reference")]
    Stress(stress::StressArgs),
    /// Compare a solution with another, or with a truth.
    Compare(compare::CompareArgs),
    /// Tell what is in a scene, and what was repaired.
    Inspect(inspect::InspectArgs),
    /// Write a solution as PLY (vertex colours) or CSV.
    Export(export::ExportArgs),
    /// Test the functions of src/student, task by task, and name what is wrong with them.
    Check(check::CheckArgs),
    /// Make the archive of your work: your files, what `check` says, pictures.
    Handin(Box<handin::HandinArgs>),
    /// For teachers: write the source tree that students get, without the answers.
    #[cfg(feature = "reference")]
    Handout(handout::HandoutArgs),
    /// For teachers: build, run and mark hand-ins.
    #[cfg(feature = "reference")]
    Grade(grade::GradeArgs),
}

/// Reads the program's arguments and runs the command. Errors are printed as one line.
pub fn main() -> ExitCode {
    be_quiet_about_student_panics();
    let matches = Cli::command().get_matches();
    let outcome = Cli::from_arg_matches(&matches).map_err(anyhow::Error::from).and_then(|cli| {
        let Some(command) = cli.command else {
            return without_command();
        };
        let flags = matches.subcommand().map_or(&matches, |(_, flags)| flags);
        match command {
            #[cfg(feature = "app")]
            Command::Window(args) => window::run(&args, flags),
            Command::Solve(args) => solve::run(&args, flags),
            #[cfg(feature = "gpu")]
            Command::Lightmap(args) => lightmap::run(&args, flags),
            #[cfg(any(feature = "gpu", feature = "reference"))]
            Command::FormFactors(args) => form_factors::run(&args, flags),
            #[cfg(feature = "gpu")]
            Command::ScreenSpace(args) => screen_space::run(&args, flags),
            #[cfg(feature = "gpu")]
            Command::Devices(args) => devices::run(&args),
            Command::Render(args) => render::run(&args),
            Command::Probe(args) => probe::run(&args),
            #[cfg(feature = "reference")]
            Command::Truth(args) => truth::run(&args, flags),
            #[cfg(feature = "reference")]
            Command::Rays(args) => rays::run(&args, flags),
            #[cfg(feature = "reference")]
            Command::Bench(args) => bench::run(&args, flags),
            #[cfg(feature = "reference")]
            Command::Stress(args) => stress::run(&args),
            Command::Compare(args) => compare::run(&args),
            Command::Inspect(args) => inspect::run(&args),
            Command::Export(args) => export::run(&args),
            Command::Check(args) => check::run(&args),
            Command::Handin(args) => handin::run(&args),
            #[cfg(feature = "reference")]
            Command::Handout(args) => handout::run(&args),
            #[cfg(feature = "reference")]
            Command::Grade(args) => grade::run(&args),
        }
    });
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Unfinished) => ExitCode::from(1),
        Ok(Outcome::Cancelled) => ExitCode::from(130),
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// A panic in src/student is caught and told where it concerns somebody; without this each would be printed as well,
/// thousands of times.
fn be_quiet_about_student_panics() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let is_student = |location: &std::panic::Location| {
            std::path::Path::new(location.file()).iter().any(|name| name == "student")
        };
        if !panic.location().is_some_and(is_student) {
            print(panic);
        }
    }));
}

/// The window, or else what it would show, on the command line.
fn without_command() -> anyhow::Result<Outcome> {
    #[cfg(feature = "app")]
    match window::run_builtin() {
        Ok(()) => return Ok(Outcome::Done),
        Err(problem) => eprintln!("{problem:#}; going on without a window"),
    }
    demo::run()
}
