//! `radiosity form-factors`: form factors by item buffers, and the solution that Gauss-Seidel finds with them.

use std::{path::PathBuf, time::Instant};

use anyhow::bail;
use clap::{ArgMatches, Args, ValueEnum};
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
        lightmap::{
            hemicube::delta_form_factors,
            item_buffer::{ItemBuffers, Row, Viewpoint},
            lamps::lamps_of,
        },
    },
    math::ratio_or_zero,
    scene::{Scene, Tessellation, area_light::AreaLightState, reflectance::triangle_mean_reflectance},
    solver::{
        Solution, SolutionInfo, SolveSettings,
        form_factors::{FormFactorQuality, FormFactors, gauss_seidel},
    },
    trace::surface::lift,
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
    /// Cut every edge in two this many times (2^N segments an edge); every triangle is a patch.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub subdivide: u32,
    /// Pixels along a hemicube: even, 16 to 512.
    #[arg(long, value_name = "PIXELS", default_value_t = 128)]
    pub resolution: u32,
    /// What a pixel counts.
    #[arg(long, value_enum, default_value_t = Weights::Delta)]
    pub weights: Weights,
    /// Sweeps of Gauss-Seidel; fewer if nothing changes by more than a millionth.
    #[arg(long, value_name = "N", default_value_t = 50)]
    pub sweeps: u32,
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

/// What a pixel of a hemicube counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weights {
    /// Its delta form factor (eq. 8).
    Delta,
    /// As much as any other: pixels are counted.
    Plain,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct FormFactorsReport {
    /// Patches.
    pub patches: usize,
    /// Pixels along a hemicube.
    pub resolution: u32,
    /// What a pixel counts.
    pub weights: Weights,
    /// Row sums and reciprocity.
    pub quality: FormFactorQuality,
    /// Seconds for all hemicubes.
    pub hemicube_seconds: f64,
    /// Seconds for all sweeps.
    pub sweep_seconds: f64,
    /// The largest change of each sweep, relative to the mean radiosity.
    pub changes: Vec<f64>,
}

/// Patches: the elements of a tessellation.
struct Patches<'a> {
    scene: &'a Scene,
    tessellation: Tessellation,
    viewpoints: Vec<Viewpoint>,
    /// Without the holes that textures cut.
    areas: Vec<f32>,
}

/// Runs the command.
pub fn run(args: &FormFactorsArgs, matches: &ArgMatches) -> anyhow::Result<Outcome> {
    if !(16..=512).contains(&args.resolution) || !args.resolution.is_multiple_of(2) {
        bail!("the resolution must be an even number of pixels from 16 to 512, not {}", args.resolution);
    }
    if let Some(path) = &args.output {
        files::check_writable(path)?;
    }
    let card = device::choose(args.device.as_deref()).and_then(|device| device.open()).map_err(anyhow::Error::msg)?;
    let loaded = args.scene.load(matches)?;
    let patches = Patches::new(&loaded.scene, args.subdivide)?;
    if args.table {
        return print_table(&card, &patches);
    }
    let light = args.light.over(loaded.state.light)?;
    let mut progress = Progress::new(args.json);
    let started = Instant::now();
    let weights = weights(args.weights, args.resolution);
    let buffers = item_buffers(&card, &patches, args.resolution, &weights)?;
    let factors = FormFactors {
        areas: patches.areas.clone(),
        rows: all_rows(&buffers, &patches.viewpoints, |done| progress.update(done, "hemicubes"))?,
    };
    let direct = direct_irradiance(&buffers, &patches, light)?;
    let mut report = FormFactorsReport {
        patches: patches.areas.len(),
        resolution: args.resolution,
        weights: args.weights,
        quality: factors.quality(),
        hemicube_seconds: started.elapsed().as_secs_f64(),
        sweep_seconds: 0.0,
        changes: Vec::new(),
    };
    let started = Instant::now();
    let (emission, reflectance) = materials(&loaded.scene, &patches.tessellation);
    let radiosity = gauss_seidel(&factors, &emission, &reflectance, &direct, |sweep, _, change| {
        progress.update(sweep as f32 / args.sweeps as f32, &format!("sweep {sweep}: change {change:.2e}"));
        report.changes.push(change);
        change > 1e-6 && sweep < args.sweeps
    });
    report.sweep_seconds = started.elapsed().as_secs_f64();
    progress.finish("done");
    let emitted: Vec<Vec3> = (0..emission.len()).map(|patch| factors.gathered(patch, &emission)).collect();
    let direct: Vec<Vec3> = direct.iter().zip(&emitted).map(|(placed, emitted)| *placed + *emitted).collect();
    let indirect: Vec<Vec3> = (0..radiosity.len())
        .map(|patch| (factors.gathered(patch, &radiosity) - emitted[patch]).max(Vec3::ZERO))
        .collect();
    if let Some(path) = &args.output {
        files::write_solution(path, &solution(&loaded, args, light, &patches, [&direct, &indirect]))?;
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print_summary(&report);
    }
    Ok(Outcome::Done)
}

