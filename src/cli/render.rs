//! `radiosity render`: a solution as a picture.

use std::{path::PathBuf, time::Instant};

use anyhow::{anyhow, bail};
use clap::Args;

#[cfg(feature = "reference")]
use crate::{solver::Reconstructor, trace::SurfacePoint, transport::visible_light::Scratch};

use super::{Outcome, files, scene_args::LoadedScene, solved_scene};
use crate::{
    files::solved_field::AnySolution,
    math::color::{ToneCurve, ToneMap},
    render::{RenderSettings, Subject, View, render, view::VIEW_NAMES},
    scene::{Tessellation, tessellate::TessellationOptions},
    solver::{LightmapSolution, Reconstruction, Solution, lightmap_solution},
    trace::Tracer,
};

/// Arguments of `radiosity render`.
#[derive(Clone, Debug, Args)]
pub struct RenderArgs {
    /// The scene: an OBJ file or `cornell`. It is read with the options that it was solved with.
    pub scene: PathBuf,
    /// The solution, or the lightmap.
    pub solution: PathBuf,
    /// State file (TOML) with camera and tone map, if not the one beside the scene.
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// What is shown.
    #[arg(long, default_value_t = View::Radiosity, help = format!("What is shown: {VIEW_NAMES}"))]
    pub view: View,
    /// How the field is rebuilt between the vertices.
    #[arg(long, value_enum, default_value_t)]
    pub reconstruct: Reconstruction,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "960x720", value_parser = parse_size)]
    pub size: (u32, u32),
    /// Rays a pixel.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: u32,
    /// The tone map.
    #[command(flatten)]
    pub tone: ToneArgs,
    /// Where the picture goes (PNG).
    #[arg(short, long, value_name = "FILE.png")]
    pub output: PathBuf,
}

/// The tone map by flags; each replaces that part of the state's.
#[derive(Clone, Debug, Default, Args)]
pub struct ToneArgs {
    /// Exposure in stops: 1 doubles the brightness.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = parse_stops)]
    pub exposure: Option<f32>,
    /// Clip at white, or roll off towards it.
    #[arg(long, value_enum)]
    pub tone_curve: Option<ToneCurve>,
}

impl ToneArgs {
    /// `saved` with the flags' parts in place.
    pub fn over(&self, saved: ToneMap) -> ToneMap {
        ToneMap {
            exposure: self.exposure.unwrap_or(saved.exposure),
            curve: self.tone_curve.unwrap_or(saved.curve),
            ..saved
        }
    }
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> anyhow::Result<Outcome> {
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        bail!("{}: pictures are written as PNG; end the name in .png", args.output.display());
    }
    match AnySolution::read(&args.solution)? {
        AnySolution::Vertices(solution) => render_vertices(args, solution),
        AnySolution::Lightmap(solution) => render_lightmap(args, &solution),
    }
}

fn render_vertices(args: &RenderArgs, solution: Solution) -> anyhow::Result<Outcome> {
    let solved = solved_scene::with_scene(&args.solution, solution, &args.scene, args.state.as_deref())?;
    let scene = &solved.loaded.scene;
    let field = args.view.field(&solved.solution, args.reconstruct);
    let field = field.map_err(|problem| anyhow!("{}: {problem}", args.solution.display()))?;
    let tracer = Tracer::new(scene.clone());
    #[cfg(feature = "reference")]
    let rebuilt = Reconstructor::new(scene, &tracer, &solved.tessellation, &solved.solution, args.reconstruct);
    #[cfg(feature = "reference")]
    let direct = |point: &SurfacePoint, scratch: &mut Scratch| rebuilt.direct_at(point, scratch);
    let subject = Subject {
        scene,
        tracer: &tracer,
        tessellation: &solved.tessellation,
        charts: None,
        field: &field,
        #[cfg(feature = "reference")]
        direct: (args.reconstruct == Reconstruction::PointDirect && args.view.shows_direct()).then_some(&direct),
        #[cfg(not(feature = "reference"))]
        direct: None,
        light: solved.solution.info.light.map(|light| light.to_local(&scene.frame)),
    };
    draw(args, &subject, &solved.loaded)
}

fn render_lightmap(args: &RenderArgs, solution: &LightmapSolution) -> anyhow::Result<Outcome> {
    if args.reconstruct != Reconstruction::default() {
        bail!("a lightmap is read between its texels: --reconstruct is for solutions at vertices");
    }
    let loaded = solved_scene::load(&args.scene, args.state.as_deref(), &solution.info.load)?;
    let scene = &loaded.scene;
    let named = |problem: String| anyhow!("{}: {problem}", args.solution.display());
    lightmap_solution::check_scene(solution, scene).map_err(|problem| named(problem.to_string()))?;
    let whole = TessellationOptions { subdivide: 0, max_edge: None };
    let subject = Subject {
        scene,
        tracer: &Tracer::new(scene.clone()),
        tessellation: &Tessellation::new(scene, &whole).map_err(named)?,
        charts: Some(&solution.charts),
        field: &args.view.texels(solution).map_err(named)?,
        direct: None,
        light: solution.info.light.map(|light| light.to_local(&scene.frame)),
    };
    draw(args, &subject, &loaded)
}

fn draw(args: &RenderArgs, subject: &Subject<'_, Tracer>, loaded: &LoadedScene) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let (width, height) = args.size;
    let tone_map = args.tone.over(loaded.tone_map);
    let settings = RenderSettings { width, height, view: args.view, samples: args.samples, tone_map };
    let picture = render(subject, &loaded.camera.to_local(&subject.scene.frame), &settings);
    let seconds = started.elapsed().as_secs_f64();
    files::write_picture(&args.output, &picture)?;
    eprintln!("{}: {width}x{height} pixels, drawn in {seconds:.2} s", args.output.display());
    Ok(Outcome::Done)
}

/// `WxH`, each from 1 to 16384.
pub(super) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| (1..=16_384).contains(side));
    let (width, height) = text.split_once(['x', 'X']).ok_or("a size is written as 960x720")?;
    side(width).zip(side(height)).ok_or_else(|| String::from("width and height must be whole numbers from 1 to 16384"))
}

/// A number of stops that f32 can still multiply light by.
fn parse_stops(text: &str) -> Result<f32, String> {
    let stops = text.parse::<f32>().ok().filter(|stops| stops.abs() <= 60.0);
    stops.ok_or_else(|| String::from("an exposure is a number of stops from -60 to 60"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_stops_are_read_and_bad_ones_refused() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        for bad in ["640", "0x480", "640x-1", "x", "99999x1", "1x1x1"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_stops("-1.5"), Ok(-1.5));
        for bad in ["nan", "inf", "", "1e9"] {
            assert!(parse_stops(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn tone_flags_replace_only_what_they_name() {
        let saved = ToneMap { exposure: 2.0, white: 5.0, gamma: 1.1, curve: ToneCurve::Plain };
        let flags = ToneArgs { exposure: None, tone_curve: Some(ToneCurve::Filmic) };
        assert_eq!(flags.over(saved), ToneMap { curve: ToneCurve::Filmic, ..saved });
        let flags = ToneArgs { exposure: Some(0.0), tone_curve: None };
        assert_eq!(flags.over(saved), ToneMap { exposure: 0.0, ..saved });
    }
}
