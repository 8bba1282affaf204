//! Wrong gathers of a bounce.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Mat3, Vec2, Vec3};
use radiosity::{
    math::sequence::{Sampler, Sequence, Stream},
    student::{
        Receiver, SurfaceHit, World, form_basis, interpolate_barycentric, square_to_cosine_hemisphere,
        surface_reflectance,
    },
};

use super::{Mutant, mutant};

/// The right gather, made of parts that can be exchanged.
fn gather_with(
    world: &World,
    receiver: &Receiver,
    direction: impl Fn(Vec2) -> Vec3,
    value: impl Fn(&SurfaceHit, Vec3) -> Vec3,
) -> Vec3 {
    let points = world.hemisphere_points(receiver);
    let count = points.len().max(1) as f32;
    let rays = points.filter_map(|point| {
        let direction = direction(point);
        let hit = receiver.point.ray(direction).and_then(|ray| world.trace(&ray))?;
        Some(value(&hit, direction))
    });
    rays.sum::<Vec3>() / count
}

fn about_normal(receiver: &Receiver) -> impl Fn(Vec2) -> Vec3 {
    let basis = form_basis(receiver.normal());
    move |point| basis * square_to_cosine_hemisphere(point)
}

/// Irradiance at a hit from the values of the field.
fn at(hit: &SurfaceHit, field: &[Vec3]) -> Vec3 {
    interpolate_barycentric(hit.vertices.map(|vertex| field[vertex as usize]), hit.barycentric)
}

fn radiosity(world: &World, hit: &SurfaceHit, field: &[Vec3]) -> Vec3 {
    if hit.front { surface_reflectance(world, hit) * at(hit, field) } else { Vec3::ZERO }
}

/// The right gather with another value for each hit on a front.
fn valued(world: &World, receiver: &Receiver, value: impl Fn(&SurfaceHit) -> Vec3) -> Vec3 {
    gather_with(world, receiver, about_normal(receiver), |hit, _| if hit.front { value(hit) } else { Vec3::ZERO })
}

/// The right gather of a field.
fn gather(world: &World, receiver: &Receiver, field: &[Vec3]) -> Vec3 {
    valued(world, receiver, |hit| radiosity(world, hit, field))
}

fn last<'a>(bounces: &[&'a [Vec3]]) -> &'a [Vec3] {
    bounces[bounces.len() - 1]
}

fn times_pi(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    PI * gather(world, receiver, last(bounces))
}

fn by_pi(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    gather(world, receiver, last(bounces)) / PI
}

fn no_albedo(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    valued(world, receiver, |hit| at(hit, last(bounces)))
}

fn albedo_twice(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    valued(world, receiver, |hit| hit.material.reflectance * radiosity(world, hit, last(bounces)))
}

fn albedo_of_the_receiver(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let own = world.scene.material(receiver.point.triangle).reflectance;
    valued(world, receiver, |hit| own * at(hit, last(bounces)))
}

fn uniform_direction(normal: Vec3) -> impl Fn(Vec2) -> Vec3 {
    let basis = form_basis(normal);
    move |point| {
        let (z, angle) = (point.x, TAU * point.y);
        let radius = (1.0 - z * z).sqrt();
        basis * Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
    }
}

fn uniform_with_cosine_pdf(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let normal = receiver.normal();
    gather_with(world, receiver, uniform_direction(normal), |hit, direction| {
        let cosine = direction.dot(normal);
        radiosity(world, hit, last(bounces)) * FRAC_1_PI * cosine / (cosine * FRAC_1_PI)
    })
}

fn cosine_again(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    gather_with(world, receiver, about_normal(receiver), |hit, direction| {
        direction.dot(receiver.normal()) * radiosity(world, hit, last(bounces))
    })
}

fn not_turned(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    gather_with(world, receiver, square_to_cosine_hemisphere, |hit, _| radiosity(world, hit, last(bounces)))
}

fn about_the_triangles_normal(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let basis: Mat3 = form_basis(receiver.point.geometric_normal);
    let direction = |point| basis * square_to_cosine_hemisphere(point);
    gather_with(world, receiver, direction, |hit, _| radiosity(world, hit, last(bounces)))
}

fn wrong_order(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    valued(world, receiver, |hit| {
        let [a, b, c] = hit.vertices.map(|vertex| last(bounces)[vertex as usize]);
        surface_reflectance(world, hit) * interpolate_barycentric([b, c, a], hit.barycentric)
    })
}

fn one_corner(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    valued(world, receiver, |hit| surface_reflectance(world, hit) * last(bounces)[hit.vertices[0] as usize])
}

fn mean_of_corners(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    valued(world, receiver, |hit| {
        let sum: Vec3 = hit.vertices.map(|vertex| last(bounces)[vertex as usize]).into_iter().sum();
        surface_reflectance(world, hit) * sum / 3.0
    })
}

fn sum_of_corners(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    valued(world, receiver, |hit| {
        let sum: Vec3 = hit.vertices.map(|vertex| last(bounces)[vertex as usize]).into_iter().sum();
        surface_reflectance(world, hit) * sum
    })
}

