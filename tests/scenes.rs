//! The project's own scenes and states: as the generator writes them, usable, and with their fronts to the viewer.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;
#[path = "../examples/make_scenes/mod.rs"]
mod make_scenes;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use common::own_scene;
use glam::{DVec3, Vec3};
use radiosity::{
    math::sequence::{Sampler, Sequence, Stream},
    scene::{LoadOptions, Scene, builtin},
    solver::State,
    trace::{NO_TRIANGLE, Ray, RayTracer, Tracer},
};

/// Every state file, and the scene it is for.
const STATES: [(&str, &str); 11] = [
    ("scenes/cornell/cornell.toml", "cornell/cornell"),
    ("scenes/bleeding/bleeding.toml", "bleeding/bleeding"),
    ("scenes/atrium/atrium.toml", "atrium/atrium"),
    ("states/cornell-front.toml", "cornell/cornell"),
    ("states/cornell-left.toml", "cornell/cornell"),
    ("states/cornell-floor.toml", "cornell/cornell"),
    ("states/cornell-inside.toml", "cornell/cornell"),
    ("states/atrium-court.toml", "atrium/atrium"),
    ("states/atrium-banners.toml", "atrium/atrium"),
    ("states/atrium-gallery.toml", "atrium/atrium"),
    ("states/atrium-vaults.toml", "atrium/atrium"),
];

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn state(path: &str) -> State {
    let (state, warnings) = State::from_toml(&fs::read_to_string(package().join(path)).unwrap()).unwrap();
    assert!(warnings.is_empty(), "{path}: {warnings:?}");
    state
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] }).collect()
}

/// Of 4,000 rays from a point in all directions: how many meet a front, a back, and nothing.
fn looks_around(scene: &Arc<Scene>, from: DVec3) -> [u32; 3] {
    let tracer = Tracer::new(Arc::clone(scene));
    let origin = scene.frame.point_to_local(from);
    let mut counts = [0; 3];
    let sequence = Sequence::new(Sampler::Sobol, 1, 0, Stream::Hemisphere, 4000);
    for index in 0..4000 {
        let point = sequence.sample_2d(index);
        let height = 1.0 - 2.0 * point.x; // uniform on the sphere (Archimedes)
        let (sine, cosine) = (std::f32::consts::TAU * point.y).sin_cos();
        let radius = (1.0 - height * height).max(0.0).sqrt();
        let direction = Vec3::new(radius * cosine, height, radius * sine);
        let ray = Ray { origin, direction, max_distance: f32::INFINITY, origin_triangle: NO_TRIANGLE };
        counts[tracer.closest_hit(&ray).map_or(2, |hit| if hit.front { 0 } else { 1 })] += 1;
    }
    counts
}

#[test]
fn the_generator_writes_the_files_of_this_repository() {
    for file in make_scenes::all().unwrap() {
        let path = package().join("scenes").join(&file.path);
        let stored = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let same = if file.path.ends_with(".png") {
            // By texels: another version of the compressor may write other bytes.
            image::load_from_memory(&stored).unwrap() == image::load_from_memory(&file.bytes).unwrap()
        } else {
            stored == file.bytes
        };
        assert!(same, "{} is not what `cargo run --release --example make_scenes` writes", file.path);
    }
}

#[test]
fn every_state_file_is_in_the_list_and_reads_without_warnings() {
    let mut found: Vec<PathBuf> = [files_below(&package().join("scenes")), files_below(&package().join("states"))]
        .concat()
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    let mut listed: Vec<PathBuf> = STATES.iter().map(|(path, _)| package().join(path)).collect();
    found.sort();
    listed.sort();
    assert_eq!(found, listed);
    for (path, _) in STATES {
        let state = state(path);
        assert!(state.camera.is_some() && state.light.is_some(), "{path}");
    }
}

#[test]
fn every_view_sees_only_fronts_and_the_rooms_are_closed() {
    for (path, scene) in STATES {
        let scene = own_scene(scene, &LoadOptions::default());
        let camera = state(path).camera.unwrap();
        let [fronts, backs, nothing] = looks_around(&scene, DVec3::from_array(camera.position));
        if path.contains("cornell") {
            // From outside, through the open side, all that is seen is inside; the rest of the world is empty.
            assert!(fronts > 0 && backs == 0, "{path}: {backs} backs");
        } else {
            assert!(fronts > 2000, "{path}: {fronts} fronts");
            // Where a banner's hem is cut, one ray in some 30,000 gets between its two faces.
            assert!(backs <= 1, "{path}: {backs} backs");
            assert!(nothing == 0 || path.contains("atrium"), "{path}: only the atrium is open, to the sky");
        }
    }
    for name in ["furnace-30", "furnace-50", "furnace-80", "furnace-95", "sphere-in-box"] {
        let scene = own_scene(&format!("tests/{name}"), &LoadOptions::default());
        assert_eq!(looks_around(&scene, DVec3::new(0.7, 0.75, 0.8)), [4000, 0, 0], "{name}");
    }
}

