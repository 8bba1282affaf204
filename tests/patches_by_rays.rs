//! Form factors between constant patches by rays, against closed forms, and the radiosity that follows from them.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use glam::Vec3;
use radiosity::{
    check::closed_form::{furnace_irradiance, parallel_squares_form_factor, perpendicular_squares_form_factor},
    lightmap::{FormFactorMethod, FormFactorSettings, PairKernel},
    scene::{LoadOptions, Scene, Tessellation, builtin, load::load_from_memory, tessellate::TessellationOptions},
    solver::{
        form_factors::{FormFactors, gauss_seidel},
        patch_rays::{PatchRays, memory_problem},
        patches::Patches,
    },
    trace::Tracer,
};

const FLOOR: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const CEILING: &str = "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 8 7 6 5\n";
const WALL: &str = "v 0 0 0\nv 0 1 0\nv 0 1 1\nv 0 0 1\nf 5 6 7 8\n";
/// Half-way up, as large as both.
const BLOCKER: &str = "v 0 0 0.5\nv 1 0 0.5\nv 1 1 0.5\nv 0 1 0.5\nf 9 10 11 12\n";
/// Sides of three lengths, so that patches have different areas.
const BOX: &str = "v 0 0 0\nv 1 0 0\nv 1 0.7 0\nv 0 0.7 0\nv 0 0 1.3\nv 1 0 1.3\nv 1 0.7 1.3\nv 0 0.7 1.3\n\
                   f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 5 1 4 8\nf 2 6 7 3\n";

fn scene(parts: &[&str]) -> Arc<Scene> {
    Arc::new(load_from_memory("squares", &parts.concat(), "", &LoadOptions::default()).unwrap())
}

fn settings(pair_rays: u32, kernel: PairKernel) -> FormFactorSettings {
    FormFactorSettings { by: FormFactorMethod::Rays, pair_rays, kernel, ..FormFactorSettings::default() }
}

/// Patches with edges of at most `max_edge` metres, and all that rays find between them.
fn found(scene: &Arc<Scene>, max_edge: f64, settings: &FormFactorSettings) -> (Tessellation, Patches, FormFactors) {
    let elements = Tessellation::new(scene, &TessellationOptions { subdivide: 0, max_edge: Some(max_edge) }).unwrap();
    let patches = Patches::new(scene, &elements);
    let tracer = Tracer::new(Arc::clone(scene));
    let rays = PatchRays::new(scene, &tracer, &elements, &patches, settings);
    let (factors, _) = rays.form_factors(&|_| true).unwrap();
    (elements, patches, factors)
}

/// The form factor from the first square of a scene (its first two triangles) to the second.
fn from_first_to_second(scene: &Arc<Scene>, max_edge: f64, settings: &FormFactorSettings) -> f64 {
    let (elements, _, factors) = found(scene, max_edge, settings);
    let square = |patch: usize| elements.scene_triangle[patch] / 2;
    let exchange = |from: usize| -> f64 {
        let row = factors.rows[from].iter().filter(|(to, _)| square(*to as usize) == 1);
        f64::from(factors.areas[from]) * row.map(|(_, factor)| f64::from(*factor)).sum::<f64>()
    };
    let first = || (0..factors.rows.len()).filter(|patch| square(*patch) == 0);
    first().map(exchange).sum::<f64>() / first().map(|patch| f64::from(factors.areas[patch])).sum::<f64>()
}

#[test]
fn parallel_squares_have_their_form_factor_within_1_percent() {
    let expected = parallel_squares_form_factor(1.0);
    for kernel in [PairKernel::Point, PairKernel::Polygon] {
        let found = from_first_to_second(&scene(&[FLOOR, CEILING]), 0.2, &settings(1, kernel));
        assert!((found / expected - 1.0).abs() < 0.01, "{kernel:?}: {found}, not {expected}");
    }
}

#[test]
fn perpendicular_squares_have_their_form_factor_within_1_percent_by_polygons_and_more_by_points_that_touch() {
    let expected = perpendicular_squares_form_factor();
    let of = |max_edge: f64, kernel| from_first_to_second(&scene(&[FLOOR, WALL]), max_edge, &settings(1, kernel));
    let polygons = of(0.1, PairKernel::Polygon);
    assert!((polygons / expected - 1.0).abs() < 0.01, "{polygons}, not {expected}");
    // What patches along the edge exchange is wrong by the same part however small they are, but they are ever fewer.
    let [coarse, fine] = [0.2, 0.1].map(|max_edge| of(max_edge, PairKernel::Point) / expected - 1.0);
    assert!(coarse > 0.02 && fine > 0.01 && fine < 0.6 * coarse, "{coarse}, then {fine}");
}

#[test]
fn what_lies_between_two_squares_leaves_nothing_between_them() {
    let blocked = scene(&[FLOOR, CEILING, BLOCKER]);
    for pair_rays in [1, 4] {
        assert_eq!(from_first_to_second(&blocked, 0.3, &settings(pair_rays, PairKernel::Point)), 0.0);
    }
}

