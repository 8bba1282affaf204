//! The panel of the assignment: the tasks of `radiosity check` with what is wrong, a picture of what a sampler does, and
//! the rays of one vertex.

use egui::{Color32, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints, Points};

use super::{
    command::Command,
    task_pictures::TaskPicture,
    vertex_rays::{VertexRaysView, colour},
};
use crate::{
    check::tasks::{Status, TASKS, TaskReport},
    solver::Engine,
};

/// What is known of the student's functions, and what the panel shows.
#[derive(Default)]
pub struct Assignment {
    /// The tasks that were tested, in the order of [`TASKS`].
    pub reports: Vec<TaskReport>,
    /// Pictures of the samplers, by task.
    pub pictures: Vec<(&'static str, TaskPicture)>,
    /// True while tests run.
    pub running: bool,
    /// The task whose picture is shown.
    pub shown: Option<&'static str>,
    /// The rays of the clicked point's vertex.
    pub rays: VertexRaysView,
}

impl Assignment {
    /// Takes in what the tests of some tasks found.
    pub fn take(&mut self, reports: Vec<TaskReport>, pictures: Vec<(&'static str, TaskPicture)>) {
        self.running = false;
        for report in reports {
            self.reports.retain(|known| known.task != report.task);
            self.reports.push(report);
        }
        let place = |name: &str| TASKS.iter().position(|task| task.name == name);
        self.reports.sort_by_key(|report| place(report.task));
        for (task, picture) in pictures {
            self.pictures.retain(|(known, _)| *known != task);
            self.pictures.push((task, picture));
        }
    }

    fn report(&self, task: &str) -> Option<&TaskReport> {
        self.reports.iter().find(|report| report.task == task)
    }
}

/// Draws the panel. `has_point` tells whether a point of the scene was clicked.
pub(super) fn ui(ui: &mut Ui, assignment: &mut Assignment, engine: &mut Engine, has_point: bool) -> Option<Command> {
    let mut command = None;
    let mut with_student = *engine == Engine::Student;
    let tooltip = "ENTER then runs the functions of src/student, on all cores; off: the program's own engine";
    ui.add_enabled_ui(cfg!(feature = "reference"), |ui| {
        if ui.checkbox(&mut with_student, "Solve with src/student").on_hover_text(tooltip).changed() {
            *engine = if with_student { Engine::Student } else { Engine::Reference };
        }
    });
    ui.horizontal(|ui| {
        let test = egui::Button::new("Test all tasks");
        if ui.add_enabled(!assignment.running, test).on_hover_text("As `radiosity check` does").clicked() {
            command = Some(Command::Check(None));
        }
        if assignment.running {
            ui.spinner();
        } else if !assignment.reports.is_empty() {
            let earned: f32 = assignment.reports.iter().map(|report| report.earned).sum();
            ui.label(format!("{earned} points"));
        }
    });
    egui::Grid::new("tasks").num_columns(4).striped(true).show(ui, |ui| {
        for task in &TASKS {
            let name = if task.is_extra { format!("{} (extra)", task.name) } else { String::from(task.name) };
            ui.label(name).on_hover_text(task.title);
            ui.label(task.points.to_string());
            let (text, colour) = status(assignment.report(task.name));
            ui.label(RichText::new(text).color(colour));
            let test = egui::Button::new(format!("Test {}", task.name)).small();
            if ui.add_enabled(!assignment.running, test).clicked() {
                assignment.shown = Some(task.name);
                command = Some(Command::Check(Some(task.name)));
            }
            ui.end_row();
        }
    });
    for report in &assignment.reports {
        finding_ui(ui, report);
    }
    if let Some((_, picture)) = assignment.pictures.iter().find(|(task, _)| Some(*task) == assignment.shown) {
        picture_ui(ui, picture);
    }
    rays_ui(ui, &mut assignment.rays, has_point);
    command
}

fn status(report: Option<&TaskReport>) -> (&'static str, Color32) {
    match report.map(|report| &report.status) {
        None => ("not tested", Color32::GRAY),
        Some(Status::Done) => ("done", Color32::from_rgb(90, 200, 100)),
        Some(Status::Waits(_)) => ("waits", Color32::from_rgb(240, 190, 80)),
        Some(Status::NotDone(_)) => ("not done", Color32::from_rgb(240, 190, 80)),
        Some(Status::Wrong(_)) => ("wrong", Color32::from_rgb(235, 90, 80)),
    }
}

fn finding_ui(ui: &mut Ui, report: &TaskReport) {
    match &report.status {
        Status::Done => {}
        Status::NotDone(function) => {
            ui.label(RichText::new(format!("{}: write {function}", report.task)).small());
        }
        Status::Waits(task) => {
            ui.label(RichText::new(format!("{}: {task} comes first", report.task)).small());
        }
        Status::Wrong(finding) => {
            egui::CollapsingHeader::new(format!("{}: {}", report.task, finding.function)).default_open(true).show(
                ui,
                |ui| {
                    ui.label(&finding.hint);
                    ui.label(RichText::new(format!("{}: {}", finding.test, finding.measured)).small());
                    ui.label(RichText::new(format!("expected: {}", finding.expected)).small());
                },
            );
        }
    }
}

fn picture_ui(ui: &mut Ui, picture: &TaskPicture) {
    ui.label(picture.title);
    let plot = Plot::new("what the function does").height(220.0).data_aspect(1.0);
    plot.allow_scroll(false).allow_drag(false).allow_zoom(false).show(ui, |plot| {
        let outline = Line::new("outline", PlotPoints::from(picture.outline.clone()));
        plot.line(outline.color(Color32::GRAY));
        let points = Points::new("points", PlotPoints::from(picture.points.clone()));
        plot.points(points.radius(1.5).color(Color32::from_rgb(240, 190, 80)));
    });
}

fn rays_ui(ui: &mut Ui, view: &mut VertexRaysView, has_point: bool) {
    ui.separator();
    ui.horizontal(|ui| {
        let tooltip = "Draws every ray that src/student traces for the vertex nearest to the clicked point";
        ui.checkbox(&mut view.show, "Rays of one vertex, bounce").on_hover_text(tooltip);
        ui.add(egui::DragValue::new(&mut view.bounce).range(0..=1000).speed(0.05))
            .on_hover_text("0 is direct light; later ones need the bounces before them");
    });
    match (&view.rays, view.show, has_point) {
        (_, true, false) => drop(ui.weak("Click a point of the scene.")),
        (Some(rays), true, true) => {
            ui.label(format!("vertex {}: {} rays", rays.vertex, rays.rays.len()));
            match &rays.irradiance {
                Ok(value) => ui.label(format!("irradiance {:.3} {:.3} {:.3} W/m²", value.x, value.y, value.z)),
                Err(fault) => ui.colored_label(super::notices::Level::Error.colour(), fault.to_string()),
            };
            let legend = [("free or front", true), ("blocked, back or nothing", false)];
            ui.horizontal(|ui| legend.map(|(text, brings)| ui.colored_label(colour(brings), text)));
        }
        _ => {}
    }
}
