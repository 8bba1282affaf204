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
    trace::{Located, SurfacePoint, Tracer},
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
        let origins = places
            .iter()
            .map(|&(triangle, place)| SurfacePoint::new(scene, triangle, place).on_curve(scene, place, tracer))
            .collect();
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
    let origins = points
        .iter()
        .zip(located)
        .map(|(point, place)| ray_origin(scene, tracer, point, place.and_then(Located::on)))
        .collect();
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

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use clap::{Command, FromArgMatches as _};

    use super::*;
    use crate::check::closed_form::polygon_irradiance;

    /// Runs the command as it is typed.
    fn truth(words: &[&str]) -> anyhow::Result<Outcome> {
        let matches =
            TruthArgs::augment_args(Command::new("truth")).try_get_matches_from([&["truth"], words].concat())?;
        run(&TruthArgs::from_arg_matches(&matches)?, &matches)
    }

    #[test]
    fn points_are_sampled_computed_and_computed_again_from_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        std::fs::write(at("floor.obj"), "v 0 0 0\nv 0 0 2\nv 2 0 2\nv 2 0 0\nf 1 2 3 4\n").unwrap();
        let light = ["--light-centre", "1,1.5,1", "--light-u", "0.5,0,0", "--light-v", "0,0,0.25"];
        let light = [&light[..], &["--light-radiance", "8,4,2", "--samples", "400", "--quiet"]].concat();
        let (scene, first, second) = (at("floor.obj"), at("first.csv"), at("second.csv"));
        truth(&[&[scene.as_str(), "--sample", "20", "-o", &first], &light[..]].concat()).unwrap();
        truth(&[&[scene.as_str(), "--points", &first, "-o", &second], &light[..]].concat()).unwrap();
        for path in [&first, &second] {
            let file = truth_file::read(path.as_ref()).unwrap();
            assert!(file.comments[1].contains("1,1.5,1 0.5,0,0 0,0,0.25 0,-1,0 8,4,2"), "{:?}", file.comments);
            let values = file.values.unwrap();
            assert_eq!(values.len(), 20);
            for (point, value) in file.points.iter().zip(values) {
                let corners = [[0.5, 0.75], [1.5, 0.75], [1.5, 1.25], [0.5, 1.25]];
                let corners = corners.map(|[x, z]| glam::Vec3::new(x, 1.5, z));
                let radiance = glam::Vec3::new(8.0, 4.0, 2.0);
                let position = point.position.as_vec3();
                let expected = polygon_irradiance(position, glam::Vec3::Y, &corners, radiance).as_dvec3(); // eq. 6
                let allowed = 4.5 * value.standard_error + 1e-5;
                assert!((value.total - expected).abs().cmple(allowed).all(), "{value:?}, expected {expected}");
                assert_eq!((value.direct, value.bounce1), (value.total, glam::DVec3::ZERO)); // a floor alone
            }
        }
    }

    #[test]
    fn words_that_cannot_be_done_are_refused() {
        assert!(truth(&["cornell", "-o", "out.csv"]).is_err(), "neither points nor a count");
        assert!(truth(&["cornell", "--sample", "1", "--samples", "1", "-o", "out.csv"]).is_err());
    }
}
