//! Wrong maps from the square to the disk and to the hemisphere.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::{Vec2, Vec3};
use radiosity::student;

use super::{Mutant, mutant};

fn disk_without_root(point: Vec2) -> Vec2 {
    point.y * Vec2::from_angle(TAU * point.x)
}

fn half_disk(point: Vec2) -> Vec2 {
    point.y.sqrt() * Vec2::from_angle(PI * point.x)
}

fn disk_in_degrees(point: Vec2) -> Vec2 {
    point.y.sqrt() * Vec2::from_angle(360.0 * point.x)
}

fn disk_to_radians(point: Vec2) -> Vec2 {
    point.y.sqrt() * Vec2::from_angle((TAU * point.x).to_radians())
}

fn square_as_disk(point: Vec2) -> Vec2 {
    2.0 * point - 1.0
}

fn one_number_for_both(point: Vec2) -> Vec2 {
    point.x.sqrt() * Vec2::from_angle(TAU * point.x)
}

fn disk_inverse_without_whole_turn(disk: Vec2) -> Vec2 {
    Vec2::new(disk.to_angle() / TAU, disk.length_squared())
}

fn disk_inverse_without_square(disk: Vec2) -> Vec2 {
    Vec2::new(student::disk_to_square_polar(disk).x, disk.length())
}

fn concentric_without_middle(point: Vec2) -> Vec2 {
    let centred = 2.0 * point - 1.0;
    let (radius, angle) = if centred.x.abs() > centred.y.abs() {
        (centred.x, FRAC_PI_4 * (centred.y / centred.x))
    } else {
        (centred.y, FRAC_PI_2 - FRAC_PI_4 * (centred.x / centred.y))
    };
    radius * Vec2::from_angle(angle)
}

fn concentric_with_wrong_branch(point: Vec2) -> Vec2 {
    let centred = 2.0 * point - 1.0;
    if centred.x.abs() > centred.y.abs() {
        centred.x * Vec2::from_angle(FRAC_PI_4 * (centred.y / centred.x))
    } else if centred == Vec2::ZERO {
        Vec2::ZERO
    } else {
        centred.y * Vec2::from_angle(FRAC_PI_4 * (centred.x / centred.y))
    }
}

fn concentric_without_signs(point: Vec2) -> Vec2 {
    let centred = 2.0 * point - 1.0;
    if centred == Vec2::ZERO {
        Vec2::ZERO
    } else if centred.x.abs() > centred.y.abs() {
        centred.x.abs() * Vec2::from_angle(FRAC_PI_4 * (centred.y / centred.x))
    } else {
        centred.y.abs() * Vec2::from_angle(FRAC_PI_2 - FRAC_PI_4 * (centred.x / centred.y))
    }
}

fn disk_inverse_in_radians(disk: Vec2) -> Vec2 {
    Vec2::new(TAU * student::disk_to_square_polar(disk).x, disk.length_squared())
}

fn cosine_for_both(point: Vec2) -> Vec2 {
    point.y.sqrt() * Vec2::splat((TAU * point.x).cos())
}

fn concentric_with_smaller_radius(point: Vec2) -> Vec2 {
    let Vec2 { x, y } = 2.0 * point - 1.0;
    if x == 0.0 || y == 0.0 {
        Vec2::ZERO
    } else if x.abs() < y.abs() {
        x * Vec2::from_angle(FRAC_PI_4 * y / x)
    } else {
        y * Vec2::from_angle(FRAC_PI_2 - FRAC_PI_4 * x / y)
    }
}

fn disk_of_diameter_one(point: Vec2) -> Vec2 {
    0.5 * student::square_to_disk_polar(point)
}

fn whole_sphere(point: Vec2) -> Vec3 {
    let z = 2.0 * point.x - 1.0;
    ((1.0 - z * z).max(0.0).sqrt() * Vec2::from_angle(TAU * point.y)).extend(z)
}

fn hemisphere_of_half_a_turn(point: Vec2) -> Vec3 {
    lifted(half_disk(point))
}

fn hemisphere_in_degrees(point: Vec2) -> Vec3 {
    lifted(disk_in_degrees(point))
}

fn hemisphere_of_one_number(point: Vec2) -> Vec3 {
    lifted(one_number_for_both(point))
}

fn hemisphere_on_the_disk(point: Vec2) -> Vec3 {
    student::square_to_disk_concentric(point).extend(0.0)
}

fn hemisphere_by_normalised_cube(point: Vec2) -> Vec3 {
    (2.0 * point - 1.0).extend(1.0).normalize()
}

fn concentric_not_centred(point: Vec2) -> Vec2 {
    student::square_to_disk_concentric(0.5 * point + 0.5)
}

