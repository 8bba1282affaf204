//! The ray tracer against brute force, against itself, and against rays aimed at edges.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{path::PathBuf, sync::Arc, time::Duration};

use glam::{DVec3, Vec3};
use obvhs::{BvhBuildParams, bvh2::builder::build_bvh2};
use radiosity::{
    scene::{LoadOptions, Mesh, Scene, load},
    trace::{Hit, Ray, RayTracer, SurfacePoint, Tracer, surface::free_ray},
};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rayon::prelude::*;

const SCENES: [&str; 10] = [
    "cornell/cornell",
    "atrium/atrium",
    "bleeding/bleeding",
    "tests/furnace-30",
    "tests/furnace-50",
    "tests/furnace-80",
    "tests/furnace-95",
    "tests/parallel-plates",
    "tests/perpendicular-plates",
    "tests/sphere-in-box",
];

fn scene(name: &str) -> Arc<Scene> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.obj"));
    Arc::new(load::load(&path, &LoadOptions::default()).unwrap())
}

fn random_unit(generator: &mut SmallRng) -> Vec3 {
    loop {
        let candidate = Vec3::from_array(generator.random::<[f32; 3]>()) * 2.0 - 1.0;
        if (0.01..=1.0).contains(&candidate.length_squared()) {
            return candidate.normalize();
        }
    }
}

/// Rays from points in and around the scene's box into all directions, some of them along an axis (with components
/// of +0 and -0).
fn random_rays(seed: u64, count: usize) -> Vec<Ray> {
    let mut generator = SmallRng::seed_from_u64(seed);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut ray = |index: usize| {
        let origin = (Vec3::from_array(generator.random::<[f32; 3]>()) * 2.0 - 1.0) * 1.2;
        let direction = random_unit(&mut generator);
        free_ray(origin, if index.is_multiple_of(10) { axes[index / 10 % 6] } else { direction })
    };
    (0..count).map(&mut ray).collect()
}

/// Triangles for brute force: a corner and two edges in f64, and bounding spheres to pass over the many that a ray
/// comes nowhere near.
struct Triangles {
    edges: Vec<[DVec3; 3]>,
    centres: [Vec<f32>; 3],
    squared_radii: Vec<f32>,
}

impl Triangles {
    fn new(scene: &Scene) -> Self {
        let all = || (0..scene.mesh.triangles.len() as u32).map(|triangle| scene.mesh.corners(triangle));
        let centre = |corners: [Vec3; 3]| corners.into_iter().sum::<Vec3>() / 3.0;
        let squared_radius = |corners: [Vec3; 3]| {
            let reach = corners.map(|corner| corner.distance(centre(corners))).into_iter().fold(0.0, f32::max);
            (reach * 1.001 + 1e-4).powi(2)
        };
        let edges = |corners: [Vec3; 3]| {
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            [a, b - a, c - a]
        };
        Self {
            edges: all().map(edges).collect(),
            centres: [0, 1, 2].map(|axis| all().map(|corners| centre(corners)[axis]).collect()),
            squared_radii: all().map(squared_radius).collect(),
        }
    }

    /// Triangles whose bounding sphere the ray's line meets.
    fn near(&self, ray: &Ray) -> impl Iterator<Item = usize> + '_ {
        let (origin, direction) = (ray.origin, ray.direction);
        let [xs, ys, zs] = &self.centres;
        let is_near: Vec<bool> = (0..self.edges.len())
            .map(|index| {
                let [x, y, z] = [xs[index] - origin.x, ys[index] - origin.y, zs[index] - origin.z];
                let along = x * direction.x + y * direction.y + z * direction.z;
                x * x + y * y + z * z - along * along <= self.squared_radii[index]
            })
            .collect();
        is_near.into_iter().enumerate().filter_map(|(index, near)| near.then_some(index))
    }
}

/// Distances at which a ray meets each triangle, by Möller and Trumbore (1997) in f64: another method than the tracer's.
fn brute_force(triangles: &Triangles, ray: &Ray) -> Vec<(f64, u32)> {
    const SLACK: f64 = 1e-7;
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let meet = |id: usize| {
        let [corner, edge_b, edge_c] = triangles.edges[id];
        let cross = direction.cross(edge_c);
        let determinant = edge_b.dot(cross);
        let to_origin = origin - corner;
        let (u, sign) = (to_origin.dot(cross) * determinant.signum(), determinant.signum());
        let limit = determinant.abs() * (1.0 + SLACK);
        if u < -SLACK * limit || u > limit {
            return None;
        }
        let around = to_origin.cross(edge_b);
        let v = direction.dot(around) * sign;
        let distance = edge_c.dot(around) / determinant;
        (v >= -SLACK * limit && u + v <= limit && distance > 0.0).then_some((distance, id as u32))
    };
    triangles.near(ray).filter_map(meet).collect()
}

