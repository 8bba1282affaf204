//! Equal-area charts of the disk, the hemisphere and the light, apart from the student's own functions.
//!
//! Each takes in what rounding put a hair outside: ranges are tested before.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::{check::chi_square::Chart, scene::AreaLight};

/// Angle and squared radius of the disk.
pub(super) fn disk() -> Chart<'static, Vec2> {
    Chart {
        to_square: Box::new(|disk: Vec2| Vec2::new(disk.to_angle() / TAU + 0.5, disk.length_squared()).min(Vec2::ONE)),
        from_square: Box::new(|place| place.y.sqrt() * Vec2::from_angle((place.x - 0.5) * TAU)),
        measure: f64::from(PI),
    }
}

/// Angle and height on the hemisphere about +z (Archimedes).
pub(super) fn hemisphere() -> Chart<'static, Vec3> {
    Chart {
        to_square: Box::new(|direction: Vec3| {
            Vec2::new(direction.truncate().to_angle() / TAU + 0.5, direction.z.clamp(0.0, 1.0))
        }),
        from_square: Box::new(|place| direction(place.y, (place.x - 0.5) * TAU)),
        measure: f64::from(TAU),
    }
}

/// The unit direction of height `z` and azimuth `angle`.
pub(super) fn direction(z: f32, angle: f32) -> Vec3 {
    ((1.0 - z * z).max(0.0).sqrt() * Vec2::from_angle(angle)).extend(z)
}

/// The place of a position in the light's own coordinates: (-1, -1) to (1, 1) on the light, whatever the angle between
/// its half extents.
pub(super) fn light_coordinates(light: &AreaLight, position: Vec3) -> Vec2 {
    let (u, v) = (light.half_extent_u, light.half_extent_v);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let offset = position - light.centre;
    let (along_u, along_v) = (offset.dot(u), offset.dot(v));
    Vec2::new(vv * along_u - uv * along_v, uu * along_v - uv * along_u) / (uu * vv - uv * uv)
}

/// The light itself.
pub(super) fn light(light: &AreaLight) -> Chart<'_, Vec3> {
    let (u, v) = (light.half_extent_u, light.half_extent_v);
    Chart {
        to_square: Box::new(move |position| {
            (0.5 * light_coordinates(light, position) + 0.5).clamp(Vec2::ZERO, Vec2::ONE)
        }),
        from_square: Box::new(move |place| light.centre + (2.0 * place.x - 1.0) * u + (2.0 * place.y - 1.0) * v),
        measure: 4.0 * f64::from(u.cross(v).length()),
    }
}
