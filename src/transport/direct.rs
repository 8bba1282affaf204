//! E0: direct irradiance, by Lambert's formula over what is seen of each light (eq. 6, `visible_light`), or by samples
//! on the lights with shadow rays (eq. 3).
//!
//! Of sampled light from emissive triangles this finds one share; the gather rays find the other ([`FinderCounts`]).

use std::time::Instant;

use glam::{Vec2, Vec3};

pub use super::visible_light::ShadowRays;
use super::{
    blocks::{BLOCKS, block_ends_of, squared_error},
    lights::{DirectMethod, FinderCounts, Lights, area_to_solid_angle},
    origins::samples_of_origin,
    sampling::{area_light_point, cosine_pdf_solid_angle, triangle_point},
    visible_light::{PolygonLight, Scratch, Seen, Sight, visible_irradiance},
};
use crate::{
    math::sequence::{Sampler, Sequence, Stream},
    scene::{AreaLight, Scene},
    trace::{NO_TRIANGLE, RayTracer, SurfacePoint, surface::lift},
};

/// Direct light at a vertex or a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectLight {
    /// Irradiance from the area light [W/m²].
    pub area_light: Vec3,
    /// Irradiance from the emissive triangles [W/m²].
    pub emitters: Vec3,
    /// The squared standard error of both together, by the scatter of blocks of samples.
    pub squared_error: Vec3,
}

impl DirectLight {
    /// Irradiance from both [W/m²].
    pub fn irradiance(&self) -> Vec3 {
        self.area_light + self.emitters
    }
}

/// What direct light is gathered with.
pub struct DirectContext<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Traces the shadow rays.
    pub tracer: &'a dyn RayTracer,
    /// What shines.
    pub lights: &'a Lights,
    /// With samples alone or not.
    pub method: DirectMethod,
    /// How sample points are placed.
    pub sampler: Sampler,
    /// The solve's seed.
    pub seed: u64,
    /// Samples for the area light, and again for the emissive triangles.
    pub light_rays: u32,
    /// How light from emissive triangles is split where it is sampled.
    pub finders: FinderCounts,
    /// Looked at now and then; once true, what is returned is of no use.
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Samples between two looks at the cancel flag.
const SAMPLES_PER_LOOK: u32 = 4096;

/// The light that reaches one vertex, one origin after the other.
struct Receiver<'a> {
    vertex: u32,
    origins: &'a [SurfacePoint],
    /// The sample that each block ends before.
    ends: [u32; BLOCKS],
    /// Sum and number of each block's samples. What is known without samples is spread evenly: it does not scatter.
    blocks: [(Vec3, u32); BLOCKS],
}

