//! Wrong versions that were written after the diagnosis, without a look at it.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use radiosity::{
    math::color::{linear_to_srgb, luminance, srgb_to_linear},
    student::{
        Receiver, SurfaceHit, World, form_basis, interpolate_barycentric, sample_area_light, sample_texture,
        square_to_cosine_hemisphere, surface_reflectance,
    },
    trace::{NO_TRIANGLE, Ray},
};

use super::{Mutant, mutant};

/// A direct sum in which each sample's value is given by the vector to the light, not normalised, and its length.
fn summed(world: &World, receiver: &Receiver, value: impl Fn(Vec3, f32, Vec3, f32) -> f32) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points = world.light_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let sample = sample_area_light(light, point);
        let to_light = sample.position - receiver.point.origin;
        let blocked = receiver.point.ray_to(sample.position).is_none_or(|ray| world.occluded(&ray));
        if !blocked {
            sum += value(to_light, to_light.length(), sample.normal, sample.pdf_area) * light.radiance;
        }
    }
    sum / count
}

fn right_value(to_light: Vec3, length: f32, normal: Vec3, pdf: f32, receiver: Vec3) -> f32 {
    let direction = to_light / length;
    direction.dot(receiver).max(0.0) * (-direction).dot(normal).max(0.0) / (length * length * pdf)
}

fn one_vector_not_normalised(world: &World, receiver: &Receiver) -> Vec3 {
    summed(world, receiver, |to_light, length, normal, pdf| {
        let direction = to_light / length;
        to_light.dot(receiver.normal()).max(0.0) * (-direction).dot(normal).max(0.0) / (length * length * pdf)
    })
}

fn no_vector_normalised(world: &World, receiver: &Receiver) -> Vec3 {
    summed(world, receiver, |to_light, length, normal, pdf| {
        to_light.dot(receiver.normal()).max(0.0) * (-to_light).dot(normal).max(0.0) / (length * length * pdf)
    })
}

fn both_absolute(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points = world.light_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let sample = sample_area_light(light, point);
        let (direction, length) = (sample.position - receiver.point.origin).normalize_and_length();
        let cosines = direction.dot(receiver.normal()).abs() * direction.dot(sample.normal).abs();
        let ray = receiver.point.ray_to(sample.position);
        if ray.is_none_or(|ray| !world.occluded(&ray)) {
            sum += light.radiance * cosines / (length * length * sample.pdf_area);
        }
    }
    sum / count
}

fn grey_light(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let coloured =
        summed(world, receiver, |to, length, normal, pdf| right_value(to, length, normal, pdf, receiver.normal()));
    Vec3::splat(luminance(light.radiance)) * coloured / light.radiance
}

fn power_for_radiance(world: &World, receiver: &Receiver) -> Vec3 {
    PI * PI * summed(world, receiver, |to, length, normal, pdf| right_value(to, length, normal, pdf, receiver.normal()))
}

fn no_radiance(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    summed(world, receiver, |to, length, normal, pdf| right_value(to, length, normal, pdf, receiver.normal()))
        / light.radiance
}

fn middle_of_the_light(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let Some(ray) = receiver.point.ray_to(light.centre) else { return Vec3::ZERO };
    if world.occluded(&ray) || world.light_rays == 0 {
        return Vec3::ZERO;
    }
    let to_light = light.centre - receiver.point.origin;
    light.radiance * right_value(to_light, to_light.length(), light.normal(), 1.0 / light.area(), receiver.normal())
}

fn own_points(world: &World, receiver: &Receiver) -> impl Iterator<Item = Vec2> {
    let side = (world.light_rays as f32).sqrt().ceil() as u32;
    let _ = receiver;
    (0..side * side).map(move |index| (Vec2::new((index % side) as f32, (index / side) as f32) + 0.5) / side as f32)
}

fn grid_of_its_own(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points: Vec<Vec2> = own_points(world, receiver).collect();
    let mut sum = Vec3::ZERO;
    for point in &points {
        let sample = sample_area_light(light, *point);
        let to_light = sample.position - receiver.point.origin;
        if receiver.point.ray_to(sample.position).is_some_and(|ray| !world.occluded(&ray)) {
            sum += light.radiance
                * right_value(to_light, to_light.length(), sample.normal, sample.pdf_area, receiver.normal());
        }
    }
    sum / points.len().max(1) as f32
}

