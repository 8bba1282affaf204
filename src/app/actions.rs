//! What the commands do.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::Context as _;

use super::{
    App,
    command::Command,
    document::{Document, LightPreset},
    file_dialog::{FileDialog, Purpose},
    fly_camera::FlyCamera,
    loader::{self, Done, OpenedScene},
    notices::Level,
    results::Results,
    solving::{SolveEvent, Solving},
    view_settings::Shown,
};
use crate::{
    files::{
        self,
        loaded_scene::{self, LoadedScene},
    },
    solver::State,
};

/// What a file that was dropped on the window asks for.
pub(super) fn dropped(path: PathBuf) -> Command {
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    match extension.as_ref().and_then(|extension| extension.to_str()) {
        Some("obj") => Command::OpenScene(path),
        Some("safetensors") => Command::LoadSolution(path),
        Some("toml") => Command::LoadState(path),
        _ => Command::Complain(format!(
            "{}: not a scene (.obj), a solution (.safetensors) or a state (.toml)",
            path.display()
        )),
    }
}

impl App {
    /// Does what a key or a panel asked for.
    pub fn fulfil(&mut self, command: Command) {
        let layout = &mut self.layout;
        match command {
            Command::Solve => self.solve(false),
            Command::SolveLightmap => self.solve_lightmap(),
            Command::FormFactors => self.start_or_stop_factors(),
            Command::ReloadShaders => self.reload_shaders(),
            Command::Step => self.step(),
            Command::Cancel => self.cancel(),
            Command::PauseOrResume => {
                if let Some(solving) = &self.solving {
                    solving.set_stepping(false);
                    solving.set_paused(!solving.is_paused());
                }
            }
            Command::PlaceLight => {
                let light =
                    self.document.edit.light.unwrap_or_else(|| self.document.preset_light(LightPreset::Ceiling));
                self.document.edit.light = Some(self.camera.place(&light));
            }
            Command::ToggleHelp => layout.help = !layout.help,
            Command::TogglePanels => layout.panels = !layout.panels,
            Command::TogglePlots => layout.plots = !layout.plots,
            Command::ToggleFrameTimes => layout.frame_times = !layout.frame_times,
            Command::ToggleSecondView => layout.second_view = !layout.second_view,
            Command::NextView => layout.views[0].shown = layout.views[0].shown.next(),
            Command::ToggleWireframe => layout.views[0].wireframe = !layout.views[0].wireframe,
            Command::ToggleFalseColour => layout.views[0].false_colour = !layout.views[0].false_colour,
            Command::ToggleAmbient => layout.ambient = !layout.ambient,
            Command::Play => {
                layout.views[0].shown = Shown::UpToBounce;
                layout.views[0].bounce = 0;
                self.playing_since = Some(Instant::now());
            }
            Command::Undo => self.undo(),
            Command::Redo => self.redo(),
            Command::CopyView => self.copy_view(),
            Command::PasteView(text) => self.paste_view(&text),
            Command::ResetCamera => self.camera = FlyCamera::new(&self.document.loaded.camera, &self.elements().scene),
            Command::KeepForComparison => {
                self.other = self.results.clone();
                self.other.iter_mut().for_each(Results::forget_rows);
            }
            Command::Screenshot => self.screenshot(),
            Command::Check(task) => {
                self.assignment.running = true;
                self.loader.run(move || Ok(loader::check(task)));
            }
            Command::Complain(text) => self.notices.say(Level::Error, text),
            about_files => self.fulfil_about_files(about_files),
        }
    }

    fn fulfil_about_files(&mut self, command: Command) {
        match command {
            Command::Ask(purpose) => self.ask(purpose),
            Command::OpenScene(path) => {
                self.loader.run(move || Ok(Done::Scene(Box::new(loader::open_scene(&path, None)?))));
            }
            Command::ReadAgain(options) => {
                let LoadedScene { path, state, .. } = self.document.loaded.clone();
                let state = State { load: Some(options.clone()), ..state };
                let read = move || loader::prepare(LoadedScene::load(&path, state, options)?, Vec::new());
                self.loader.run(move || Ok(Done::Scene(Box::new(read()?))));
            }
            Command::LoadSolution(path) => {
                let (loaded, scene) = self.scene_of_solutions();
                let open = move || loader::open_solution(&path, &loaded, &scene);
                self.loader.run(move || Ok(Done::Solution(Box::new(open()?))));
            }
            Command::LoadOther(path) => {
                let (loaded, scene) = self.scene_of_solutions();
                let open = move || loader::open_solution(&path, &loaded, &scene);
                self.loader.run(move || Ok(Done::Other(Box::new(open()?))));
            }
            Command::CompareWithTruth(path) => self.compare_with_truth(path),
            Command::SavePlots(path) => self.save_plots(path),
            Command::SaveSolution(path) => self.save_solution(path),
            Command::SaveMesh(path) => self.save_mesh(path),
            Command::SaveState(path) => {
                let saved = self.save_state(&path);
                self.tell(saved, &path, "saved");
            }
            Command::LoadState(path) => {
                let loaded = self.load_state(&path);
                self.tell(loaded, &path, "loaded");
            }
            Command::SaveNumber(number) => self.fulfil_about_files(Command::SaveState(self.numbered_state(number))),
            Command::LoadNumber(number) => {
                let path = self.numbered_state(number);
                if path.is_file() {
                    self.fulfil_about_files(Command::LoadState(path));
                } else {
                    let advice = format!("There is no {}: ALT + {number} saves one", path.display());
                    self.notices.say(Level::Warning, advice);
                }
            }
            _ => {}
        }
    }

