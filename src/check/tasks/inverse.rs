//! What goes wrong in the inverse of a sampler.

use glam::{Vec2, Vec2Swizzles as _};

/// A wrong inverse: what it makes of the right point, and what to say.
type Wrong = (fn(Vec2) -> Vec2, &'static str);

const KNOWN: [Wrong; 8] = [
    (|point| point.yx(), "the inverse swaps the two coordinates of the point"),
    (|point| 2.0 * point - 1.0, "the inverse stops at [-1, 1]: move and scale it to [0, 1]"),
    (|point| Vec2::new(1.0 - point.x, point.y), "the inverse mirrors the first coordinate (x becomes 1 - x)"),
    (|point| Vec2::new(point.x, 1.0 - point.y), "the inverse mirrors the second coordinate (y becomes 1 - y)"),
    (|point| Vec2::ONE - point, "the inverse mirrors both coordinates (p becomes 1 - p)"),
    (
        |point| Vec2::new(point.x, point.y.sqrt()),
        "the inverse returns the radius where its square is meant: the sampler took a square root",
    ),
    (
        |point| Vec2::new(if point.x > 0.5 { point.x - 1.0 } else { point.x }, point.y),
        "atan2 gives angles from -π to π: add a whole turn to the negative ones",
    ),
    (|point| 0.5 * point + 0.25, "the inverse takes the half extents for the full ones: its result covers a quarter"),
];

/// The mistake that explains all pairs of a point and what came back, if one is known.
pub(super) fn mistake(pairs: &[(Vec2, Vec2)]) -> Option<&'static str> {
    let explains = |wrong: fn(Vec2) -> Vec2| pairs.iter().all(|&(point, found)| wrong(point).distance(found) < 2e-3);
    KNOWN.iter().find(|(wrong, _)| explains(*wrong)).map(|(_, hint)| *hint)
}
