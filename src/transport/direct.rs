//! E0: direct irradiance, by Lambert's formula over what is seen of each light (eq. 6, `visible_light`), or by samples
//! on the lights with shadow rays (eq. 3).
//!
//! Of sampled light from emissive triangles this finds one share; the gather rays find the other ([`FinderCounts`]).

use std::time::Instant;

use glam::{Vec2, Vec3};

pub use super::visible_light::ShadowRays;
use super::{
    blocks::{BLOCKS, block_ends_of, squared_error},
    lamps::Lamp,
    lights::{DirectMethod, FinderCounts, Lights, area_to_solid_angle},
    origins::samples_of_origin,
    sampling::{area_light_point, cosine_pdf_solid_angle, triangle_point},
    visible_light::{Scratch, Seen, Sight, unhidden_irradiance, visible_irradiance},
};
use crate::{
    math::sequence::{Sampler, Sequence, Stream},
    scene::{AreaLight, Scene},
    trace::{RayTracer, SurfacePoint, surface::lift},
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
        let (normal, area) = (light.normal(), light.area());
        let look = |origin: &SurfacePoint| self.look_at(origin, self.lights.area_lamp.as_slice(), scratch);
        self.mean_over(receiver, Stream::AreaLight, rays, look, |origin, point| {
            // One term of eq. 3, the density being one over the area.
            let position = area_light_point(light, point);
            Some((light.radiance * (geometry_term(origin, position, normal) * area), position))
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
        let gathers = self.finders.gather > 0 && self.method == DirectMethod::Analytic;
        let mut from_gather = Vec3::ZERO;
        let mut index = 0;
        let look = |origin: &SurfacePoint| {
            let known = match emitters.lamps() {
                None => Look::Sample { unhidden: None },
                Some(lamps) => match self.look_at(origin, lamps, scratch) {
                    // Many lamps fill much of what is seen: gather rays find them with less noise than few samples.
                    Look::Sample { .. } if lamps.len() > 1 && gathers => Look::Sample { unhidden: None },
                    known => known,
                },
            };
            if matches!(known, Look::Sample { unhidden: None }) {
                from_gather += found.get(index).copied().unwrap_or_default();
            }
            index += 1;
            known
        };
        let mean =
            self.mean_over(receiver, Stream::Emitters, rays, look, |origin, point| self.emitters_term(origin, point));
        mean + from_gather
    }

    /// The mean over the origins of what a look at the light says, or where that is not enough, of samples from there:
    /// `sample` gives the term of eq. 3 with nothing between, and the point on the light.
    fn mean_over(
        &self,
        receiver: &mut Receiver,
        stream: Stream,
        rays: &mut ShadowRays,
        mut look: impl FnMut(&SurfacePoint) -> Look,
        sample: impl Fn(&SurfacePoint, Vec2) -> Option<(Vec3, Vec3)>,
    ) -> Vec3 {
        let sequence = Sequence::new(self.sampler, self.seed, receiver.vertex, stream, self.light_rays);
        let (mut sum, mut is_untimed) = (Vec3::ZERO, true);
        // Where no sample could see the light, what hides it is not known there, but from the other origins: what there
        // would be at such origins with nothing between, and at the others, with what there is.
        let [mut untold, mut unhidden_elsewhere, mut found_elsewhere] = [Vec3::ZERO; 3];
        for (place, origin) in receiver.origins.iter().enumerate() {
            let run = samples_of_origin(place, self.light_rays, receiver.origins.len());
            let count = u64::from(run.end - run.start);
            let unhidden = match look(origin) {
                Look::Known(seen) => {
                    rays.skip(seen.sight, count);
                    sum += receiver.spread_evenly(seen.irradiance);
                    continue;
                }
                Look::Sample { unhidden } => unhidden,
            };
            let (timed, traced_before) = (is_untimed.then(Instant::now), rays.traced);
            is_untimed = false;
            let agreeing = FEWEST_AGREEING.max((AGREEING * count as f32) as u32);
            let mut samples = Samples { agreeing, ..Samples::default() };
            for index in run.take_while(|index| index % SAMPLES_PER_LOOK != 0 || !(self.is_cancelled)()) {
                if unhidden.is_some() && samples.agree() {
                    break;
                }
                let sample = self.is_seen(sample(origin, sequence.sample_2d(index)), origin, rays);
                samples.enter(sample, receiver.block_of(index));
            }
            if let Some(started) = timed.filter(|_| rays.traced > traced_before) {
                rays.timed += rays.traced - traced_before;
                rays.timed_nanoseconds += started.elapsed().as_nanos() as u64;
            }
            let part = match unhidden {
                Some(unhidden) if samples.tell_nothing() => {
                    untold += unhidden;
                    continue;
                }
                Some(unhidden) if samples.agree() => {
                    let sight = if samples.seen == 0 { Sight::Hidden } else { Sight::Whole };
                    rays.skip(sight, count - u64::from(samples.taken));
                    receiver.spread_evenly(if samples.seen == 0 { Vec3::ZERO } else { unhidden })
                }
                _ => receiver.enter(&samples, unhidden, self.light_rays),
            };
            sum += part;
            if let Some(unhidden) = unhidden {
                unhidden_elsewhere += unhidden;
                found_elsewhere += part * receiver.origins.len() as f32;
            }
        }
        let is_told = unhidden_elsewhere.cmpgt(Vec3::ZERO);
        let seen = Vec3::select(is_told, found_elsewhere / unhidden_elsewhere, Vec3::ONE);
        sum + receiver.spread_evenly(untold * seen)
    }

    /// A sample's term, and whether the light is seen there; none, and no ray, where it cannot be.
    fn is_seen(
        &self,
        sample: Option<(Vec3, Vec3)>,
        from: &SurfacePoint,
        rays: &mut ShadowRays,
    ) -> Option<(Vec3, bool)> {
        // A product that overflowed is dropped with its ray: no infinity may reach a result.
        let sample = sample.filter(|(term, _)| term.max_element() > 0.0 && term.is_finite());
        let Some((term, ray)) = sample.and_then(|(term, target)| Some((term, from.ray_to(target)?))) else {
            rays.skip(Sight::BelowHorizon, 1);
            return None;
        };
        rays.traced += 1;
        Some((term, !self.tracer.occluded(&ray)))
    }

    /// What is known of lamps without samples.
    fn look_at(&self, origin: &SurfacePoint, lamps: &[Lamp], scratch: &mut Scratch) -> Look {
        if self.method == DirectMethod::Sampled {
            return Look::Sample { unhidden: None };
        }
        let unhidden =
            |scratch: &mut Scratch| lamps.iter().map(|lamp| unhidden_irradiance(origin, lamp, scratch)).sum();
        if self.method == DirectMethod::Ratio {
            return Look::Sample { unhidden: Some(unhidden(scratch)) };
        }
        let corners_of = |triangle| self.scene.mesh.corners(triangle);
        let none = Seen { irradiance: Vec3::ZERO, sight: Sight::BelowHorizon };
        let known = lamps.iter().try_fold(none, |sum, lamp| {
            let seen = visible_irradiance(self.tracer, corners_of, origin, lamp, scratch)?;
            Some(Seen { irradiance: sum.irradiance + seen.irradiance, sight: sum.sight.max(seen.sight) })
        });
        known.map_or_else(|| Look::Sample { unhidden: Some(unhidden(scratch)) }, Look::Known)
    }

    /// One term of eq. 3 for the emissive triangles: a point on one of them, chosen by power. This is the samples'
    /// share of it.
    fn emitters_term(&self, from: &SurfacePoint, point: Vec2) -> Option<(Vec3, Vec3)> {
        let (triangle, rest) = self.lights.emitters.choose(point.x)?;
        let corners = self.scene.mesh.corners(triangle);
        let normal = self.scene.mesh.geometric_normal(triangle);
        let position = triangle_point(corners, Vec2::new(rest, point.y)).1;
        let radiance = self.scene.material(triangle).emitted_radiance;
        let pdf_area = self.lights.emitters.pdf_area(radiance);
        let geometry = geometry_term(from, position, normal);
        let (direction, distance) = (position - from.origin).normalize_and_length();
        let light_pdf = area_to_solid_angle(pdf_area, distance, -direction.dot(normal));
        let gather_pdf = cosine_pdf_solid_angle(direction.dot(from.shading_normal));
        let share = 1.0 - self.finders.gather_share(gather_pdf, light_pdf);
        (geometry > 0.0).then(|| (radiance * (geometry / pdf_area * share), lift(position, normal, corners)))
    }
}

impl Receiver<'_> {
    fn block_of(&self, index: u32) -> usize {
        self.ends.iter().position(|&end| index < end).unwrap_or(BLOCKS - 1)
    }

    /// Enters what is known of one origin; it does not scatter. Returns its part of the mean.
    fn spread_evenly(&mut self, irradiance: Vec3) -> Vec3 {
        let part = irradiance / self.origins.len() as f32;
        self.blocks.iter_mut().for_each(|(sum, count)| *sum += part * *count as f32);
        part
    }

    /// Enters the samples of one origin. Where the light's irradiance is known but for what hides it, they tell that
    /// part alone (a ratio estimator; Heitz, Hill and McGuire 2018, "Combining Analytic Direct Illumination and Stochastic
    /// Shadows"): so there is no spike beside a light. Returns their part of the mean.
    fn enter(&mut self, samples: &Samples, unhidden: Option<Vec3>, light_rays: u32) -> Vec3 {
        let factor = unhidden.map_or(Vec3::ONE, |unhidden| {
            let whole = unhidden * (light_rays as f32 / self.origins.len() as f32);
            Vec3::select(samples.unhidden.cmpgt(Vec3::ZERO), whole / samples.unhidden, Vec3::ZERO)
        });
        let mut part = Vec3::ZERO;
        for ((sum, _), block) in self.blocks.iter_mut().zip(samples.blocks) {
            *sum += factor * block;
            part += factor * block / light_rays as f32;
        }
        part
    }
}

