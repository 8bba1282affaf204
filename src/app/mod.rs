//! The window: a second listener of a solve, beside the command line.
//!
//! [`App`] holds the scene with its edits, the solution as far as it is known, and the views. Panels edit what they are
//! handed and return a [`Command`] for the rest, which [`App`] fulfils once all are drawn (`actions`). Whatever takes
//! time runs on other threads: solving (`solving`), reading and writing (`loader`).

mod actions;
pub mod command;
mod controls;
pub mod device_loss;
pub mod document;
pub mod elements;
pub mod factors_job;
pub mod file_dialog;
mod fill_unknown;
pub mod fly_camera;
pub mod frame_times;
mod help;
pub mod keys;
pub mod layout;
mod light_handles;
mod lightmap_actions;
pub mod lightmap_job;
pub mod loader;
pub mod notices;
pub mod panel_assignment;
mod panel_light;
pub mod panel_lightmap;
mod panel_scene;
pub mod panel_screen;
pub mod panel_solution;
pub mod panel_solve;
mod panel_view;
pub mod panes;
pub mod picked;
mod plots;
mod relighting;
pub mod results;
mod saving;
mod screen_actions;
pub mod screen_job;
mod shown;
pub mod solving;
mod status_bar;
pub mod task_pictures;
mod theme;
mod tool_bar;
pub mod vertex_rays;
mod view;
pub mod view_settings;
mod window;

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use egui::{Panel, Ui, util::undoer::Undoer};
use glam::Vec3;

use command::Command;
use document::{Document, Edit};
use elements::Elements;
use file_dialog::FileDialog;
use fly_camera::FlyCamera;
use frame_times::FrameTimes;
use layout::Layout;
use loader::{Loader, OpenedScene};
use notices::{Level, Notices};
use panel_assignment::Assignment;
use panel_lightmap::LightmapPanel;
use panel_screen::ScreenPanel;
use panel_solve::SolveStatus;
use picked::{KnownShares, Picked};
use results::Results;
use solving::Solving;
use view_settings::ViewField;
pub use window::{run, wgpu_setup};

use crate::{gpu, gpu::trouble::Troubles};

/// Seconds that each bounce is shown for when they are played back.
const SECONDS_A_BOUNCE: f32 = 0.7;
/// The key of the layout in what eframe keeps from run to run.
const LAYOUT_KEY: &str = "layout";

/// The window's state.
pub struct App {
    /// The scene with its edits.
    pub document: Document,
    /// The camera of both views.
    pub camera: FlyCamera,
    /// The solution, whole or on its way.
    pub results: Option<Results>,
    /// A solution to compare with.
    pub other: Option<Results>,
    /// Panels and views.
    pub layout: Layout,
    /// What was said.
    pub notices: Notices,
    /// Frame times.
    pub frame_times: FrameTimes,
    /// The clicked point.
    pub picked: Option<Picked>,
    /// The question for a file, while it is asked.
    pub dialog: Option<FileDialog>,
    /// Where the views were drawn last.
    pub view_area: egui::Rect,
    /// The student's functions: what their tests found.
    pub assignment: Assignment,
    /// The lightmap of the graphics card.
    pub lightmap: LightmapPanel,
    /// The scene in screen space.
    pub screen: ScreenPanel,
    /// Where the plots were drawn last.
    plots_area: egui::Rect,
    /// What was last copied by [`Command::CopyView`].
    pub copied: Option<String>,
    /// Where the clicked point's light comes from.
    shares: KnownShares,
    fields: [ViewField; 2],
    /// The window's device and its queue.
    device: Option<(wgpu::Device, wgpu::Queue)>,
    /// The views are drawn on the processor's own cores.
    software_driver: bool,
    /// What the device says.
    troubles: Troubles,
    is_lost: bool,
    /// The window was opened anew after a loss.
    is_attached_again: bool,
    solving: Option<Solving>,
    /// What the kept rows cannot be lit by: it waits for ENTER.
    #[cfg(feature = "reference")]
    refused: Option<solving::SolveInput>,
    loader: Loader,
    undoer: Undoer<Edit>,
    /// When the playback of the bounces began.
    playing_since: Option<Instant>,
    /// The folder of `states` and `screenshots`.
    folder: PathBuf,
    /// The title that the window has.
    title: String,
    context: egui::Context,
}

