//! `radiosity form-factors`: form factors by item buffers, and the solution that Gauss-Seidel finds with them.

use std::{path::PathBuf, time::Instant};

use anyhow::bail;
use clap::{ArgMatches, Args};
use glam::Vec3;
use serde::Serialize;

use super::{
    Outcome, files,
    progress::Progress,
    scene_args::{LightArgs, LoadedScene, SceneArgs},
};
use crate::{
    gpu::{
        device,
        lightmap::item_buffer::{ItemBuffers, Viewpoint, weights_of},
    },
    lightmap::{FormFactorSettings, PixelWeights},
    scene::{Scene, Tessellation, area_light::AreaLightState},
    solver::{
        Solution, SolutionInfo, SolveSettings,
        form_factors::{FormFactorQuality, FormFactors, gauss_seidel},
        patches::Patches,
    },
};

/// Arguments of `radiosity form-factors`.
#[derive(Clone, Debug, Args)]
pub struct FormFactorsArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The light.
    #[command(flatten, next_help_heading = "Area light")]
    pub light: LightArgs,
    /// Patches and hemicubes.
    #[command(flatten)]
    pub settings: FormFactorSettings,
    /// A part of the device's name, as `radiosity devices` lists it; else the best one.
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// Where the solution goes (safetensors).
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Compare hemicubes of 32 to 512 pixels and both kinds of weights, row by row, instead of solving.
    #[arg(long)]
    pub table: bool,
    /// Print a report to standard output as JSON, and no progress.
    #[arg(long)]
    pub json: bool,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct FormFactorsReport {
    /// Patches.
    pub patches: usize,
    /// Pixels along a hemicube.
    pub resolution: u32,
    /// What a pixel counts.
    pub weights: PixelWeights,
    /// Row sums and reciprocity.
    pub quality: FormFactorQuality,
    /// Seconds for all hemicubes.
    pub hemicube_seconds: f64,
    /// Seconds for all sweeps.
    pub sweep_seconds: f64,
    /// The largest change of each sweep, relative to the mean radiosity.
    pub changes: Vec<f64>,
}

/// What rows are drawn of.
struct Elements<'a> {
    scene: &'a Scene,
    tessellation: Tessellation,
    patches: Patches,
}

/// Runs the command.
pub fn run(args: &FormFactorsArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    if let Some(problem) = args.settings.problem() {
        bail!("{problem}");
    }
    if let Some(path) = &args.output {
        files::check_writable(path)?;
    }
    let card = device::choose(args.device.as_deref()).and_then(|device| device.open()).map_err(anyhow::Error::msg)?;
    let loaded = args.scene.load(matches)?;
    let elements = Elements::new(&loaded.scene, args.settings.subdivide)?;
    if args.table {
        return print_table(&card, &elements);
    }
    let light = args.light.over(loaded.state.light)?;
    let FormFactorSettings { resolution, weights, sweeps, .. } = args.settings;
    let patches = &elements.patches;
    let mut progress = Progress::new(args.json);
    let started = Instant::now();
    let buffers = elements.item_buffers(&card, resolution, weights)?;
    let factors = elements.form_factors(&buffers, |done| progress.update(done, "hemicubes"))?;
    let placed = light.map(|light| light.to_local(&loaded.scene.frame));
    let placed = buffers.direct_irradiance(placed.as_ref(), &patches.areas).map_err(anyhow::Error::msg)?;
    let mut report = FormFactorsReport {
        patches: patches.areas.len(),
        resolution,
        weights,
        quality: factors.quality(),
        hemicube_seconds: started.elapsed().as_secs_f64(),
        sweep_seconds: 0.0,
        changes: Vec::new(),
    };
    let started = Instant::now();
    let watch = |sweep, _: &[Vec3], change| {
        progress.update(sweep as f32 / sweeps as f32, &format!("sweep {sweep}: change {change:.2e}"));
        report.changes.push(change);
        args.settings.goes_on(sweep, change)
    };
    let radiosity = gauss_seidel(&factors, &patches.emission, &patches.reflectance, &placed, watch);
    report.sweep_seconds = started.elapsed().as_secs_f64();
    progress.finish("done");
    if let Some(path) = &args.output {
        let fields = patches.irradiance_at_vertices(&elements.tessellation, &factors, &placed, &radiosity);
        files::write_solution(path, &solution(&loaded, args, light, &elements.tessellation, fields))?;
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print_summary(&report);
    }
    Ok(Outcome::Done)
}

impl<'a> Elements<'a> {
    fn new(scene: &'a Scene, subdivide: u32) -> anyhow::Result<Self> {
        let settings = SolveSettings { subdivide, ..SolveSettings::even() };
        if let Some(problem) = settings.problem() {
            bail!("{problem}");
        }
        let tessellation = Tessellation::new(scene, &settings.tessellation()).map_err(anyhow::Error::msg)?;
        Ok(Self { patches: Patches::new(scene, &tessellation), scene, tessellation })
    }

