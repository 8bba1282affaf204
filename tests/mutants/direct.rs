//! Wrong direct irradiance.

use std::f32::consts::PI;

use glam::Vec3;
use radiosity::{
    math::sequence::{Sampler, Sequence, Stream},
    student::{Receiver, World, sample_area_light},
    trace::{NO_TRIANGLE, Ray},
};

use super::{Mutant, mutant};

/// What a sample is made of.
#[derive(Clone, Copy)]
struct Sample {
    cosine: f32,
    cosine_light: f32,
    distance: f32,
    pdf: f32,
    is_visible: bool,
}

/// The mean over the samples of `value` per unit of radiance; samples from the wrong sides included.
fn mean_of(world: &World, receiver: &Receiver, value: impl Fn(Sample) -> f32) -> Vec3 {
    let (sum, count, _) = sums(world, receiver, value);
    sum / count.max(1.0)
}

/// The sum, the number of all samples, and that of the visible ones.
fn sums(world: &World, receiver: &Receiver, value: impl Fn(Sample) -> f32) -> (Vec3, f32, f32) {
    let Some(light) = &world.light else { return (Vec3::ZERO, 1.0, 1.0) };
    let (mut sum, mut count, mut visible) = (Vec3::ZERO, 0.0, 0.0);
    for point in world.light_points(receiver) {
        let sample = sample_area_light(light, point);
        let (direction, distance) = (sample.position - receiver.point.origin).normalize_and_length();
        let ray = receiver.point.ray_to(sample.position);
        let is_visible = ray.is_some_and(|ray| !world.occluded(&ray));
        let value = value(Sample {
            cosine: direction.dot(receiver.normal()),
            cosine_light: -direction.dot(sample.normal),
            distance,
            pdf: sample.pdf_area,
            is_visible,
        });
        sum += value * light.radiance;
        count += 1.0;
        // Below the horizon there is no ray that could be blocked.
        visible += f32::from(u8::from(is_visible || ray.is_none()));
    }
    (sum, count, visible)
}

impl Sample {
    /// cosθ cosθ_l V / (r² pdf), 0 from the wrong sides.
    fn right(self) -> f32 {
        if self.is_lit() && self.is_visible { self.unclamped() } else { 0.0 }
    }

    fn is_lit(self) -> bool {
        self.cosine > 0.0 && self.cosine_light > 0.0
    }

    fn unclamped(self) -> f32 {
        self.cosine * self.cosine_light / (self.distance * self.distance * self.pdf)
    }
}

fn times_pi(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| PI * sample.right())
}

fn by_pi(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() / PI)
}

fn pi_twice(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() / PI / PI)
}

fn no_cosine(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| if sample.is_lit() { sample.right() / sample.cosine } else { 0.0 })
}

fn squared_cosine(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() * sample.cosine)
}

fn no_light_cosine(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| if sample.is_lit() { sample.right() / sample.cosine_light } else { 0.0 })
}

fn light_cosine_of_the_wrong_side(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| {
        let turned = Sample { cosine_light: -sample.cosine_light, ..sample };
        turned.right()
    })
}

fn cosine_of_the_wrong_side(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| {
        let turned = Sample { cosine: -sample.cosine, is_visible: true, ..sample };
        turned.right()
    })
}

fn back_side_shines(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| {
        let turned = Sample { cosine_light: sample.cosine_light.abs(), ..sample };
        turned.right()
    })
}

fn no_visibility(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points = world.light_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let sample = sample_area_light(light, point);
        let (direction, distance) = (sample.position - receiver.point.origin).normalize_and_length();
        let cosine = direction.dot(receiver.normal()).max(0.0);
        let cosine_light = (-direction.dot(sample.normal)).max(0.0);
        sum += light.radiance * (cosine * cosine_light / (distance * distance * sample.pdf_area));
    }
    sum / count
}

fn visibility_not_used(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| Sample { is_visible: true, ..sample }.right())
}

fn visibility_turned_round(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| Sample { is_visible: !sample.is_visible, ..sample }.right())
}

