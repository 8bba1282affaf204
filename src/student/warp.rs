//! From the unit square to the disk and to the hemisphere, and back.

// <answer>
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, TAU};
// </answer>

use glam::{Vec2, Vec3};

/// Maps the unit square to the unit disk so that equal areas stay equal: density 1/π everywhere. The simplest such map:
/// one coordinate turns, the other moves outwards. (Any other map of this density passes the tests as well.)
///
/// `point` lies in [0, 1]²; the result has length at most 1. Placeholder while not done: (0, 0).
///
/// Tests: `radiosity check`, task `disk`.
///
/// Hint: half of the area lies outside of radius 1/√2, not of radius 1/2.
pub fn square_to_disk_polar(point: Vec2) -> Vec2 {
    // <answer>
    point.y.sqrt() * Vec2::from_angle(TAU * point.x)
    // </answer> (super::PLACEHOLDERS.square_to_disk_polar)(point)
}

/// The inverse of [`square_to_disk_polar`]: a point of the unit disk to its point of [0, 1]².
///
/// Placeholder while not done: (1/2, 1/2). Tests: `radiosity check`, task `disk`.
///
/// Hint: `atan2` gives angles from -π to π; the square wants fractions of a turn from 0 to 1.
pub fn disk_to_square_polar(disk: Vec2) -> Vec2 {
    // <answer>
    let turn = disk.to_angle() / TAU;
    Vec2::new(if turn < 0.0 { turn + 1.0 } else { turn }, disk.length_squared()).clamp(Vec2::ZERO, Vec2::ONE)
    // </answer> (super::PLACEHOLDERS.disk_to_square_polar)(disk)
}

/// The density of a uniform point on the unit disk [1/area]: 1/π, and 0 outside.
///
/// Placeholder while not done: 0. Tests: `radiosity check`, task `disk`.
///
/// Hint: the integral over the disk must be 1, and the disk's area is π.
pub fn disk_pdf_area(disk: Vec2) -> f32 {
    // <answer>
    if disk.length_squared() <= 1.0 { FRAC_1_PI } else { 0.0 }
    // </answer> (super::PLACEHOLDERS.disk_pdf_area)(disk)
}

/// Maps the unit square to the unit disk so that equal areas stay equal: density 1/π everywhere.
///
/// `point` lies in [0, 1]²; the result has length at most 1. Squares around the middle become circles around it, so
/// neighbours stay neighbours and a stratified set stays well spread.
///
/// Method: Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
///
/// Placeholder while not done: (0, 0). Tests: `radiosity check`, task `concentric`.
///
/// Hint: move the middle to (0, 0). The larger of |x| and |y| is the radius; the smaller divided by the larger runs
/// from -1 to 1 and is the angle from the nearest axis, in units of π/4.
pub fn square_to_disk_concentric(point: Vec2) -> Vec2 {
    // <answer>
    let centred = 2.0 * point - 1.0;
    if centred == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if centred.x.abs() > centred.y.abs() {
        (centred.x, FRAC_PI_4 * (centred.y / centred.x))
    } else {
        (centred.y, FRAC_PI_2 - FRAC_PI_4 * (centred.x / centred.y))
    };
    radius * Vec2::from_angle(angle)
    // </answer> (super::PLACEHOLDERS.square_to_disk_concentric)(point)
}

/// The inverse of [`square_to_disk_concentric`]: a point of the unit disk to its point of the square.
///
/// Placeholder while not done: (1/2, 1/2). Tests: `radiosity check`, task `concentric`.
///
/// Hint: the axis with the larger coordinate tells which branch the point came from.
pub fn disk_to_square_concentric(disk: Vec2) -> Vec2 {
    // <answer>
    if disk == Vec2::ZERO {
        return Vec2::splat(0.5);
    }
    let radius = disk.length();
    let centred = if disk.x.abs() > disk.y.abs() {
        let x = radius.copysign(disk.x);
        Vec2::new(x, x * (disk.y / disk.x).atan() / FRAC_PI_4)
    } else {
        let y = radius.copysign(disk.y);
        Vec2::new(y * (disk.x / disk.y).atan() / FRAC_PI_4, y)
    };
    (0.5 * centred + 0.5).clamp(Vec2::ZERO, Vec2::ONE)
    // </answer> (super::PLACEHOLDERS.disk_to_square_concentric)(disk)
}

/// Maps the unit square to directions about +z with density cosθ/π, θ from z (eq. 4).
///
/// `point` lies in [0, 1]²; the result has unit length and z ≥ 0. With this density cosθ/pdf is the constant π, so the
/// gather of eq. 4 is a plain mean of the radiosities that the rays meet.
///
/// Method: Malley's: a uniform disk seen as the hemisphere's shadow.
///
/// Placeholder while not done: (0, 0, 1). Tests: `radiosity check`, task `hemisphere`; any map of this density passes.
///
/// Hint: the direction stands above the point of [`square_to_disk_concentric`]; Pythagoras gives its height, which
/// rounding must not take below 0.
pub fn square_to_cosine_hemisphere(point: Vec2) -> Vec3 {
    // <answer>
    let disk = square_to_disk_concentric(point);
    disk.extend((1.0 - disk.length_squared()).max(0.0).sqrt())
    // </answer> (super::PLACEHOLDERS.square_to_cosine_hemisphere)(point)
}

/// The density of [`square_to_cosine_hemisphere`] [1/sr]: cosθ/π, and 0 below the horizon.
///
/// `direction` has unit length, z up.
///
/// Placeholder while not done: 1. Tests: `radiosity check`, task `hemisphere`.
///
/// Hint: the integral over the hemisphere must be 1; that of cosθ alone is π.
pub fn cosine_hemisphere_pdf_solid_angle(direction: Vec3) -> f32 {
    // <answer>
    direction.z.max(0.0) * FRAC_1_PI
    // </answer> (super::PLACEHOLDERS.cosine_hemisphere_pdf_solid_angle)(direction)
}

/// The inverse of [`square_to_cosine_hemisphere`]: a unit direction with z ≥ 0 to its point of the square.
///
/// Placeholder while not done: (1/2, 1/2). Tests: `radiosity check`, task `hemisphere`.
///
/// Hint: the shadow on the disk is (x, y).
pub fn cosine_hemisphere_to_square(direction: Vec3) -> Vec2 {
    // <answer>
    disk_to_square_concentric(direction.truncate())
    // </answer> (super::PLACEHOLDERS.cosine_hemisphere_to_square)(direction)
}