fn with_ray(world: &World, receiver: &Receiver, blocked: impl Fn(Vec3, f32) -> bool) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points = world.light_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let sample = sample_area_light(light, point);
        let to_light = sample.position - receiver.point.origin;
        let length = to_light.length();
        if !blocked(to_light / length, length) {
            sum += light.radiance * right_value(to_light, length, sample.normal, sample.pdf_area, receiver.normal());
        }
    }
    sum / count
}

fn ray(receiver: &Receiver, direction: Vec3, max_distance: f32) -> Ray {
    Ray { origin: receiver.point.origin, direction, max_distance, origin_triangle: receiver.point.triangle }
}

fn any_hit_blocks(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, _| world.trace(&ray(receiver, direction, f32::INFINITY)).is_some())
}

fn only_fronts_block(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, length| {
        world.trace(&ray(receiver, direction, length)).is_some_and(|hit| hit.front)
    })
}

fn ray_away_from_the_light(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, length| {
        world.occluded(&Ray { origin_triangle: NO_TRIANGLE, ..ray(receiver, -direction, length) })
    })
}

fn ray_to_the_middle(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    with_ray(world, receiver, |_, _| receiver.point.ray_to(light.centre).is_none_or(|ray| world.occluded(&ray)))
}

fn squared_length_as_end(world: &World, receiver: &Receiver) -> Vec3 {
    with_ray(world, receiver, |direction, length| world.occluded(&ray(receiver, direction, 2.0 * length * length)))
}

/// A gather in which every ray's value is given.
fn gathered(world: &World, receiver: &Receiver, value: impl Fn(Vec2, &SurfaceHit) -> Vec3) -> Vec3 {
    let basis = form_basis(receiver.normal());
    let points = world.hemisphere_points(receiver);
    let count = points.len().max(1) as f32;
    let rays = points.filter_map(|point| {
        let hit = receiver.point.ray(basis * square_to_cosine_hemisphere(point)).and_then(|ray| world.trace(&ray))?;
        hit.front.then(|| value(point, &hit))
    });
    rays.sum::<Vec3>() / count
}

fn at(hit: &SurfaceHit, field: &[Vec3]) -> Vec3 {
    interpolate_barycentric(hit.vertices.map(|vertex| field[vertex as usize]), hit.barycentric)
}

fn pi_squared(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    gathered(world, receiver, |_, hit| surface_reflectance(world, hit) * at(hit, field)) / PI / PI
}

fn no_albedo_and_pi(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    gathered(world, receiver, |_, hit| at(hit, field)) / PI
}

fn swapped_u_and_v(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    gathered(world, receiver, |_, hit| {
        let swapped = SurfaceHit { barycentric: Vec2::new(hit.barycentric.y, hit.barycentric.x), ..*hit };
        surface_reflectance(world, hit) * at(&swapped, field)
    })
}

fn nearest_corner(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    gathered(world, receiver, |_, hit| {
        let Vec2 { x: u, y: v } = hit.barycentric;
        let weights = [1.0 - u - v, u, v];
        let nearest = (0..3).max_by(|a, b| weights[*a].total_cmp(&weights[*b])).unwrap_or(0);
        surface_reflectance(world, hit) * field[hit.vertices[nearest] as usize]
    })
}

fn transposed_basis(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    let basis = form_basis(receiver.normal()).transpose();
    let points = world.hemisphere_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let direction = basis * square_to_cosine_hemisphere(point);
        if let Some(hit) = receiver.point.ray(direction).and_then(|ray| world.trace(&ray)).filter(|hit| hit.front) {
            sum += surface_reflectance(world, &hit) * at(&hit, field);
        }
    }
    sum / count
}

