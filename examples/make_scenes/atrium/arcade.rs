//! The walls that stand on the columns: arches, bands, balustrade.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{BAND_EDGE, BAY, CORNICE_EDGE, HALF_WALL, KERB, KERB_EDGE, ROOF, STOREYS, Side, Storey, UPPER_FLOOR};
use crate::make_scenes::model::Model;
use crate::make_scenes::shapes::mix;

/// Quads along an arch, and from it to the top of the wall on the sides of the court and of the gallery.
const ALONG: usize = 12;
const UP: usize = 3;
const UP_BEHIND: usize = 2;
/// The raised ring around an arch: its width and how far it stands out.
const RING: f64 = 0.16;
const RAISED: f64 = 0.05;
/// Size of one repeat of the masonry's picture [m].
const MASONRY: f64 = 1.6;

pub(super) fn arches(model: &mut Model, side: &Side, storey: &Storey) {
    model.obj.object("arches");
    for bay in 0..side.bays() {
        let middle = DVec3::new(side.column_x(bay) + BAY / 2.0, storey.spring, 0.0);
        // The face to the court, then the one to the gallery, which runs the other way.
        model.obj.material("masonry");
        wall_above_arch(model, middle, storey, |u| u, HALF_WALL, UP);
        wall_above_arch(model, middle, storey, |u| 1.0 - u, -HALF_WALL, UP_BEHIND);
        model.obj.material("moulding");
        ring(model, middle, storey.arch_radius);
    }
    model.obj.object("roundels");
    model.obj.material("majolica");
    for index in 1..side.bays() {
        roundel(model, DVec3::new(side.column_x(index), storey.spring + 0.95, HALF_WALL));
    }
}

/// The point of a unit half circle that `share` of its length leads to, from left to right.
fn half_circle(share: f64) -> DVec2 {
    let (sine, cosine) = (PI * (1.0 - share)).sin_cos();
    DVec2::new(cosine, sine)
}

fn wall_above_arch(model: &mut Model, middle: DVec3, storey: &Storey, along: impl Fn(f64) -> f64, z: f64, rows: usize) {
    let (radius, top) = (storey.arch_radius, storey.top - storey.spring);
    let texcoord = |point: DVec3| DVec2::new(point.x, point.y) / MASONRY;
    let above = |u: f64, v: f64| {
        let on_arch = radius * half_circle(along(u));
        let on_top = DVec2::new(mix(-radius, radius, along(u)), top);
        middle + on_arch.lerp(on_top, v).extend(z)
    };
    model.textured_patch([ALONG, rows], above, |u, v| texcoord(above(u, v)));
    for [left, right] in [[-BAY / 2.0, -radius], [radius, BAY / 2.0]] {
        let beside = |u: f64, v: f64| middle + DVec3::new(mix(left, right, along(u)), v * top, z);
        model.textured_patch([1, rows], beside, |u, v| texcoord(beside(u, v)));
    }
}

/// The underside of an arch, and the ring around it.
fn ring(model: &mut Model, middle: DVec3, radius: f64) {
    let front = HALF_WALL + RAISED;
    let at = |radius: f64, u: f64, z: f64| middle + (radius * half_circle(u)).extend(z);
    model.patch([ALONG, 1], |u, v| at(radius, u, mix(-HALF_WALL, front, v)));
    model.patch([ALONG, 1], |u, v| at(radius + RING * v, u, front));
    model.patch([ALONG, 1], |u, v| at(radius + RING, u, mix(front, HALF_WALL, v)));
}

/// A flat dome that looks into the court.
fn roundel(model: &mut Model, centre: DVec3) {
    let outer_frame = model.frame;
    model.frame = outer_frame
        * glam::DAffine3::from_translation(centre)
        * glam::DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    model.lathe(DVec3::ZERO, &[[0.2, 0.0], [0.19, 0.03]], 10);
    model.lathe(DVec3::ZERO, &[[0.19, 0.03], [0.1, 0.06], [0.0, 0.07]], 10);
    model.frame = outer_frame;
}

/// A band along the side, mitred at the corners of the court; the profile's points are (z, y), its front lies to the
/// court where it rises.
fn band(model: &mut Model, side: &Side, profile: &[[f64; 2]]) {
    let pieces = profile.len() - 1;
    let columns = side.bays() * 5;
    model.patch([columns, pieces], |u, v| {
        let piece = ((v * pieces as f64) as usize).min(pieces - 1);
        let share = v * pieces as f64 - piece as f64;
        let z = mix(profile[piece][0], profile[piece + 1][0], share);
        let y = mix(profile[piece][1], profile[piece + 1][1], share);
        DVec3::new(mix(z - side.half, side.half - z, u), y, z)
    });
}

pub(super) fn mouldings(model: &mut Model, side: &Side) {
    let [ground, upper] = STOREYS.map(|storey| storey.top);
    model.obj.object("mouldings");
    model.obj.material("moulding");
    // The riser of the kerb.
    band(model, side, &[[KERB_EDGE, 0.0], [KERB_EDGE, KERB]]);
    // Below the upper floor: an underside, a round and a flat edge.
    band(model, side, &[[HALF_WALL, ground], [HALF_WALL + 0.06, ground]]);
    band(model, side, &[[HALF_WALL + 0.06, ground], [HALF_WALL + 0.08, ground + 0.1], [BAND_EDGE, ground + 0.18]]);
    band(model, side, &[[BAND_EDGE, ground + 0.18], [BAND_EDGE, UPPER_FLOOR]]);
    // The cornice.
    band(model, side, &[[HALF_WALL, upper], [HALF_WALL + 0.05, upper]]);
    let wave = [[0.05, 0.0], [0.07, 0.1], [0.14, 0.18], [0.26, 0.22], [0.32, 0.3]];
    band(model, side, &wave.map(|[out, up]| [HALF_WALL + out, upper + up]));
    band(model, side, &[[CORNICE_EDGE, upper + 0.3], [CORNICE_EDGE, ROOF]]);
}

/// Rails and balusters between the upper columns.
pub(super) fn balustrade(model: &mut Model, side: &Side) {
    const BALUSTERS: usize = 5;
    model.obj.object("balustrade");
    model.obj.material("stone");
    for bay in 0..side.bays() {
        let left = side.column_x(bay);
        let [from, to] = [left + 0.12, left + BAY - 0.12]; // the rails end inside of the columns
        let box_between = |model: &mut Model, low: f64, high: f64, half: f64, hidden: &[DVec3]| {
            let hidden = [hidden, &[DVec3::X, DVec3::NEG_X]].concat();
            model.block(DVec3::new(from, low, -half), DVec3::new(to, high, half), 0.9, &hidden);
        };
        box_between(model, UPPER_FLOOR, UPPER_FLOOR + 0.1, 0.12, &[DVec3::NEG_Y]);
        box_between(model, UPPER_FLOOR + 0.82, UPPER_FLOOR + 0.98, 0.13, &[]);
        for index in 0..BALUSTERS {
            let x = mix(from, to, (index as f64 + 1.0) / (BALUSTERS as f64 + 1.0));
            let profile = [[0.05, 0.0], [0.085, 0.22], [0.04, 0.5], [0.065, 0.72]];
            model.lathe(DVec3::new(x, UPPER_FLOOR + 0.1, 0.0), &profile, 6);
        }
    }
}
