//! A program with a student's functions, run apart: what its tests say and what it computes, within limits of time and
//! memory. An endless loop, a stack that overflows or memory without end cost one task or one solve.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Duration,
};

use anyhow::{Context as _, anyhow};
use clap::Args;
use image::RgbaImage;
use process_control::{ChildExt as _, Control as _};
use serde::Deserialize;

use super::tree::STUDENT_FOLDER;
use crate::{
    check::tasks::{Finding, Status, TASKS, Task, TaskReport},
    files::{elements_of, loaded_scene, loaded_scene::LoadedScene, read_solution},
    math::color::ToneMap,
    render::{RenderSettings, Subject, View, render},
    scene::{Camera, LoadOptions, Tessellation},
    solver::{Solution, faults::Fault},
    trace::Tracer,
};

/// How long and how large a student's program may become.
#[derive(Clone, Copy, Debug, Args)]
pub struct Limits {
    /// Seconds for the tests of each task, and for each solve.
    #[arg(long, value_name = "SECONDS", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..))]
    pub time_limit: u64,
    /// Memory of the student's program, in MiB (on Linux and Windows).
    #[arg(long, value_name = "MIB", default_value_t = 4096, value_parser = clap::value_parser!(u64).range(64..=1 << 20))]
    pub memory_limit: u64,
}

/// How a program ended.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// What it wrote to standard output, up to a limit.
    pub output: Vec<u8>,
    /// What it wrote to standard error, up to a limit.
    pub errors: String,
    /// Its exit status, if it ended by itself.
    pub exit_status: Option<i64>,
    /// Why it did not end by itself.
    pub stopped: Option<String>,
}

/// What is kept of a program's output, in bytes.
const KEPT_OUTPUT: usize = 1 << 20;

/// Runs a program to its end, or to a limit.
///
/// # Errors
/// It could not be started.
pub fn run_limited(command: &mut Command, seconds: u64, memory_mib: Option<u64>) -> anyhow::Result<Run> {
    let name = command.get_program().to_string_lossy().into_owned();
    let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let child = child.with_context(|| format!("{name}: could not be started"))?;
    let control = child.controlled_with_output().time_limit(Duration::from_secs(seconds)).terminate_for_timeout();
    let control = control.stdout_filter(keep(KEPT_OUTPUT)).stderr_filter(keep(KEPT_OUTPUT));
    #[cfg(any(target_os = "linux", windows))]
    let control = match memory_mib {
        Some(memory) => control.memory_limit(usize::try_from(memory << 20).unwrap_or(usize::MAX)),
        None => control,
    };
    let Some(output) = control.wait().with_context(|| format!("{name}: could not be waited for"))? else {
        return Ok(Run { stopped: Some(format!("it did not end within {seconds} s")), ..Run::default() });
    };
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    let exit_status = output.status.code();
    let stopped = exit_status.is_none().then(|| {
        let overflows = errors.contains("overflowed its stack");
        let starves = errors.contains("memory allocation of");
        match (overflows, starves, memory_mib) {
            (true, ..) => String::from("its stack overflowed: a function that calls itself without end"),
            (_, true, Some(limit)) => format!("it wanted more than the {limit} MiB of memory that it may have"),
            _ => format!("it was ended by the system ({})", output.status),
        }
    });
    Ok(Run { output: output.stdout, errors, exit_status, stopped })
}

/// Keeps so many bytes of a stream and lets the rest pass.
fn keep(mut bytes: usize) -> impl FnMut(&[u8]) -> std::io::Result<bool> + Send + 'static {
    move |chunk| {
        let fits = chunk.len() <= bytes;
        bytes = if fits { bytes - chunk.len() } else { 0 };
        Ok(fits)
    }
}

/// A program with a student's functions.
#[derive(Clone, Debug)]
pub struct Program {
    /// Its executable file.
    pub executable: PathBuf,
    /// The source tree that it was built from, with its scenes.
    pub root: PathBuf,
    /// Its limits.
    pub limits: Limits,
}

/// The part of `radiosity check --json` that is wanted.
#[derive(Deserialize)]
struct Checked {
    tasks: [CheckedTask; 1],
}

#[derive(Deserialize)]
struct CheckedTask {
    status: Status,
}

/// One scene that is solved for the pictures of a hand-in: coarsely, so that it takes seconds.
#[derive(Debug)]
pub struct PictureSolve {
    /// Its short name.
    pub name: &'static str,
    /// The scene, from the tree's root.
    pub scene: &'static str,
    /// Flags of `radiosity solve`.
    pub flags: &'static [&'static str],
    /// The pictures: their names, and their state files, if not the one beside the scene.
    pub pictures: &'static [(&'static str, Option<&'static str>)],
}

/// What is solved and drawn.
pub const PICTURE_SOLVES: [PictureSolve; 2] = [
    PictureSolve {
        name: "cornell",
        scene: "scenes/cornell/cornell.obj",
        flags: &["--subdivide", "4", "--rays", "128", "--light-rays", "32", "--bounces", "5"],
        pictures: &[("cornell", None)],
    },
    PictureSolve {
        name: "atrium",
        scene: "scenes/atrium/atrium.obj",
        flags: &["--rays", "32", "--light-rays", "8", "--bounces", "2"],
        pictures: &[
            ("atrium-gallery", Some("states/atrium-gallery.toml")),
            ("atrium-vaults", Some("states/atrium-vaults.toml")),
        ],
    },
];

/// A solve that has ended.
pub struct Solved {
    /// The solution.
    pub solution: Solution,
    /// What functions of `student` did that they must not do.
    pub faults: Vec<Fault>,
}