#[test]
fn more_rays_a_pair_see_the_part_of_a_patch_that_one_ray_misses() {
    // Two whole squares of two triangles with a blocker over half of each: one ray a pair sees all or nothing.
    let half = "v 0 0 0.5\nv 0.5 0 0.5\nv 0.5 1 0.5\nv 0 1 0.5\nf 9 10 11 12\n";
    let open = from_first_to_second(&scene(&[FLOOR, CEILING]), 2.0, &settings(4096, PairKernel::Point));
    let expected = parallel_squares_form_factor(1.0);
    assert!((open / expected - 1.0).abs() < 0.02, "{open}, not {expected}");
    let fine = from_first_to_second(&scene(&[FLOOR, CEILING, half]), 0.1, &settings(1, PairKernel::Point));
    let many = from_first_to_second(&scene(&[FLOOR, CEILING, half]), 2.0, &settings(4096, PairKernel::Point));
    assert!((many / fine - 1.0).abs() < 0.05 && many < 0.8 * open, "{many} by many rays, {fine} by many patches");
}

#[test]
fn in_a_closed_box_row_sums_come_to_one_as_patches_get_smaller_and_reciprocity_holds_to_the_last_bit_of_f32() {
    let mean_error = |max_edge, kernel| {
        let (.., factors) = found(&scene(&[BOX]), max_edge, &settings(1, kernel));
        let quality = factors.quality(&|| false).unwrap();
        // Both ways come from one number; each is rounded once.
        assert!(quality.reciprocity_error < 1e-7, "{quality:?}");
        (quality.mean_row_sum - 1.0).abs()
    };
    // The part of the area that lies along an edge halves with the edges' length.
    let by_points = [0.5, 0.25, 0.125].map(|max_edge| mean_error(max_edge, PairKernel::Point));
    assert!(by_points.windows(2).all(|pair| pair[1] < 0.7 * pair[0]), "{by_points:?}");
    assert!(mean_error(0.25, PairKernel::Polygon) < 0.01);
}

/// A closed box in which all reflects `reflectance`.
fn furnace(reflectance: f64) -> Arc<Scene> {
    let material = format!("newmtl wall\nKd {reflectance} {reflectance} {reflectance}\n");
    let text = format!("usemtl wall\n{BOX}");
    Arc::new(load_from_memory("furnace", &text, &material, &LoadOptions::default()).unwrap())
}

#[test]
fn in_a_furnace_gauss_seidel_comes_to_the_limit_of_equation_5() {
    for reflectance in [0.3, 0.8] {
        let (_, patches, factors) = found(&furnace(reflectance), 0.25, &settings(1, PairKernel::Polygon));
        let direct = vec![Vec3::ONE; patches.areas.len()];
        let solved =
            gauss_seidel(&factors, &patches.emission, &patches.reflectance, &direct, &|| false, |sweep, _, change| {
                change > 1e-6 && sweep < 200
            });
        let radiosity = solved.unwrap();
        let by_area = radiosity.iter().zip(&patches.areas).map(|(value, area)| f64::from(value.x * area)).sum::<f64>();
        let irradiance = by_area / patches.areas.iter().map(|area| f64::from(*area)).sum::<f64>() / reflectance;
        // Row sums are off by less than 1 % (see above); by the geometric series the limit is off by ρ / (1 - ρ) times that.
        let expected = furnace_irradiance(1.0, reflectance, 10_000);
        let allowed = 0.01 * reflectance / (1.0 - reflectance);
        assert!((irradiance / expected - 1.0).abs() < allowed, "{reflectance}: {irradiance}, not {expected}");
    }
}

#[test]
fn any_number_of_threads_finds_the_same_bits() {
    let cornell = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| found(&cornell, 0.15, &settings(3, PairKernel::Polygon)).2)
    };
    assert_eq!(by(1), by(2));
}

#[test]
fn it_can_be_stopped_at_once_and_says_how_much_memory_it_may_take() {
    let cornell = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let elements = Tessellation::new(&cornell, &TessellationOptions { subdivide: 4, max_edge: None }).unwrap();
    let patches = Patches::new(&cornell, &elements);
    let (tracer, settings) = (Tracer::new(Arc::clone(&cornell)), settings(64, PairKernel::Point));
    let rays = PatchRays::new(&cornell, &tracer, &elements, &patches, &settings);
    let started = std::time::Instant::now();
    assert!(rays.form_factors(&|done| done < 1e-5).is_none());
    assert!(started.elapsed().as_millis() < 100, "{:?}", started.elapsed()); // all of it takes a minute
    assert_eq!(memory_problem(1000, 8_000_000), None);
    assert!(memory_problem(1001, 8_000_000).unwrap().starts_with("1001 patches may have 8 MiB of form factors"));
}
