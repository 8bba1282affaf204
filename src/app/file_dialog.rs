//! Asking for a file: a path to type, and a list of the folder to click in.

use std::path::{Path, PathBuf};

use egui::{Align2, Key};

use super::command::Command;

/// What a file is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A scene to open.
    OpenScene,
    /// A mesh or table to write.
    SaveMesh,
    /// A solution to write.
    SaveSolution,
    /// A solution to show.
    LoadSolution,
    /// A solution to compare with.
    LoadOther,
    /// A truth to compare with.
    LoadTruth,
    /// Curves of convergence to write.
    SavePlots,
    /// A state file to write.
    SaveState,
    /// A state file to read.
    LoadState,
}

impl Purpose {
    fn title(self) -> &'static str {
        match self {
            Self::OpenScene => "Open a scene (OBJ)",
            Self::SaveMesh => "Save the solution as a mesh (.ply) or a table (.csv)",
            Self::SaveSolution => "Save the solution",
            Self::LoadSolution => "Load a solution",
            Self::LoadOther => "Load a solution to compare with",
            Self::LoadTruth => "Load a truth to compare with (points and values, .csv)",
            Self::SavePlots => "Save the curves as a table (.csv) or a picture (.png)",
            Self::SaveState => "Save camera, light, settings and tone map",
            Self::LoadState => "Load camera, light, settings and tone map",
        }
    }

    fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::OpenScene => &["obj"],
            Self::SaveMesh => &["ply", "csv"],
            Self::SaveSolution | Self::LoadSolution | Self::LoadOther => &["safetensors"],
            Self::LoadTruth => &["csv"],
            Self::SavePlots => &["csv", "png"],
            Self::SaveState | Self::LoadState => &["toml"],
        }
    }

    fn saves(self) -> bool {
        matches!(self, Self::SaveMesh | Self::SaveSolution | Self::SavePlots | Self::SaveState)
    }

    fn command(self, path: PathBuf) -> Command {
        match self {
            Self::OpenScene => Command::OpenScene(path),
            Self::SaveMesh => Command::SaveMesh(path),
            Self::SaveSolution => Command::SaveSolution(path),
            Self::LoadSolution => Command::LoadSolution(path),
            Self::LoadOther => Command::LoadOther(path),
            Self::LoadTruth => Command::CompareWithTruth(path),
            Self::SavePlots => Command::SavePlots(path),
            Self::SaveState => Command::SaveState(path),
            Self::LoadState => Command::LoadState(path),
        }
    }
}

/// An open question for a file.
pub struct FileDialog {
    purpose: Purpose,
    folder: PathBuf,
    /// What is typed: a path from the folder, or an absolute one.
    name: String,
    folders: Vec<String>,
    files: Vec<String>,
    is_new: bool,
}

impl FileDialog {
    /// Asks, with the folder's files to choose from; `name` is what stands in the field at first.
    pub fn new(purpose: Purpose, folder: &Path, name: &str) -> Self {
        let mut dialog = Self {
            purpose,
            folder: folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf()),
            name: String::from(name),
            folders: Vec::new(),
            files: Vec::new(),
            is_new: true,
        };
        dialog.list();
        dialog
    }

    /// The folder that is shown.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn list(&mut self) {
        self.folders.clear();
        self.files.clear();
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        for entry in entries.flatten() {
            let path = entry.path();
            let name = entry.file_name().to_string_lossy().into_owned();
            let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
            if name.starts_with('.') {
                continue;
            } else if path.is_dir() {
                self.folders.push(name);
            } else if self.purpose.extensions().iter().any(|known| extension.eq_ignore_ascii_case(known)) {
                self.files.push(name);
            }
        }
        self.folders.sort_unstable();
        self.files.sort_unstable();
    }

    fn enter(&mut self, folder: PathBuf) {
        self.folder = folder;
        self.list();
    }

    /// The path as typed; one to be saved gets the first extension if it has none.
    fn path(&self) -> PathBuf {
        let mut path = self.folder.join(self.name.trim());
        if self.purpose.saves() && path.extension().is_none() {
            path.set_extension(self.purpose.extensions()[0]);
        }
        path
    }

    /// Draws the dialog. The second value is false once it is to be closed.
    pub fn ui(&mut self, context: &egui::Context) -> (Option<Command>, bool) {
        let mut stays = true;
        let mut accepted = false;
        let window = egui::Window::new(self.purpose.title()).collapsible(false).default_size([460.0, 380.0]);
        window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).resizable(true).show(context, |ui| {
            accepted |= self.name_ui(ui);
            accepted |= self.list_ui(ui);
            ui.separator();
            ui.horizontal(|ui| {
                accepted |= ui.button(if self.purpose.saves() { "Save" } else { "Open" }).clicked();
                stays &= !ui.button("Cancel").clicked();
            });
        });
        if accepted && self.folder.join(self.name.trim()).is_dir() {
            let folder = self.folder.join(std::mem::take(&mut self.name).trim());
            self.enter(folder);
            accepted = false;
        }
        stays &= !context.input(|input| input.key_pressed(Key::Escape));
        let command = accepted.then(|| self.purpose.command(self.path()));
        (command, stays && !accepted)
    }

    fn name_ui(&mut self, ui: &mut egui::Ui) -> bool {
        let label = ui.label("File name or path");
        let field = ui.add(egui::TextEdit::singleline(&mut self.name).desired_width(f32::INFINITY));
        let field = field.labelled_by(label.id);
        if std::mem::take(&mut self.is_new) {
            field.request_focus();
        }
        if self.purpose.saves() && !self.name.trim().is_empty() && self.path().is_file() {
            ui.colored_label(super::notices::Level::Warning.colour(), "This file exists and will be replaced.");
        }
        field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
    }

    fn list_ui(&mut self, ui: &mut egui::Ui) -> bool {
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("The folder above").clicked()
                && let Some(parent) = self.folder.parent().map(Path::to_path_buf)
            {
                self.enter(parent);
            }
            ui.label(self.folder.display().to_string());
        });
        let (mut entered, mut accepted) = (None, false);
        egui::ScrollArea::vertical().max_height(260.0).auto_shrink([false, false]).show(ui, |ui| {
            for name in &self.folders {
                if ui.selectable_label(false, format!("{name}/")).clicked() {
                    entered = Some(self.folder.join(name));
                }
            }
            for name in &self.files {
                let row = ui.selectable_label(*name == self.name, name);
                if row.clicked() {
                    self.name.clone_from(name);
                }
                accepted |= row.double_clicked();
            }
        });
        if let Some(folder) = entered {
            self.enter(folder);
        }
        accepted
    }
}
