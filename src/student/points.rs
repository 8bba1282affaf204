//! Extra: sample points that are spread better than by chance.

use glam::Vec2;

/// Point `index` of a stratified set of `count`: the unit square is cut into `count` cells of equal area, and cell
/// `index` gets one point, at `jitter` (in [0, 1)²) of the cell. The result lies in [0, 1)².
///
/// Any `count` must do; for a square number the cells are the squares of a grid.
///
/// Placeholder while not done: `jitter`, a random point. Tests: `radiosity check`, task `stratified`. The solver calls
/// it for `--sampler stratified`.
///
/// Hint: full rows of ⌊√count⌋ cells, and a last row of what is left, as high as its share. Divide as numbers with a
/// fraction.
pub fn stratified_point(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    // <answer>
    let columns = count.isqrt().max(1);
    let (row, column) = (index / columns, index % columns);
    let in_row = columns.min(count - row * columns);
    let x = (column as f32 + jitter.x) / in_row as f32;
    let y = ((row * columns) as f32 + in_row as f32 * jitter.y) / count as f32;
    Vec2::new(x, y).min(Vec2::splat(1.0 - f32::EPSILON))
    // </answer> (super::PLACEHOLDERS.stratified_point)(index, count, jitter)
}

/// Point `index` of a sequence of low discrepancy in [0, 1)²: every start of the sequence is spread evenly, without
/// knowing how many points there will be. The same for every vertex; the program shifts it.
///
/// Placeholder while not done: (1/2, 1/2). Tests: `radiosity check`, task `qmc`. Once written, the solver calls it for
/// `--sampler sobol`.
///
/// Method: Halton 1960, "On the efficiency of certain quasi-random sequences": radical inverses in bases 2 and 3. Any
/// sequence that is as even passes.
///
/// Hint: the radical inverse mirrors the digits of `index` at the point: in base 2, 6 = 110 becomes 0.011 = 3/8.
pub fn low_discrepancy_point(index: u32) -> Vec2 {
    // <answer>
    Vec2::new(radical_inverse(2, index), radical_inverse(3, index))
    // </answer> (super::PLACEHOLDERS.low_discrepancy_point)(index)
}

// <answer>
/// The digits of `index` in `base`, mirrored at the point.
fn radical_inverse(base: u32, mut index: u32) -> f32 {
    let (mut inverse, mut scale) = (0.0_f64, 1.0 / f64::from(base));
    while index > 0 {
        inverse += f64::from(index % base) * scale;
        index /= base;
        scale /= f64::from(base);
    }
    (inverse as f32).min(1.0 - f32::EPSILON)
}
// </answer>