#[test]
fn closest_hits_agree_with_brute_force_on_every_scene_for_100_000_rays() {
    for name in SCENES {
        let scene = scene(name);
        if scene.materials.iter().any(|material| material.opacity_texture.is_some()) {
            // Brute force here knows no cut-outs: compare with them closed.
            let mut closed = (*scene).clone();
            closed.materials.iter_mut().for_each(|material| material.opacity_texture = None);
            agree_with_brute_force(name, Arc::new(closed));
        } else {
            agree_with_brute_force(name, scene);
        }
    }
}

fn agree_with_brute_force(name: &str, scene: Arc<Scene>) {
    let tracer = Tracer::new(Arc::clone(&scene));
    let triangles = Triangles::new(&scene);
    // Where two triangles lie within the rounding of f32 of each other, either answer is right.
    let tolerance = 4e-6;
    random_rays(11, 100_000).par_iter().for_each(|ray| {
        let all = brute_force(&triangles, ray);
        let nearest = all.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
        match tracer.closest_hit(ray) {
            None => {
                assert!(nearest == f64::INFINITY || is_grazing(&scene, ray, &all), "{name}: {ray:?} missed {all:?}");
            }
            Some(hit) => {
                let distance = f64::from(hit.distance);
                let found = all.iter().any(|(other, id)| *id == hit.triangle && (other - distance).abs() < tolerance);
                assert!(
                    found || is_grazing(&scene, ray, &[(0.0, hit.triangle)]),
                    "{name}: {ray:?} hit {hit:?}, not {all:?}"
                );
                assert!(
                    distance < nearest + tolerance || is_grazing(&scene, ray, &all),
                    "{name}: {ray:?} hit {hit:?}, not {nearest}"
                );
                assert!(tracer.occluded(ray), "{name}: {ray:?} hits {hit:?} but is not occluded");
            }
        }
    });
}

/// True if a ray meets one of these triangles nearly edge-on, where f32 distances lose their digits.
fn is_grazing(scene: &Scene, ray: &Ray, hits: &[(f64, u32)]) -> bool {
    hits.iter().any(|&(_, id)| scene.mesh.geometric_normal(id).dot(ray.direction).abs() < 1e-3)
}

/// Rays from up to 100 scenes away at the triangles' edges and corners.
fn rays_at_edges(scene: &Scene, seed: u64, count: usize) -> impl Iterator<Item = Ray> {
    let mut generator = SmallRng::seed_from_u64(seed);
    (0..count).map(move |index| {
        let [a, b, _] = scene.mesh.corners(generator.random_range(0..scene.mesh.triangles.len() as u32));
        let target = if index.is_multiple_of(4) { a } else { a.lerp(b, generator.random()) };
        let origin = generator.random_range(1.0..100.0) * random_unit(&mut generator);
        free_ray(origin, (target - origin).normalize())
    })
}

#[test]
fn all_trees_give_the_same_answers() {
    let presets = [
        BvhBuildParams::fastest_build(),
        BvhBuildParams::very_fast_build(),
        BvhBuildParams::fast_build(),
        BvhBuildParams::medium_build(),
        BvhBuildParams::slow_build(),
        BvhBuildParams::very_slow_build(),
    ];
    for name in ["cornell/cornell", "atrium/atrium", "tests/sphere-in-box"] {
        let scene = scene(name);
        let rays: Vec<Ray> = random_rays(5, 20_000).into_iter().chain(rays_at_edges(&scene, 6, 50_000)).collect();
        let answers =
            |tracer: Tracer| -> Vec<Option<Hit>> { rays.par_iter().map(|ray| tracer.closest_hit(ray)).collect() };
        let own = answers(Tracer::new(Arc::clone(&scene)));
        for preset in presets {
            let tracer = Tracer::with_tree(Arc::clone(&scene), |boxes| {
                build_bvh2(boxes, BvhBuildParams { max_prims_per_leaf: 1, ..preset }, &mut Duration::default())
            });
            assert!(own == answers(tracer), "{name}: {preset:?}");
        }
    }
}

#[test]
fn no_ray_escapes_a_closed_scene_through_10_million_edges_and_vertices() {
    for name in ["tests/furnace-50", "tests/sphere-in-box"] {
        let scene = scene(name);
        let tracer = Tracer::new(Arc::clone(&scene));
        let triangle_count = scene.mesh.triangles.len() as u32;
        let escaped: u64 = (0..10_000_u64)
            .into_par_iter()
            .map(|block| {
                let mut generator = SmallRng::seed_from_u64(block);
                let mut escaped = 0;
                for index in 0..1000 {
                    let [a, b, _] = scene.mesh.corners(generator.random_range(0..triangle_count));
                    let target = if index % 4 == 0 { a } else { a.lerp(b, generator.random()) };
                    let origin = (Vec3::from_array(generator.random::<[f32; 3]>()) - 0.5) * 1.9;
                    let ray = free_ray(origin, (target - origin).normalize());
                    escaped += u64::from(tracer.closest_hit(&ray).is_none());
                }
                escaped
            })
            .sum();
        assert_eq!(escaped, 0, "{name}");
    }
}

