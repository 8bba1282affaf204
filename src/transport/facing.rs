//! Which sides of the surfaces light first meets. A scene that is wound the wrong way, as one that was mirrored is, stays
//! black and looks like one without light: so it is said.

use glam::{Vec2, Vec3};

use crate::{
    math::{
        color::luminance,
        sequence::{Sampler, Sequence, Stream},
    },
    scene::{AreaLight, LoadOptions, Scene},
    trace::{Ray, RayTracer, SurfacePoint, surface::free_ray},
};

/// Rays from the lights, and from each side of the surfaces.
const RAYS: u32 = 1024;

/// Of all light so much must first meet back faces, and of the surface that it meets so much must be theirs. The first
/// leaves out a lamp whose light mostly escapes; the second a lamp under a shade of one side, which takes most of the
/// light but is small beside the room around.
const MOST_IN_BACKS: f64 = 0.5;

/// Of a scene that is wound right all but one body seen from outside has fronts that face each other: so few that do are
/// none.
const NO_FRONTS: f64 = 0.02;

/// From behind nearly all of a scene that is closed is back faces.
const ALL_BACKS: f64 = 0.9;

/// What helps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// To swap front and back of all triangles: [`LoadOptions::flip`], or not to.
    Flip,
    /// To give all of them two sides: [`LoadOptions::two_sided`].
    TwoSided,
}

/// What is to be said of a scene that light meets from behind.
#[derive(Clone, Debug, PartialEq)]
pub struct Facing {
    /// One line: how much, where, what to do.
    pub text: String,
    /// What likely helps.
    pub remedy: Remedy,
}

/// What rays first met.
#[derive(Default)]
struct Met {
    rays: u32,
    fronts: u32,
    backs: u32,
    /// The surface that the rays stand for (the squares of their lengths), and what of it is back faces.
    surface: f64,
    surface_of_backs: f64,
    /// Rays that met back faces, by material.
    backs_of_material: Vec<u32>,
}

/// What is to be said, if anything, of a scene as light from its emissive triangles and `light` meets it. Without light it
/// is judged by what its surfaces see. `load` are the options that it was read with; `tracer` must hold the same scene.
pub fn facing(scene: &Scene, tracer: &dyn RayTracer, light: Option<&AreaLight>, load: &LoadOptions) -> Option<Facing> {
    let flip = if load.flip { "leave out --flip" } else { "use --flip" };
    let met = Met::of(scene, tracer, rays_of_lights(scene, light));
    if light.is_none() && met.part(met.fronts + met.backs) < NO_FRONTS {
        // Nothing shines, or only what is part of the scene, and away from it.
        return is_inside_out(scene, tracer).then(|| Facing {
            text: format!("no surface faces another one, and from behind all do: if this is a room, {flip}"),
            remedy: Remedy::Flip,
        });
    }
    if met.part(met.backs) <= MOST_IN_BACKS || met.surface_of_backs <= MOST_IN_BACKS * met.surface {
        return None;
    }
    let most = (0..scene.materials.len()).max_by_key(|&material| met.backs_of_material[material])?;
    let text = format!(
        "{:.0} % of the light first meets back faces, most of them of `{}`: if the scene is inside out, {flip}; if its \
         surfaces are seen from both sides, use --two-sided",
        100.0 * met.part(met.backs),
        scene.materials[most].name,
    );
    let is_all_wrong = f64::from(met.backs) > ALL_BACKS * f64::from(met.fronts + met.backs);
    Some(Facing { text, remedy: if is_all_wrong { Remedy::Flip } else { Remedy::TwoSided } })
}

/// True if hardly a ray from the surfaces' front sides meets a front, and nearly all from behind meet backs: a room that
/// is wound outwards, or one body alone.
fn is_inside_out(scene: &Scene, tracer: &dyn RayTracer) -> bool {
    let areas = (0..scene.mesh.triangles.len() as u32).map(|triangle| (triangle, scene.mesh.area(triangle)));
    let Some(surfaces) = Chooser::new(areas) else {
        return false;
    };
    let rays = |side: f32| {
        let ray = move |(triangle, point, direction): (u32, SurfacePoint, Vec3)| Ray {
            origin: if side > 0.0 { point.origin } else { mirrored(scene, triangle, point.origin) },
            direction: side * direction,
            max_distance: f32::INFINITY,
            origin_triangle: triangle,
        };
        (0..RAYS).map(|index| surfaces.sample(scene, index)).map(ray)
    };
    let (front, behind) = (Met::of(scene, tracer, rays(1.0)), Met::of(scene, tracer, rays(-1.0)));
    front.part(front.fronts) < NO_FRONTS && behind.part(behind.backs) > ALL_BACKS
}

