//! Radiosity on the graphics card: passes with known answers, and the Cornell box against the truth.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{f32::consts::PI, sync::Arc, time::Instant};

use common::lightmap::*;
use glam::{DVec3, Vec2, Vec3};
use radiosity::{
    check::{
        closed_form::polygon_irradiance,
        metrics::{Field, FieldErrors, field_errors},
        surface_points::{area_uniform_points, locate},
    },
    gpu::lightmap::hemicube,
    lightmap::{Ambient, Atlas, GpuSettings, LightmapSettings, ShootingOrder, pages_of},
    scene::{AreaLight, LoadOptions, Scene, area_light::AreaLightState, builtin},
    solver::SolveSettings,
    trace::Tracer,
};

/// 32 texels along a wall of 0.556 m.
fn cornell_map() -> LightmapSettings {
    LightmapSettings { texels_per_metre: Some(32.0 / 0.556), ..LightmapSettings::default() }
}

fn errors_against(
    case: &common::truths::Case,
    tracer: &Tracer,
    atlas: &Atlas,
    direct: &[Vec3],
    total: &[Vec3],
) -> FieldErrors {
    let [direct, total] = [direct, total].map(|values| pages_of(&atlas.charts, &atlas.texels, values));
    let places: Vec<_> = case.points.iter().map(|point| locate(&case.scene, tracer, point).unwrap().on()).collect();
    let at = |pages: &[Vec3]| -> Vec<DVec3> {
        let value = |(triangle, place)| atlas.charts.interpolate(pages, triangle, place).as_dvec3();
        places.iter().map(|place| place.map_or(DVec3::ZERO, value)).collect()
    };
    let (direct, total) = (at(&direct), at(&total));
    let known: (Vec<_>, Vec<_>) = case.values.iter().map(|value| (value.direct, value.total)).unzip();
    field_errors(Field { direct: &direct, total: &total }, Field { direct: &known.0, total: &known.1 })
}

#[test]
fn delta_form_factors_of_a_hemicube_sum_to_one() {
    // A patch's form factors to everything around it are 1 (eq. 8); the sum over pixel middles converges with 1/n².
    for resolution in [16, 64, 128, 256] {
        let tolerance = 0.6 / f64::from(resolution * resolution) + 1e-6;
        let weights = hemicube::delta_form_factors(resolution);
        let sum: f64 = weights.iter().map(|weight| f64::from(*weight)).sum();
        assert!((sum - 1.0).abs() < tolerance, "{resolution} pixels: {sum}");
        // The top has the form factor of a square of side 2 at height 1 above the middle of it (eq. 6): 0.5541.
        let top: f64 = weights[..(resolution * resolution) as usize].iter().map(|weight| f64::from(*weight)).sum();
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| Vec3::new(x, y, 1.0));
        let expected = f64::from(polygon_irradiance(Vec3::ZERO, Vec3::Z, &corners, Vec3::ONE / PI).x);
        assert!((top - expected).abs() < tolerance, "{resolution} pixels: {top}, not {expected}");
    }
}

/// A closed box of 1 × 1.2 × 1.4 m, every wall of reflectance `reflectance` and emission π [W/m²].
fn furnace(reflectance: f32) -> Arc<Scene> {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1.2 0\nv 0 1.2 0\nv 0 0 1.4\nv 1 0 1.4\nv 1 1.2 1.4\nv 0 1.2 1.4\n";
    // Fronts inwards.
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 5 1 4 8\nf 2 6 7 3\n";
    let mtl = format!("newmtl wall\nKd {reflectance} {reflectance} {reflectance}\nKe 1 1 1\n");
    from_obj(&format!("{corners}usemtl wall\n{faces}"), &mtl)
}