#[test]
fn no_ray_from_far_away_passes_between_the_triangles_of_a_closed_box() {
    let scene = scene("tests/furnace-50");
    let tracer = Tracer::new(Arc::clone(&scene));
    let half = scene.mesh.positions.iter().fold(Vec3::ZERO, |half, position| half.max(position.abs()));
    let triangle_count = scene.mesh.triangles.len() as u32;
    let (aimed, passed): (u64, u64) = (0..2000_u64)
        .into_par_iter()
        .map(|block| {
            let mut generator = SmallRng::seed_from_u64(block);
            let (mut aimed, mut passed) = (0, 0);
            for index in 0..500 {
                let [a, b, _] = scene.mesh.corners(generator.random_range(0..triangle_count));
                let target = if index % 4 == 0 { a } else { a.lerp(b, generator.random()) };
                // From 20 to 100 half-sizes away, before the wall that the target lies inside of.
                let outside = (target / half).abs().cmpgt(Vec3::splat(0.999));
                if outside.bitmask().count_ones() != 1 {
                    continue;
                }
                let side = Vec3::select(outside, target.signum(), Vec3::ZERO);
                let origin = generator.random_range(20.0..100.0) * (side + 0.3 * random_unit(&mut generator));
                aimed += 1;
                passed += u64::from(tracer.closest_hit(&free_ray(origin, (target - origin).normalize())).is_none());
            }
            (aimed, passed)
        })
        .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    assert!(aimed > 500_000, "{aimed}");
    assert_eq!(passed, 0, "of {aimed}");
}

/// Triangles of all sorts in a box: random ones, needles, some without area, and some on top of another; `scale` times as
/// large.
fn soup(seed: u64, scale: f32) -> Arc<Scene> {
    let mut generator = SmallRng::seed_from_u64(seed);
    let mut scene = (*scene("tests/parallel-plates")).clone();
    let material = scene.mesh.material_indices[0];
    let mut corners: Vec<[Vec3; 3]> = Vec::new();
    for index in 0..2000 {
        let centre = Vec3::from_array(generator.random::<[f32; 3]>()) * 1.8 - 0.9;
        let [u, v] = [random_unit(&mut generator), random_unit(&mut generator)].map(|unit| 0.1 * unit);
        corners.push(match index % 10 {
            0 => [centre, centre + 5.0 * u, centre + 5.0 * u + 1e-5 * v],
            1 => [centre, centre + u, centre + u],
            2 => [centre; 3],
            3 if index > 10 => corners[index - 5],
            _ => [centre, centre + u, centre + v],
        });
    }
    scene.mesh = Mesh {
        positions: corners.iter().flatten().map(|corner| *corner * scale).collect(),
        triangles: (0..corners.len() as u32).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner)).collect(),
        material_indices: vec![material; corners.len()],
        ..Mesh::default()
    };
    Arc::new(scene)
}

#[test]
fn in_a_soup_of_needles_points_and_coincident_triangles_hits_are_those_of_brute_force() {
    for seed in 0..4 {
        let scene = soup(seed, 1.0);
        let tracer = Tracer::new(Arc::clone(&scene));
        let triangles = Triangles::new(&scene);
        random_rays(seed, 20_000).par_iter().for_each(|ray| {
            let all = brute_force(&triangles, ray);
            let is_certain = |(_, id): &&(f64, u32)| !is_edge_on(&triangles, ray, *id);
            let nearest = all.iter().filter(is_certain).map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
            let hit = tracer.closest_hit(ray);
            let distance = hit.map_or(f64::INFINITY, |hit| f64::from(hit.distance));
            assert!(distance < nearest + 4e-6 || nearest == f64::INFINITY, "{ray:?}: {hit:?}, not at {nearest}");
            if let Some(hit) = hit {
                let is_there = all.iter().any(|(other, id)| *id == hit.triangle && (other - distance).abs() < 4e-6);
                assert!(is_there || is_edge_on(&triangles, ray, hit.triangle), "{ray:?}: {hit:?} is none of {all:?}");
                // Of two that lie on each other the first is hit, and with it left out the second.
                let first = scene.mesh.corners(hit.triangle);
                let others = (0..hit.triangle).filter(|&other| scene.mesh.corners(other) == first);
                assert_eq!(others.count(), 0, "{ray:?}: {hit:?} lies on a triangle that comes first");
            }
        });
    }
}

