//! `radiosity compare`: how far one result is from another.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use clap::Args;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::{Outcome, files::solved_field::AnySolution, solved_scene};
use crate::{
    check::{
        metrics::{
            Agreement, ErrorSummary, Estimates, Field, FieldErrors, PartErrors, agreement, bounce_errors, field_errors,
        },
        surface_points::area_uniform_points,
        truth_file::{self, TruthFile, TruthValue},
    },
    files::truth_comparison::{compare_with_truth as compare_with_truth_file, values_of},
    scene::Scene,
    solver::{Reconstruction, Solution},
    trace::Tracer,
};

/// Arguments of `radiosity compare`.
///
/// Errors are relative L2 differences over all three bands, `sqrt(mean |A - B|²) / mean(total of B)`; bias is the
/// difference of the means over the same mean. "Lit" leaves out what is unlit, buried or beside an emitter in B.
#[derive(Clone, Debug, Args)]
pub struct CompareArgs {
    /// What is judged: a solution, a lightmap, or a truth file (CSV).
    pub a: PathBuf,
    /// What it is judged by: a solution of the same elements, or of any if the scene is given; or a truth file (CSV).
    pub b: PathBuf,
    /// The scene; needed to compare a solution with a truth file, or with a solution of other elements.
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// How a solution's field is rebuilt at the points of a truth file.
    #[arg(long, value_enum, default_value_t)]
    pub reconstruct: Reconstruction,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// What a comparison found.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The errors over points, or over vertices where two solutions are compared.
    pub errors: FieldErrors,
    /// The errors of each bounce alone; for two solutions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bounces: Vec<ErrorSummary>,
    /// Points of the truth file that lie on no surface of the scene, and were left out.
    pub off_surface: usize,
    /// Whether two truth files agree within their noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement: Option<Agreement>,
}

enum Input {
    Solution(Box<AnySolution>),
    Truth(TruthFile),
}

/// Runs the command.
pub fn run(args: &CompareArgs) -> anyhow::Result<Outcome> {
    let comparison = compare(args)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&comparison).context("the comparison")?);
    } else {
        print!("{}", table(&comparison));
    }
    Ok(Outcome::Done)
}

/// Reads both files and compares them.
pub fn compare(args: &CompareArgs) -> anyhow::Result<Comparison> {
    match (read(&args.a)?, read(&args.b)?) {
        (Input::Solution(a), Input::Solution(b)) => match (*a, *b, &args.scene) {
            (AnySolution::Vertices(a), AnySolution::Vertices(b), None) => compare_solutions(args, &a, &b),
            (_, _, Some(scene)) => compare_fields(args, scene),
            _ => bail!("a lightmap is compared at points of the scene's surfaces; give --scene SCENE"),
        },
        (Input::Solution(_), Input::Truth(b)) => compare_with_truth(args, &b),
        (Input::Truth(a), Input::Truth(b)) => compare_truths(args, &a, &b),
        (Input::Truth(_), Input::Solution(_)) => {
            bail!("{}: the truth comes second: compare SOLUTION TRUTH", args.a.display())
        }
    }
}

fn read(path: &Path) -> anyhow::Result<Input> {
    let is_table = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    Ok(if is_table {
        Input::Truth(truth_file::read(path)?)
    } else {
        Input::Solution(Box::new(AnySolution::read(path)?))
    })
}

fn compare_solutions(args: &CompareArgs, a: &Solution, b: &Solution) -> anyhow::Result<Comparison> {
    if a.info.scene_hash != b.info.scene_hash || a.info.tessellation_hash != b.info.tessellation_hash {
        bail!(
            "{} and {} have different scenes or elements; give --scene SCENE to compare them at points of it",
            args.a.display(),
            args.b.display()
        );
    }
    if a.info.light != b.info.light {
        eprintln!("warning: the two solutions were lit by different area lights");
    }
    if a.bounces.len() != b.bounces.len() {
        let (first, second) = (a.bounces.len() - 1, b.bounces.len() - 1);
        eprintln!("warning: the two solutions have {first} and {second} indirect bounces");
    }
    let bounces = |solution: &Solution| solution.bounces.iter().map(|bounce| in_double(bounce)).collect::<Vec<_>>();
    let (total_a, total_b) = (in_double(&a.total()), in_double(&b.total()));
    let (bounces_a, bounces_b) = (bounces(a), bounces(b));
    Ok(Comparison {
        errors: field_errors(
            Field { direct: &bounces_a[0], total: &total_a },
            Field { direct: &bounces_b[0], total: &total_b },
        ),
        bounces: bounce_errors(&bounces_a, &bounces_b),
        off_surface: 0,
        agreement: None,
    })
}

/// Points of the surfaces at which fields of different elements are compared.
const POINT_COUNT: u32 = 16_384;