fn uniform_without_weight(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    let basis = form_basis(receiver.normal());
    let points = world.hemisphere_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let radius = (1.0 - point.x * point.x).sqrt();
        let direction = basis * (radius * Vec2::from_angle(TAU * point.y)).extend(point.x);
        if let Some(hit) = receiver.point.ray(direction).and_then(|ray| world.trace(&ray)).filter(|hit| hit.front) {
            sum += point.x * surface_reflectance(world, &hit) * at(&hit, field);
        }
    }
    sum / count
}

fn values_of_the_receiver(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    gathered(world, receiver, |_, hit| surface_reflectance(world, hit) * field[receiver.vertex as usize])
}

fn falls_with_distance(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let field = bounces[bounces.len() - 1];
    gathered(world, receiver, |_, hit| surface_reflectance(world, hit) * at(hit, field) / hit.distance.powi(2))
}

fn mean_of_the_bounces(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let sum: Vec3 = bounces
        .iter()
        .map(|field| gathered(world, receiver, |_, hit| surface_reflectance(world, hit) * at(hit, field)))
        .sum();
    sum / bounces.len() as f32
}

fn sum_so_far_returned(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let last =
        gathered(world, receiver, |_, hit| surface_reflectance(world, hit) * at(hit, bounces[bounces.len() - 1]));
    let before: Vec3 = bounces[1..].iter().map(|field| field[receiver.vertex as usize]).sum();
    before + last
}

fn encoded(size: (u32, u32), texels: &[[u8; 4]], texcoord: Vec2) -> Vec3 {
    let right = sample_texture(size, texels, texcoord);
    Vec3::from(right.to_array().map(|value| linear_to_srgb(linear_to_srgb(value))))
}

fn power_curve(size: (u32, u32), texels: &[[u8; 4]], texcoord: Vec2) -> Vec3 {
    let right = sample_texture(size, texels, texcoord);
    Vec3::from(right.to_array().map(|value| linear_to_srgb(value).powf(2.2)))
}

fn from_the_top(size: (u32, u32), texels: &[[u8; 4]], texcoord: Vec2) -> Vec3 {
    let place = (texcoord - texcoord.floor()) * Vec2::new(size.0 as f32, size.1 as f32);
    let index = (place.y as u32).min(size.1 - 1) * size.0 + (place.x as u32).min(size.0 - 1);
    let [red, green, blue, _] = texels[index as usize];
    Vec3::from([red, green, blue].map(|byte| srgb_to_linear(f32::from(byte) / 255.0)))
}

fn height_as_stride((width, height): (u32, u32), texels: &[[u8; 4]], texcoord: Vec2) -> Vec3 {
    let place = (texcoord - texcoord.floor()) * Vec2::new(width as f32, height as f32);
    let row = height - 1 - (place.y as u32).min(height - 1);
    let index = (row * height + (place.x as u32).min(width - 1)) as usize % texels.len();
    let [red, green, blue, _] = texels[index];
    Vec3::from([red, green, blue].map(|byte| srgb_to_linear(f32::from(byte) / 255.0)))
}

fn twice_the_texture(world: &World, hit: &SurfaceHit) -> Vec3 {
    let Some(index) = hit.material.reflectance_texture else { return hit.material.reflectance };
    let texture = &world.scene.textures[index as usize];
    let colour = sample_texture(texture.size(), texture.texels(), hit.texcoord);
    hit.material.reflectance * colour * colour
}

fn added_texture(world: &World, hit: &SurfaceHit) -> Vec3 {
    let Some(index) = hit.material.reflectance_texture else { return hit.material.reflectance };
    let texture = &world.scene.textures[index as usize];
    0.5 * (hit.material.reflectance + sample_texture(texture.size(), texture.texels(), hit.texcoord))
}

fn on_the_diagonal(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    ((Vec2::splat(index as f32) + jitter) / count as f32).min(Vec2::splat(1.0 - f32::EPSILON))
}

fn rounded_up(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    let side = (count as f32).sqrt().ceil();
    let cell = Vec2::new(index as f32 % side, (index as f32 / side).floor());
    ((cell + jitter) / side).min(Vec2::splat(1.0 - f32::EPSILON))
}

fn strips(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    Vec2::new((index as f32 + jitter.x) / count as f32, jitter.y).min(Vec2::splat(1.0 - f32::EPSILON))
}

