//! Irradiance at a point: the two functions that the solver calls, each a sum over samples.
//!
//! [`World`] holds what is given: the scene, the ray tracer, the light, the sample points.

use glam::Vec3;

// <answer>
use super::{form_basis, interpolate_barycentric, sample_area_light, sample_texture, square_to_cosine_hemisphere};
// </answer>
use super::{Receiver, SurfaceHit, World};

/// Irradiance [W/m²] at `receiver` that comes straight from the area light, by eq. 3: the mean over the points of
/// [`World::light_points`] of L cosθ cosθ_l V / (r² pdf_area).
///
/// θ is the angle at the receiver, θ_l that at the light; both cosines count only where they are positive: light comes
/// from above the horizon, and from the side of the light that shines. V is 0 where something lies between, 1 elsewhere.
/// 0 without a light, and without points.
///
/// Do it in two steps, each with its tests: first without V (task `unshadowed`: soft light without shadows), then with
/// a shadow ray for each sample (task `shadows`). [`crate::trace::SurfacePoint::ray_to`] makes the ray from the receiver
/// to a point and no further, or none if it starts into the surface; [`World::occluded`] traces it.
///
/// Placeholder while not done: the normal as a colour. Tests: `radiosity check`, tasks `unshadowed` and `shadows`.
///
/// Hint: the light's normal and density come from [`super::sample_area_light`]. Divide the vector to the light's point by its
/// length before you take cosines from it, and the sum by the number of points, whether they contribute or not.
pub fn direct_irradiance(world: &World, receiver: &Receiver) -> Vec3 {
    // <answer>
    let Some(light) = &world.light else { return Vec3::ZERO };
    let points = world.light_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let sample = sample_area_light(light, point);
        let (direction, distance) = (sample.position - receiver.point.origin).normalize_and_length();
        let cosine = direction.dot(receiver.normal());
        let cosine_light = -direction.dot(sample.normal);
        if cosine <= 0.0 || cosine_light <= 0.0 || sample.pdf_area <= 0.0 {
            continue;
        }
        let Some(ray) = receiver.point.ray_to(sample.position) else { continue };
        if !world.occluded(&ray) {
            sum += light.radiance * (cosine * cosine_light / (distance * distance * sample.pdf_area));
        }
    }
    sum / count
    // </answer> (super::PLACEHOLDERS.direct_irradiance)(world, receiver)
}

/// Irradiance [W/m²] at `receiver` of the next bounce alone, by eq. 4: the mean over cosine-weighted rays of the
/// radiosity B = ρ E at what they meet.
///
/// `bounces` are the bounces so far, each a value [W/m²] for every vertex; the first is direct light, the last is the
/// bounce before the one that is wanted, and the only one that is needed: every bounce is gathered once.
///
/// For each point of [`World::hemisphere_points`]: a direction about the receiver's normal, its ray
/// ([`crate::trace::SurfacePoint::ray`], none if it starts into the surface), what it meets ([`World::trace`]), E there from the
/// three vertices, times [`surface_reflectance`]. A ray that meets nothing, or a back side, brings 0.
///
/// Steps, each with its tests: one bounce (task `bounce`), more bounces (task `bounces`), textures (task `textures`).
///
/// Placeholder while not done: 0. Tests: `radiosity check`, tasks `bounce`, `bounces` and `textures`.
///
/// Hint: with density cosθ/π, the π of the density and the π of B = π L cancel: no π is left.
pub fn indirect_irradiance(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    // <answer>
    let Some(previous) = bounces.last() else { return Vec3::ZERO };
    let basis = form_basis(receiver.normal());
    let points = world.hemisphere_points(receiver);
    let count = points.len().max(1) as f32;
    let mut sum = Vec3::ZERO;
    for point in points {
        let direction = basis * square_to_cosine_hemisphere(point);
        let hit = receiver.point.ray(direction).and_then(|ray| world.trace(&ray));
        if let Some(hit) = hit.filter(|hit| hit.front) {
            let corners = hit.vertices.map(|vertex| previous[vertex as usize]);
            sum += surface_reflectance(world, &hit) * interpolate_barycentric(corners, hit.barycentric);
        }
    }
    sum / count
    // </answer> (super::PLACEHOLDERS.indirect_irradiance)(world, receiver, bounces)
}

/// Reflectance ρ at a hit, per band: the material's, times its texture at the hit where it has one.
///
/// Placeholder while not done: the material's alone. Tests: `radiosity check`, task `textures`.
///
/// Hint: `material.reflectance_texture` is an index into `world.scene.textures`; [`super::sample_texture`] reads it.
pub fn surface_reflectance(world: &World, hit: &SurfaceHit) -> Vec3 {
    // <answer>
    match hit.material.reflectance_texture {
        None => hit.material.reflectance,
        Some(index) => {
            let texture = &world.scene.textures[index as usize];
            hit.material.reflectance * sample_texture(texture.size(), texture.texels(), hit.texcoord)
        }
    }
    // </answer> (super::PLACEHOLDERS.surface_reflectance)(world, hit)
}