/// Compares two solutions of one scene, of any elements, at points of its surfaces.
fn compare_fields(args: &CompareArgs, scene_path: &Path) -> anyhow::Result<Comparison> {
    let (a, scene) = solved_scene::open_field(&args.a, scene_path)?;
    let (b, _) = solved_scene::open_field(&args.b, scene_path)?;
    let points = area_uniform_points(&scene, POINT_COUNT, 1);
    let at = |field: &crate::files::solved_field::SolvedField| -> (Vec<DVec3>, Vec<DVec3>) {
        let values = points.par_iter().map(|(triangle, place)| field.at(*triangle, *place));
        values.map(|(direct, total)| (direct.as_dvec3(), total.as_dvec3())).unzip()
    };
    let ((direct_a, total_a), (direct_b, total_b)) = (at(&a), at(&b));
    let errors =
        field_errors(Field { direct: &direct_a, total: &total_a }, Field { direct: &direct_b, total: &total_b });
    Ok(Comparison { errors, bounces: Vec::new(), off_surface: 0, agreement: None })
}

fn compare_with_truth(args: &CompareArgs, truth: &TruthFile) -> anyhow::Result<Comparison> {
    let Some(scene) = &args.scene else {
        bail!("a solution is compared with a truth file at its points, which needs the scene; give --scene SCENE");
    };
    let (field, scene): (_, std::sync::Arc<Scene>) = solved_scene::open_field(&args.a, scene)?;
    let tracer = Tracer::new(scene.clone());
    let at = field.rebuilt(&scene, &tracer, args.reconstruct);
    let compared = compare_with_truth_file(&scene, &tracer, at, (truth, &args.b))?;
    let (errors, off_surface) = (compared.errors, compared.off_surface);
    Ok(Comparison { errors, bounces: Vec::new(), off_surface, agreement: None })
}

fn compare_truths(args: &CompareArgs, a: &TruthFile, b: &TruthFile) -> anyhow::Result<Comparison> {
    let (values_a, values_b) = (values_of(a, &args.a)?, values_of(b, &args.b)?);
    // Points are compared as f32 holds them: files keep seven digits or more.
    let places = |file: &TruthFile| file.points.iter().map(|point| point.position.as_vec3()).collect::<Vec<_>>();
    let size = places(b).iter().map(|place| place.abs().max_element()).fold(0.0, f32::max);
    let apart = |(a, b): (Vec3, Vec3)| a.distance(b) > 1e-5 * size;
    if a.points.len() != b.points.len() || places(a).into_iter().zip(places(b)).any(apart) {
        bail!("{} and {} have different points", args.a.display(), args.b.display());
    }
    let column = |values: &[TruthValue], pick: fn(&TruthValue) -> DVec3| values.iter().map(pick).collect::<Vec<_>>();
    let columns = |values: &[TruthValue]| {
        (
            column(values, |value| value.direct),
            column(values, |value| value.total),
            column(values, |value| value.standard_error),
        )
    };
    let ((direct_a, total_a, noise_a), (direct_b, total_b, noise_b)) = (columns(values_a), columns(values_b));
    let errors =
        field_errors(Field { direct: &direct_a, total: &total_a }, Field { direct: &direct_b, total: &total_b });
    let agreement = agreement(
        Estimates { values: &total_a, standard_errors: &noise_a },
        Estimates { values: &total_b, standard_errors: &noise_b },
        1e-4 * errors.all.mean_truth,
    );
    Ok(Comparison { errors, bounces: Vec::new(), off_surface: 0, agreement: Some(agreement) })
}

fn in_double(values: &[Vec3]) -> Vec<DVec3> {
    values.iter().map(|value| value.as_dvec3()).collect()
}

/// The comparison as text for people.
pub fn table(comparison: &Comparison) -> String {
    let mut text = format!(
        "{:6} {:>9} {:>12} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
        "", "points", "mean [W/m²]", "total", "direct", "indirect", "bias", "largest"
    );
    for (name, part) in [("all", &comparison.errors.all), ("lit", &comparison.errors.lit)] {
        let PartErrors { point_count, mean_truth, total, direct, indirect } = part;
        let percents = [
            percent(total.relative_l2),
            percent(direct.relative_l2),
            percent(indirect.relative_l2),
            percent(total.bias),
            percent(total.largest),
        ];
        text += &format!("{name:6} {point_count:>9} {mean_truth:>12.5} {}\n", percents.join(" "));
    }
    for (index, bounce) in comparison.bounces.iter().enumerate() {
        text += &format!(
            "bounce {index:2}: {} bias {} largest {}\n",
            percent(bounce.relative_l2),
            percent(bounce.bias),
            percent(bounce.largest)
        );
    }
    if comparison.off_surface > 0 {
        text += &format!("{} points lie on no surface and were left out\n", comparison.off_surface);
    }
    if let Some(agreement) = &comparison.agreement {
        let [red, green, blue] = agreement.mean_difference;
        text += &format!(
            "in standard errors: means apart by {red:.2}, {green:.2}, {blue:.2}; largest {:.2} at point {}; mean square {:.3}\n",
            agreement.largest, agreement.largest_at, agreement.mean_square
        );
    }
    text
}