/// The right sum with a shadow ray of its own.
fn with_ray(world: &World, receiver: &Receiver, ray: impl Fn(Vec3, f32) -> Ray) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points = world.light_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let sample = sample_area_light(light, point);
        let (direction, distance) = (sample.position - receiver.point.origin).normalize_and_length();
        let cosine = direction.dot(receiver.normal()).max(0.0);
        let cosine_light = (-direction.dot(sample.normal)).max(0.0);
        if !world.occluded(&ray(direction, distance)) {
            sum += light.radiance * (cosine * cosine_light / (distance * distance * sample.pdf_area));
        }
    }
    sum / count
}

fn ray_without_end(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, _| Ray {
        origin: receiver.point.origin,
        direction,
        max_distance: f32::INFINITY,
        origin_triangle: receiver.point.triangle,
    })
}

fn ray_through_the_lights_plane(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, distance| Ray {
        origin: receiver.point.origin,
        direction,
        max_distance: distance + 0.02,
        origin_triangle: receiver.point.triangle,
    })
}

fn ray_from_below_the_surface(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, distance| Ray {
        origin: receiver.point.origin - 1e-4 * receiver.normal(),
        direction,
        max_distance: distance,
        origin_triangle: NO_TRIANGLE,
    })
}

fn ray_from_the_light(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, distance| Ray {
        origin: receiver.point.origin + distance * direction,
        direction: -direction,
        max_distance: 1.001 * distance,
        origin_triangle: NO_TRIANGLE,
    })
}

fn ray_from_far_above(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, distance| Ray {
        origin: receiver.point.origin + 0.01 * receiver.normal(),
        direction,
        max_distance: distance - 0.02,
        origin_triangle: receiver.point.triangle,
    })
}

fn by_unblocked_rays(world: &World, receiver: &Receiver) -> Vec3 {
    let (sum, _, visible) = sums(world, receiver, Sample::right);
    sum / visible.max(1.0)
}

fn by_points_that_contribute(world: &World, receiver: &Receiver) -> Vec3 {
    let (sum, ..) = sums(world, receiver, Sample::right);
    let (contributing, ..) = sums(world, receiver, |sample| if sample.right() > 0.0 { 1.0 } else { 0.0 });
    let radiance = world.light.map_or(Vec3::ONE, |light| light.radiance);
    sum / (contributing / radiance).max(Vec3::ONE)
}

fn not_divided(world: &World, receiver: &Receiver) -> Vec3 {
    sums(world, receiver, Sample::right).0
}

fn distance_not_squared(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() * sample.distance)
}

fn no_distance(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() * sample.distance * sample.distance)
}

fn no_density(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() * sample.pdf)
}

fn times_density(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() * sample.pdf * sample.pdf)
}

fn no_density_and_pi(world: &World, receiver: &Receiver) -> Vec3 {
    mean_of(world, receiver, |sample| sample.right() * sample.pdf / PI)
}

fn triangles_normal(world: &World, receiver: &Receiver) -> Vec3 {
    let mut receiver = *receiver;
    receiver.point.shading_normal = receiver.point.geometric_normal;
    mean_of(world, &receiver, Sample::right)
}

fn same_points_everywhere(world: &World, receiver: &Receiver) -> Vec3 {
    let receiver = Receiver { vertex: 0, ..*receiver };
    mean_of(world, &receiver, Sample::right)
}

fn own_points_of_one_seed(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points = Sequence::new(Sampler::Random, 7, receiver.vertex, Stream::AreaLight, world.light_rays);
    let mut sum = Vec3::ZERO;
    for index in 0..world.light_rays {
        let sample = sample_area_light(light, points.sample_2d(index));
        let (direction, distance) = (sample.position - receiver.point.origin).normalize_and_length();
        let (cosine, cosine_light) = (direction.dot(receiver.normal()), -direction.dot(sample.normal));
        let is_visible = receiver.point.ray_to(sample.position).is_some_and(|ray| !world.occluded(&ray));
        sum += light.radiance * Sample { cosine, cosine_light, distance, pdf: sample.pdf_area, is_visible }.right();
    }
    sum / world.light_rays.max(1) as f32
}

