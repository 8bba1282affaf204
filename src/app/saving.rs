//! What the window saves of a solution, and its comparison with a truth.

use std::{path::PathBuf, sync::Arc, time::Duration};

use anyhow::Context as _;

use super::{
    App,
    loader::{self, Done},
    notices::Level,
    plots,
    results::TruthView,
};
use crate::{
    files::{self, mesh_export},
    solver::Solution,
};

impl App {
    pub(super) fn save_solution(&mut self, path: PathBuf) {
        let Some(solution) = self.results.as_ref().and_then(|results| results.solution.clone()) else {
            let advice = "There is no solution to save yet: press ENTER, and wait for its end";
            self.notices.say(Level::Error, advice);
            return;
        };
        self.loader.run(move || {
            files::write_solution(&path, &solution)?;
            Ok(Done::Written(path))
        });
    }

    pub(super) fn save_mesh(&mut self, path: PathBuf) {
        let solved =
            self.results.as_ref().and_then(|results| Some((results.solution.clone()?, results.elements.clone())));
        let Some((solution, elements)) = solved else {
            let advice = "There is no solution to save as a mesh yet: press ENTER, and wait for its end";
            self.notices.say(Level::Error, advice);
            return;
        };
        let tone_map = self.document.edit.tone_map;
        self.loader.run(move || {
            let (scene, tessellation) = (&elements.scene, &elements.tessellation);
            let as_table = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
            files::write_atomically(&path, |writer| {
                if as_table {
                    mesh_export::write_csv(writer, scene, tessellation, &solution)
                } else {
                    mesh_export::write_ply(writer, scene, tessellation, &solution, &tone_map)
                }
            })?;
            Ok(Done::Written(path))
        });
    }

    pub(super) fn save_plots(&mut self, path: PathBuf) {
        let Some(results) = &self.results else {
            self.notices.say(Level::Error, "There are no curves yet: press ENTER");
            return;
        };
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            self.layout.plots = true;
            let area = self.plots_area * self.context.pixels_per_point();
            self.picture_of_window(Some(area), move || Ok(path));
            return;
        }
        let table = plots::table(results);
        self.loader.run(move || {
            files::write_atomically(&path, |writer| Ok(writer.write_all(table.as_bytes())?))?;
            Ok(Done::Written(path))
        });
    }

    pub(super) fn compare_with_truth(&mut self, path: PathBuf) {
        let solved =
            self.results.as_ref().and_then(|results| Some((results.solution.clone()?, results.elements.clone())));
        let Some((solution, elements)) = solved else {
            self.notices.say(Level::Error, "There is no solution to compare yet: press ENTER, and wait for its end");
            return;
        };
        self.loader.run(move || {
            let truth = loader::compare_with_truth(&path, &elements, &solution)?;
            Ok(Done::Truth(Box::new(truth), solution))
        });
    }

    /// Shows a comparison, if the solution is still the one that was compared.
    pub(super) fn show_truth(&mut self, truth: TruthView, compared: &Arc<Solution>) {
        let Some(results) = &mut self.results else { return };
        if results.solution.as_ref().is_some_and(|solution| Arc::ptr_eq(solution, compared)) {
            let error = 100.0 * truth.comparison.errors.lit.total.relative_l2;
            self.notices.say(Level::Note, format!("{}: {error:.2} % off over the lit points", truth.name));
            results.truth = Some(Arc::new(truth));
        }
    }

    pub(super) fn screenshot(&mut self) {
        let folder = self.folder.join("screenshots");
        let name = self.document.loaded.scene.name.clone();
        self.picture_of_window(None, move || {
            std::fs::create_dir_all(&folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
            let free = (1..).map(|number| folder.join(format!("{name}-{number}.png"))).find(|path| !path.exists());
            Ok(free.unwrap_or_else(|| folder.join("screenshot.png")))
        });
    }

    /// Writes a picture of the window, or of a part of it in pixels, to where `path` says.
    fn picture_of_window(
        &mut self,
        part: Option<egui::Rect>,
        path: impl FnOnce() -> anyhow::Result<PathBuf> + Send + 'static,
    ) {
        let (sender, receiver) = std::sync::mpsc::channel();
        self.context.request_screenshot(move |image| {
            // The thread that waits for it ends with the window.
            let _ = sender.send(image);
        });
        self.loader.run(move || {
            let wait = Duration::from_secs(10);
            let image = receiver.recv_timeout(wait).map_err(|_| anyhow::anyhow!("the window gave no picture"))?;
            let [width, height] = image.size.map(|pixels| pixels as u32);
            let bytes: Vec<u8> = image.pixels.iter().flat_map(|pixel| pixel.to_array()).collect();
            let mut picture =
                image::RgbaImage::from_raw(width, height, bytes).context("the window's picture is damaged")?;
            if let Some(part) = part {
                let [left, top, across, down] =
                    [part.left(), part.top(), part.width(), part.height()].map(|pixels| pixels.max(0.0) as u32);
                picture = image::imageops::crop(&mut picture, left, top, across, down).to_image();
            }
            let path = path()?;
            files::write_picture(&path, &picture)?;
            Ok(Done::Written(path))
        });
    }
}