/// True if f32 cannot tell how a ray meets a triangle: a needle, or one that it sees from the side.
fn is_edge_on(triangles: &Triangles, ray: &Ray, id: u32) -> bool {
    let [_, b, c] = triangles.edges[id as usize];
    let across = b.cross(c).dot(ray.direction.as_dvec3()).abs();
    across < 1e-2 * b.length().max(c.length()).powi(2)
}

#[test]
fn a_scene_a_million_times_as_large_or_as_small_gives_the_same_hits() {
    let rays = random_rays(21, 20_000);
    let hits = |scale: f32| -> Vec<Option<Hit>> {
        let tracer = Tracer::new(soup(9, scale));
        let scaled = rays.iter().map(|ray| Ray { origin: ray.origin * scale, ..*ray });
        scaled.map(|ray| tracer.closest_hit(&ray).map(|hit| Hit { distance: hit.distance / scale, ..hit })).collect()
    };
    let plain = hits(1.0);
    assert!(plain.iter().flatten().count() > 1000);
    // Powers of two, so that nothing is rounded otherwise.
    for exponent in [-20, 20] {
        assert!(hits(2.0_f32.powi(exponent)) == plain, "2^{exponent}");
    }
}

#[test]
fn a_ray_is_occluded_just_when_it_has_a_hit_before_its_end() {
    for scene in [scene("cornell/cornell"), scene("atrium/atrium"), soup(3, 1.0)] {
        let tracer = Tracer::new(Arc::clone(&scene));
        let mut generator = SmallRng::seed_from_u64(1);
        let mut occluded = 0;
        for ray in random_rays(4, 50_000) {
            // Ends at random, and just at, before and behind the nearest hit.
            let mut ends = vec![generator.random_range(0.0..2.0), f32::INFINITY, 0.0];
            let nearest = tracer.closest_hit(&ray).map(|hit| hit.distance);
            ends.extend(nearest.into_iter().flat_map(|hit| [hit.next_down(), hit, hit.next_up()]));
            for max_distance in ends {
                let ray = Ray { max_distance, ..ray };
                let hit = tracer.closest_hit(&ray);
                assert!(hit.is_none_or(|hit| hit.distance > 0.0 && hit.distance < max_distance), "{ray:?}: {hit:?}");
                assert_eq!(hit.is_some(), nearest.is_some_and(|nearest| nearest < max_distance), "{ray:?}");
                assert_eq!(tracer.occluded(&ray), hit.is_some(), "{ray:?}: {hit:?}");
                occluded += u32::from(hit.is_some());
            }
        }
        assert!(occluded > 1000);
    }
}

#[test]
fn a_ray_that_leaves_a_surface_does_not_meet_it_again_at_any_scale_or_place() {
    let flat = scene("tests/furnace-50");
    let tracer = Tracer::new(Arc::clone(&flat));
    let mut generator = SmallRng::seed_from_u64(3);
    for _ in 0..200_000 {
        let triangle = generator.random_range(0..flat.mesh.triangles.len() as u32);
        let [u, v] = generator.random::<[f32; 2]>();
        let barycentric = if u + v <= 1.0 { glam::Vec2::new(u, v) } else { glam::Vec2::new(1.0 - u, 1.0 - v) };
        let point = SurfacePoint::new(&flat, triangle, barycentric);
        let Some(ray) = point.ray(random_unit(&mut generator)) else { continue };
        let hit = tracer.closest_hit(&ray).unwrap_or_else(|| panic!("{ray:?} from {point:?} {barycentric} escapes"));
        assert!(hit.front, "from {point:?} along {ray:?}: {hit:?} is seen from behind");
        let same_plane = flat.mesh.geometric_normal(hit.triangle).dot(point.geometric_normal) > 0.999;
        assert!(!same_plane, "from {point:?} along {ray:?}: {hit:?} lies in the same wall");
    }
}

#[test]
fn a_two_sided_plate_is_hit_on_its_front_from_both_sides() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes/tests/parallel-plates.obj");
    let options = LoadOptions { two_sided: true, ..LoadOptions::default() };
    let scene = Arc::new(load::load(&path, &options).unwrap());
    let tracer = Tracer::new(Arc::clone(&scene));
    for ray in random_rays(8, 10_000) {
        let Some(hit) = tracer.closest_hit(&ray) else { continue };
        assert!(hit.front);
        assert!(scene.mesh.geometric_normal(hit.triangle).dot(ray.direction) < 0.0);
        let expected = ray.origin + hit.distance * ray.direction;
        assert!(scene.mesh.position(hit.triangle, hit.barycentric).abs_diff_eq(expected, 1e-5));
        let again = Ray { origin_triangle: hit.triangle, ..ray };
        assert_ne!(
            tracer.closest_hit(&again).map(|other| other.triangle % (scene.mesh.triangles.len() as u32 / 2)),
            Some(hit.triangle % (scene.mesh.triangles.len() as u32 / 2))
        );
    }
}