impl<'a> Patches<'a> {
    fn new(scene: &'a Scene, subdivide: u32) -> anyhow::Result<Self> {
        let settings = SolveSettings { subdivide, ..SolveSettings::even() };
        if let Some(problem) = settings.problem() {
            bail!("{problem}");
        }
        let tessellation = Tessellation::new(scene, &settings.tessellation()).map_err(anyhow::Error::msg)?;
        let mesh = &tessellation.mesh;
        let count = mesh.triangles.len() as u32;
        let viewpoint = |element: u32| {
            let corners = mesh.corners(element);
            let normal = scene.mesh.geometric_normal(tessellation.scene_triangle[element as usize]);
            Viewpoint { origin: lift(corners.iter().sum::<Vec3>() / 3.0, normal, corners), normal }
        };
        Ok(Self {
            viewpoints: (0..count).map(viewpoint).collect(),
            areas: (0..count).map(|element| mesh.area(element) * opaque_share(scene, &tessellation, element)).collect(),
            scene,
            tessellation,
        })
    }
}

/// The part of an element that is no hole, by the points of a grid.
fn opaque_share(scene: &Scene, tessellation: &Tessellation, element: u32) -> f32 {
    const SIDE: u32 = 16;
    let triangle = tessellation.scene_triangle[element as usize];
    if !scene.may_be_cut_out(triangle) {
        return 1.0;
    }
    let [a, b, c] = tessellation.corner_barycentrics[element as usize];
    let thirds = |index: u32| (index as f32 + 1.0 / 3.0) / SIDE as f32;
    let points = (0..SIDE).flat_map(|row| (0..SIDE - row).map(move |column| (thirds(column), thirds(row))));
    let (mut opaque, mut all) = (0, 0);
    for (u, v) in points {
        opaque += u32::from(!scene.is_cut_out(triangle, a + u * (b - a) + v * (c - a)));
        all += 1;
    }
    opaque as f32 / all as f32
}

fn weights(kind: Weights, resolution: u32) -> Vec<f32> {
    match kind {
        Weights::Delta => delta_form_factors(resolution),
        Weights::Plain => {
            let count = 3 * resolution * resolution;
            vec![1.0 / count as f32; count as usize]
        }
    }
}

fn item_buffers(
    card: &(wgpu::Device, wgpu::Queue),
    patches: &Patches<'_>,
    resolution: u32,
    weights: &[f32],
) -> anyhow::Result<ItemBuffers> {
    let elements = (patches.scene, &patches.tessellation);
    ItemBuffers::of_elements((&card.0, &card.1), elements, resolution, weights).map_err(anyhow::Error::msg)
}

fn all_rows(buffers: &ItemBuffers, viewpoints: &[Viewpoint], mut report: impl FnMut(f32)) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::with_capacity(viewpoints.len());
    for batch in viewpoints.chunks(buffers.batch()) {
        rows.extend(buffers.rows(batch).map_err(anyhow::Error::msg)?);
        report(rows.len() as f32 / viewpoints.len() as f32);
    }
    Ok(rows)
}

