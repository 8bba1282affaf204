//! What lies behind the arcades: floors, walls, vaults, the timber ceiling, doors, and the roof.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::{
    BAND_EDGE, BAY, CEILING, CORNICE_EDGE, GALLERY, HALF_WALL, KERB, KERB_EDGE, OUTSIDE, ROOF, STOREYS, Side,
    UPPER_FLOOR,
};
use crate::make_scenes::model::Model;
use crate::make_scenes::shapes::mix;

/// Size of the cells of large surfaces [m].
const CELL: f64 = 0.8;
/// Width of the arches across the gallery, and how far below the vault they reach.
const RIB: f64 = 2.0 * HALF_WALL;
const RIB_DROP: f64 = 0.14;
/// Rise of the vault, and quads from the middle of a bay to its edge.
const RISE: f64 = 1.4;
const WEB: i32 = 5;

/// A flat ring around the court, this side's share of it: from `edge` (towards the court) back to `back`. Repeats its
/// picture every `period` metres; faces down if `down`.
fn flat_ring(model: &mut Model, side: &Side, y: f64, [edge, back]: [f64; 2], period: Option<f64>, down: bool) {
    let inner = side.half - edge;
    for [left, right] in [[-inner, inner], [inner, side.half + back]] {
        let corner = DVec3::new(left, y, -back);
        let (along, across) = (DVec3::X * (right - left), DVec3::Z * (edge + back));
        let (u, v) = if down { (along, across) } else { (across, along) };
        match period {
            Some(period) => model.tiled_rectangle(corner, u, v, CELL, period),
            None => model.rectangle(corner, u, v, CELL),
        }
    }
}

pub(super) fn floors(model: &mut Model, side: &Side) {
    model.obj.object("floors");
    model.obj.material("stone");
    flat_ring(model, side, KERB, [KERB_EDGE, KERB_EDGE], None, false);
    model.obj.material("gallery_tiles");
    flat_ring(model, side, KERB, [-KERB_EDGE, GALLERY], Some(1.2), false);
    flat_ring(model, side, UPPER_FLOOR, [BAND_EDGE, GALLERY], Some(1.2), false);
    model.obj.object("roof");
    model.obj.material("roof");
    flat_ring(model, side, ROOF, [CORNICE_EDGE, OUTSIDE], None, false);
}

pub(super) fn walls(model: &mut Model, side: &Side) {
    let end = side.half + GALLERY;
    model.obj.object("walls");
    let mut inside = |material: &str, low: f64, high: f64| {
        model.obj.material(material);
        let corner = DVec3::new(-end, low, -GALLERY);
        model.rectangle(corner, DVec3::X * 2.0 * end, DVec3::Y * (high - low), CELL);
    };
    for storey in &STOREYS {
        let dado = storey.floor + 1.2;
        inside("dado", storey.floor, dado);
        inside("plaster", dado, if storey.floor < UPPER_FLOOR { UPPER_FLOOR } else { CEILING });
    }
    model.obj.material("moulding");
    for storey in &STOREYS {
        let rail = DVec3::new(-end, storey.floor + 1.17, -GALLERY);
        model.block(rail, rail + DVec3::new(2.0 * end, 0.07, 0.04), CELL, &[DVec3::NEG_Z]);
    }
    let outer = side.half + OUTSIDE;
    model.obj.object("outer_wall");
    model.obj.material("masonry");
    let corner = DVec3::new(outer, 0.0, -OUTSIDE);
    model.tiled_rectangle(corner, DVec3::NEG_X * 2.0 * outer, DVec3::Y * ROOF, 2.5, 1.6);
}

/// Groin vaults over the ground floor's gallery, arches across it between them, and pilasters below those.
pub(super) fn vaults(model: &mut Model, side: &Side) {
    let spring = STOREYS[0].spring;
    let (front, back) = (-HALF_WALL, -GALLERY);
    let centre_z = (front + back) / 2.0;
    let half_depth = (front - back) / 2.0;
    model.obj.object("vaults");
    model.obj.material("vault");
    for bay in 0..side.bays() {
        let centre = DVec3::new(side.column_x(bay) + BAY / 2.0, spring, centre_z);
        groin_vault(model, centre, [(BAY - RIB) / 2.0, half_depth]);
    }
    groin_vault(model, DVec3::new(side.half + HALF_WALL + half_depth, spring, centre_z), [half_depth, half_depth]);
    model.obj.object("ribs");
    model.obj.material("moulding");
    for index in 0..=side.bays() {
        rib(model, DVec3::new(side.column_x(index), spring, centre_z), half_depth);
        pilaster(model, side.column_x(index), spring);
    }
}

