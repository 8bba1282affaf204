//! Columns with base and capital, and the piers at the corners of the court.

use glam::DVec3;

use super::{Side, Storey};
use crate::make_scenes::model::Model;

/// The measures of a column [m].
#[derive(Clone, Copy)]
pub(super) struct Column {
    /// Radius of the shaft at its foot.
    radius: f64,
    /// Half the width of the square plates below and above.
    half_plate: f64,
    segments: usize,
}

pub(super) const GROUND: Column = Column { radius: 0.25, half_plate: 0.34, segments: 12 };
pub(super) const UPPER: Column = Column { radius: 0.19, half_plate: 0.3, segments: 10 };

/// The columns of a side, and the pier at its right-hand end.
pub(super) fn row(model: &mut Model, side: &Side, storey: &Storey) {
    model.obj.object("columns");
    model.obj.material("stone");
    for index in 1..side.bays() {
        column(model, DVec3::new(side.column_x(index), storey.floor, 0.0), storey);
    }
    model.obj.object("pier");
    pier(model, side.half, storey);
}

fn plate(model: &mut Model, base: DVec3, half: f64, height: f64, hidden: DVec3) {
    let reach = DVec3::new(half, 0.0, half);
    model.block(base - reach, base + reach + DVec3::Y * height, 1.0, &[hidden]);
}

fn column(model: &mut Model, base: DVec3, storey: &Storey) {
    let Column { radius, half_plate, segments } = storey.column;
    let height = storey.spring - storey.floor;
    plate(model, base, half_plate, 0.14, DVec3::NEG_Y);
    plate(model, base + DVec3::Y * (height - 0.18), half_plate, 0.18, DVec3::ZERO);

    // Base: a round torus and a hollow below the shaft.
    let torus = [[1.2, 0.14], [1.36, 0.18], [1.34, 0.23], [1.12, 0.26]];
    let hollow = [[1.12, 0.26], [1.06, 0.31], [1.0, 0.36]];
    // Shaft: slightly swollen, to 84 % at the neck.
    let (foot, neck) = (0.36, height - 0.62);
    let shaft: Vec<[f64; 2]> = (0..=5)
        .map(|step| {
            let share = f64::from(step) / 5.0;
            [1.0 + 0.05 * share - 0.21 * share * share, foot + (neck - foot) * share]
        })
        .collect();
    let ring = [[0.84, neck], [0.97, neck + 0.03], [0.84, neck + 0.07]];
    let top = height - 0.18;
    let bell =
        [[0.84, neck + 0.07], [0.94, neck + 0.25], [1.2, top - 0.05], [half_plate / radius, top]];
    for profile in [&torus[..], &hollow, &shaft, &ring, &bell] {
        let scaled: Vec<[f64; 2]> = profile.iter().map(|[share, height]| [share * radius, *height]).collect();
        model.lathe(base, &scaled, segments);
    }
}

fn pier(model: &mut Model, x: f64, storey: &Storey) {
    let upright = |half: f64, from: f64, to: f64| (DVec3::new(x - half, from, -half), DVec3::new(x + half, to, half));
    let base = storey.floor + 0.36;
    let capital = storey.spring - 0.4;
    for (half, from, to) in [
        (0.46, storey.floor, base),
        (0.38, base, capital),
        (0.42, capital, storey.spring - 0.18),
        (0.46, storey.spring - 0.18, storey.spring),
        (0.36, storey.spring, storey.top),
    ] {
        let (low, high) = upright(half, from, to);
        model.block(low, high, 0.45, &[]);
    }
}
