//! `radiosity truth`: irradiance at points of the surfaces by the reference path tracer.

use std::path::PathBuf;

use anyhow::bail;
use clap::{ArgMatches, Args};

use super::{
    Outcome, files,
    progress::Progress,
    scene_args::{LightArgs, SceneArgs},
};
use crate::{
    check::{
        path_tracer::{PathSettings, PathTracer, PointEstimate},
        surface_points::{area_uniform_points, locate, ray_origin, truth_point},
        truth_file::{self, TruthFile, TruthPoint, TruthValue},
    },
    scene::{Scene, area_light::AreaLightState},
    trace::{SurfacePoint, Tracer},
};

/// Arguments of `radiosity truth`.
///
/// Points and result are CSV files with columns by name: px,py,pz (point, metres), nx,ny,nz (shading normal), and in
/// the result direct_r,g,b, bounce1_r,g,b, bounce2_r,g,b (those bounces alone), total_r,g,b (all bounces) and se_r,g,b
/// (standard error of the total), in W/m².
#[derive(Clone, Debug, Args)]
pub struct TruthArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// Points to compute, as CSV with the columns px,py,pz,nx,ny,nz; others are left unread.
    #[arg(long, value_name = "FILE", conflicts_with = "sample", required_unless_present = "sample")]
    pub points: Option<PathBuf>,
    /// Take this many points instead, uniform by area over all surfaces.
    #[arg(long, value_name = "COUNT")]
    pub sample: Option<u32>,
    /// Paths a point. The error falls with the square root: 65536 gives about 0.3 %.
    #[arg(long, value_name = "N", default_value_t = 1024)]
    pub samples: u32,
    /// Indirect bounces; later ones are left out.
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub bounces: u32,
    /// Seed of all random numbers: the same seed gives the same bits on any number of threads.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Where the result goes (CSV).
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Show no progress.
    #[arg(long)]
    pub quiet: bool,
}

/// Runs the command.
pub fn run(args: &TruthArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    if args.samples < 2 {
        bail!("--samples {}: a standard error needs at least 2 paths a point", args.samples);
    }
    let loaded = args.scene.load(matches)?;
    let light = args.light.over(loaded.state.light)?;
    let scene = &loaded.scene;
    if light.is_none() && scene.emissive_triangles().next().is_none() {
        eprintln!("warning: nothing shines in this scene; place a light with --light-centre and the like, or --state");
    }
    let tracer = Tracer::new(scene.clone());
    let (points, origins) = points_of(args, scene, &tracer)?;
    let settings = PathSettings { samples: args.samples, bounces: args.bounces, seed: args.seed };
    let area_light = light.map(|light| light.to_local(&scene.frame));
    let mut progress = Progress::new(args.quiet);
    let count = points.len();
    let estimates = PathTracer::new(scene, &tracer, area_light.as_ref(), settings).estimate_all(&origins, |done| {
        progress.update(done as f32 / count as f32, &format!("{done} of {count} points"));
    });
    progress.finish(&format!("{count} points of {} paths: {}", args.samples, args.output.display()));
    let file = TruthFile {
        comments: comments(args, light.as_ref()),
        points,
        values: Some(estimates.iter().map(truth_value).collect()),
    };
    files::write_atomically(&args.output, |writer| Ok(truth_file::write(&file, writer)?))?;
    Ok(Outcome::Done)
}

/// The points to compute, and where their rays leave from.
fn points_of(args: &TruthArgs, scene: &Scene, tracer: &Tracer) -> anyhow::Result<(Vec<TruthPoint>, Vec<SurfacePoint>)> {
    let Some(path) = &args.points else {
        let places = area_uniform_points(scene, args.sample.unwrap_or(0), args.seed);
        if places.is_empty() {
            bail!("{}: no points to compute: no surface, or --sample 0", args.scene.scene.display());
        }
        let origins = places.iter().map(|&(triangle, place)| SurfacePoint::new(scene, triangle, place)).collect();
        return Ok((places.iter().map(|&place| truth_point(scene, place)).collect(), origins));
    };
    let points = truth_file::read(path)?.points;
    if points.is_empty() {
        bail!("{}: holds no points", path.display());
    }
    let located: Vec<_> = points.iter().map(|point| locate(scene, tracer, point)).collect();
    let astray = located.iter().filter(|place| place.is_none()).count();
    if astray > 0 {
        eprintln!("warning: {astray} of {} points lie on no surface of the scene; kept where they are", points.len());
    }
    let origins = points.iter().zip(located).map(|(point, place)| ray_origin(scene, point, place)).collect();
    Ok((points, origins))
}

fn comments(args: &TruthArgs, light: Option<&AreaLightState>) -> Vec<String> {
    let light = light.map_or_else(
        || String::from("emissive materials only"),
        |light| {
            let triple = |values: [f64; 3]| values.map(|value| value.to_string()).join(",");
            let radiance = light.radiance.map(|band| band.to_string()).join(",");
            let (u, v) = (glam::DVec3::from_array(light.u), glam::DVec3::from_array(light.v));
            let normal = triple(u.cross(v).normalize_or_zero().to_array());
            format!("{} {} {} {normal} {radiance}", triple(light.centre), triple(light.u), triple(light.v))
        },
    );
    vec![
        format!("scene: {}", args.scene.scene.file_name().unwrap_or_default().display()),
        format!("light (centre u v normal radiance): {light}"),
        format!(
            "{} samples a point, {} indirect bounces, front sides only, light is not geometry, seed {}",
            args.samples, args.bounces, args.seed
        ),
    ]
}

fn truth_value(estimate: &PointEstimate) -> TruthValue {
    TruthValue {
        direct: estimate.direct.mean,
        bounce1: estimate.bounce1.mean,
        bounce2: estimate.bounce2.mean,
        total: estimate.total.mean,
        standard_error: estimate.total.standard_error,
    }
}
