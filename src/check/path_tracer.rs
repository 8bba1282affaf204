//! The reference: irradiance at points by path tracing, with its standard error.
//!
//! Apart from the scene and the ray tracer it shares nothing with the solver, nor with the functions that a student
//! writes: it has its own random numbers and its own samplers. Light sampling and hits by chance are weighted against
//! each other (Veach and Guibas 1995, balance heuristic), so that points beside an emitter have no rare bright samples.

use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rayon::prelude::*;

use super::emitters::{AreaEmitter, EmissiveTriangles, Light, LightPoint};
use crate::{
    math::statistics::RunningMean,
    scene::{AreaLight, Scene},
    trace::{Hit, RayTracer, SurfacePoint},
};

/// Paths may end by Russian roulette from this bounce on: after the bounces that are reported apart.
const ROULETTE_FROM_BOUNCE: u32 = 4;

/// How many paths, and how long.
#[derive(Clone, Copy, Debug)]
pub struct PathSettings {
    /// Paths a point.
    pub samples: u32,
    /// Indirect bounces; later ones are left out.
    pub bounces: u32,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A mean with its standard error [W/m²].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: DVec3,
    /// Its standard error.
    pub standard_error: DVec3,
}

/// Irradiance at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointEstimate {
    /// Bounce 0.
    pub direct: Estimate,
    /// Bounce 1 alone.
    pub bounce1: Estimate,
    /// Bounce 2 alone.
    pub bounce2: Estimate,
    /// All bounces.
    pub total: Estimate,
}

/// Traces paths in one scene.
pub struct PathTracer<'a, R> {
    scene: &'a Scene,
    tracer: &'a R,
    area_light: Option<AreaEmitter>,
    emissive: EmissiveTriangles<'a>,
    settings: PathSettings,
}

/// What one path found: bounces 0, 1, 2, and the sum of all.
type PathSums = [DVec3; 4];

impl<'a, R: RayTracer> PathTracer<'a, R> {
    /// A path tracer of `scene`, lit by its emissive materials and `area_light`. `tracer` must hold the same scene.
    pub fn new(scene: &'a Scene, tracer: &'a R, area_light: Option<&AreaLight>, settings: PathSettings) -> Self {
        Self {
            scene,
            tracer,
            area_light: area_light.and_then(AreaEmitter::new),
            emissive: EmissiveTriangles::new(scene),
            settings,
        }
    }

    /// Irradiance at each point; the same bits on any number of threads. `progress` is told now and then how many
    /// points are done.
    pub fn estimate_all(&self, points: &[SurfacePoint], mut progress: impl FnMut(usize)) -> Vec<PointEstimate> {
        const BLOCK: usize = 512;
        let mut estimates = Vec::with_capacity(points.len());
        while estimates.len() < points.len() {
            let block = estimates.len()..points.len().min(estimates.len() + BLOCK);
            estimates.par_extend(block.into_par_iter().map(|index| self.estimate(&points[index], index as u32)));
            progress(estimates.len());
        }
        estimates
    }

    /// Irradiance at one point; `index` tells its random numbers from those of other points.
    pub fn estimate(&self, point: &SurfacePoint, index: u32) -> PointEstimate {
        let key: u64 = SmallRng::seed_from_u64(self.settings.seed).random();
        let mut generator = SmallRng::seed_from_u64(key ^ u64::from(index));
        let mut means = [RunningMean::default(); 4];
        for _ in 0..self.settings.samples {
            for (mean, value) in means.iter_mut().zip(self.sample_path(point, &mut generator)) {
                mean.add(value);
            }
        }
        let [direct, bounce1, bounce2, total] =
            means.map(|mean| Estimate { mean: mean.mean(), standard_error: mean.standard_error() });
        PointEstimate { direct, bounce1, bounce2, total }
    }

    fn sample_path(&self, start: &SurfacePoint, generator: &mut SmallRng) -> PathSums {
        let mut sums = PathSums::default();
        let mut point = *start;
        // cosθ/π cancels against the density of the directions, so only reflectances gather here (eq. 4).
        let mut throughput = Vec3::ONE;
        for bounce in 0..=self.settings.bounces {
            let direction = cosine_direction(point.shading_normal, generator);
            let hit = point.ray(direction).and_then(|ray| self.tracer.closest_hit(&ray));
            let irradiance = self.light_samples(&point, generator) + self.lights_met(&point, direction, hit);
            let found = (throughput * irradiance).as_dvec3();
            sums[3] += found;
            if let Some(sum) = sums[..3].get_mut(bounce as usize) {
                *sum += found;
            }
            let Some(hit) = hit.filter(|hit| hit.front) else {
                break; // a back face absorbs
            };
            throughput *= self.scene.reflectance(hit.triangle, hit.barycentric);
            let survival = if bounce < ROULETTE_FROM_BOUNCE { 1.0 } else { throughput.max_element().min(1.0) };
            if throughput == Vec3::ZERO || generator.random::<f32>() >= survival {
                break;
            }
            throughput /= survival;
            point = SurfacePoint::new(self.scene, hit.triangle, hit.barycentric).on_curve(
                self.scene,
                hit.barycentric,
                self.tracer,
            );
        }
        sums
    }