impl Program {
    /// Runs the tests of one task.
    ///
    /// # Errors
    /// The program could not be started.
    pub fn check(&self, task: &Task) -> anyhow::Result<TaskReport> {
        let run = self.run(&["check", "--json", "--task", task.name])?;
        if let Some(stopped) = run.stopped {
            return Ok(task.report(failed_to_end(stopped)));
        }
        let unreadable = || Finding {
            function: STUDENT_FOLDER.into(),
            test: "the program".into(),
            hint: String::from("the tests did not come to an end"),
            measured: format!("exit status {}: {}", run.exit_status.unwrap_or(-1), first_line(&run.errors)),
            expected: String::from("a report"),
        };
        let checked: Result<Checked, _> = serde_json::from_slice(&run.output);
        Ok(task.report(checked.map_or_else(|_| Status::Wrong(unreadable()), |Checked { tasks: [task] }| task.status)))
    }

    /// Runs the tests of all tasks, one after the other.
    ///
    /// # Errors
    /// The program could not be started.
    pub fn check_all(&self) -> anyhow::Result<Vec<TaskReport>> {
        TASKS.iter().map(|task| self.check(task)).collect()
    }

    /// Solves a scene with the student's functions.
    ///
    /// # Errors
    /// One line: why there is no solution.
    pub fn solve(&self, solve: &PictureSolve) -> anyhow::Result<Solved> {
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let path = folder.path().join("solution.safetensors");
        let words = [&["solve", solve.scene, "--engine", "student", "--json", "-o"][..]].concat();
        let path_text = path.to_str().context("the temporary folder has a name that is no text")?;
        let run = self.run(&[&words[..], &[path_text], solve.flags].concat())?;
        if let Some(stopped) = run.stopped {
            return Err(anyhow!("{stopped}"));
        }
        if run.exit_status != Some(0) {
            return Err(anyhow!("exit status {}: {}", run.exit_status.unwrap_or(-1), first_line(&run.errors)));
        }
        let report: serde_json::Value = serde_json::from_slice(&run.output).unwrap_or_default();
        let faults = Vec::<Fault>::deserialize(&report["solve"]["faults"]).unwrap_or_default();
        Ok(Solved { solution: read_solution(&path)?, faults })
    }

    fn run(&self, words: &[&str]) -> anyhow::Result<Run> {
        let mut command = Command::new(&self.executable);
        // glibc reserves address space for each thread, which would count as memory on a machine of many cores.
        command.args(words).current_dir(&self.root).env("MALLOC_ARENA_MAX", "2");
        run_limited(&mut command, self.limits.time_limit, Some(self.limits.memory_limit))
    }
}

fn failed_to_end(stopped: String) -> Status {
    let hint = String::from("the tests did not come to an end: a loop or a recursion without end, or too much work?");
    let expected = String::from("an end, and an answer");
    Status::Wrong(Finding {
        function: STUDENT_FOLDER.into(),
        test: "the program".into(),
        hint,
        measured: stopped,
        expected,
    })
}

fn first_line(text: &str) -> &str {
    let is_error = |line: &&str| line.starts_with("error");
    text.lines().find(is_error).or_else(|| text.lines().next()).unwrap_or("no message")
}

/// A scene as [`PICTURE_SOLVES`] has it, ready to draw solutions of it.
pub struct Stage {
    root: PathBuf,
    solve: &'static PictureSolve,
    loaded: LoadedScene,
    tracer: Tracer,
}

/// Size of a picture in pixels.
const PICTURE_SIZE: (u32, u32) = (560, 420);

impl Stage {
    /// Reads the scene.
    ///
    /// # Errors
    /// One line: what cannot be read.
    pub fn new(root: &Path, solve: &'static PictureSolve) -> anyhow::Result<Self> {
        let path = root.join(solve.scene);
        let (state, _) = loaded_scene::read_state(&path, None)?;
        let loaded = LoadedScene::load(&path, state, LoadOptions::default())?;
        let tracer = Tracer::new(loaded.scene.clone());
        Ok(Self { root: root.to_path_buf(), solve, loaded, tracer })
    }

    /// What it is the stage of.
    pub fn solve(&self) -> &'static PictureSolve {
        self.solve
    }

    /// Draws the pictures of a solution, by name.
    ///
    /// # Errors
    /// One line: the solution belongs to another scene, or a state cannot be read.
    pub fn draw(&self, solution: &Solution) -> anyhow::Result<Vec<(&'static str, RgbaImage)>> {
        let scene = &self.loaded.scene;
        let elements = elements_of(Path::new(self.solve.name), solution, scene)?;
        let draw = |&(name, state): &(&'static str, Option<&str>)| {
            let state = state.map(|state| self.root.join(state));
            let (state, _) = loaded_scene::read_state(&self.loaded.path, state.as_deref())?;
            let camera = state.camera.unwrap_or(self.loaded.camera).to_local(&scene.frame);
            let tone_map = state.tone_map.unwrap_or_default();
            Ok((name, self.picture(solution, &elements, &camera, tone_map)))
        };
        self.solve.pictures.iter().map(draw).collect()
    }

    fn picture(&self, solution: &Solution, elements: &Tessellation, camera: &Camera, tone_map: ToneMap) -> RgbaImage {
        let subject = Subject {
            scene: &self.loaded.scene,
            tracer: &self.tracer,
            tessellation: elements,
            charts: None,
            field: &solution.total(),
            direct: None,
            light: solution.info.light.map(|light| light.to_local(&self.loaded.scene.frame)),
        };
        let (width, height) = PICTURE_SIZE;
        render(&subject, camera, &RenderSettings { width, height, view: View::Radiosity, tone_map, samples: 4 })
    }
}
