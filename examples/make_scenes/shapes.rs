//! Simple shapes out of patches.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::model::Model;

/// How many cells of about `size` fit into a length.
pub(super) fn cells(length: f64, size: f64) -> usize {
    ((length / size).round() as usize).max(1)
}

/// From `a` (at 0) to `b` (at 1).
pub(super) fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}

impl Model {
    /// A parallelogram from `corner` along `u` and `v`, cut into cells of about `size`; its front is where u × v
    /// points.
    pub(super) fn rectangle(&mut self, corner: DVec3, u: DVec3, v: DVec3, size: f64) {
        let counts = [cells(u.length(), size), cells(v.length(), size)];
        self.patch(counts, |s, t| corner + s * u + t * v);
    }

    /// [`Model::rectangle`] with a texture that repeats every `period` metres.
    pub(super) fn tiled_rectangle(&mut self, corner: DVec3, u: DVec3, v: DVec3, size: f64, period: f64) {
        let counts = [cells(u.length(), size), cells(v.length(), size)];
        let repeats = DVec2::new(u.length(), v.length()) / period;
        self.textured_patch(counts, |s, t| corner + s * u + t * v, |s, t| DVec2::new(s, t) * repeats);
    }

    /// The outside of a box, without those of its six sides that are named by their outward directions.
    pub(super) fn block(&mut self, low: DVec3, high: DVec3, size: f64, without: &[DVec3]) {
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        for (normal, u, v) in SIDES {
            if !without.contains(&normal) {
                let corner = middle + (normal - u - v) * half;
                self.rectangle(corner, 2.0 * u * half, 2.0 * v * half, size);
            }
        }
    }

    /// The inside of a box.
    pub(super) fn room(&mut self, low: DVec3, high: DVec3, size: f64) {
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        for (normal, u, v) in SIDES {
            let corner = middle + (normal - u - v) * half;
            self.rectangle(corner, 2.0 * v * half, 2.0 * u * half, size);
        }
    }

    /// A surface of revolution about the upright through `base`. The profile's points are (radius, height); it is
    /// smooth, and its front lies outside where it rises.
    pub(super) fn lathe(&mut self, base: DVec3, profile: &[[f64; 2]], segments: usize) {
        let pieces = profile.len() - 1;
        self.patch([segments, pieces], |u, v| {
            let place = v * pieces as f64;
            let piece = (place as usize).min(pieces - 1);
            let share = place - piece as f64;
            let radius = mix(profile[piece][0], profile[piece + 1][0], share);
            let height = mix(profile[piece][1], profile[piece + 1][1], share);
            let (sine, cosine) = (u * TAU).sin_cos();
            base + DVec3::new(radius * cosine, height, -radius * sine)
        });
    }
}

/// Outward direction of each side of a box, and two edges u, v with u × v along it.
const SIDES: [(DVec3, DVec3, DVec3); 6] = [
    (DVec3::X, DVec3::Y, DVec3::Z),
    (DVec3::NEG_X, DVec3::Z, DVec3::Y),
    (DVec3::Y, DVec3::Z, DVec3::X),
    (DVec3::NEG_Y, DVec3::X, DVec3::Z),
    (DVec3::Z, DVec3::X, DVec3::Y),
    (DVec3::NEG_Z, DVec3::Y, DVec3::X),
];
