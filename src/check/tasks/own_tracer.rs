//! A student's ray tracer against the program's own: random rays, and rays that are hard to get right.

use std::{sync::Arc, time::Instant};

use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use serde::Serialize;

use super::stage::{Quad, Stage, box_inside, matt};
use crate::{
    scene::{LoadOptions, Scene, builtin},
    solver::faults::caught,
    student::Functions,
    trace::{Hit, NO_TRIANGLE, Ray, RayTracer, surface::lift},
};

/// Rays of each kind in each scene.
const RAYS: u32 = 2000;

/// What a comparison found.
#[derive(Clone, Debug, Serialize)]
pub struct TracerReport {
    /// Rays compared; those at the very rim of a surface, where both answers are right, do not count.
    pub rays: u32,
    /// The first ray that is answered wrongly: its kind, the ray, both answers.
    pub wrong: Option<String>,
    /// Nearest hits a second, compared with the program's own tracer: 2 is twice as fast. 0 if it answers wrongly.
    pub relative_speed: f64,
}

/// Compares; `None` while no tracer is written.
pub fn compare_tracer(functions: &Functions, seed: u64) -> Option<TracerReport> {
    let (mut rays, mut speeds) = (0, Vec::new());
    for stage in stages() {
        let wrong = |wrong, rays| Some(TracerReport { rays, wrong: Some(wrong), relative_speed: 0.0 });
        let theirs = match caught(|| (functions.ray_tracer)(&stage.scene)) {
            Ok(tracer) => tracer?,
            Err(message) => return wrong(format!("{}: it panics while it is made: {message}", stage.scene.name), rays),
        };
        let mut generator = SmallRng::seed_from_u64(seed);
        for (kind, make) in KINDS {
            for _ in 0..RAYS {
                let ray = make(&stage.scene, &mut generator);
                if !is_settled(&stage, &ray) {
                    continue;
                }
                rays += 1;
                if let Some(problem) = mistake(&stage, &*theirs, &ray) {
                    return wrong(format!("{}, {kind}: {problem}, for {ray:?}", stage.scene.name), rays);
                }
            }
        }
        speeds.push(relative_speed(&stage, &*theirs, &mut generator));
    }
    let product: f64 = speeds.iter().product();
    Some(TracerReport { rays, wrong: None, relative_speed: product.powf(1.0 / speeds.len() as f64) })
}

/// The Cornell box, whose walls lie along the axes, and a room at no special angle with triangles that coincide, lie
/// close to each other, or are long and thin.
fn stages() -> Vec<Stage> {
    let mut quads = box_inside(Vec3::new(-0.5, -0.4, -0.6), Vec3::new(0.5, 0.5, 0.6));
    let plate = |y: f32, width: f32| Quad {
        corner: Vec3::new(-0.3, y, -0.3),
        along: 0.6 * Vec3::X,
        up: width * Vec3::Z,
        material: 0,
    };
    quads.extend([plate(0.1, 0.5), plate(0.1, 0.5), plate(0.1001, 0.4), plate(-0.1, 0.001), plate(-0.2, 1e-4)]);
    let room = Stage::new(&quads, vec![matt(Vec3::ONE); 6], Vec::new(), 0);
    let cornell = builtin::cornell(&LoadOptions::default()).map(|scene| Stage::of(Arc::new(scene), 0));
    cornell.into_iter().chain([room]).collect()
}

type Kind = (&'static str, fn(&Scene, &mut SmallRng) -> Ray);

const KINDS: [Kind; 8] = [
    ("a random ray", |_, random| free(point(random), direction(random))),
    ("a ray at a vertex", |scene, random| at_place(scene, random, |_| Vec2::ZERO)),
    ("a ray at an edge", |scene, random| at_place(scene, random, |random| Vec2::new(random.random(), 0.0))),
    ("a ray along an axis", |_, random| {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
        free(point(random), axes[random.random_range(0..6)])
    }),
    ("a grazing ray", |scene, random| {
        let triangle = random.random_range(0..scene.mesh.triangles.len() as u32);
        let [a, b, c] = scene.mesh.corners(triangle);
        let normal = scene.mesh.geometric_normal(triangle);
        let along = (b - a + random.random::<f32>() * (c - b)).normalize_or_zero();
        free(a - 0.3 * along + 2e-3 * normal, (along - 1e-3 * normal).normalize_or_zero())
    }),
    ("a ray that leaves a surface", |scene, random| {
        let triangle = random.random_range(0..scene.mesh.triangles.len() as u32);
        let normal = scene.mesh.geometric_normal(triangle);
        let place = scene.mesh.position(triangle, Vec2::new(random.random::<f32>() * 0.5, 0.4));
        let direction = direction(random);
        Ray {
            origin_triangle: triangle,
            ..free(
                lift(place, normal, scene.mesh.corners(triangle)),
                if direction.dot(normal) < 0.0 { -direction } else { direction },
            )
        }
    }),
    ("a ray in the plane of the triangle that it leaves", |scene, random| {
        let triangle = random.random_range(0..scene.mesh.triangles.len() as u32);
        let [a, b, c] = scene.mesh.corners(triangle);
        let origin = (a + b + c) / 3.0;
        let direction = (b - origin + random.random::<f32>() * (c - b)).normalize_or_zero();
        Ray { origin_triangle: triangle, ..free(origin, direction) }
    }),
    ("a ray with an end", |_, random| Ray {
        max_distance: 0.9 * random.random::<f32>(),
        ..free(point(random), direction(random))
    }),
];

fn free(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, max_distance: f32::INFINITY, origin_triangle: NO_TRIANGLE }
}

