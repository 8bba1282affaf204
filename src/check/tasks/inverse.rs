//! What goes wrong in the inverse of a sampler.

use std::f32::consts::TAU;

use glam::{Vec2, Vec2Swizzles as _};

/// A wrong inverse: what it makes of the right point, and what to say.
type Wrong = (fn(Vec2) -> Vec2, &'static str);

/// Where only one coordinate is concerned it stands first here; either is tried.
const KNOWN: [Wrong; 10] = [
    (|point| point.yx(), "the inverse swaps the two coordinates of the point"),
    (|point| 2.0 * point - 1.0, "the inverse stops at [-1, 1]: move and scale it to [0, 1]"),
    (|point| Vec2::new(1.0 - point.x, point.y), "the inverse mirrors one coordinate (x becomes 1 - x)"),
    (|point| Vec2::ONE - point, "the inverse mirrors both coordinates (p becomes 1 - p)"),
    (
        |point| Vec2::new(point.x.sqrt(), point.y),
        "the inverse returns the radius where its square is meant: the sampler took a square root",
    ),
    (
        |point| Vec2::new(point.x * point.x, point.y),
        "the inverse squares what the sampler has squared already, or the sampler's square root is undone twice",
    ),
    (
        |point| Vec2::new(signed_turn(point.x), point.y),
        "atan2 gives angles from -π to π: add a whole turn to the negative ones",
    ),
    (|point| Vec2::new(TAU * point.x, point.y), "the angle is not divided by 2π: the square wants fractions of a turn"),
    (
        |point| Vec2::new(TAU * signed_turn(point.x), point.y),
        "the angle is not divided by 2π, nor its negative half moved up by a turn",
    ),
    (|point| 0.5 * point + 0.25, "the inverse takes the half extents for the full ones: its result covers a quarter"),
];

/// A fraction of a turn as atan2 has it: from -1/2 to 1/2.
fn signed_turn(turn: f32) -> f32 {
    if turn > 0.5 { turn - 1.0 } else { turn }
}

/// The mistake that explains all pairs of a point and what came back, if one is known.
pub(super) fn mistake(pairs: &[(Vec2, Vec2)]) -> Option<&'static str> {
    let explains = |wrong: fn(Vec2) -> Vec2| {
        pairs.iter().all(|&(point, found)| wrong(point).distance(found) < 2e-3)
            || pairs.iter().all(|&(point, found)| wrong(point.yx()).yx().distance(found) < 2e-3)
    };
    KNOWN.iter().find(|(wrong, _)| explains(*wrong)).map(|(_, hint)| *hint)
}
