//! The program without a command and without a window: the built-in Cornell box, solved, summed up and drawn.

use std::path::{Path, PathBuf};

use super::{
    Outcome, files,
    scene_args::{LoadedScene, SceneArgs},
    solve::{Solved, full_report, print_summary, solve_with_progress},
};
use crate::{
    render::{RenderSettings, Subject, render},
    scene::LoadOptions,
};

const PICTURE: &str = "cornell.png";

/// Solves the built-in Cornell box with its own state, and writes a picture into the current folder.
pub fn run() -> anyhow::Result<Outcome> {
    println!("Solving the built-in Cornell box; Ctrl-C stops and keeps what there is. `radiosity --help` shows more.");
    let args = SceneArgs { scene: PathBuf::from("cornell"), state: None, load: LoadOptions::default() };
    let loaded = args.load_as_solved(&LoadOptions::default())?;
    let settings = loaded.state.settings.clone().unwrap_or_default();
    let solved = solve_with_progress(&loaded, loaded.state.light, settings, 0, false)?;
    print_summary(&full_report(&loaded, &solved, 0));
    draw(&loaded, &solved)?;
    println!("picture    {PICTURE}");
    Ok(if solved.solution.info.complete { Outcome::Done } else { Outcome::Cancelled })
}

fn draw(loaded: &LoadedScene, solved: &Solved) -> anyhow::Result<()> {
    let scene = &loaded.scene;
    let subject = Subject {
        scene,
        tracer: &*solved.tracer,
        tessellation: &solved.tessellation,
        charts: None,
        field: &solved.solution.total(),
        direct: None,
        light: solved.solution.info.light.map(|light| light.to_local(&scene.frame)),
    };
    let settings = RenderSettings { tone_map: loaded.tone_map, ..RenderSettings::default() };
    let picture = render(&subject, &loaded.camera.to_local(&scene.frame), &settings);
    files::write_picture(Path::new(PICTURE), &picture)
}
