//! Equal-area charts of the disk, the hemisphere and the light, apart from the student's own functions.
//!
//! Each takes in what rounding put a hair outside: ranges are tested before.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::{check::chi_square::Chart, scene::AreaLight};

/// The disk by upright strips: the area to the left of a point, and its place on the chord through it.
pub(super) fn disk() -> Chart<'static, Vec2> {
    let half_chord = |x: f32| (1.0 - x * x).max(1e-12).sqrt();
    let area_to_the_left = move |x: f32| 0.5 + (x.asin() + x * half_chord(x)) / PI;
    Chart {
        to_square: Box::new(move |disk: Vec2| {
            let x = disk.x.clamp(-1.0, 1.0);
            Vec2::new(area_to_the_left(x), 0.5 + 0.5 * disk.y / half_chord(x)).clamp(Vec2::ZERO, Vec2::ONE)
        }),
        from_square: Box::new(move |place| {
            // Newton's method from the middle never leaves the disk: the area is convex, then concave.
            let step = |x: f32| x - (area_to_the_left(x) - place.x) * 0.5 * PI / half_chord(x);
            let x = (0..8).fold(0.0, |x, _| step(x).clamp(-1.0, 1.0));
            Vec2::new(x, (2.0 * place.y - 1.0) * half_chord(x))
        }),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::chi_square::random_points;

    #[test]
    fn the_disks_chart_leads_there_and_back_and_keeps_areas() {
        let chart = disk();
        for place in random_points(1, 1000) {
            let there = (chart.from_square)(place);
            assert!(there.length() <= 1.0 + 1e-5);
            assert!((chart.to_square)(there).abs_diff_eq(place, 1e-4), "{place}");
        }
        // A quarter of the area lies within half the radius.
        let inside = random_points(2, 10_000).filter(|place| (chart.from_square)(*place).length() < 0.5).count();
        assert!(inside.abs_diff(2500) < 200, "{inside}");
    }
}
