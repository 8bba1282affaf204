//! Reading and writing files on threads of their own, so that the window goes on meanwhile.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, mpsc},
};

use glam::Vec3;

use super::{
    elements::Elements,
    fill_unknown::fill_unknown,
    results::{Results, TruthView},
    task_pictures::{self, TaskPicture},
};
use crate::{
    check::{
        tasks::{TASKS, Task, TaskReport, run_task},
        truth_file,
    },
    files::{self, loaded_scene, loaded_scene::LoadedScene, truth_comparison},
    scene::{Scene, inspect},
    solver::{Solution, SolveSettings},
    student::FUNCTIONS,
    transport::facing::{Facing, facing},
};

/// A scene, ready to be shown.
pub struct OpenedScene {
    /// The scene with its state.
    pub loaded: LoadedScene,
    /// Its elements, by the state's settings.
    pub elements: Elements,
    /// The scene in numbers.
    pub report: inspect::SceneReport,
    /// What is to be said of the sides that light meets.
    pub facing: Option<Facing>,
    /// What is to be said about the state and the scene.
    pub warnings: Vec<String>,
}

/// Reads a scene (an OBJ file, or the name of the built-in one) with its state.
///
/// # Errors
/// One line: what, where, what to do.
pub fn open_scene(path: &Path, state: Option<&Path>) -> anyhow::Result<OpenedScene> {
    let (state, warnings) = loaded_scene::read_state(path, state)?;
    let follows_light = state.settings.as_ref().is_none_or(SolveSettings::follows_light);
    let options = state.load.clone().unwrap_or_default().merging_flat(follows_light);
    prepare(LoadedScene::load(path, state, options)?, warnings)
}

/// Makes the elements of a scene that was read.
///
/// # Errors
/// One line: what, where, what to do.
pub fn prepare(loaded: LoadedScene, mut warnings: Vec<String>) -> anyhow::Result<OpenedScene> {
    warnings.extend(loaded.scene.warnings.iter().map(|warning| format!("{}: {warning}", loaded.path.display())));
    let settings = loaded.state.settings.clone().unwrap_or_default();
    let elements =
        Elements::new(Arc::clone(&loaded.scene), loaded.load.clone(), &settings).map_err(anyhow::Error::msg)?;
    let report = inspect::report(&loaded.scene);
    let light = loaded.state.light.map(|light| light.to_local(&loaded.scene.frame));
    let facing = facing(&loaded.scene, &*elements.tracer, light.as_ref(), &loaded.load);
    warnings.extend(facing.iter().map(|facing| format!("{}: {}", loaded.path.display(), facing.text)));
    Ok(OpenedScene { loaded, elements, report, facing, warnings })
}

/// Reads a solution of a scene. The scene is read again if it was solved with other options than it was opened with.
///
/// # Errors
/// One line: what, where, what to do; also for a solution of another scene.
pub fn open_solution(path: &Path, opened: &LoadedScene, scene: &Arc<Scene>) -> anyhow::Result<Results> {
    let solution = files::read_solution(path)?;
    let scene = if solution.info.load == opened.load {
        Arc::clone(scene)
    } else {
        LoadedScene::load(&opened.path, opened.state.clone(), solution.info.load.clone())?.scene
    };
    let tessellation = files::elements_of(path, &solution, &scene)?;
    let elements =
        Elements::of_tessellation(scene, solution.info.load.clone(), tessellation).map_err(anyhow::Error::msg)?;
    let total = Arc::new(solution.total());
    Ok(Results::of_solution(elements, Arc::new(solution), total))
}

/// Tests one task of the assignment, or all, and draws what the samplers do.
pub fn check(task: Option<&'static str>) -> Done {
    let wanted = || TASKS.iter().filter(|known| task.is_none_or(|name| name == known.name));
    let reports = wanted().map(|task| run_task(task, &FUNCTIONS, 1)).collect();
    let picture = |task: &Task| Some((task.name, task_pictures::picture(task.name, &FUNCTIONS)?));
    let pictures = wanted().filter_map(picture).collect();
    Done::Checked(reports, pictures)
}

/// Compares a solution with a truth file.
///
/// # Errors
/// One line: what, where, what to do; also for a truth of another scene.
pub fn compare_with_truth(path: &Path, elements: &Elements, solution: &Solution) -> anyhow::Result<TruthView> {
    let truth = truth_file::read(path)?;
    let tessellation = &elements.tessellation;
    let total = solution.total();
    let at = |triangle, place| {
        let of = |field: &[Vec3]| tessellation.interpolate(field, triangle, place);
        (of(solution.direct()), of(&total))
    };
    let comparison = truth_comparison::compare_with_truth(&elements.scene, &elements.tracer, at, (&truth, path))?;
    let mut sums = vec![(0.0, 0.0); tessellation.mesh.positions.len()];
    for point in &comparison.points {
        let error = (point.difference.length_squared() / 3.0).sqrt();
        let (element, _) = tessellation.locate(point.triangle, point.barycentric);
        for vertex in tessellation.mesh.triangles[element as usize] {
            let sum: &mut (f64, f64) = &mut sums[vertex as usize];
            *sum = (sum.0 + error, sum.1 + 1.0);
        }
    }
    let known = sums.iter().map(|(_, count)| *count > 0.0).collect();
    let mean = |(sum, count): &(f64, f64)| Vec3::splat((sum / count.max(1.0)) as f32);
    let mut field: Vec<Vec3> = sums.iter().map(mean).collect();
    fill_unknown(&mut field, known, &tessellation.mesh.triangles, None);
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    Ok(TruthView { name, comparison, field: Arc::new(field) })
}

/// What came of a task.
pub enum Done {
    /// A scene was read.
    Scene(Box<OpenedScene>),
    /// A solution was read, to be shown.
    Solution(Box<Results>),
    /// A solution was read, to be compared with.
    Other(Box<Results>),
    /// A solution was compared with a truth.
    Truth(Box<TruthView>, Arc<Solution>),
    /// A file was written.
    Written(PathBuf),
    /// Tasks of the assignment were tested.
    Checked(Vec<TaskReport>, Vec<(&'static str, TaskPicture)>),
}

/// Runs tasks and hands over what came of them.
pub struct Loader {
    sender: mpsc::Sender<anyhow::Result<Done>>,
    receiver: mpsc::Receiver<anyhow::Result<Done>>,
    running: usize,
    context: egui::Context,
}

impl Loader {
    /// Wakes `context` when a task is done.
    pub fn new(context: egui::Context) -> Self {
        let (sender, receiver) = mpsc::channel();
        Self { sender, receiver, running: 0, context }
    }

    /// Runs a task on a thread of its own.
    pub fn run(&mut self, task: impl FnOnce() -> anyhow::Result<Done> + Send + 'static) {
        let (sender, context) = (self.sender.clone(), self.context.clone());
        let thread = std::thread::Builder::new().name(String::from("files")).spawn(move || {
            // A window that was closed meanwhile needs no answer.
            let _ = sender.send(task());
            context.request_repaint();
        });
        match thread {
            Ok(_) => self.running += 1,
            Err(error) => {
                let _ = self.sender.send(Err(anyhow::anyhow!("no thread could be started: {error}")));
                self.running += 1;
            }
        }
    }

    /// What has been done since the last call.
    pub fn finished(&mut self) -> Vec<anyhow::Result<Done>> {
        let done: Vec<_> = self.receiver.try_iter().collect();
        self.running -= done.len();
        done
    }

    /// True while a task runs.
    pub fn is_busy(&self) -> bool {
        self.running > 0
    }
}
