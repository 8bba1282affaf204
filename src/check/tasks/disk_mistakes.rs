//! Wrong maps to the disk, and wrong densities, by what they do.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec2;

use super::probe::near;

/// A mistake in the angle around z, if the azimuths of `places` show one.
pub(super) fn azimuth(places: &[Vec2]) -> Option<&'static str> {
    let all = |test: fn(Vec2) -> bool| places.iter().all(|&place| test(place));
    let angles = || places.iter().filter(|place| place.length() > 1e-3).map(|place| place.to_angle());
    let (least, most) = (angles().fold(f32::INFINITY, f32::min), angles().fold(f32::NEG_INFINITY, f32::max));
    if most - least < 0.2 {
        Some("all samples lie in one narrow sector: degrees where radians are meant, or no full turn (2π)?")
    } else if all(|place| place.min_element() > -1e-5) {
        Some("the samples fill a quarter of the turn: the angle must run over 2π, not π/2")
    } else if all(|place| place.y > -1e-5) || all(|place| place.x > -1e-5) {
        Some("the samples fill half of the turn: the angle must run over 2π, not π")
    } else {
        None
    }
}

/// The mistake of a map to the unit disk, from (point, place) pairs.
pub(super) fn map(samples: &[(Vec2, Vec2)]) -> Option<&'static str> {
    if samples.is_empty() {
        return None;
    }
    let places: Vec<Vec2> = samples.iter().map(|sample| sample.1).collect();
    let mean = places.iter().map(|place| f64::from(place.length())).sum::<f64>() / places.len() as f64;
    let most = places.iter().map(|place| place.length()).fold(0.0, f32::max);
    let is_mean = |expected: f64| (mean - expected).abs() < 0.01;
    if samples.iter().all(|(point, place)| place.abs_diff_eq(2.0 * *point - 1.0, 1e-4)) {
        return Some("this is the centred square, not yet a disk");
    }
    if places.iter().all(|place| (place.x - place.y).abs() < 1e-4 || (place.x + place.y).abs() < 1e-4) {
        return Some("all samples lie on a diagonal: x takes the cosine of the angle, y its sine");
    }
    if let Some(mistake) = azimuth(&places) {
        return Some(mistake);
    }
    if most > 1.01 {
        return Some(if is_mean(4.0 / 3.0) {
            "the radius is twice too long: it must run from 0 to 1"
        } else {
            "samples lie outside the disk: the radius must run from 0 to 1"
        });
    }
    if mean > 0.99 {
        Some("all samples lie on the circle: the radius is not used")
    } else if is_mean(1.0 / 3.0) && most < 0.51 {
        Some("the radius is halved: the samples cover a quarter of the disk")
    } else if is_mean(1.0 / 2.0) {
        Some("the radius lacks its square root: the samples crowd in the middle (mean radius 1/2 instead of 2/3)")
    } else if is_mean(1.0 / 3.0) {
        Some("the radius is squared where its square root is meant (mean radius 1/3 instead of 2/3)")
    } else if is_mean(4.0 / 5.0) {
        Some("the square root of the radius is taken twice (mean radius 4/5 instead of 2/3)")
    } else {
        None
    }
}

/// What a density is wrong by, from the constant `ratio` of what was found to what is right.
pub(super) fn density_factor(ratio: f32) -> Option<&'static str> {
    let known = [
        (PI, "π is missing: divide by π, so that the integral is 1"),
        (FRAC_1_PI, "π is divided by twice"),
        (PI * PI, "multiplied by π where it must be divided by it"),
        (2.0, "the density is twice too large: that of half the domain"),
        (0.5, "the density is halved: 1/(2π) where 1/π is meant, or that of a domain twice as large"),
        (4.0, "the density is four times too large: that of a quarter of the domain"),
        (0.25, "the density is a quarter of the right one"),
    ];
    known.into_iter().find(|(factor, _)| near(ratio, *factor, 1e-3)).map(|(_, hint)| hint)
}