/// What a look at a light tells.
enum Look {
    /// Its irradiance.
    Known(Seen),
    /// Samples must tell how much of it is hidden, or all of it where what there would be with nothing between is not
    /// known either.
    Sample { unhidden: Option<Vec3> },
}

/// If this part of the samples, but no fewer than so many, agrees that a light is seen, or that it is hidden, the others
/// need not be taken.
const AGREEING: f32 = 0.25;
const FEWEST_AGREEING: u32 = 4;

/// Samples of a light from one origin.
#[derive(Default)]
struct Samples {
    /// Taken, and of those that could see the light, those that do and those that do not.
    taken: u32,
    /// So many are enough if they agree.
    agreeing: u32,
    seen: u32,
    hidden: u32,
    /// The sum of their terms, and of each block those that are not hidden.
    unhidden: Vec3,
    blocks: [Vec3; BLOCKS],
}

impl Samples {
    fn enter(&mut self, sample: Option<(Vec3, bool)>, block: usize) {
        self.taken += 1;
        let Some((term, is_seen)) = sample else { return };
        self.unhidden += term;
        self.seen += u32::from(is_seen);
        self.hidden += u32::from(!is_seen);
        if is_seen {
            self.blocks[block] += term;
        }
    }

    /// True if none of them could see the light, were there nothing between.
    fn tell_nothing(&self) -> bool {
        self.seen + self.hidden == 0
    }

    /// True if enough of them see the light altogether, or not at all.
    fn agree(&self) -> bool {
        self.taken >= self.agreeing && !self.tell_nothing() && (self.seen == 0 || self.hidden == 0)
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