fn digits_not_mirrored(index: u32) -> Vec2 {
    Vec2::new((index % 1024) as f32 / 1024.0, (index % 2187) as f32 / 2187.0)
}

fn second_is_constant(index: u32) -> Vec2 {
    Vec2::new(radiosity::student::low_discrepancy_point(index).x, 0.0)
}

/// Written after the diagnosis.
pub(crate) fn mutants() -> Vec<Mutant> {
    vec![
        mutant!("unshadowed", "later: one vector not normalised", "not of unit length", direct_irradiance: one_vector_not_normalised),
        mutant!("unshadowed", "later: no vector normalised", "not of unit length", direct_irradiance: no_vector_normalised),
        mutant!("unshadowed", "later: both cosines absolute", "back side shines", direct_irradiance: both_absolute),
        mutant!("unshadowed", "later: grey light", "bands", direct_irradiance: grey_light),
        mutant!("unshadowed", "later: times pi twice", "multiplied by π twice", direct_irradiance: power_for_radiance),
        mutant!("unshadowed", "later: no radiance", "radiance is missing", direct_irradiance: no_radiance),
        mutant!("unshadowed", "later: middle of the light", "middle of the light", direct_irradiance: middle_of_the_light),
        mutant!("unshadowed", "later: grid of its own", "same at every vertex", direct_irradiance: grid_of_its_own),
        mutant!("shadows", "later: any hit blocks", "beyond the light blocks", direct_irradiance: any_hit_blocks),
        mutant!("shadows", "later: only fronts block", "back of a surface", direct_irradiance: only_fronts_block),
        mutant!("shadows", "later: ray away from the light", "away from the light", direct_irradiance: ray_away_from_the_light),
        mutant!("shadows", "later: ray to the middle", "each point has its own", direct_irradiance: ray_to_the_middle),
        mutant!("shadows", "later: ends at r squared", "must end at the light's point", direct_irradiance: squared_length_as_end),
        mutant!("bounce", "later: divided by pi twice", "divided by π twice", indirect_irradiance: pi_squared),
        mutant!("bounce", "later: no albedo, divided by pi", "reflectance is missing", indirect_irradiance: no_albedo_and_pi),
        mutant!("bounce", "later: u and v swapped", "wrong order", indirect_irradiance: swapped_u_and_v),
        mutant!("bounce", "later: nearest corner", "one vertex alone", indirect_irradiance: nearest_corner),
        mutant!("bounce", "later: transposed basis", "frame", indirect_irradiance: transposed_basis),
        mutant!("bounce", "later: uniform, cosine without 2", "half", indirect_irradiance: uniform_without_weight),
        mutant!("bounce", "later: values of the receiver", "receiver", indirect_irradiance: values_of_the_receiver),
        mutant!("bounce", "later: falls with distance", "distance", indirect_irradiance: falls_with_distance),
        mutant!("bounces", "later: mean of the bounces", "mean of the bounces", indirect_irradiance: mean_of_the_bounces),
        mutant!("bounces", "later: sum so far returned", "alone is wanted", indirect_irradiance: sum_so_far_returned),
        mutant!("textures", "later: encoded", "encoded", sample_texture: encoded),
        mutant!("textures", "later: power of 2.2", "2.2", sample_texture: power_curve),
        mutant!("textures", "later: first row at the bottom", "upside down", sample_texture: from_the_top),
        mutant!("textures", "later: height for width", "width", sample_texture: height_as_stride),
        mutant!("textures", "later: texture twice", "multiplied in twice", surface_reflectance: twice_the_texture),
        mutant!("textures", "later: mean with the texture", "times the texture's colour", surface_reflectance: added_texture),
        mutant!("stratified", "later: on the diagonal", "diagonal", stratified_point: on_the_diagonal),
        mutant!("stratified", "later: rounded up", "square numbers work", stratified_point: rounded_up),
        mutant!("stratified", "later: strips", "not strips", stratified_point: strips),
        mutant!("qmc", "later: digits not mirrored", "mirrored", low_discrepancy_point: digits_not_mirrored),
        mutant!("qmc", "later: one coordinate constant", "never changes", low_discrepancy_point: second_is_constant),
    ]
}