fn percent(fraction: f64) -> String {
    format!("{:>7.3} %", 100.0 * fraction)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;
    use crate::{
        check::surface_points::{area_uniform_points, truth_point},
        files,
        scene::{LoadOptions, Tessellation, load::load},
        solver::{SolutionInfo, SolveSettings},
    };

    const OBJ: &str = "v 0 0 0\nv 0 0 2\nv 2 0 2\nv 2 0 0\nv 0 2 0\nf 1 2 3 4\nf 1 5 2\n";

    /// A folder with a scene, a solution of direct 1 and bounce 2 everywhere, and a truth of direct 1 and total 4.
    fn files_of_known_error() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("scene.obj"), OBJ).unwrap();
        let scene = load(&at("scene.obj"), &LoadOptions::default()).unwrap();
        let settings = SolveSettings { subdivide: 2, ..SolveSettings::even() };
        let tessellation = Tessellation::new(&scene, &settings.tessellation()).unwrap();
        let constant = |value: f32| vec![Vec3::splat(value); tessellation.mesh.positions.len()];
        let info = SolutionInfo {
            scene_name: scene.name.clone(),
            scene_hash: scene.hash(),
            tessellation_hash: tessellation.hash(),
            load: LoadOptions::default(),
            settings,
            light: None,
            program_version: String::from("test"),
            complete: true,
        };
        let solution = Solution {
            info,
            bounces: vec![constant(1.0), constant(2.0)],
            buried: vec![false; constant(0.0).len()],
            cuts: Vec::new(),
        };
        files::write_solution(&at("a.safetensors"), &solution).unwrap();
        let other = Solution { bounces: vec![constant(1.0), constant(1.5)], ..solution };
        files::write_solution(&at("b.safetensors"), &other).unwrap();
        let points: Vec<_> =
            area_uniform_points(&scene, 50, 1).into_iter().map(|place| truth_point(&scene, place)).collect();
        let value = TruthValue { direct: DVec3::ONE, total: DVec3::splat(4.0), ..TruthValue::default() };
        let truth = TruthFile { comments: Vec::new(), values: Some(vec![value; points.len()]), points };
        truth_file::write(&truth, std::fs::File::create(at("truth.csv")).unwrap()).unwrap();
        let alone = TruthFile { values: None, ..truth };
        truth_file::write(&alone, std::fs::File::create(at("points.csv")).unwrap()).unwrap();
        folder
    }

    fn compare_in(folder: &tempfile::TempDir, a: &str, b: &str, with_scene: bool) -> anyhow::Result<Comparison> {
        let at = |name: &str| folder.path().join(name);
        compare(&CompareArgs {
            a: at(a),
            b: at(b),
            scene: with_scene.then(|| at("scene.obj")),
            reconstruct: Reconstruction::Vertex,
            json: false,
        })
    }

    #[test]
    fn a_solution_against_a_truth_has_the_error_that_was_put_in() {
        let folder = files_of_known_error();
        let found = compare_in(&folder, "a.safetensors", "truth.csv", true).unwrap();
        let all = found.errors.all;
        assert_eq!((all.point_count, found.off_surface), (50, 0));
        assert!((all.total.relative_l2 - 0.25).abs() < 1e-6 && (all.total.bias + 0.25).abs() < 1e-6);
        assert!(all.direct.relative_l2 < 1e-6 && (all.indirect.relative_l2 - 0.25).abs() < 1e-6);
        assert!(table(&found).contains("25.000 %"));
    }

    #[test]
    fn two_solutions_are_compared_by_vertex_and_bounce() {
        let folder = files_of_known_error();
        let found = compare_in(&folder, "a.safetensors", "b.safetensors", false).unwrap();
        assert!((found.errors.all.total.bias - 0.2).abs() < 1e-6); // 3 against 2.5
        assert_eq!(found.bounces.len(), 2);
        assert!(found.bounces[0].relative_l2 == 0.0 && (found.bounces[1].relative_l2 - 0.2).abs() < 1e-6);
        let json: serde_json::Value = serde_json::to_value(&found).unwrap();
        assert!(json["errors"]["lit"]["total"]["relative_l2"].is_number());
    }

    #[test]
    fn files_that_cannot_be_compared_are_refused_in_one_line() {
        let folder = files_of_known_error();
        let refusal = |a: &str, b: &str, with_scene| {
            let line = format!("{:#}", compare_in(&folder, a, b, with_scene).unwrap_err());
            assert!(!line.contains('\n'), "{line}");
            line
        };
        assert!(refusal("a.safetensors", "truth.csv", false).contains("--scene"));
        assert!(refusal("truth.csv", "a.safetensors", true).contains("second"));
        assert!(refusal("a.safetensors", "points.csv", true).contains("points alone"));
        assert!(refusal("a.safetensors", "missing.csv", true).contains("missing.csv"));
        std::fs::write(folder.path().join("scene.obj"), OBJ.replace("v 2 0 2", "v 2 0 3")).unwrap();
        assert!(refusal("a.safetensors", "truth.csv", true).contains("a.safetensors"));
    }

    #[test]
    fn a_truth_agrees_with_itself() {
        let folder = files_of_known_error();
        let found = compare_in(&folder, "truth.csv", "truth.csv", false).unwrap();
        assert_eq!(found.agreement.map(|agreement| agreement.largest), Some(0.0));
    }
}