    /// Direct irradiance by one point on each kind of light (eq. 3).
    fn light_samples(&self, point: &SurfacePoint, generator: &mut SmallRng) -> Vec3 {
        let mut irradiance = Vec3::ZERO;
        if let Some(light) = &self.area_light {
            let sample = light.sample(generator);
            let is_visible = |ray: &_| !self.tracer.occluded(ray);
            irradiance += self.of_light_point(point, &sample, is_visible);
        }
        if let Some((triangle, sample)) = self.emissive.sample(generator) {
            // Visible where the ray, however long, meets this triangle first: no margin that could hide or show
            // what lies close to it.
            irradiance += self.of_light_point(point, &sample, |ray| {
                let unlimited = crate::trace::Ray { max_distance: f32::INFINITY, ..*ray };
                self.tracer.closest_hit(&unlimited).is_some_and(|hit| hit.triangle == triangle)
            });
        }
        irradiance
    }

    /// Direct irradiance by one sampled point.
    fn of_light_point(
        &self,
        point: &SurfacePoint,
        sample: &LightPoint,
        is_visible: impl Fn(&crate::trace::Ray) -> bool,
    ) -> Vec3 {
        let Some(ray) = point.ray_to(sample.position) else {
            return Vec3::ZERO;
        };
        let cosine = ray.direction.dot(point.shading_normal);
        let light_cosine = -ray.direction.dot(sample.normal);
        if cosine <= 0.0 || light_cosine <= 0.0 || !is_visible(&ray) {
            return Vec3::ZERO;
        }
        let pdf_solid_angle = sample.pdf_area * ray.max_distance * ray.max_distance / light_cosine;
        // The balance heuristic: each way's density counts.
        sample.radiance * (cosine / (pdf_solid_angle + cosine_pdf(cosine)))
    }

    /// Direct irradiance by the lights that a cosine-distributed ray meets.
    fn lights_met(&self, point: &SurfacePoint, direction: Vec3, hit: Option<Hit>) -> Vec3 {
        if direction.dot(point.geometric_normal) <= 0.0 {
            return Vec3::ZERO;
        }
        let cosine = direction.dot(point.shading_normal);
        let weighted = |light: Light| light.radiance * (cosine / (light.pdf_solid_angle + cosine_pdf(cosine)));
        let nearest = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let area_light = self.area_light.as_ref().and_then(|light| light.meet(point.origin, direction, nearest));
        let triangle = hit.and_then(|hit| self.emissive.meet(&hit, direction));
        area_light.map_or(Vec3::ZERO, weighted) + triangle.map_or(Vec3::ZERO, weighted)
    }
}

/// Density of [`cosine_direction`] [1/sr].
fn cosine_pdf(cosine: f32) -> f32 {
    cosine.max(0.0) * std::f32::consts::FRAC_1_PI
}

