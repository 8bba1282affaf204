//! `radiosity screen-space`: a picture in screen space, judged by a solution, without a window.

use std::{path::PathBuf, sync::Arc};

use anyhow::{Context as _, anyhow, bail};
use clap::{ArgMatches, Args};
use serde::Serialize;

use super::{
    Outcome, files,
    files::solved_field::{AnySolution, SolvedField},
    progress::Progress,
    render::{ToneArgs, parse_size},
    scene_args::{LightArgs, LoadedScene, SceneArgs},
    screen_pictures::Pictures,
    screen_table::{Row, measure, print, variants},
    solve::solve_with_progress,
};
use crate::{
    check::picture_errors::PictureTruth,
    gpu::{
        device,
        lightmap::timing::PassTime,
        screen_space::{ScreenRenderer, ScreenSettings, ScreenView},
    },
    scene::{Tessellation, area_light::AreaLightState},
    solver::{Reconstruction, Reconstructor, SolveSettings},
    trace::Tracer,
};

/// Arguments of `radiosity screen-space`.
#[derive(Clone, Debug, Args)]
pub struct ScreenArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// How it is drawn.
    #[command(flatten, next_help_heading = "Screen space")]
    pub settings: ScreenSettings,
    /// The tone map.
    #[command(flatten)]
    pub tone: ToneArgs,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse_size)]
    pub size: (u32, u32),
    /// Still frames whose mean is judged, besides the first one alone.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub frames: u32,
    /// The solution that judges; else the scene is solved first, with the settings of its state.
    #[arg(long, value_name = "FILE")]
    pub solution: Option<PathBuf>,
    /// A part of the device's name, as `radiosity devices` lists it; else the best one.
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// Where the picture goes (PNG): the mean of all frames.
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,
    /// Where the table goes (JSON).
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// A folder for pictures of each buffer of both layers, of the solution, and of the difference to it.
    #[arg(long, value_name = "DIR")]
    pub buffers: Option<PathBuf>,
    /// Judge the settings alone, without the table of others.
    #[arg(long)]
    pub alone: bool,
}

/// What the command found.
#[derive(Clone, Debug, Serialize)]
pub struct ScreenReport {
    /// The scene.
    pub scene: String,
    /// The device.
    pub device: String,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Still frames whose mean is judged.
    pub frames: u32,
    /// The settings, as they were asked for.
    pub settings: ScreenSettings,
    /// Each setting with its errors and times; the first as it was asked for.
    pub rows: Vec<Row>,
    /// What the passes of the first row took.
    pub passes: Vec<PassTime>,
    /// The longest submission, in seconds.
    pub longest_submission_seconds: f64,
}