fn not_a_number_without_points(world: &World, receiver: &Receiver) -> Vec3 {
    if world.light.is_none() {
        return Vec3::ZERO;
    }
    let (sum, count, _) = sums(world, receiver, Sample::right);
    sum / count
}

/// The wrong versions that the diagnosis was written with.
pub(crate) fn mutants() -> Vec<Mutant> {
    vec![
        mutant!("unshadowed", "times pi", "multiplied by π", direct_irradiance: times_pi),
        mutant!("unshadowed", "divided by pi", "divided by π: eq. 3 has no π", direct_irradiance: by_pi),
        mutant!("unshadowed", "divided by pi twice", "divided by π twice", direct_irradiance: pi_twice),
        mutant!("unshadowed", "no cosine", "cosθ, is missing", direct_irradiance: no_cosine),
        mutant!("unshadowed", "cosine squared", "cosθ, is squared", direct_irradiance: squared_cosine),
        mutant!("unshadowed", "no cosine at the light", "cosθ_l, is missing", direct_irradiance: no_light_cosine),
        mutant!("unshadowed", "light's cosine of the wrong side", "at the light has the wrong sign", direct_irradiance: light_cosine_of_the_wrong_side),
        mutant!("unshadowed", "cosine of the wrong side", "at the receiver has the wrong sign", direct_irradiance: cosine_of_the_wrong_side),
        mutant!("unshadowed", "back side shines", "back side shines", direct_irradiance: back_side_shines),
        mutant!("unshadowed", "r for r squared", "r where r² is meant", direct_irradiance: distance_not_squared),
        mutant!("unshadowed", "no distance", "division by r² is missing", direct_irradiance: no_distance),
        mutant!("unshadowed", "no density", "division by the density pdf_area is missing", direct_irradiance: no_density),
        mutant!("unshadowed", "times density", "multiplied by the density", direct_irradiance: times_density),
        mutant!("unshadowed", "no density, and pi", "pdf_area is missing; and divided by π", direct_irradiance: no_density_and_pi),
        mutant!("unshadowed", "sum not divided", "not divided by the number", direct_irradiance: not_divided),
        mutant!("unshadowed", "triangle's normal", "triangle's normal is used", direct_irradiance: triangles_normal),
        mutant!("unshadowed", "same points at every vertex", "the same at every vertex", direct_irradiance: same_points_everywhere),
        mutant!("unshadowed", "one seed", "seed has no part", direct_irradiance: own_points_of_one_seed),
        mutant!("unshadowed", "0/0 without points", "divided by 0", direct_irradiance: not_a_number_without_points),
        mutant!("shadows", "no visibility", "write the shadow rays", direct_irradiance: no_visibility),
        mutant!("shadows", "visibility not used", "is not used", direct_irradiance: visibility_not_used),
        mutant!("unshadowed", "visibility turned round", "shadow ray is turned round", direct_irradiance: visibility_turned_round),
        mutant!("shadows", "ray without end", "beyond the light blocks", direct_irradiance: ray_without_end),
        mutant!("shadows", "ray through the light's plane", "through the light's plane", direct_irradiance: ray_through_the_lights_plane),
        mutant!("shadows", "ray from below the surface", "surface that it leaves from", direct_irradiance: ray_from_below_the_surface),
        mutant!("shadows", "ray from the light", "receiver's own surface", direct_irradiance: ray_from_the_light),
        mutant!("shadows", "ray from far above", "starts too far", direct_irradiance: ray_from_far_above),
        mutant!("unshadowed", "divided by what contributes", "number of points that contribute", direct_irradiance: by_points_that_contribute),
        mutant!("shadows", "divided by unblocked rays", "number of unblocked rays", direct_irradiance: by_unblocked_rays),
    ]
}