/// A direction of density cosθ/π about `normal`: the normal plus a point of the unit sphere, which needs no frame.
fn cosine_direction(normal: Vec3, generator: &mut SmallRng) -> Vec3 {
    let z = 1.0 - 2.0 * generator.random::<f32>();
    let (sine, cosine) = (std::f32::consts::TAU * generator.random::<f32>()).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    (normal + Vec3::new(radius * cosine, radius * sine, z)).try_normalize().unwrap_or(normal)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec2;

    use super::*;
    use crate::{
        check::closed_form::{furnace_irradiance, polygon_irradiance},
        scene::{LocalFrame, Material, Mesh},
        trace::Tracer,
    };

    /// The inside of the cube [-1/2, 1/2]³, all of one material.
    fn box_inside(material: Material) -> Arc<Scene> {
        let mut mesh = Mesh::default();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let normal = -sign * Vec3::AXES[axis];
                let across = Vec3::AXES[(axis + 1) % 3];
                let along = normal.cross(across);
                let first = mesh.positions.len() as u32;
                for [s, t] in [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]] {
                    mesh.positions.push(-0.5 * normal + s * across + t * along);
                    mesh.normals.push(normal);
                }
                mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
                mesh.material_indices.extend([0, 0]);
            }
        }
        Arc::new(Scene {
            name: String::from("box"),
            mesh,
            materials: vec![material],
            textures: Vec::new(),
            frame: LocalFrame::default(),
            enclosed: Vec::new(),
            two_sided: false,
            faceted: false,
            warnings: Vec::new(),
        })
    }

    fn settings(samples: u32, bounces: u32) -> PathSettings {
        PathSettings { samples, bounces, seed: 3 }
    }

    fn assert_within(found: Estimate, expected: f64, errors: f64, what: &str) {
        let allowed = errors * found.standard_error + 1e-5 * expected;
        assert!((found.mean - expected).abs().cmple(allowed).all(), "{what}: {found:?}, expected {expected}");
    }

    #[test]
    fn an_emissive_box_is_a_furnace_bounce_by_bounce() {
        let material =
            Material { reflectance: Vec3::splat(0.6), emitted_radiance: Vec3::splat(2.0), ..Material::default() };
        let scene = box_inside(material);
        let tracer = Tracer::new(scene.clone());
        let points: Vec<_> = (0..12).map(|id| SurfacePoint::new(&scene, id, Vec2::new(0.2, 0.3))).collect();
        let direct = 2.0 * std::f64::consts::PI;
        for bounces in [0, 1, 2, 12] {
            let path_tracer = PathTracer::new(&scene, &tracer, None, settings(500, bounces));
            for found in path_tracer.estimate_all(&points, |_| ()) {
                assert_within(found.direct, direct, 4.0, "direct");
                assert_within(found.total, furnace_irradiance(direct, 0.6, bounces), 4.0, "total"); // eq. 5
                let bounce1 = if bounces >= 1 { 0.6 * direct } else { 0.0 };
                assert_within(found.bounce1, bounce1, 4.0, "bounce 1");
                let bounce2 = if bounces >= 2 { 0.36 * direct } else { 0.0 };
                assert_within(found.bounce2, bounce2, 4.0, "bounce 2");
            }
        }
    }

    #[test]
    fn light_of_a_rectangle_matches_lamberts_formula_near_and_far() {
        let scene = box_inside(Material::default());
        let tracer = Tracer::new(scene.clone());
        let light = AreaLight {
            centre: Vec3::new(0.1, 0.3, 0.0),
            half_extent_u: Vec3::new(0.3, 0.0, 0.1),
            half_extent_v: Vec3::new(0.1, 0.0, 0.2),
            radiance: Vec3::new(1.0, 2.0, 3.0),
        };
        assert!(light.normal().y < 0.0);
        let path_tracer = PathTracer::new(&scene, &tracer, Some(&light), settings(4000, 0));
        for (index, position) in [[0.0, -0.5, 0.0], [0.1, 0.29, 0.0], [0.4, 0.2, 0.1]].into_iter().enumerate() {
            for normal in [Vec3::Y, Vec3::new(-0.6, 0.8, 0.0)] {
                let position = Vec3::from_array(position);
                let point = SurfacePoint {
                    origin: position,
                    geometric_normal: normal,
                    shading_normal: normal,
                    triangle: crate::trace::NO_TRIANGLE,
                };
                let expected = polygon_irradiance(position, normal, &light.corners(), light.radiance).as_dvec3();
                let found = path_tracer.estimate(&point, index as u32).direct; // eq. 6
                let allowed = 4.0 * found.standard_error + 1e-6;
                assert!((found.mean - expected).abs().cmple(allowed).all(), "{position}: {found:?} {expected}");
                assert!(found.standard_error.cmple(0.02 * expected).all(), "{position}: noisy {found:?}");
            }
        }
        let behind = SurfacePoint::new(&scene, 6, Vec2::new(0.3, 0.3));
        assert!(behind.origin.y > 0.4); // the ceiling, above the light
        assert_eq!(path_tracer.estimate(&behind, 0).direct, Estimate::default());
    }

    #[test]
    fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
        let material = Material { emitted_radiance: Vec3::ONE, ..Material::default() };
        let scene = box_inside(material);
        let tracer = Tracer::new(scene.clone());
        let points: Vec<_> = (0..12).map(|id| SurfacePoint::new(&scene, id, Vec2::new(0.2, 0.3))).collect();
        let run = |threads, seed| {
            let path_tracer = PathTracer::new(&scene, &tracer, None, PathSettings { samples: 20, bounces: 4, seed });
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.map(|pool| pool.install(|| path_tracer.estimate_all(&points, |_| ()))).ok()
        };
        let one = run(1, 7);
        assert!(one.is_some());
        assert_eq!(one, run(3, 7));
        assert_ne!(one, run(1, 8));
    }
}