#[test]
fn a_closed_glowing_box_has_its_emission_over_one_minus_its_reflectance() {
    // E = M + ρ M + ρ² M + ... = M / (1 - ρ) everywhere (eq. 5), whatever the box's shape.
    for reflectance in [0.3, 0.8] {
        let scene = furnace(reflectance);
        let atlas = atlas_of(&scene, &texels(600));
        // Blocks of ten texels a wall would be walls.
        let settings = GpuSettings { unabsorbed: 1e-3, group: 2, far_group: 2, ..GpuSettings::default() };
        let solver = solved(solver(&scene, &atlas, None, &settings));
        let fields = solver.fields().unwrap();
        let direct = mean(&atlas, &fields.direct) / PI;
        assert!(direct.abs_diff_eq(Vec3::ONE, 0.004), "direct light {direct} of the emission");
        let expected = PI / (1.0 - reflectance);
        let total = mean(&atlas, &fields.total) / expected;
        // What the first sum errs, all bounces together err 1 / (1 - ρ) times.
        assert!(
            total.abs_diff_eq(Vec3::ONE, 0.004 / (1.0 - reflectance)),
            "reflectance {reflectance}: {total} of the closed form"
        );
        for (texel, value) in atlas.texels.iter().zip(&fields.total).filter(|(texel, _)| texel.open > 0.0) {
            assert!((value.x / expected - 1.0).abs() < 0.06, "{} at {}", value.x / expected, texel.position);
        }
        let ledger = solver.ledger();
        assert!(ledger.balance().abs() < 0.02 && ledger.escaped.max_element() < 1e-3 * ledger.emitted.x, "{ledger:?}");
    }
}

/// A floor of 4 m.
const FLOOR: &str = "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nf 1 2 3 4\n";

fn lamp(scene: &Scene) -> AreaLight {
    let light =
        AreaLightState { centre: [0.2, 0.6, 0.1], u: [0.3, 0.0, 0.0], v: [0.0, 0.0, 0.2], radiance: [5.0, 4.0, 3.0] };
    light.to_local(&scene.frame)
}

#[test]
fn a_light_over_a_floor_has_the_irradiance_of_the_closed_form() {
    let scene = from_obj(FLOOR, "newmtl unused\n");
    let atlas = atlas_of(&scene, &texels(2000));
    let light = lamp(&scene);
    let settings = GpuSettings { light_side: 8, ..GpuSettings::default() };
    let solver = solved(solver(&scene, &atlas, Some(light), &settings));
    let fields = solver.fields().unwrap();
    for (texel, value) in atlas.texels.iter().zip(&fields.total) {
        // Lambert's formula for the whole light (eq. 6); the light shines downwards.
        let expected = polygon_irradiance(texel.position, texel.geometric_normal, &light.corners(), light.radiance);
        // The 64 parts of the light are taken by their middles where they are far: at r, a side s errs by (s/r)²/3.
        assert!(
            value.abs_diff_eq(expected, 5e-3 * expected.x + 1e-4),
            "{value}, not {expected}, at {}",
            texel.position
        );
    }
    // What the hemicubes see leave and what the texels absorb is all there is: the floor sees nothing else.
    let ledger = solver.ledger();
    assert!(ledger.balance().abs() < 2e-3, "{ledger:?}");
    assert!(ledger.escaped.x > 0.1 * ledger.emitted.x && ledger.absorbed.x > 0.1 * ledger.emitted.x, "{ledger:?}");
}

#[test]
fn a_plane_at_any_slant_sends_no_light_to_itself() {
    // Rounding puts some texels before the plane of their own group, or of the next one.
    let tilted = "v -2 -0.3 -2\nv -1.6 -0.1 2\nv 2.1 0.45 1.7\nv 1.7 0.25 -2.3\nusemtl grey\nf 1 2 3 4\n";
    let scene = from_obj(tilted, "newmtl grey\nKd 0.8 0.8 0.8\n");
    let atlas = atlas_of(&scene, &texels(3000));
    let settings = GpuSettings { far_group: 4, ..GpuSettings::default() };
    let solver = solved(solver(&scene, &atlas, Some(lamp(&scene)), &settings));
    let fields = solver.fields().unwrap();
    assert!(solver.ledger().shooters > 100 && solver.ledger().unabsorbed() < 0.011, "{:?}", solver.ledger());
    assert!(fields.total == fields.direct);
}