fn concentric_is_polar(point: Vec2) -> Vec2 {
    student::square_to_disk_polar(point)
}

fn concentric_inverse_not_scaled(disk: Vec2) -> Vec2 {
    2.0 * student::disk_to_square_concentric(disk) - 1.0
}

fn uniform_hemisphere(point: Vec2) -> Vec3 {
    let radius = (1.0 - point.x * point.x).sqrt();
    (radius * Vec2::from_angle(TAU * point.y)).extend(point.x)
}

fn cosine_squared(point: Vec2) -> Vec3 {
    let z = point.x.cbrt();
    ((1.0 - z * z).max(0.0).sqrt() * Vec2::from_angle(TAU * point.y)).extend(z)
}

fn lifted(disk: Vec2) -> Vec3 {
    disk.extend((1.0 - disk.length_squared()).max(0.0).sqrt())
}

fn hemisphere_without_root(point: Vec2) -> Vec3 {
    lifted(disk_without_root(point))
}

fn hemisphere_y_up(point: Vec2) -> Vec3 {
    let Vec3 { x, y, z } = student::square_to_cosine_hemisphere(point);
    Vec3::new(x, z, y)
}

fn hemisphere_not_lifted(point: Vec2) -> Vec3 {
    let disk = student::square_to_disk_concentric(point);
    disk.extend(1.0 - disk.length_squared())
}

fn hemisphere_nan_at_the_rim(point: Vec2) -> Vec3 {
    let disk = student::square_to_disk_concentric(point);
    disk.extend((1.0 - disk.length_squared()).sqrt())
}

fn uniform_angle(point: Vec2) -> Vec3 {
    let (sine, cosine) = (FRAC_PI_2 * point.x).sin_cos();
    (sine * Vec2::from_angle(TAU * point.y)).extend(cosine)
}

fn hemisphere_down(point: Vec2) -> Vec3 {
    -student::square_to_cosine_hemisphere(point)
}

fn hemisphere_panics(point: Vec2) -> Vec3 {
    assert!(point.x < 1.0, "the point is out of range");
    student::square_to_cosine_hemisphere(point)
}

fn hemisphere_inverse_swapped(direction: Vec3) -> Vec2 {
    let point = student::cosine_hemisphere_to_square(direction);
    Vec2::new(point.y, point.x)
}

fn maps_to_disk() -> Vec<Mutant> {
    vec![
        mutant!("disk", "disk without root", "square root", square_to_disk_polar: disk_without_root),
        mutant!("disk", "half of the turn", "half of the turn", square_to_disk_polar: half_disk),
        mutant!("disk", "degrees", "degrees", square_to_disk_polar: disk_in_degrees),
        mutant!("disk", "turned to radians twice", "57 times too small", square_to_disk_polar: disk_to_radians),
        mutant!("disk", "square for disk", "not yet a disk", square_to_disk_polar: square_as_disk),
        mutant!("disk", "one number for both", "not used", square_to_disk_polar: one_number_for_both),
        mutant!("disk", "pdf without π", "π is missing", disk_pdf_area: |_| 1.0),
        mutant!("disk", "pdf outside of the disk", "outside the disk", disk_pdf_area: |_| FRAC_1_PI),
        mutant!("disk", "angle not divided by 2π", "not divided by 2π", disk_to_square_polar: disk_inverse_in_radians),
        mutant!("disk", "cosine for both", "on a diagonal", square_to_disk_polar: cosine_for_both),
        mutant!("concentric", "smaller for larger", "smaller coordinate",
            square_to_disk_concentric: concentric_with_smaller_radius),
        mutant!("disk", "radius halved", "radius is halved", square_to_disk_polar: disk_of_diameter_one),
        mutant!("concentric", "signs lost", "sign of a coordinate", square_to_disk_concentric: concentric_without_signs),
        mutant!("disk", "negative angles", "whole turn", disk_to_square_polar: disk_inverse_without_whole_turn),
        mutant!("disk", "radius not squared back", "where its square is meant",
            disk_to_square_polar: disk_inverse_without_square),
        mutant!("concentric", "NaN in the middle", "0/0", square_to_disk_concentric: concentric_without_middle),
        mutant!("concentric", "second branch's angle", "branch |y| > |x|",
            square_to_disk_concentric: concentric_with_wrong_branch),
        mutant!("concentric", "not centred", "not centred", square_to_disk_concentric: concentric_not_centred),
        mutant!("concentric", "polar", "polar map", square_to_disk_concentric: concentric_is_polar),
        mutant!("concentric", "inverse in [-1, 1]", "stops at [-1, 1]",
            disk_to_square_concentric: concentric_inverse_not_scaled),
    ]
}