/// Two crossing barrels over a rectangle, of which the higher counts: four webs that meet in the diagonals.
fn groin_vault(model: &mut Model, centre: DVec3, half: [f64; 2]) {
    for quarter in 0..4 {
        let (sine, cosine) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarter];
        // The web towards +x in a unit square, turned by quarters: its barrel runs along x. Both parameters are angles:
        // u across the barrel, v from the middle of the bay outwards.
        let web = |u: f64, v: f64| {
            let (across, height) = ((1.0 - 2.0 * u) * FRAC_PI_2).sin_cos();
            let outwards = (v * FRAC_PI_2).sin();
            let (x, z) = (outwards * cosine - across * sine, outwards * sine + across * cosine);
            centre + DVec3::new(x * half[0], RISE * height, z * half[1])
        };
        // Row j has 2 j + 1 points: a triangle with its tip in the middle of the bay.
        let at = |i: i32, j: i32| [0.5 + 0.5 * f64::from(i) / f64::from(WEB), f64::from(j) / f64::from(WEB)];
        for j in 0..WEB {
            for i in -j..j {
                model.polygon(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], web);
            }
            model.polygon(&[at(-j, j), at(-j, j + 1), at(-j - 1, j + 1)], web);
            model.polygon(&[at(j, j), at(j + 1, j + 1), at(j, j + 1)], web);
        }
    }
}

/// An arch across the gallery.
fn rib(model: &mut Model, centre: DVec3, half_depth: f64) {
    let at = |x: f64, u: f64, rise: f64| {
        let (sine, cosine) = (std::f64::consts::PI * u).sin_cos();
        centre + DVec3::new(x, rise * sine, -half_depth * cosine)
    };
    let low = RISE - RIB_DROP;
    let half = RIB / 2.0;
    model.patch([2 * WEB as usize, 1], |u, v| at(mix(half, -half, v), u, low));
    model.patch([2 * WEB as usize, 1], |u, v| at(half, 1.0 - u, mix(low, RISE, v)));
    model.patch([2 * WEB as usize, 1], |u, v| at(-half, u, mix(low, RISE, v)));
}

fn pilaster(model: &mut Model, x: f64, spring: f64) {
    let mut part = |half: f64, from: f64, to: f64, depth: f64| {
        let low = DVec3::new(x - half, from, -GALLERY);
        let high = DVec3::new(x + half, to, depth - GALLERY);
        model.block(low, high, CELL, &[DVec3::NEG_Z]);
    };
    part(0.28, KERB, KERB + 0.3, 0.16);
    part(0.24, KERB + 0.3, spring - 0.2, 0.12);
    part(0.28, spring - 0.2, spring, 0.17);
}

/// Boards and beams over the upper gallery.
pub(super) fn upper_ceiling(model: &mut Model, side: &Side) {
    model.obj.object("timber_ceiling");
    model.obj.material("wood");
    flat_ring(model, side, CEILING, [-HALF_WALL, GALLERY], None, true);
    for half_bay in 0..=2 * side.bays() {
        let x = half_bay as f64 * BAY / 2.0 - side.half;
        let (low, high) = (DVec3::new(x - 0.1, CEILING - 0.28, -GALLERY), DVec3::new(x + 0.1, CEILING, -HALF_WALL));
        model.block(low, high, CELL, &[DVec3::Y, DVec3::Z, DVec3::NEG_Z]);
    }
}

/// A door in every third bay of both storeys: a stone frame, two leaves and panels on them.
pub(super) fn doors(model: &mut Model, side: &Side) {
    model.obj.object("doors");
    for storey in &STOREYS {
        for bay in (0..side.bays()).filter(|bay| bay % 3 == 1) {
            door(model, DVec2::new(side.column_x(bay) + BAY / 2.0, storey.floor));
        }
    }
}

fn door(model: &mut Model, foot: DVec2) {
    let part = |model: &mut Model, x: [f64; 2], y: [f64; 2], depth: f64| {
        let low = DVec3::new(foot.x + x[0], foot.y + y[0], -GALLERY);
        let high = DVec3::new(foot.x + x[1], foot.y + y[1], depth - GALLERY);
        model.block(low, high, 1.2, &[DVec3::NEG_Z]);
    };
    model.obj.material("moulding");
    part(model, [-0.82, -0.64], [0.0, 2.4], 0.14);
    part(model, [0.64, 0.82], [0.0, 2.4], 0.14);
    part(model, [-0.9, 0.9], [2.4, 2.66], 0.2);
    model.obj.material("wood");
    for [left, right] in [[-0.64, -0.01], [0.01, 0.64]] {
        part(model, [left, right], [0.0, 2.4], 0.06);
        for [bottom, top] in [[0.2, 1.0], [1.2, 2.2]] {
            part(model, [left + 0.1, right - 0.1], [bottom, top], 0.085);
        }
    }
}