    fn item_buffers(
        &self,
        card: &(wgpu::Device, wgpu::Queue),
        resolution: u32,
        weights: PixelWeights,
    ) -> anyhow::Result<ItemBuffers> {
        let weights = weights_of(weights, resolution);
        ItemBuffers::of_elements((&card.0, &card.1), (self.scene, &self.tessellation), resolution, &weights)
            .map_err(anyhow::Error::msg)
    }

    fn form_factors(&self, buffers: &ItemBuffers, mut report: impl FnMut(f32)) -> anyhow::Result<FormFactors> {
        let viewpoints: Vec<Viewpoint> =
            self.patches.places.iter().map(|(origin, normal)| Viewpoint { origin: *origin, normal: *normal }).collect();
        let mut go_on = |done| {
            report(done);
            true
        };
        let rows = buffers.all_rows(&viewpoints, &mut go_on).map_err(anyhow::Error::msg)?;
        Ok(FormFactors { areas: self.patches.areas.clone(), rows: rows.unwrap_or_default() })
    }
}

/// Direct and all other irradiance at the vertices as a solution.
fn solution(
    loaded: &LoadedScene,
    args: &FormFactorsArgs,
    light: Option<AreaLightState>,
    tessellation: &Tessellation,
    fields: [Vec<Vec3>; 2],
) -> Solution {
    Solution {
        info: SolutionInfo {
            scene_name: loaded.scene.name.clone(),
            scene_hash: loaded.scene.hash(),
            tessellation_hash: tessellation.hash(),
            load: loaded.load.clone(),
            settings: SolveSettings { subdivide: args.settings.subdivide, ..SolveSettings::even() },
            light,
            program_version: String::from(env!("CARGO_PKG_VERSION")),
            complete: true,
        },
        bounces: fields.into(),
        buried: vec![false; tessellation.mesh.positions.len()],
        cuts: Vec::new(),
    }
}

/// Resolutions and weights against the finest delta form factors.
fn print_table(card: &(wgpu::Device, wgpu::Queue), elements: &Elements<'_>) -> anyhow::Result<Outcome> {
    const FINEST: u32 = 512;
    let rows_of = |kind, resolution| -> anyhow::Result<FormFactors> {
        elements.form_factors(&elements.item_buffers(card, resolution, kind)?, |_| ())
    };
    let reference = rows_of(PixelWeights::Delta, FINEST)?;
    println!(
        "patches {}; error: mean over rows of Σ |F - F_512|, F_512 the delta form factors of {FINEST} pixels",
        elements.patches.areas.len()
    );
    println!("pixels  weights     error   reciprocity  row sums: least    mean  greatest  seconds");
    for resolution in [32, 64, 128, 256, 512] {
        for kind in [PixelWeights::Plain, PixelWeights::Delta] {
            let started = Instant::now();
            let factors = rows_of(kind, resolution)?;
            let seconds = started.elapsed().as_secs_f64();
            let quality = factors.quality();
            println!(
                "{resolution:6}  {:7}  {:8.4}  {:10.3} %  {:15.4}  {:6.4}  {:8.4}  {seconds:7.2}",
                if kind == PixelWeights::Plain { "plain" } else { "delta" },
                mean_difference(&factors, &reference),
                100.0 * quality.reciprocity_error,
                quality.least_row_sum,
                quality.mean_row_sum,
                quality.greatest_row_sum,
            );
        }
    }
    Ok(Outcome::Done)
}

/// Mean over rows of Σ |F_ij - G_ij|.
fn mean_difference(factors: &FormFactors, reference: &FormFactors) -> f64 {
    let row_difference = |from: usize| -> f64 {
        let known = reference.rows[from].iter();
        let from_known: f64 =
            known.map(|(to, value)| f64::from((value - factors.factor(from as u32, *to)).abs())).sum();
        let unknown = factors.rows[from].iter().filter(|(to, _)| reference.factor(from as u32, *to) == 0.0);
        from_known + unknown.map(|(_, value)| f64::from(*value)).sum::<f64>()
    };
    (0..factors.rows.len()).map(row_difference).sum::<f64>() / factors.rows.len() as f64
}

fn print_summary(report: &FormFactorsReport) {
    let FormFactorQuality { entries, least_row_sum, mean_row_sum, greatest_row_sum, reciprocity_error } =
        report.quality;
    println!("patches    {} with {entries} form factors, {} pixels", report.patches, report.resolution);
    println!("row sums   {least_row_sum:.4} to {greatest_row_sum:.4}, mean {mean_row_sum:.4} (1 in a closed scene)");
    println!("reciprocity A_i F_ij and A_j F_ji differ by {:.3} %", 100.0 * reciprocity_error);
    println!("sweeps     {}; changes {}", report.changes.len(), changes(&report.changes));
    println!("seconds    {:.3} hemicubes, {:.3} sweeps", report.hemicube_seconds, report.sweep_seconds);
}

fn changes(changes: &[f64]) -> String {
    changes.iter().take(6).map(|change| format!("{change:.1e}")).collect::<Vec<_>>().join(", ")
}