    /// Takes in what the solve and the loader have to tell.
    pub(super) fn listen(&mut self) {
        for done in self.loader.finished() {
            match done {
                Ok(Done::Scene(opened)) => self.show_scene(*opened),
                Ok(Done::Solution(results)) => self.show_solution(*results),
                Ok(Done::Other(results)) => {
                    self.notices.say(Level::Note, "Solution to compare with: loaded");
                    self.other = Some(*results);
                }
                Ok(Done::Truth(truth, solution)) => self.show_truth(*truth, &solution),
                Ok(Done::Written(path)) => self.notices.say(Level::Note, format!("{}: saved", path.display())),
                Ok(Done::Checked(reports, pictures)) => self.assignment.take(reports, pictures),
                Err(error) => self.notices.say(Level::Error, format!("{error:#}")),
            }
        }
        self.listen_to_solve();
        self.listen_to_lightmap();
        self.listen_to_factors();
    }

    fn listen_to_solve(&mut self) {
        let Some(solving) = &self.solving else { return };
        let mut ended = false;
        for event in solving.events() {
            match event {
                // Elements are cut before the first bounce is known: nothing else gets lost.
                SolveEvent::Elements(elements, total) => {
                    let progress = self.results.as_ref().and_then(|results| results.progress);
                    let begun = Results::begun(elements, total, solving.input.clone());
                    self.results = Some(Results { progress, ..begun });
                }
                #[cfg(feature = "reference")]
                SolveEvent::Relit { elements, solution, report } => {
                    let is_superseded = !solution.info.complete && solving.input != self.document.edit.solve_input();
                    if let Some(known) = self.results.as_mut().filter(|_| !is_superseded) {
                        *known = known.lit_again(elements, solution, report, solving.input.clone());
                    }
                    ended = true;
                }
                SolveEvent::Failed(problem) => {
                    self.notices.say(Level::Error, problem);
                    ended = true;
                }
                SolveEvent::Remark(remark) => self.notices.say(Level::Warning, remark),
                SolveEvent::Fault(fault) => self.notices.say(Level::Error, format!("src/student: {fault}")),
                // Of lighting rows again nothing is taken in but its end: what is shown keeps the bounces of its solve.
                _ if solving.relights => {}
                event => {
                    ended |= matches!(event, SolveEvent::Finished { .. });
                    if let Some(results) = &mut self.results {
                        // From the first bounce on the elements stay.
                        let are_final = matches!(event, SolveEvent::Bounce { .. }) && results.bounces.is_empty();
                        if let (Some(job), true) = (&self.lightmap.job, are_final) {
                            job.set_elements(results.elements.clone());
                        }
                        results.take(event);
                    }
                }
            }
        }
        if let (Some(results), false) = (&mut self.results, ended)
            && let Some(live) = solving.take_live(&results.elements)
        {
            results.total = live;
        }
        if ended {
            self.solving = None;
        }
    }

    /// One bounce more of a solve that waits; else a new solve, which waits after each bounce.
    fn step(&mut self) {
        match &self.solving {
            Some(solving) => {
                solving.set_stepping(true);
                solving.set_paused(false);
            }
            None => self.solve(true),
        }
    }

    fn solve(&mut self, stepping: bool) {
        if !self.document.shines() {
            let advice = "Nothing shines in this scene: press SPACE to put a light at the camera, then ENTER";
            self.notices.say(Level::Error, advice);
            return;
        }
        let input = self.document.edit.solve_input();
        let (elements, made_with) = self.elements_at_hand();
        let context = self.context.clone();
        self.layout.ambient = false;
        self.playing_since = None;
        self.frame_times.solve_begins();
        // The new solve needs the memory.
        self.results.iter_mut().for_each(Results::forget_rows);
        // The solve that ran before is cancelled by being dropped.
        // Asked for at once, egui draws twice.
        let wake = move || context.request_repaint_after(Duration::from_millis(1));
        match Solving::start(elements, made_with, input, wake) {
            Ok(solving) => {
                solving.set_stepping(stepping);
                self.solving = Some(solving);
            }
            Err(error) => self.notices.say(Level::Error, format!("no thread for the solver could be started: {error}")),
        }
    }

    fn cancel(&mut self) {
        if self.layout.help {
            self.layout.help = false;
        } else if let Some(solving) = &self.solving {
            solving.cancel();
        }
    }

    fn undo(&mut self) {
        if let Some(before) = self.undoer.undo(&self.document.edit) {
            self.document.edit = before.clone();
        }
    }