/// A point that was lifted off a triangle's front, as far off its back.
fn mirrored(scene: &Scene, triangle: u32, origin: Vec3) -> Vec3 {
    let [corner, ..] = scene.mesh.corners(triangle);
    let normal = scene.mesh.geometric_normal(triangle);
    origin - 2.0 * (origin - corner).dot(normal) * normal
}

/// Rays from the lights, as many from each as its power asks, spread by the cosine.
fn rays_of_lights(scene: &Scene, light: Option<&AreaLight>) -> Vec<Ray> {
    let power = |triangle| luminance(scene.material(triangle).emitted_radiance) * scene.mesh.area(triangle);
    let emitters = Chooser::new(scene.emissive_triangles().map(|triangle| (triangle, power(triangle))));
    let emitted = emitters.as_ref().map_or(0.0, |emitters| emitters.total);
    let placed = light.map_or(0.0, |light| f64::from(luminance(light.radiance) * light.area()));
    if emitted + placed <= 0.0 {
        return Vec::new();
    }
    let from_placed = (f64::from(RAYS) * placed / (emitted + placed)).round() as u32;
    let of_light = |light: &AreaLight, index| {
        let (direction, place) = sample(index);
        let Vec2 { x, y } = 2.0 * place - 1.0;
        let origin = light.centre + x * light.half_extent_u + y * light.half_extent_v;
        free_ray(origin, about(light.normal(), direction))
    };
    let of_triangle = |emitters: &Chooser, index| {
        let (_, point, direction) = emitters.sample(scene, index);
        point.ray(direction)
    };
    let mut rays: Vec<Ray> =
        light.into_iter().flat_map(|light| (0..from_placed).map(move |index| of_light(light, index))).collect();
    rays.extend(
        emitters.iter().flat_map(|emitters| (from_placed..RAYS).filter_map(|index| of_triangle(emitters, index))),
    );
    rays
}

/// Point `index` of the directions' square, and of the surface's.
fn sample(index: u32) -> (Vec2, Vec2) {
    Sequence::new(Sampler::Sobol, 1, 0, Stream::Surface, RAYS).sample_4d(index)
}

/// A direction of density cosθ/π about `normal`: the normal plus a point of the unit sphere, which needs no frame.
fn about(normal: Vec3, square: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * square.x;
    let (sine, cosine) = (std::f32::consts::TAU * square.y).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    (normal + Vec3::new(radius * cosine, radius * sine, z)).try_normalize().unwrap_or(normal)
}

/// Chooses triangles by a weight.
struct Chooser {
    triangles: Vec<u32>,
    /// Sums of the weights up to each.
    sums: Vec<f64>,
    total: f64,
}

impl Chooser {
    /// None if nothing weighs anything.
    fn new(weights: impl Iterator<Item = (u32, f32)>) -> Option<Self> {
        let mut total = 0.0;
        let (triangles, sums) = weights
            .map(|(triangle, weight)| {
                total += f64::from(weight);
                (triangle, total)
            })
            .unzip();
        (total > 0.0).then_some(Self { triangles, sums, total })
    }

    /// A point of a triangle, even over the surface, and a direction from its front side.
    fn sample(&self, scene: &Scene, index: u32) -> (u32, SurfacePoint, Vec3) {
        let (direction, place) = sample(index);
        let choice = (f64::from(index) + 0.5) / f64::from(RAYS) * self.total;
        let triangle = self.triangles[self.sums.partition_point(|&sum| sum <= choice).min(self.triangles.len() - 1)];
        let root = place.x.sqrt();
        let point = SurfacePoint::new(scene, triangle, Vec2::new(root * (1.0 - place.y), root * place.y));
        (triangle, point, about(point.geometric_normal, direction))
    }
}

impl Met {
    fn of(scene: &Scene, tracer: &dyn RayTracer, rays: impl IntoIterator<Item = Ray>) -> Self {
        let mut met = Self { backs_of_material: vec![0; scene.materials.len()], ..Self::default() };
        for ray in rays {
            met.rays += 1;
            let Some(hit) = tracer.closest_hit(&ray) else { continue };
            let surface = f64::from(hit.distance) * f64::from(hit.distance);
            met.surface += surface;
            if hit.front {
                met.fronts += 1;
            } else {
                met.backs += 1;
                met.surface_of_backs += surface;
                met.backs_of_material[scene.mesh.material_indices[hit.triangle as usize] as usize] += 1;
            }
        }
        met
    }

    /// So many of all rays.
    fn part(&self, rays: u32) -> f64 {
        f64::from(rays) / f64::from(self.rays.max(1))
    }
}