#[test]
fn what_stands_between_hides_the_light_as_rays_say() {
    let blocker = "v -0.4 0.3 -0.3\nv 0.5 0.3 -0.3\nv 0.5 0.35 0.4\nv -0.4 0.3 0.4\nf 5 6 7 8\n";
    let scene = from_obj(&format!("{FLOOR}{blocker}"), "newmtl unused\n");
    let atlas = atlas_of(&scene, &texels(4000));
    let light = lamp(&scene);
    // The whole light is one shooter, seen from its middle or not.
    let settings = GpuSettings { light_side: 1, ..GpuSettings::default() };
    let fields = solved(solver(&scene, &atlas, Some(light), &settings)).fields().unwrap();
    let found = against_rays(&scene, &atlas, &light, &fields.direct, |texel| texel.triangle < 2);
    assert!(found.shaded > 100, "{} texels in shadow", found.shaded);
    assert!(found.misplaced < 0.02, "{} of the light", found.misplaced); // at the edges of the shadow
}

#[test]
fn a_solve_that_is_left_alone_and_goes_on_has_the_bits_of_one_that_is_not() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(1500));
    let light = common::cornell_light().to_local(&scene.frame);
    let settings = GpuSettings { batch: 8, unabsorbed: 0.05, light_side: 4, ..GpuSettings::default() };
    let whole = solved(solver(&scene, &atlas, Some(light), &settings)).fields().unwrap();
    let mut paused = solver(&scene, &atlas, Some(light), &settings);
    (0..5).for_each(|_| paused.step().unwrap());
    let partial = paused.fields().unwrap();
    assert!(mean(&atlas, &partial.total).x < mean(&atlas, &whole.total).x);
    assert!(paused.ledger().unabsorbed() > 0.05);
    assert_eq!(solved(paused).fields().unwrap(), whole);
}

#[test]
fn power_is_shot_from_the_brightest_down_and_ends_where_it_was_told_to() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(1500));
    let light = common::cornell_light().to_local(&scene.frame);
    let settings = GpuSettings { batch: 16, light_side: 4, unabsorbed: 0.02, ..GpuSettings::default() };
    let mut solver = solver(&scene, &atlas, Some(light), &settings);
    let emitted = solver.ledger().emitted;
    // Φ = π L A: the light is 0.13 by 0.105 m.
    assert!((emitted.x / (std::f64::consts::PI * 18.4 * 0.13 * 0.105) - 1.0).abs() < 1e-5, "{emitted}");
    solver.step().unwrap();
    let mut last = solver.ledger().unabsorbed();
    let mut steps = Vec::new();
    while !solver.is_done() {
        solver.step().unwrap();
        steps.push(last - solver.ledger().unabsorbed());
        last = solver.ledger().unabsorbed();
    }
    assert!(steps[0] > 3.0 * steps[steps.len() - 1], "{steps:?}");
    assert!(last <= 0.02 && last > 0.0, "{last}");
    assert!(solver.ledger().balance().abs() < 0.01, "{:?}", solver.ledger());
}

#[test]
fn without_light_there_is_nothing_to_shoot() {
    let scene = from_obj(FLOOR, "newmtl unused\n");
    let atlas = atlas_of(&scene, &texels(200));
    let mut solver = solver(&scene, &atlas, None, &GpuSettings::default());
    assert!(solver.is_done());
    solver.step().unwrap();
    let fields = solver.fields().unwrap();
    assert!(fields.total.iter().all(|value| *value == Vec3::ZERO));
}