/// Runs the command.
pub fn run(args: &ScreenArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    if let Some(problem) = args.settings.problem() {
        bail!("{problem}");
    }
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        bail!("{}: pictures are written as PNG; end the name in .png", args.output.display());
    }
    for path in [&args.output].into_iter().chain(&args.report) {
        files::check_writable(path)?;
    }
    if let Some(folder) = &args.buffers {
        std::fs::create_dir_all(folder).with_context(|| format!("{}: the folder cannot be made", folder.display()))?;
    }
    let found = device::choose(args.device.as_deref()).map_err(anyhow::Error::msg)?;
    let solution = args.solution.as_deref().map(AnySolution::read).transpose()?;
    let loaded = match &solution {
        Some(solution) => args.scene.load_as_solved(solution.load_options())?,
        None => args.scene.load(matches)?,
    };
    let light = args.light.over(loaded.state.light)?;
    let tracer = Tracer::new(Arc::clone(&loaded.scene));
    let size = [args.size.0, args.size.1];
    let Some((truth, tessellation)) = truth(args, &loaded, light, (&tracer, solution, size))? else {
        return Ok(Outcome::Cancelled);
    };
    let (device, queue) = found.open().map_err(anyhow::Error::msg)?;
    let mut pictures =
        Pictures::new((&device, &queue), &loaded, &tessellation, light, args.tone.over(loaded.tone_map))?;
    let mesh = pictures.mesh();
    let mut renderer = ScreenRenderer::new((&device, &queue), &pictures.geometry, mesh);
    let view = ScreenView {
        camera: loaded.camera.to_local(&loaded.scene.frame),
        size,
        light: light.map(|light| light.to_local(&loaded.scene.frame)),
        materials: Arc::new(loaded.scene.materials.clone()),
    };
    let mut progress = Progress::new(false);
    let variants = if args.alone { variants(&args.settings)[..1].to_vec() } else { variants(&args.settings) };
    let mut rows = Vec::new();
    let mut passes = Vec::new();
    for (number, (name, settings)) in variants.iter().enumerate() {
        let row = measure(&mut renderer, &view, (name, settings), &truth, args.frames).map_err(anyhow::Error::msg)?;
        if number == 0 {
            passes = renderer.pass_times();
            pictures.write(
                &mut renderer,
                &view,
                (settings, args.frames),
                &truth,
                (&args.output, args.buffers.as_deref()),
            )?;
        }
        rows.push(row);
        progress.update((number + 1) as f32 / variants.len() as f32, name);
    }
    progress.finish("done");
    let report = ScreenReport {
        scene: loaded.scene.name.clone(),
        device: format!("{} [{}]", found.info.name, found.info.backend),
        size,
        frames: args.frames,
        settings: args.settings.clone(),
        rows,
        passes,
        longest_submission_seconds: renderer.submissions().1.as_secs_f64(),
    };
    print(&report);
    println!("picture    {}", args.output.display());
    if let Some(path) = &args.report {
        let json = serde_json::to_string_pretty(&report).context("the report")?;
        files::write_atomically(path, |writer| Ok(writer.write_all(json.as_bytes())?))?;
    }
    Ok(Outcome::Done)
}

/// What the solution says arrives at each pixel, and elements that the scene is drawn by; none if the solve was cancelled.
fn truth(
    args: &ScreenArgs,
    loaded: &LoadedScene,
    light: Option<AreaLightState>,
    (tracer, solution, size): (&Tracer, Option<AnySolution>, [u32; 2]),
) -> anyhow::Result<Option<(PictureTruth, Tessellation)>> {
    let (scene, camera) = (&loaded.scene, loaded.camera.to_local(&loaded.scene.frame));
    if let (Some(solution), Some(path)) = (solution, &args.solution) {
        let solved_light = match &solution {
            AnySolution::Vertices(solution) => solution.info.light,
            AnySolution::Lightmap(solution) => solution.info.light,
        };
        if solved_light != light {
            bail!("{}: it was solved with another area light than the picture is drawn with", path.display());
        }
        let field = SolvedField::new(path, solution, scene)?;
        let at = field.rebuilt(scene, tracer, RECONSTRUCTION);
        let elements = Tessellation::new(scene, &SolveSettings::default().tessellation());
        return Ok(Some((PictureTruth::new(tracer, &camera, size, at), elements.map_err(|error| anyhow!("{error}"))?)));
    }
    let settings = loaded.state.settings.clone().unwrap_or_default();
    let solved = solve_with_progress(loaded, light, settings, 0, false)?;
    if !solved.solution.info.complete {
        return Ok(None);
    }
    let field = Reconstructor::new(scene, tracer, &solved.tessellation, &solved.solution, RECONSTRUCTION);
    let at = |triangle, place| field.direct_and_total(triangle, place);
    let truth = PictureTruth::new(tracer, &camera, size, at);
    let elements = Tessellation::clone(&solved.tessellation);
    Ok(Some((truth, elements)))
}

/// Direct light at the pixels themselves, where the program can compute it.
#[cfg(feature = "reference")]
const RECONSTRUCTION: Reconstruction = Reconstruction::PointDirect;
/// Direct light at the pixels themselves, where the program can compute it.
#[cfg(not(feature = "reference"))]
const RECONSTRUCTION: Reconstruction = Reconstruction::Vertex;
