//! E0: direct irradiance by samples on the lights (eq. 3), with shadow rays.
//!
//! Of the light from emissive triangles this finds one share; the gather rays find the other ([`FinderCounts`]).

use glam::{Vec2, Vec3};

use super::{
    lights::{FinderCounts, Lights, area_to_solid_angle},
    origins::origin_of_sample,
    rows::{BLOCKS, block_ends_of, squared_error},
    sampling::{area_light_point, cosine_pdf_solid_angle, triangle_point},
};
use crate::{
    math::sequence::{Sampler, Sequence, Stream},
    scene::{AreaLight, Scene},
    trace::{RayTracer, SurfacePoint, surface::lift},
};

/// Shadow rays that were traced, and those that a light below the horizon or facing away made needless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowRays {
    /// Traced.
    pub traced: u64,
    /// Asked for, but known to carry nothing.
    pub skipped: u64,
}

/// What direct light is gathered with.
pub struct DirectContext<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Traces the shadow rays.
    pub tracer: &'a dyn RayTracer,
    /// What shines.
    pub lights: &'a Lights,
    /// How sample points are placed.
    pub sampler: Sampler,
    /// The solve's seed.
    pub seed: u64,
    /// Samples for the area light, and again for the emissive triangles.
    pub light_rays: u32,
    /// How light from emissive triangles is split.
    pub finders: FinderCounts,
    /// Looked at now and then; once true, what is returned is of no use.
    pub is_cancelled: &'a dyn Fn() -> bool,
}

/// Samples between two looks at the cancel flag.
const SAMPLES_PER_LOOK: u32 = 4096;

impl DirectContext<'_> {
    /// Direct irradiance [W/m²] at a vertex whose rays start from `origins` in turn, and its squared standard error by
    /// the scatter of blocks of samples; 0 without origins.
    pub fn irradiance(&self, vertex: u32, origins: &[SurfacePoint], rays: &mut ShadowRays) -> (Vec3, Vec3) {
        if origins.is_empty() || self.light_rays == 0 {
            return (Vec3::ZERO, Vec3::ZERO);
        }
        let ends = block_ends_of(self.light_rays);
        let starts: [u32; BLOCKS] = std::array::from_fn(|block| if block == 0 { 0 } else { ends[block - 1] });
        let mut blocks: [(Vec3, u32); BLOCKS] = std::array::from_fn(|block| (Vec3::ZERO, ends[block] - starts[block]));
        let mut sum = Vec3::ZERO;
        if let Some(light) = &self.lights.area_light {
            if origins.iter().any(|origin| may_shine_on(light, origin)) {
                let (normal, area) = (light.normal(), light.area());
                sum += self.sum_over(vertex, origins, Stream::AreaLight, &mut blocks, |origin, point| {
                    // One term of eq. 3, the density being one over the area.
                    let position = area_light_point(light, point);
                    let weight = geometry_term(origin, position, normal) * area;
                    self.if_visible(light.radiance * weight, origin, position, rays)
                });
            } else {
                rays.skipped += u64::from(self.light_rays);
            }
        }
        if !self.lights.emitters.is_empty() {
            sum += self.sum_over(vertex, origins, Stream::Emitters, &mut blocks, |origin, point| {
                self.emitters_term(origin, point, rays)
            });
        }
        (sum / self.light_rays as f32, squared_error(blocks))
    }

    fn sum_over(
        &self,
        vertex: u32,
        origins: &[SurfacePoint],
        stream: Stream,
        blocks: &mut [(Vec3, u32); BLOCKS],
        mut estimate: impl FnMut(&SurfacePoint, Vec2) -> Vec3,
    ) -> Vec3 {
        let sequence = Sequence::new(self.sampler, self.seed, vertex, stream, self.light_rays);
        let (ends, mut block) = (block_ends_of(self.light_rays), 0);
        (0..self.light_rays)
            .take_while(|index| index % SAMPLES_PER_LOOK != 0 || !(self.is_cancelled)())
            .map(|index| {
                let origin = &origins[origin_of_sample(index, self.light_rays, origins.len())];
                let term = estimate(origin, sequence.sample_2d(index));
                while index >= ends[block] {
                    block += 1;
                }
                blocks[block].0 += term;
                term
            })
            .sum()
    }

    /// One term of eq. 3 for the emissive triangles: a point on one of them, chosen by power. This is the samples'
    /// share of it.
    fn emitters_term(&self, from: &SurfacePoint, point: Vec2, rays: &mut ShadowRays) -> Vec3 {
        let Some((triangle, rest)) = self.lights.emitters.choose(point.x) else {
            return Vec3::ZERO;
        };
        let corners = self.scene.mesh.corners(triangle);
        let normal = self.scene.mesh.geometric_normal(triangle);
        let position = triangle_point(corners, Vec2::new(rest, point.y)).1;
        let radiance = self.scene.material(triangle).emitted_radiance;
        let pdf_area = self.lights.emitters.pdf_area(radiance);
        let geometry = geometry_term(from, position, normal);
        if geometry <= 0.0 {
            rays.skipped += 1;
            return Vec3::ZERO;
        }
        let (direction, distance) = (position - from.origin).normalize_and_length();
        let light_pdf = area_to_solid_angle(pdf_area, distance, -direction.dot(normal));
        let gather_pdf = cosine_pdf_solid_angle(direction.dot(from.shading_normal));
        let share = 1.0 - self.finders.gather_share(gather_pdf, light_pdf);
        let irradiance = radiance * (geometry / pdf_area * share);
        self.if_visible(irradiance, from, lift(position, normal, corners), rays)
    }

    fn if_visible(&self, irradiance: Vec3, from: &SurfacePoint, target: Vec3, rays: &mut ShadowRays) -> Vec3 {
        // A product that overflowed is dropped with its ray: no infinity may reach a result.
        if !(irradiance.max_element() > 0.0 && irradiance.is_finite()) {
            rays.skipped += 1;
            return Vec3::ZERO;
        }
        let Some(ray) = from.ray_to(target) else {
            rays.skipped += 1;
            return Vec3::ZERO;
        };
        rays.traced += 1;
        if self.tracer.occluded(&ray) { Vec3::ZERO } else { irradiance }
    }
}

/// cosθ cosθ_l / r² between a receiving point and a point of a light; 0 where either faces away.
fn geometry_term(from: &SurfacePoint, position: Vec3, light_normal: Vec3) -> f32 {
    let offset = position - from.origin;
    let squared = offset.length_squared();
    let direction = offset / squared.sqrt();
    let cosine = direction.dot(from.shading_normal);
    let cosine_light = -direction.dot(light_normal);
    if cosine > 0.0 && cosine_light > 0.0 { cosine * cosine_light / squared } else { 0.0 }
}

/// False where the whole light is below the horizon, or the point is behind the light.
fn may_shine_on(light: &AreaLight, from: &SurfacePoint) -> bool {
    let in_front = (from.origin - light.centre).dot(light.normal()) > 0.0;
    in_front && light.corners().iter().any(|corner| (*corner - from.origin).dot(from.shading_normal) > 0.0)
}