#[test]
fn the_cornell_box_is_near_the_converged_field_of_the_ray_tracer() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let settings = SolveSettings { subdivide: 4, unabsorbed: 1e-4, ..SolveSettings::even() };
    let problem = common::problem(&scene, Some(common::cornell_light()), settings);
    let (rays, _) = common::solve_unwatched(&problem);
    let by_rays = rays.total();
    let atlas = atlas_of(&scene, &cornell_map());
    let light = common::cornell_light().to_local(&scene.frame);
    let solver = solved(solver(&scene, &atlas, Some(light), &GpuSettings::default()));
    let pages = pages_of(&atlas.charts, &atlas.texels, &solver.fields().unwrap().total);
    let mut is_open = vec![false; atlas.charts.pixel_count()];
    atlas.texels.iter().for_each(|texel| is_open[texel.pixel as usize] = texel.open == 1.0);
    // Not under the blocks or at their feet, where neither field means anything.
    let mut points = area_uniform_points(&scene, 8192, 1);
    points.retain(|(triangle, place)| {
        let at = atlas.charts.map_point(*triangle, *place);
        is_open[atlas.charts.pixel(atlas.charts.pages[*triangle as usize], at.x as u32, at.y as u32)]
    });
    assert!(points.len() > 7000, "{}", points.len());
    let at = |field: &dyn Fn(u32, Vec2) -> Vec3| -> Vec<DVec3> {
        points.iter().map(|(triangle, place)| field(*triangle, *place).as_dvec3()).collect()
    };
    let by_rays = at(&|triangle, place| problem.tessellation.interpolate(&by_rays, triangle, place));
    let by_card = at(&|triangle, place| atlas.charts.interpolate(&pages, triangle, place));
    let errors = field_errors(Field { direct: &by_card, total: &by_card }, Field { direct: &by_rays, total: &by_rays });
    assert!(errors.lit.total.bias.abs() < 0.02, "means differ by {:.2} %", 100.0 * errors.lit.total.bias);
    assert!(errors.lit.total.relative_l2 < 0.05, "fields differ by {:.2} %", 100.0 * errors.lit.total.relative_l2);
}

#[test]
fn the_cornell_box_at_32_texels_a_wall_is_within_5_percent_of_the_truth() {
    let Some(case) = common::truths::case("cornell", "cornell/cornell.obj", 1) else { return };
    let tracer = Tracer::new(case.scene.clone());
    let atlas = atlas_of(&case.scene, &cornell_map());
    let light = case.light.map(|light| light.to_local(&case.scene.frame));
    let solver = solved(solver(&case.scene, &atlas, light, &GpuSettings::default()));
    let fields = solver.fields().unwrap();
    let errors = errors_against(&case, &tracer, &atlas, &fields.direct, &fields.total).lit;
    let ledger = solver.ledger();
    println!("{ledger:?} {errors:?}");
    assert!(errors.total.relative_l2 < 0.05, "{errors:?}");
    assert!(errors.direct.relative_l2 < 0.015 && errors.total.bias.abs() < 0.02, "{errors:?}");
    assert!(ledger.balance().abs() < 0.01, "{ledger:?}");
}

#[test]
fn in_a_scene_of_many_triangles_the_light_is_seen_where_rays_say_so() {
    // 60,000 triangles, and one shooter.
    let scene = common::own_scene("atrium/atrium", &LoadOptions::default());
    let atlas = atlas_of(&scene, &texels(20_000));
    let (low, high) = scene.bounds_in_metres();
    let middle = 0.5 * (low + high);
    let light =
        AreaLightState { centre: middle.to_array(), u: [0.1, 0.0, 0.0], v: [0.0, 0.1, 0.0], radiance: [10.0; 3] };
    let light = light.to_local(&scene.frame);
    let settings = GpuSettings { light_side: 1, light_hemicube: 512, ..GpuSettings::default() };
    let mut solver = solver(&scene, &atlas, Some(light), &settings);
    solver.step().unwrap();
    let direct = solver.fields().unwrap().direct;
    let misplaced = against_rays(&scene, &atlas, &light, &direct, |texel| texel.open > 0.5).misplaced;
    assert!(misplaced < 0.05, "{:.1} % of the light is wrong", 100.0 * misplaced);
}

#[test]
fn mesh_after_mesh_gives_the_same_light_with_more_shooters() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(1000));
    let light = common::cornell_light().to_local(&scene.frame);
    let brightest = GpuSettings { unabsorbed: 0.02, light_side: 4, batch: 16, ..GpuSettings::default() };
    let mesh = GpuSettings { order: ShootingOrder::Mesh, ..brightest };
    let [first, second] = [brightest, mesh].map(|settings| solved(solver(&scene, &atlas, Some(light), &settings)));
    let [a, b] = [&first, &second].map(|solver| mean(&atlas, &solver.fields().unwrap().total));
    assert!(a.abs_diff_eq(b, 0.02 * a.x), "{a} and {b}");
    let [fewer, more] = [&first, &second].map(|solver| solver.ledger().shooters);
    assert!(fewer < more, "{fewer} and {more} shooters");
}