impl App {
    /// The window of a scene; `folder` holds, or will hold, `states` and `screenshots`.
    pub fn new(creation: &eframe::CreationContext<'_>, opened: OpenedScene, folder: &Path) -> Self {
        let layout: Option<Layout> = creation.storage.and_then(|storage| eframe::get_value(storage, LAYOUT_KEY));
        let layout = layout.unwrap_or_default().checked();
        let mut notices = Notices::default();
        for warning in &opened.warnings {
            notices.say(Level::Warning, warning.as_str());
        }
        let camera = FlyCamera::new(&opened.loaded.camera, &opened.loaded.scene);
        let mut app = Self {
            document: Document::new(opened),
            camera,
            results: None,
            other: None,
            layout: Layout { ambient: true, ..layout },
            notices,
            frame_times: FrameTimes::default(),
            picked: None,
            dialog: None,
            view_area: egui::Rect::ZERO,
            plots_area: egui::Rect::ZERO,
            copied: None,
            assignment: Assignment::default(),
            lightmap: LightmapPanel::default(),
            screen: ScreenPanel::default(),
            shares: KnownShares::default(),
            fields: Default::default(),
            device: None,
            software_driver: false,
            troubles: Troubles::default(),
            is_lost: false,
            is_attached_again: false,
            solving: None,
            #[cfg(feature = "reference")]
            refused: None,
            loader: Loader::new(creation.egui_ctx.clone()),
            undoer: Undoer::default(),
            playing_since: None,
            folder: folder.to_path_buf(),
            title: String::new(),
            context: creation.egui_ctx.clone(),
        };
        app.attach(creation);
        app
    }

    /// How the solve stands.
    pub fn status(&self) -> SolveStatus {
        let solved = self.solving.as_ref().map(|solving| &solving.input);
        let solved = solved.or(self.results.as_ref().map(|results| &results.input));
        SolveStatus {
            running: self.solving.is_some() && !self.relights(),
            paused: self.solving.as_ref().is_some_and(Solving::is_paused),
            changed: solved.is_some_and(|input| *input != self.document.edit.solve_input()) && !self.relights(),
        }
    }

    /// True while kept rows are lit again.
    fn relights(&self) -> bool {
        self.solving.as_ref().is_some_and(|solving| solving.relights)
    }

    /// True while a solve has not yet traced all vertices.
    fn is_tracing(&self) -> bool {
        self.solving.is_some() && self.results.as_ref().is_none_or(|results| results.bounces.is_empty())
    }

    /// True while a solve runs and does not wait.
    fn is_working(&self) -> bool {
        self.solving.as_ref().is_some_and(|solving| !solving.is_paused())
    }

    /// True while drawing should be cheap: a software driver takes its time from the solver.
    fn saves_time(&self) -> bool {
        self.software_driver && (self.is_working() || self.lightmap.is_working())
    }

    /// True while a file is read or written.
    pub fn is_busy(&self) -> bool {
        self.loader.is_busy()
    }

    /// The elements that are shown: the solution's, or the scene's own before there is one.
    pub fn elements(&self) -> &Elements {
        self.results.as_ref().map_or(&self.document.elements, |results| &results.elements)
    }

    fn bars_ui(&mut self, ui: &mut Ui) -> Option<Command> {
        let status = self.status();
        let bar = status_bar::Status {
            solve: status,
            results: self.results.as_ref(),
            busy: self.loader.is_busy(),
            speed: self.camera.speed,
            frames: self.frame_times.summary(),
        };
        Panel::bottom("status").show(ui, |ui| status_bar::ui(ui, &bar));
        let bar = Panel::top("buttons").show(ui, |ui| tool_bar::ui(ui, status, &mut self.layout));
        bar.inner
    }