fn back_faces_shine(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    gather_with(world, receiver, about_normal(receiver), |hit, _| {
        surface_reflectance(world, hit) * at(hit, last(bounces))
    })
}

fn only_back_faces(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    gather_with(world, receiver, about_normal(receiver), |hit, _| {
        if hit.front { Vec3::ZERO } else { surface_reflectance(world, hit) * at(hit, last(bounces)) }
    })
}

fn not_divided(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    gather(world, receiver, last(bounces)) * world.hemisphere_points(receiver).len() as f32
}

fn by_hits(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let hits = gather_with(world, receiver, about_normal(receiver), |_, _| Vec3::ONE);
    gather(world, receiver, last(bounces)) / hits.max(Vec3::splat(1e-6))
}

fn direct_added(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    if world.rays == 0 {
        return Vec3::ZERO;
    }
    bounces[0][receiver.vertex as usize] + gather(world, receiver, last(bounces))
}

fn same_points_everywhere(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let basis = form_basis(receiver.normal());
    let points = Sequence::new(Sampler::Random, world.seed, 0, Stream::Hemisphere, world.rays);
    let mut sum = Vec3::ZERO;
    for index in 0..world.rays {
        let direction = basis * square_to_cosine_hemisphere(points.sample_2d(index));
        if let Some(hit) = receiver.point.ray(direction).and_then(|ray| world.trace(&ray)) {
            sum += radiosity(world, &hit, last(bounces));
        }
    }
    sum / world.rays.max(1) as f32
}

fn sum_of_bounces(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    bounces.iter().map(|field| gather(world, receiver, field)).sum()
}

fn first_bounce(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    gather(world, receiver, bounces[0])
}

fn direct_again(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let later = if bounces.len() > 1 { gather(world, receiver, last(bounces)) } else { Vec3::ZERO };
    gather(world, receiver, bounces[0]) + later
}

fn one_bounce_only(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    if bounces.len() == 1 { gather(world, receiver, bounces[0]) } else { Vec3::ZERO }
}

fn material_alone(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    valued(world, receiver, |hit| hit.material.reflectance * at(hit, last(bounces)))
}

/// The wrong versions that the diagnosis was written with.
pub(crate) fn mutants() -> Vec<Mutant> {
    vec![
        mutant!("bounce", "times pi", "multiplied by π", indirect_irradiance: times_pi),
        mutant!("bounce", "divided by pi", "divided by π", indirect_irradiance: by_pi),
        mutant!("bounce", "no albedo", "reflectance is missing", indirect_irradiance: no_albedo),
        mutant!("bounce", "albedo twice", "multiplied in twice", indirect_irradiance: albedo_twice),
        mutant!("bounce", "albedo of the receiver", "receiver's own surface", indirect_irradiance: albedo_of_the_receiver),
        mutant!("bounce", "uniform, cosine pdf", "spread evenly over the hemisphere", indirect_irradiance: uniform_with_cosine_pdf),
        mutant!("bounce", "cosine again", "cosine counts twice", indirect_irradiance: cosine_again),
        mutant!("bounce", "not turned", "about +z", indirect_irradiance: not_turned),
        mutant!("bounce", "triangle's normal", "triangle's normal", indirect_irradiance: about_the_triangles_normal),
        mutant!("bounce", "barycentrics in wrong order", "wrong order", indirect_irradiance: wrong_order),
        mutant!("bounce", "one corner", "one vertex alone", indirect_irradiance: one_corner),
        mutant!("bounce", "mean of the corners", "mean of the three vertices", indirect_irradiance: mean_of_corners),
        mutant!("bounce", "sum of the corners", "three times too bright", indirect_irradiance: sum_of_corners),
        mutant!("bounce", "back faces shine", "back of a surface reflects", indirect_irradiance: back_faces_shine),
        mutant!("bounce", "only back faces", "front sides are those", indirect_irradiance: only_back_faces),
        mutant!("bounce", "sum not divided", "not divided by the number of rays", indirect_irradiance: not_divided),
        mutant!("bounce", "divided by hits", "rays that meet something", indirect_irradiance: by_hits),
        mutant!("bounce", "direct light added", "direct light at the receiver is added", indirect_irradiance: direct_added),
        mutant!("bounce", "same points at every vertex", "the same at every vertex", indirect_irradiance: same_points_everywhere),
        mutant!("bounces", "sum of the bounces", "sum of all bounces", indirect_irradiance: sum_of_bounces),
        mutant!("bounces", "first bounce each time", "direct light is gathered each time", indirect_irradiance: first_bounce),
        mutant!("bounces", "direct light again", "counted again in each bounce", indirect_irradiance: direct_again),
        mutant!("bounces", "one bounce only", "bounces of indirect_irradiance after the first", indirect_irradiance: one_bounce_only),
        mutant!("textures", "gather without texture", "does not use the texture", indirect_irradiance: material_alone),
    ]
}