fn point(random: &mut SmallRng) -> Vec3 {
    0.9 * Vec3::from_array(std::array::from_fn(|_| random.random::<f32>() - 0.5))
}

fn direction(random: &mut SmallRng) -> Vec3 {
    loop {
        let vector = Vec3::from_array(std::array::from_fn(|_| 2.0 * random.random::<f32>() - 1.0));
        if vector.length() > 0.1 && vector.length() < 1.0 {
            return vector.normalize_or_zero();
        }
    }
}

fn at_place(scene: &Scene, random: &mut SmallRng, place: fn(&mut SmallRng) -> Vec2) -> Ray {
    let triangle = random.random_range(0..scene.mesh.triangles.len() as u32);
    let target = scene.mesh.position(triangle, place(random));
    let origin = point(random);
    free(origin, (target - origin).normalize_or_zero())
}

/// Whether the answer is beyond doubt: rays beside this one, and ends beside its end, get the same.
fn is_settled(stage: &Stage, ray: &Ray) -> bool {
    const NUDGE: f32 = 1e-4;
    const SLIGHT: f32 = 1e-6;
    let first = stage.tracer.closest_hit(ray);
    let (a, b) = ray.direction.any_orthonormal_pair();
    let sides = [a, -a, b, -b, a + b, a - b, b - a, -a - b];
    let nudged =
        |nudge: f32| sides.map(|side| Ray { direction: (ray.direction + nudge * side).normalize_or_zero(), ..*ray });
    let (beside, closer) = (nudged(NUDGE), nudged(SLIGHT));
    let ends = [1.0 - NUDGE, 1.0 + NUDGE].map(|factor| Ray { max_distance: factor * ray.max_distance, ..*ray });
    let is_same = |ray: &Ray, share: f32| match (first, stage.tracer.closest_hit(ray)) {
        (None, None) => true,
        (Some(first), Some(other)) => {
            first.front == other.front && (first.distance - other.distance).abs() < share * first.distance
        }
        _ => false,
    };
    ray.direction.is_normalized()
        && beside.iter().chain(&ends).all(|ray| is_same(ray, 0.2))
        && closer.iter().all(|ray| is_same(ray, 2e-4))
}

/// What is wrong with the answers to a settled ray.
fn mistake(stage: &Stage, theirs: &dyn RayTracer, ray: &Ray) -> Option<String> {
    let ours = stage.tracer.closest_hit(ray);
    let (found, occluded) = match caught(|| (theirs.closest_hit(ray), theirs.occluded(ray))) {
        Ok(answers) => answers,
        Err(message) => return Some(format!("it panics: {message}")),
    };
    let differs = |what: &str| Some(format!("{what}: {found:?} where {ours:?} is right"));
    match (found, ours) {
        (None, None) => {}
        (Some(_), None) => return differs("a hit where there is none"),
        (None, Some(_)) => return differs("no hit where there is one"),
        (Some(hit), Some(right)) => {
            if (hit.distance - right.distance).abs() > 1e-3 * right.distance + 1e-5 {
                let nearer = hit.distance < right.distance;
                return differs(if nearer { "the hit is too near" } else { "the hit is not the nearest" });
            }
            // Of triangles at the same distance any will do, if all that is said of it is true.
            if !is_on_ray(&stage.scene, &hit, ray) {
                return differs("triangle and barycentric coordinates do not give the point that was hit");
            }
            if hit.front != (ray.direction.dot(stage.scene.mesh.scaled_normal(hit.triangle)) < 0.0) {
                return differs("front and back are confused");
            }
        }
    }
    let word = if occluded { "occluded" } else { "free" };
    (occluded != ours.is_some()).then(|| format!("`occluded` says {word} where the nearest hit is {ours:?}"))
}

fn is_on_ray(scene: &Scene, hit: &Hit, ray: &Ray) -> bool {
    (hit.triangle as usize) < scene.mesh.triangles.len() && {
        let point = ray.origin + hit.distance * ray.direction;
        scene.mesh.position(hit.triangle, hit.barycentric).distance(point) < 2e-3
    }
}

/// How many times as fast: the better of three runs each, in turn.
fn relative_speed(stage: &Stage, theirs: &dyn RayTracer, random: &mut SmallRng) -> f64 {
    let rays: Vec<Ray> = (0..10 * RAYS).map(|_| free(point(random), direction(random))).collect();
    let seconds = |tracer: &dyn RayTracer| {
        let started = Instant::now();
        let hits = rays.iter().filter(|ray| tracer.closest_hit(ray).is_some()).count();
        // The count is looked at, so that no call is left out.
        started.elapsed().as_secs_f64() + if hits > rays.len() { 1.0 } else { 1e-9 }
    };
    let (mut own, mut other) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..3 {
        own = own.min(seconds(&stage.tracer));
        other = other.min(seconds(theirs));
    }
    own / other
}