    fn redo(&mut self) {
        if let Some(after) = self.undoer.redo(&self.document.edit) {
            self.document.edit = after.clone();
        }
    }

    fn show_scene(&mut self, opened: OpenedScene) {
        for warning in &opened.warnings {
            self.notices.say(Level::Warning, warning.as_str());
        }
        let vertices = opened.elements.tessellation.mesh.positions.len();
        self.notices.say(Level::Note, format!("{}: {vertices} vertices", opened.loaded.path.display()));
        self.camera = FlyCamera::new(&opened.loaded.camera, &opened.loaded.scene);
        self.document = Document::new(opened);
        (self.results, self.other, self.solving, self.picked) = (None, None, None, None);
        (self.lightmap.job, self.lightmap.factors.job) = (None, None);
        self.undoer = Default::default();
        self.layout.ambient = true;
    }

    /// The window's title names the scene and how its solve stands.
    pub(super) fn update_title(&mut self) {
        let solved = self.results.as_ref().and_then(|results| results.solution.as_ref());
        let stands = match solved {
            _ if self.status().running => ", solving",
            Some(solution) if solution.info.complete => ", solved",
            Some(_) => ", cancelled",
            None => "",
        };
        let title = format!("Radiosity: {}{stands}", self.document.loaded.scene.name);
        if title != self.title {
            self.context.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn show_solution(&mut self, results: Results) {
        self.notices.say(Level::Note, format!("Solution of {} bounces: loaded", results.bounces.len()));
        self.document.edit.light = results.input.light;
        self.document.edit.settings = results.input.settings.clone();
        self.document.edit.materials = Arc::clone(&results.input.materials);
        self.solving = None;
        self.picked = None;
        self.results = Some(results);
        self.layout.ambient = false;
    }

    fn scene_of_solutions(&self) -> (loaded_scene::LoadedScene, Arc<crate::scene::Scene>) {
        (self.document.loaded.clone(), Arc::clone(&self.document.loaded.scene))
    }

    fn ask(&mut self, purpose: Purpose) {
        let scene = &self.document.loaded;
        let folder = match purpose {
            Purpose::SaveState | Purpose::LoadState => self.folder.join("states"),
            _ => scene.path.parent().map_or_else(|| self.folder.clone(), Path::to_path_buf),
        };
        let folder = if folder.is_dir() { folder } else { self.folder.clone() };
        let name = match purpose {
            Purpose::SaveMesh => format!("{}.ply", scene.scene.name),
            Purpose::SaveSolution => format!("{}.safetensors", scene.scene.name),
            Purpose::SavePlots => format!("{}-convergence.csv", scene.scene.name),
            Purpose::SaveState => format!("{}.toml", scene.scene.name),
            _ => String::new(),
        };
        self.dialog = Some(FileDialog::new(purpose, &folder, &name));
    }

    fn numbered_state(&self, number: u8) -> PathBuf {
        self.folder.join("states").join(format!("{number}.toml"))
    }

    /// Camera, light, settings, tone map and reading options as a state.
    pub fn state(&self) -> State {
        let edit = &self.document.edit;
        State {
            camera: Some(self.camera.state()),
            light: edit.light,
            settings: Some(edit.settings.clone()),
            tone_map: Some(edit.tone_map),
            load: Some(self.document.loaded.load.clone()),
        }
    }

    fn save_state(&self, path: &Path) -> anyhow::Result<()> {
        let text = self.state().to_toml().map_err(anyhow::Error::msg)?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
        }
        files::write_atomically(path, |writer| Ok(writer.write_all(text.as_bytes())?))
    }

    fn load_state(&mut self, path: &Path) -> anyhow::Result<()> {
        let (state, warnings) = loaded_scene::read_state_file(path)?;
        for warning in warnings {
            self.notices.say(Level::Warning, warning);
        }
        self.take_state(&state);
        Ok(())
    }

    fn take_state(&mut self, state: &State) {
        if let Some(camera) = &state.camera {
            self.camera.set(camera);
        }
        self.document.apply(state);
    }

    fn tell(&mut self, result: anyhow::Result<()>, path: &Path, done: &str) {
        match result {
            Ok(()) => self.notices.say(Level::Note, format!("{}: {done}", path.display())),
            Err(error) => self.notices.say(Level::Error, format!("{error:#}")),
        }
    }

    /// Camera and light as a line of JSON.
    fn copy_view(&mut self) {
        let view = serde_json::json!({ "camera": self.camera.state(), "light": self.document.edit.light });
        self.context.copy_text(view.to_string());
        self.copied = Some(view.to_string());
        self.notices.say(Level::Note, "Camera and light are on the clipboard, as one line of text");
    }

    fn paste_view(&mut self, text: &str) {
        match serde_json::from_str::<State>(text.trim()) {
            Ok(state) if state.problem().is_none() && (state.camera.is_some() || state.light.is_some()) => {
                self.take_state(&State { camera: state.camera, light: state.light, ..State::default() });
                self.notices.say(Level::Note, "Camera and light taken from the clipboard");
            }
            _ => self.notices.say(Level::Error, "The clipboard holds no camera and light; CTRL + C copies them"),
        }
    }
}
