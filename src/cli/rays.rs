//! `radiosity rays`: rays and triangles in a file, by which other ray tracers are timed on the very same work.

use std::path::PathBuf;

use anyhow::Context as _;
use clap::{ArgMatches, Args};

use super::{
    Outcome, files,
    scene_args::{LightArgs, SceneArgs},
};
use crate::check::ray_sets::RaySets;

/// Arguments of `radiosity rays`.
///
/// The file is a safetensors file: `corners` (triangles, 3, 3), and for each of the sets `scattered` (one cosine-weighted
/// ray from each of many points), `gathered` (256 from each of some points) and `shadow` (from each point to a random place
/// on the lights) `SET.origins`, `SET.directions` (rays, 3), `SET.max_distances` and `SET.origin_triangles` (rays).
#[derive(Clone, Debug, Args)]
pub struct RaysArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light that shadow rays go to; without one, to emissive triangles.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// Rays of each kind.
    #[arg(long, value_name = "N", default_value_t = 1 << 20, value_parser = clap::value_parser!(u32).range(1..=1 << 26))]
    pub count: u32,
    /// Seed of all random numbers.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..1 << 63))]
    pub seed: u64,
    /// Where the rays go.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &RaysArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    let loaded = args.scene.load(matches)?;
    let light = args.light.over(loaded.state.light)?.map(|light| light.to_local(&loaded.scene.frame));
    files::check_writable(&args.output)?;
    let sets = RaySets::new(&loaded.scene, light, args.count, args.seed);
    let bytes = sets.encode(&loaded.scene).context("the file of rays")?;
    files::write_atomically(&args.output, |writer| Ok(writer.write_all(&bytes)?))?;
    for (name, rays) in sets.named() {
        println!("{name:9}  {:9} rays", rays.len());
    }
    Ok(Outcome::Done)
}