#[test]
fn lights_shine_down() {
    for (path, scene) in STATES {
        let frame = own_scene(scene, &LoadOptions::default()).frame;
        let normal = state(path).light.unwrap().to_local(&frame).normal();
        assert!(normal.y < -0.9, "{path}: {normal}");
    }
}

#[test]
fn the_cornell_box_is_the_published_one_and_the_built_in_one() {
    let scene = builtin::cornell(&LoadOptions::default()).unwrap();
    // 30, and what the floor is cut into around the blocks.
    assert_eq!(scene.mesh.triangles.len(), 46);
    assert_eq!(scene.hash(), own_scene("cornell/cornell", &LoadOptions::default()).hash());
    // Published: 556 mm wide, 548.8 high, 559.2 deep. The largest half-extent sets the scale.
    let corner = scene.mesh.positions.iter().copied().reduce(Vec3::max).unwrap();
    let far = scene.frame.point_to_metres(corner);
    assert!(far.abs_diff_eq(DVec3::new(0.556, 0.5488, 0.5592), 1e-6), "{far}");
    // Floor (552.8 + 549.6) / 2 · 559.2 mm², with what is left out under the blocks; it is the first quad.
    let is_floor = |&triangle: &u32| {
        scene.mesh.positions[scene.mesh.triangles[triangle as usize][0] as usize].y < -0.4
            && scene.mesh.geometric_normal(triangle).y > 0.99
    };
    let around: f32 = (0..46).filter(is_floor).map(|triangle| scene.mesh.area(triangle)).sum();
    let under: f32 = scene.enclosed.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
    let floor = f64::from(around + under) * scene.frame.square_metres_per_unit();
    assert!((floor - 0.5512 * 0.5592).abs() < 1e-6, "{floor}");
    let (state, warnings) = State::from_toml(builtin::CORNELL_STATE).unwrap();
    assert_eq!((state.light, warnings.len()), (Some(common::cornell_light()), 0));
}

#[test]
fn the_atrium_has_a_fair_size_textures_and_cut_outs() {
    let scene = own_scene("atrium/atrium", &LoadOptions::default());
    // Its stones touch, and what lies between them is left out.
    assert!(scene.warnings.iter().all(|line| line.contains("enclosed") || line.contains("in the place of")));
    // Cut where its stones stand on one another, it has more.
    let as_read = own_scene("atrium/atrium", &LoadOptions { faces_as_read: true, ..LoadOptions::default() });
    assert!((20_000..=60_000).contains(&as_read.mesh.triangles.len()), "{}", as_read.mesh.triangles.len());
    let count = scene.mesh.triangles.len();
    assert!(count < 110_000, "{count}");
    assert!(scene.textures.len() >= 6);
    assert!((0..count as u32).any(|triangle| scene.may_be_cut_out(triangle)));
}

#[test]
fn known_answers_have_the_areas_and_materials_that_the_formulas_are_for() {
    for (name, area, reflectance) in [
        ("furnace-30", 6.0, 0.3),
        ("furnace-50", 6.0, 0.5),
        ("furnace-80", 6.0, 0.8),
        ("furnace-95", 6.0, 0.95),
        ("parallel-plates", 2.0, 0.0),
        ("perpendicular-plates", 2.0, 0.0),
    ] {
        let scene = own_scene(&format!("tests/{name}"), &LoadOptions::default());
        let areas = (0..scene.mesh.triangles.len() as u32).map(|triangle| f64::from(scene.mesh.area(triangle)));
        let total = areas.sum::<f64>() * scene.frame.square_metres_per_unit();
        assert!((total - area).abs() < 1e-5, "{name}: {total}");
        let emitter = scene.material(0);
        assert_eq!(emitter.reflectance, Vec3::splat(reflectance), "{name}");
        // M = π L_e = 1 W/m².
        assert!((emitter.emitted_radiance * std::f32::consts::PI).abs_diff_eq(Vec3::ONE, 1e-6), "{name}");
    }
}