/// What the placed light gives to each patch: the light's own rows, turned round (A_i F_ij = A_j F_ji).
fn direct_irradiance(
    buffers: &ItemBuffers,
    patches: &Patches<'_>,
    light: Option<AreaLightState>,
) -> anyhow::Result<Vec<Vec3>> {
    /// Parts of the light along each side.
    const LIGHT_SIDE: u32 = 8;
    let mut direct = vec![Vec3::ZERO; patches.areas.len()];
    let lamps = light.map_or(Vec::new(), |light| lamps_of(&light.to_local(&patches.scene.frame), LIGHT_SIDE));
    let viewpoints: Vec<Viewpoint> =
        lamps.iter().map(|lamp| Viewpoint { origin: lamp.origin, normal: lamp.normal }).collect();
    for (row, lamp) in all_rows(buffers, &viewpoints, |_| ())?.iter().zip(&lamps) {
        for &(patch, factor) in row {
            let share = ratio_or_zero(f64::from(lamp.area * factor), f64::from(patches.areas[patch as usize]));
            direct[patch as usize] += share as f32 * lamp.radiosity;
        }
    }
    Ok(direct)
}

/// Emission [W/m²] and reflectance of each patch.
fn materials(scene: &Scene, tessellation: &Tessellation) -> (Vec<Vec3>, Vec<Vec3>) {
    let of_triangle = |triangle: u32| {
        let emission = std::f32::consts::PI * scene.material(triangle).emitted_radiance;
        (emission, triangle_mean_reflectance(scene, triangle))
    };
    let known: Vec<(Vec3, Vec3)> = (0..scene.mesh.triangles.len() as u32).map(of_triangle).collect();
    tessellation.scene_triangle.iter().map(|triangle| known[*triangle as usize]).unzip()
}

/// Constant patches as a solution at vertices: each takes the mean of the patches around it, by area.
fn solution(
    loaded: &LoadedScene,
    args: &FormFactorsArgs,
    light: Option<AreaLightState>,
    patches: &Patches<'_>,
    fields: [&[Vec3]; 2],
) -> Solution {
    let tessellation = &patches.tessellation;
    let mesh = &tessellation.mesh;
    let at_vertices = |field: &[Vec3]| -> Vec<Vec3> {
        let mut sums = vec![(Vec3::ZERO, 0.0); mesh.positions.len()];
        for ((corners, value), area) in mesh.triangles.iter().zip(field).zip(&patches.areas) {
            for vertex in corners {
                let (sum, whole) = &mut sums[*vertex as usize];
                *sum += *area * *value;
                *whole += area;
            }
        }
        sums.into_iter().map(|(sum, whole)| if whole > 0.0 { sum / whole } else { Vec3::ZERO }).collect()
    };
    Solution {
        info: SolutionInfo {
            scene_name: loaded.scene.name.clone(),
            scene_hash: loaded.scene.hash(),
            tessellation_hash: tessellation.hash(),
            load: loaded.load.clone(),
            settings: SolveSettings { subdivide: args.subdivide, ..SolveSettings::even() },
            light,
            program_version: String::from(env!("CARGO_PKG_VERSION")),
            complete: true,
        },
        bounces: fields.into_iter().map(at_vertices).collect(),
        buried: vec![false; mesh.positions.len()],
        cuts: Vec::new(),
    }
}

/// Resolutions and weights against the finest delta form factors.
fn print_table(card: &(wgpu::Device, wgpu::Queue), patches: &Patches<'_>) -> anyhow::Result<Outcome> {
    const FINEST: u32 = 512;
    let rows_of = |kind, resolution| -> anyhow::Result<FormFactors> {
        let buffers = item_buffers(card, patches, resolution, &weights(kind, resolution))?;
        Ok(FormFactors { areas: patches.areas.clone(), rows: all_rows(&buffers, &patches.viewpoints, |_| ())? })
    };
    let reference = rows_of(Weights::Delta, FINEST)?;
    println!(
        "patches {}; error: mean over rows of Σ |F - F_512|, F_512 the delta form factors of {FINEST} pixels",
        patches.areas.len()
    );
    println!("pixels  weights     error   reciprocity  row sums: least    mean  greatest  seconds");
    for resolution in [32, 64, 128, 256, 512] {
        for kind in [Weights::Plain, Weights::Delta] {
            let started = Instant::now();
            let factors = rows_of(kind, resolution)?;
            let seconds = started.elapsed().as_secs_f64();
            let quality = factors.quality();
            println!(
                "{resolution:6}  {:7}  {:8.4}  {:10.3} %  {:15.4}  {:6.4}  {:8.4}  {seconds:7.2}",
                if kind == Weights::Plain { "plain" } else { "delta" },
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