#[test]
#[ignore = "a table, not a test: cargo test --test gpu_lightmap -- --ignored --nocapture"]
fn table_of_orders_on_the_cornell_box() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(1600));
    let light = common::cornell_light().to_local(&scene.frame);
    let ours = GpuSettings { unabsorbed: 0.05, ..GpuSettings::default() };
    let theirs = GpuSettings { order: ShootingOrder::Mesh, group: 1, far_group: 1, batch: 1, ..ours };
    for (name, settings, reads_back) in [("groups, batches", ours, false), ("mesh by mesh", theirs, true)] {
        let mut solver = solver(&scene, &atlas, Some(light), &settings);
        let started = Instant::now();
        while !solver.is_done() {
            solver.step().unwrap();
            if reads_back {
                solver.fields().unwrap();
            }
        }
        let ledger = solver.ledger();
        println!("{name}: {} shooters, {} batches, {:?}", ledger.shooters, ledger.batches, started.elapsed());
    }
}

#[test]
#[ignore = "a table, not a test: cargo test --release --test gpu_lightmap -- --ignored --nocapture"]
fn table_of_settings_on_the_cornell_box() {
    let Some(case) = common::truths::case("cornell", "cornell/cornell.obj", 1) else { return };
    let tracer = Tracer::new(case.scene.clone());
    let started = Instant::now();
    let atlas = Atlas::new(&case.scene, &tracer, &cornell_map(), &|_, _| true).unwrap().unwrap();
    println!("atlas {:?} {} texels in {:?}", atlas.charts.page_size, atlas.texels.len(), started.elapsed());
    let light = case.light.map(|light| light.to_local(&case.scene.frame));
    for settings in experiments() {
        let started = Instant::now();
        let mut solver = solver(&case.scene, &atlas, light, &settings);
        let built = started.elapsed();
        while !solver.is_done() {
            solver.step().unwrap();
        }
        let seconds = started.elapsed();
        let ledger = *solver.ledger();
        let fields = solver.fields().unwrap();
        let errors = errors_against(&case, &tracer, &atlas, &fields.direct, &fields.total).lit;
        println!("{settings:?}");
        println!(
            "  built {built:?}, total {seconds:?}, {} shooters {} batches, balance {:.3} %, escaped {:.2} %, unabsorbed {:.3} %",
            ledger.shooters,
            ledger.batches,
            100.0 * ledger.balance(),
            100.0 * ledger.escaped.element_sum() / ledger.emitted.element_sum(),
            100.0 * ledger.unabsorbed()
        );
        println!(
            "  error {:.2} %, direct {:.2} %, indirect {:.2} %, bias {:.2} % (direct {:.2} %)",
            100.0 * errors.total.relative_l2,
            100.0 * errors.direct.relative_l2,
            100.0 * errors.indirect.relative_l2,
            100.0 * errors.total.bias,
            100.0 * errors.direct.bias
        );
    }
}

fn experiments() -> Vec<GpuSettings> {
    let base = GpuSettings::default();
    vec![
        base.clone(),
        GpuSettings { unabsorbed: 0.05, ..base.clone() },
        GpuSettings { unabsorbed: 0.001, ..base.clone() },
        GpuSettings { ambient: Ambient::Off, ..base.clone() },
        GpuSettings { light_side: 4, ..base.clone() },
        GpuSettings { light_side: 8, ..base.clone() },
        GpuSettings { light_side: 6, ..base.clone() },
        GpuSettings { light_side: 16, ..base.clone() },
        GpuSettings { group: 1, far_group: 1, ..base.clone() },
        GpuSettings { hemicube: 128, ..base.clone() },
        GpuSettings { bias: 1.0, ..base.clone() },
        GpuSettings { no_filter: true, ..base },
    ]
}
