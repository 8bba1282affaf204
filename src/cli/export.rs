//! `radiosity export`: a solution as a mesh with vertex colours (PLY) or as a table (CSV).

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use super::{Outcome, files, render::ToneArgs, solved_scene};
use crate::files::mesh_export::{write_csv, write_ply};

/// Arguments of `radiosity export`.
#[derive(Clone, Debug, Args)]
pub struct ExportArgs {
    /// The solution.
    pub solution: PathBuf,
    /// The scene: an OBJ file or `cornell`. It is read with the options that it was solved with.
    pub scene: PathBuf,
    /// State file (TOML) with a tone map, if not the one beside the scene.
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,
    /// Where the mesh (.ply) or the table of its vertices (.csv) goes.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// The tone map of the PLY's colours.
    #[command(flatten)]
    pub tone: ToneArgs,
}

/// Runs the command.
pub fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let extension = args.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let as_table = extension.eq_ignore_ascii_case("csv");
    if !as_table && !extension.eq_ignore_ascii_case("ply") {
        bail!("{}: the name must end in .ply or .csv, which decides the format", args.output.display());
    }
    let solved_scene::SolvedScene { solution, loaded, tessellation } =
        solved_scene::open_solved(&args.solution, &args.scene, args.state.as_deref())?;
    files::write_atomically(&args.output, |writer| {
        if as_table {
            write_csv(writer, &loaded.scene, &tessellation, &solution)
        } else {
            write_ply(writer, &loaded.scene, &tessellation, &solution, &args.tone.over(loaded.tone_map))
        }
    })?;
    let (vertices, faces) = (tessellation.mesh.positions.len(), tessellation.mesh.triangles.len());
    eprintln!("{}: {vertices} vertices, {faces} triangles", args.output.display());
    Ok(Outcome::Done)
}
