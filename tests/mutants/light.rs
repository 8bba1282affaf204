//! Wrong points on the area light.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use radiosity::{
    scene::AreaLight,
    student::{self, LightSample},
};

use super::{Mutant, mutant};

/// The right sample with another position: centre + x u + y v.
fn at(light: &AreaLight, x: f32, y: f32) -> LightSample {
    let position = light.centre + x * light.half_extent_u + y * light.half_extent_v;
    LightSample { position, ..student::sample_area_light(light, Vec2::ZERO) }
}

/// The right sample with another density.
fn with_pdf(light: &AreaLight, point: Vec2, pdf: f32) -> LightSample {
    let right = student::sample_area_light(light, point);
    LightSample { pdf_area: if right.pdf_area > 0.0 { pdf } else { 0.0 }, ..right }
}

fn with_normal(light: &AreaLight, point: Vec2, normal: Vec3) -> LightSample {
    LightSample { normal, ..student::sample_area_light(light, point) }
}

fn half_extent_as_full(light: &AreaLight, point: Vec2) -> LightSample {
    at(light, point.x - 0.5, point.y - 0.5)
}

fn doubled(light: &AreaLight, point: Vec2) -> LightSample {
    at(light, 4.0 * point.x - 2.0, 4.0 * point.y - 2.0)
}

fn corner_for_centre(light: &AreaLight, point: Vec2) -> LightSample {
    at(light, point.x, point.y)
}

fn corner_and_full(light: &AreaLight, point: Vec2) -> LightSample {
    at(light, 2.0 * point.x, 2.0 * point.y)
}

fn diagonal(light: &AreaLight, point: Vec2) -> LightSample {
    at(light, 2.0 * point.x - 1.0, 2.0 * point.x - 1.0)
}

fn disk(light: &AreaLight, point: Vec2) -> LightSample {
    let place = point.y.sqrt() * Vec2::from_angle(TAU * point.x);
    at(light, place.x, place.y)
}

fn along_the_axes(light: &AreaLight, point: Vec2) -> LightSample {
    let (x, y) = (2.0 * point.x - 1.0, 2.0 * point.y - 1.0);
    let offset = Vec3::new(x * light.half_extent_u.length(), 0.0, y * light.half_extent_v.length());
    LightSample { position: light.centre + offset, ..student::sample_area_light(light, point) }
}

fn swapped(light: &AreaLight, point: Vec2) -> LightSample {
    at(light, 2.0 * point.y - 1.0, 2.0 * point.x - 1.0)
}

fn centre_only(light: &AreaLight, _: Vec2) -> LightSample {
    at(light, 0.0, 0.0)
}

fn centre_forgotten(light: &AreaLight, point: Vec2) -> LightSample {
    let right = student::sample_area_light(light, point);
    LightSample { position: right.position - light.centre, ..right }
}

fn flipped_normal(light: &AreaLight, point: Vec2) -> LightSample {
    with_normal(light, point, -light.normal())
}

fn long_normal(light: &AreaLight, point: Vec2) -> LightSample {
    with_normal(light, point, light.half_extent_u.cross(light.half_extent_v))
}

fn quarter_pdf(light: &AreaLight, point: Vec2) -> LightSample {
    with_pdf(light, point, 4.0 / light.area())
}

fn half_pdf(light: &AreaLight, point: Vec2) -> LightSample {
    with_pdf(light, point, 2.0 / light.area())
}

fn area_for_pdf(light: &AreaLight, point: Vec2) -> LightSample {
    with_pdf(light, point, light.area())
}

fn rectangle_pdf(light: &AreaLight, point: Vec2) -> LightSample {
    with_pdf(light, point, 0.25 / (light.half_extent_u.length() * light.half_extent_v.length()))
}

fn infinite_pdf(light: &AreaLight, point: Vec2) -> LightSample {
    LightSample { pdf_area: 1.0 / light.area(), ..student::sample_area_light(light, point) }
}

fn inverse_of_rectangles(light: &AreaLight, position: Vec3) -> Vec2 {
    let (u, v, offset) = (light.half_extent_u, light.half_extent_v, position - light.centre);
    let along = Vec2::new(offset.dot(u) / u.length_squared(), offset.dot(v) / v.length_squared());
    if along.is_finite() { 0.5 * along + 0.5 } else { Vec2::splat(0.5) }
}

/// The wrong versions.
pub(crate) fn mutants() -> Vec<Mutant> {
    vec![
        mutant!("light", "half extents as full ones", "taken for the full extents", sample_area_light: half_extent_as_full),
        mutant!("light", "extents doubled", "extents are doubled", sample_area_light: doubled),
        mutant!("light", "corner for centre", "taken for a corner", sample_area_light: corner_for_centre),
        mutant!("light", "corner for centre, full extents", "taken for a corner", sample_area_light: corner_and_full),
        mutant!("light", "on the diagonal", "diagonal", sample_area_light: diagonal),
        mutant!("light", "on a disk", "on a disk", sample_area_light: disk),
        mutant!("light", "along the world's axes", "leave the light's plane", sample_area_light: along_the_axes),
        mutant!("light", "x and y swapped", "swapped", sample_area_light: swapped),
        mutant!("light", "centre only", "every point is the centre", sample_area_light: centre_only),
        mutant!("light", "centre forgotten", "centre is missing", sample_area_light: centre_forgotten),
        mutant!("light", "normal flipped", "light's back", sample_area_light: flipped_normal),
        mutant!("light", "normal not normalised", "not normalised", sample_area_light: long_normal),
        mutant!("light", "pdf of a quarter", "quarter of the light", sample_area_light: quarter_pdf),
        mutant!("light", "pdf of half the light", "half the light", sample_area_light: half_pdf),
        mutant!("light", "area for pdf", "the area itself", sample_area_light: area_for_pdf),
        mutant!("light", "area 4 |u| |v|", "a rectangle's", sample_area_light: rectangle_pdf),
        mutant!("light", "pdf infinite without area", "without area", sample_area_light: infinite_pdf),
        mutant!("light", "inverse of rectangles", "at right angles", area_light_inverse: inverse_of_rectangles),
    ]
}