    /// Keys that are held down, dropped files, playback.
    fn go_on(&mut self, context: &egui::Context) -> Vec<Command> {
        let mut commands = Vec::new();
        if self.dialog.is_none() && !context.text_edit_focused() {
            commands = context.input(keys::commands);
            let (direction, seconds) = context.input(|input| (keys::flight(input), input.stable_dt.min(0.1)));
            if direction != Vec3::ZERO {
                self.camera.fly(direction, f64::from(seconds));
                context.request_repaint();
            }
        }
        let dropped: Vec<PathBuf> =
            context.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).collect());
        commands.extend(dropped.into_iter().map(actions::dropped));
        self.play(context);
        commands
    }

    fn play(&mut self, context: &egui::Context) {
        let Some(since) = self.playing_since else { return };
        let last = self.results.as_ref().map_or(0, |results| results.bounces.len().saturating_sub(1));
        let bounce = (since.elapsed().as_secs_f32() / SECONDS_A_BOUNCE) as usize;
        self.layout.views[0].bounce = bounce.min(last);
        if bounce >= last {
            self.playing_since = None;
        }
        context.request_repaint_after(std::time::Duration::from_millis(50));
    }

    fn dialog_ui(&mut self, context: &egui::Context) -> Option<Command> {
        let dialog = self.dialog.as_mut()?;
        let (command, stays) = dialog.ui(context);
        if !stays {
            self.dialog = None;
        }
        command
    }
}

/// What the views took of the frame before to upload and record, and whether they get finer with the next.
fn views_of_last_frame(frame: &eframe::Frame) -> (std::time::Duration, bool) {
    let Some(render_state) = frame.wgpu_render_state() else { return Default::default() };
    render_state
        .renderer
        .write()
        .callback_resources
        .get_mut::<gpu::Viewer>()
        .map_or_else(Default::default, |viewer| (viewer.take_busy_time(), viewer.is_refining()))
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        // Nothing can be drawn on a device that is gone, not even the ground.
        if self.heeds_loss() {
            return;
        }
        let (upload, refining) = views_of_last_frame(frame);
        self.frame_times.begin(frame.info().cpu_usage, upload, self.is_working());
        let context = ui.ctx().clone();
        if refining && !self.is_working() {
            context.request_repaint();
        }
        theme::set_soft_edges(&context, !self.saves_time());
        self.listen();
        self.trace_rays_of_vertex();
        self.go_on_with_screen(frame);
        let mut commands = self.go_on(&context);
        self.frame_times.end_stage(0);
        commands.extend(self.bars_ui(ui));
        let central = egui::CentralPanel::default().frame(egui::Frame::NONE);
        commands.extend(central.show(ui, |ui| panes::ui(self, ui)).inner);
        self.frame_times.end_stage(1);
        self.notices.ui(&context, self.view_area.center_top() + egui::vec2(0.0, 8.0));
        self.layout.help &= !self.layout.help || help::ui(&context);
        self.layout.frame_times &= !self.layout.frame_times || frame_times::ui(&context, &self.frame_times.summary());
        commands.extend(self.dialog_ui(&context));
        for command in commands {
            self.fulfil(command);
        }
        self.relight_if_changed();
        self.update_title();
        self.undoer.feed_state(context.input(|input| input.time), &self.document.edit);
        self.frame_times.end_stage(3);
        self.frame_times.end();
        if let Some(solving) = &self.solving {
            let software = self.software_driver;
            solving.set_frame_time(if software { f32::MAX } else { self.frame_times.summary().mean });
        }
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        theme::clear_color()
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, LAYOUT_KEY, &self.layout);
    }
}