fn maps_to_hemisphere() -> Vec<Mutant> {
    vec![
        mutant!("hemisphere", "uniform hemisphere", "uniform hemisphere", square_to_cosine_hemisphere: uniform_hemisphere),
        mutant!("hemisphere", "cosine squared", "cosine is squared", square_to_cosine_hemisphere: cosine_squared),
        mutant!("hemisphere", "disk without root", "lacks its square root",
            square_to_cosine_hemisphere: hemisphere_without_root),
        mutant!("hemisphere", "y up", "about another axis", square_to_cosine_hemisphere: hemisphere_y_up),
        mutant!("hemisphere", "no root for z", "z lacks its square root", square_to_cosine_hemisphere: hemisphere_not_lifted),
        mutant!("hemisphere", "NaN at the rim", "by rounding at the rim",
            square_to_cosine_hemisphere: hemisphere_nan_at_the_rim),
        mutant!("hemisphere", "uniform angle", "angle from the pole is uniform", square_to_cosine_hemisphere: uniform_angle),
        mutant!("hemisphere", "downwards", "upside down", square_to_cosine_hemisphere: hemisphere_down),
        mutant!("hemisphere", "panics at a side", "panics", square_to_cosine_hemisphere: hemisphere_panics),
        mutant!("hemisphere", "whole sphere", "whole sphere", square_to_cosine_hemisphere: whole_sphere),
        mutant!("hemisphere", "half of the turn", "half of the turn", square_to_cosine_hemisphere: hemisphere_of_half_a_turn),
        mutant!("hemisphere", "degrees", "degrees", square_to_cosine_hemisphere: hemisphere_in_degrees),
        mutant!("hemisphere", "one number for both", "not used", square_to_cosine_hemisphere: hemisphere_of_one_number),
        mutant!("hemisphere", "not lifted", "not lifted", square_to_cosine_hemisphere: hemisphere_on_the_disk),
        mutant!("hemisphere", "normalised cube", "near the horizon are missing", square_to_cosine_hemisphere: hemisphere_by_normalised_cube),
        mutant!("hemisphere", "pdf without π", "π is missing",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z.max(0.0)),
        mutant!("hemisphere", "pdf with π twice", "twice",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z.max(0.0) * FRAC_1_PI * FRAC_1_PI),
        mutant!("hemisphere", "pdf times π", "multiplied by π",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z.max(0.0) * PI),
        mutant!("hemisphere", "pdf of half the density", "halved",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z.max(0.0) / TAU),
        mutant!("hemisphere", "pdf of the uniform hemisphere", "uniform hemisphere",
            cosine_hemisphere_pdf_solid_angle: |direction| if direction.z > 0.0 { 1.0 / TAU } else { 0.0 }),
        mutant!("hemisphere", "pdf without cosine", "cosine is missing",
            cosine_hemisphere_pdf_solid_angle: |direction| if direction.z > 0.0 { FRAC_1_PI } else { 0.0 }),
        mutant!("hemisphere", "pdf with cosine squared", "cosine is squared",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z.max(0.0).powi(2) * FRAC_1_PI),
        mutant!("hemisphere", "cosine of both sides", "wrong side",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z.abs() * FRAC_1_PI),
        mutant!("hemisphere", "cosine of the wrong side", "wrong side",
            cosine_hemisphere_pdf_solid_angle: |direction| (-direction.z).max(0.0) * FRAC_1_PI),
        mutant!("hemisphere", "density over angles", "sine too many",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z.max(0.0) * direction.truncate().length() * FRAC_1_PI),
        mutant!("hemisphere", "pdf by the angle", "angle itself",
            cosine_hemisphere_pdf_solid_angle: |direction| if direction.z > 0.0 { direction.z.acos() * FRAC_1_PI } else { 0.0 }),
        mutant!("hemisphere", "pdf with y up", "another axis",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.y.max(0.0) * FRAC_1_PI),
        mutant!("hemisphere", "pdf below the horizon", "negative below",
            cosine_hemisphere_pdf_solid_angle: |direction| direction.z * FRAC_1_PI),
        mutant!("hemisphere", "inverse ends at the disk", "shadow on the disk",
            cosine_hemisphere_to_square: |direction| direction.truncate()),
        mutant!("hemisphere", "inverse swapped", "swaps the two", cosine_hemisphere_to_square: hemisphere_inverse_swapped),
    ]
}

/// The wrong versions.
pub(crate) fn mutants() -> Vec<Mutant> {
    let mut mutants = maps_to_disk();
    mutants.extend(maps_to_hemisphere());
    mutants
}