impl DirectContext<'_> {
    /// Direct light at a vertex whose rays start from `origins` in turn; none without origins. `found` is the gather
    /// rays' share of the light of emissive triangles from each origin, or empty.
    pub fn at_vertex(
        &self,
        vertex: u32,
        origins: &[SurfacePoint],
        found: &[Vec3],
        scratch: &mut Scratch,
        rays: &mut ShadowRays,
    ) -> DirectLight {
        if origins.is_empty() || self.light_rays == 0 {
            return DirectLight::default();
        }
        let ends = block_ends_of(self.light_rays);
        let count = |block: usize| ends[block] - if block == 0 { 0 } else { ends[block - 1] };
        let blocks = std::array::from_fn(|block| (Vec3::ZERO, count(block)));
        let mut receiver = Receiver { vertex, origins, ends, blocks };
        let area_light = self.area_light_irradiance(&mut receiver, scratch, rays);
        let emitters = self.emitters_irradiance(&mut receiver, found, scratch, rays);
        DirectLight { area_light, emitters, squared_error: squared_error(receiver.blocks) }
    }

    /// Direct light at a single point, without the gather rays' share.
    pub fn at_point(&self, point: &SurfacePoint, scratch: &mut Scratch, rays: &mut ShadowRays) -> DirectLight {
        let bits = point.origin.to_array().map(f32::to_bits);
        let key = bits.into_iter().fold(0_u32, |key, word| key.rotate_left(11).wrapping_mul(0x9e37_79b1) ^ word);
        self.at_vertex(key, std::slice::from_ref(point), &[], scratch, rays)
    }

    fn area_light_irradiance(&self, receiver: &mut Receiver, scratch: &mut Scratch, rays: &mut ShadowRays) -> Vec3 {
        let Some(light) = &self.lights.area_light else {
            return Vec3::ZERO;
        };
        if !receiver.origins.iter().any(|origin| may_shine_on(light, origin)) {
            rays.skip(Sight::BelowHorizon, u64::from(self.light_rays));
            return Vec3::ZERO;
        }
        let (normal, area, corners) = (light.normal(), light.area(), light.corners());
        let polygon = PolygonLight { corners: &corners, normal, radiance: light.radiance, triangle: NO_TRIANGLE };
        let by_polygon = |origin: &SurfacePoint| self.visible(origin, &polygon, scratch);
        self.mean_over(receiver, Stream::AreaLight, rays, by_polygon, |origin, point, rays| {
            // One term of eq. 3, the density being one over the area.
            let position = area_light_point(light, point);
            let weight = geometry_term(origin, position, normal) * area;
            self.if_visible(light.radiance * weight, origin, position, rays)
        })
    }

    fn emitters_irradiance(
        &self,
        receiver: &mut Receiver,
        found: &[Vec3],
        scratch: &mut Scratch,
        rays: &mut ShadowRays,
    ) -> Vec3 {
        let emitters = &self.lights.emitters;
        if emitters.is_empty() {
            return Vec3::ZERO;
        }
        let triangles = emitters.as_polygons(self.scene);
        let mut from_gather = Vec3::ZERO;
        let mut index = 0;
        let by_polygon = |origin: &SurfacePoint| {
            let known = triangles.and_then(|triangles| self.visible_emitters(origin, triangles, scratch));
            if known.is_none() {
                from_gather += found.get(index).copied().unwrap_or_default();
            }
            index += 1;
            known
        };
        let mean = self.mean_over(receiver, Stream::Emitters, rays, by_polygon, |origin, point, rays| {
            self.emitters_term(origin, point, rays)
        });
        mean + from_gather
    }

    /// The mean over the origins of what `known` says, or where it knows nothing, of samples from there.
    fn mean_over(
        &self,
        receiver: &mut Receiver,
        stream: Stream,
        rays: &mut ShadowRays,
        mut known: impl FnMut(&SurfacePoint) -> Option<Seen>,
        mut estimate: impl FnMut(&SurfacePoint, Vec2, &mut ShadowRays) -> Vec3,
    ) -> Vec3 {
        let sequence = Sequence::new(self.sampler, self.seed, receiver.vertex, stream, self.light_rays);
        let (mut sum, mut is_untimed) = (Vec3::ZERO, true);
        for (place, origin) in receiver.origins.iter().enumerate() {
            let run = samples_of_origin(place, self.light_rays, receiver.origins.len());
            if let Some(seen) = known(origin) {
                rays.skip(seen.sight, u64::from(run.end - run.start));
                let part = seen.irradiance / receiver.origins.len() as f32;
                sum += part;
                receiver.blocks.iter_mut().for_each(|(sum, count)| *sum += part * *count as f32);
                continue;
            }
            let (timed, traced_before) = (is_untimed.then(Instant::now), rays.traced);
            is_untimed = false;
            let mut block = 0;
            for index in run.take_while(|index| index % SAMPLES_PER_LOOK != 0 || !(self.is_cancelled)()) {
                let term = estimate(origin, sequence.sample_2d(index), rays);
                sum += term / self.light_rays as f32;
                while index >= receiver.ends[block] {
                    block += 1;
                }
                receiver.blocks[block].0 += term;
            }
            if let Some(started) = timed.filter(|_| rays.traced > traced_before) {
                rays.timed += rays.traced - traced_before;
                rays.timed_nanoseconds += started.elapsed().as_nanos() as u64;
            }
        }
        sum
    }

    /// Irradiance from a polygon light, where it can be known without samples.
    fn visible(&self, origin: &SurfacePoint, light: &PolygonLight, scratch: &mut Scratch) -> Option<Seen> {
        if self.method == DirectMethod::Sampled {
            return None;
        }
        visible_irradiance(self.tracer, |triangle| self.scene.mesh.corners(triangle), origin, light, scratch)
    }

    /// Irradiance from all emissive triangles, where it can be known without samples.
    fn visible_emitters(&self, origin: &SurfacePoint, triangles: &[u32], scratch: &mut Scratch) -> Option<Seen> {
        let none = Seen { irradiance: Vec3::ZERO, sight: Sight::BelowHorizon };
        triangles.iter().try_fold(none, |sum, &triangle| {
            let corners = self.scene.mesh.corners(triangle);
            let light = PolygonLight {
                corners: &corners,
                normal: self.scene.mesh.geometric_normal(triangle),
                radiance: self.scene.material(triangle).emitted_radiance,
                triangle,
            };
            let seen = self.visible(origin, &light, scratch)?;
            Some(Seen { irradiance: sum.irradiance + seen.irradiance, sight: sum.sight.max(seen.sight) })
        })
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
            rays.skip(Sight::BelowHorizon, 1);
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
            rays.skip(Sight::BelowHorizon, 1);
            return Vec3::ZERO;
        }
        let Some(ray) = from.ray_to(target) else {
            rays.skip(Sight::BelowHorizon, 1);
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
