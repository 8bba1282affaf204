//! What stands in the court and hangs into it.

use glam::{DVec2, DVec3};

use super::{BAY, HALF_LENGTH, HALF_WIDTH, KERB_EDGE, Side};
use crate::make_scenes::model::Model;
use crate::make_scenes::shapes::mix;

/// The floor, the fountain and the plants.
pub(super) fn court(model: &mut Model) {
    model.obj.object("court");
    model.obj.material("court_tiles");
    let reach = DVec3::new(HALF_LENGTH - KERB_EDGE, 0.0, HALF_WIDTH - KERB_EDGE);
    model.tiled_rectangle(-reach, DVec3::Z * 2.0 * reach.z, DVec3::X * 2.0 * reach.x, 0.44, 2.7);
    fountain(model);
    for side in [-1.0, 1.0] {
        for index in [-3.0, -1.0, 1.0, 3.0] {
            plant(model, DVec3::new(index * BAY, 0.0, side * (reach.z - 0.55)));
        }
    }
}

fn fountain(model: &mut Model) {
    let profile = |model: &mut Model, pieces: &[&[[f64; 2]]], segments: usize| {
        for piece in pieces {
            model.lathe(DVec3::ZERO, piece, segments);
        }
    };
    model.obj.object("fountain");
    model.obj.material("stone");
    // The basin, from its step outside over the rim to the bottom inside.
    profile(
        model,
        &[
            &[[1.75, 0.0], [1.75, 0.12]],
            &[[1.75, 0.12], [1.5, 0.12]],
            &[[1.5, 0.12], [1.46, 0.3], [1.52, 0.5]],
            &[[1.52, 0.5], [1.6, 0.54], [1.6, 0.6]],
            &[[1.6, 0.6], [1.34, 0.6]],
            &[[1.34, 0.6], [1.34, 0.3]],
        ],
        28,
    );
    // The stem and its bowl.
    profile(
        model,
        &[
            &[[0.3, 0.3], [0.3, 0.55], [0.16, 0.7], [0.13, 1.0], [0.19, 1.2], [0.14, 1.35]],
            &[[0.14, 1.35], [0.4, 1.42], [0.64, 1.55], [0.72, 1.7]],
            &[[0.72, 1.7], [0.66, 1.7]],
            &[[0.66, 1.7], [0.6, 1.62]],
        ],
        20,
    );
    model.obj.material("water");
    profile(model, &[&[[1.34, 0.48], [0.7, 0.48], [0.2, 0.48]], &[[0.62, 1.65], [0.0, 1.65]]], 28);
}

/// A clipped bush in a pot.
fn plant(model: &mut Model, foot: DVec3) {
    model.obj.object("plant");
    model.obj.material("terracotta");
    model.lathe(foot, &[[0.2, 0.0], [0.27, 0.2], [0.31, 0.45]], 14);
    for piece in [[[0.31, 0.45], [0.35, 0.45]], [[0.35, 0.45], [0.35, 0.53]], [[0.35, 0.53], [0.0, 0.53]]] {
        model.lathe(foot, &piece, 14);
    }
    model.obj.material("wood");
    model.lathe(foot, &[[0.045, 0.5], [0.04, 0.95]], 7);
    model.obj.material("leaves");
    let centre = foot + DVec3::Y * 1.25;
    model.patch([12, 8], |u, v| {
        let (sine, cosine) = (u * std::f64::consts::TAU).sin_cos();
        let (across, up) = (v * std::f64::consts::PI).sin_cos();
        let bumps = 1.0 + 0.05 * (8.0 * u * std::f64::consts::TAU).sin() * (9.0 * v).sin() * across;
        centre + 0.42 * bumps * DVec3::new(across * cosine, -up, -across * sine)
    });
}

/// Banners on rods before the upper columns of the long sides.
pub(super) fn banners(model: &mut Model, side: &Side) {
    if side.half < HALF_LENGTH {
        return;
    }
    model.obj.object("banners");
    for (index, colour) in [(1, "red"), (3, "blue"), (5, "green"), (7, "red")] {
        let top = DVec3::new(side.column_x(index), 9.15, 0.75);
        model.obj.material("iron");
        let half = DVec3::new(0.68, 0.02, 0.02);
        model.block(top - half, top + half, 0.5, &[]);
        for end in [-0.62, 0.62] {
            let arm = top + DVec3::X * end;
            model.block(arm - DVec3::new(0.015, 0.015, 0.55), arm + DVec3::new(0.015, 0.015, 0.0), 0.6, &[]);
        }
        model.obj.material(&format!("banner_{colour}"));
        cloth(model, top - DVec3::Y * 0.03, index as f64);
    }
}

/// A cloth of 1.2 m by 3.6 m with folds that grow downwards, and its other face behind it.
fn cloth(model: &mut Model, top: DVec3, phase: f64) {
    const SIZE: DVec2 = DVec2::new(1.2, 3.6);
    const THICKNESS: f64 = 0.004;
    // The faces meet in the edges, so that nobody looks between them.
    let at = |u: f64, v: f64, side: f64| {
        let shift = side * THICKNESS * (40.0 * u * (1.0 - u)).min(40.0 * v * (1.0 - v)).clamp(0.0, 1.0);
        let fold = (u * 11.0 + phase + 1.5 * (1.0 - v)).sin() * mix(0.075, 0.02, v);
        let sway = 0.1 * (phase * 2.3).sin() * (1.0 - v) * (1.0 - v);
        top + DVec3::new((u - 0.5) * SIZE.x, (v - 1.0) * SIZE.y, fold + sway + shift)
    };
    let cells = [10, 12];
    model.textured_patch(cells, |u, v| at(u, v, 1.0), DVec2::new);
    model.textured_patch(cells, |u, v| at(1.0 - u, v, -1.0), |u, v| DVec2::new(1.0 - u, v));
}
