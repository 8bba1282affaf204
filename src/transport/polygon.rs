//! Convex polygons around a point at the origin, in f64: clipping, and Lambert's formula (eq. 6).

use glam::{DVec3, Vec3};

/// A convex polygon; fewer than 3 corners are none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    corners: [DVec3; Polygon::MOST_CORNERS],
    count: usize,
}

impl Polygon {
    /// Corners that fit; a corner more is left out, which cuts off a sliver.
    const MOST_CORNERS: usize = 16;

    pub(super) const NONE: Self = Self { corners: [DVec3::ZERO; Self::MOST_CORNERS], count: 0 };

    /// The polygon with these corners, seen from `origin`. Differences of f32 are exact in f64.
    pub(super) fn seen_from(origin: Vec3, corners: &[Vec3]) -> Self {
        let mut polygon = Self::NONE;
        corners.iter().for_each(|corner| polygon.push(corner.as_dvec3() - origin.as_dvec3()));
        polygon
    }

    pub(super) fn new(corners: impl IntoIterator<Item = DVec3>) -> Self {
        let mut polygon = Self::NONE;
        corners.into_iter().for_each(|corner| polygon.push(corner));
        polygon
    }

    /// True if the next cut may not find room for all corners.
    pub(super) fn is_full(&self) -> bool {
        self.count == Self::MOST_CORNERS
    }

    fn push(&mut self, corner: DVec3) {
        if self.count < Self::MOST_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count < 3
    }

    /// Each edge's ends.
    pub(super) fn edges(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        let corners = self.corners();
        (0..corners.len()).map(|index| (corners[index], corners[(index + 1) % corners.len()]))
    }

    /// The parts with `normal · p >= offset` and `normal · p <= offset` (Sutherland and Hodgman 1974).
    pub(super) fn split(&self, normal: DVec3, offset: f64) -> (Self, Self) {
        let (mut above, mut below) = (Self::NONE, Self::NONE);
        self.split_into(normal, offset, &mut above, &mut below);
        (above, below)
    }

    /// The same into polygons that are there: a polygon is large, and to move it costs more than to split it.
    fn split_into(&self, normal: DVec3, offset: f64, above: &mut Self, below: &mut Self) {
        (above.count, below.count) = (0, 0);
        for (start, end) in self.edges() {
            let (from, to) = (normal.dot(start) - offset, normal.dot(end) - offset);
            if from >= 0.0 {
                above.push(start);
            }
            if from <= 0.0 {
                below.push(start);
            }
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                let crossing = start.lerp(end, from / (from - to));
                above.push(crossing);
                below.push(crossing);
            }
        }
    }

    /// Irradiance [W/m²] at the origin on a surface of unit normal `normal` from this polygon at radiance 1, the
    /// polygon lying above the horizon, its corners counter-clockwise as they are seen from there (eq. 6).
    pub(super) fn irradiance(&self, normal: DVec3) -> f64 {
        let mut sum = 0.0;
        for (start, end) in self.edges() {
            let across = end.cross(start);
            let length = across.length();
            if length > 0.0 {
                sum += length.atan2(start.dot(end)) * across.dot(normal) / length;
            }
        }
        (0.5 * sum).clamp(0.0, std::f64::consts::PI)
    }
}

/// The form factor from a small surface at `origin`, of unit normal `normal`, to a polygon that nothing hides (eq. 6).
/// `corners` are counter-clockwise as the polygon's front is seen; from behind it is 0.
#[cfg(feature = "reference")]
pub fn polygon_form_factor(origin: Vec3, normal: Vec3, corners: &[Vec3]) -> f64 {
    let normal = normal.as_dvec3();
    Polygon::seen_from(origin, corners).split(normal, 0.0).0.irradiance(normal) / std::f64::consts::PI
}

/// An edge that is seen under a smaller angle than this is rounding, and has no direction.
const SHORTEST: f64 = 1e-9;

/// Inward normals of the planes through the origin and each edge.
fn sides_of(polygon: &Polygon) -> ([DVec3; Polygon::MOST_CORNERS], usize) {
    let middle = polygon.corners().iter().sum::<DVec3>();
    let mut sides = [DVec3::ZERO; Polygon::MOST_CORNERS];
    let mut count = 0;
    for (start, end) in polygon.edges() {
        let normal = start.cross(end);
        if normal.length_squared() > SHORTEST * SHORTEST * start.length_squared() * end.length_squared() {
            sides[count] = if normal.dot(middle) < 0.0 { -normal } else { normal };
            count += 1;
        }
    }
    (sides, count)
}

/// Takes what lies behind the convex `occluder`, as it is seen from the origin, out of each of the convex `pieces`, but
/// for what lies behind `but`, a convex part of it.
pub(super) fn subtract_but(pieces: &mut Vec<Polygon>, occluder: &Polygon, but: &Polygon, spare: &mut Vec<Polygon>) {
    let (sides, count) = sides_of(but);
    let behind = |piece: &Polygon| sides[..count].iter().fold(*piece, |piece, &side| piece.split(side, 0.0).0);
    let kept: Vec<Polygon> =
        pieces.iter().filter(|_| count >= 3).map(behind).filter(|piece| !piece.is_empty()).collect();
    subtract(pieces, occluder, spare);
    pieces.extend(kept);
}

/// Takes what lies behind the convex `occluder`, as it is seen from the origin, out of each of the convex `pieces`.
pub(super) fn subtract(pieces: &mut Vec<Polygon>, occluder: &Polygon, spare: &mut Vec<Polygon>) {
    let (sides, side_count) = sides_of(occluder);
    let sides = &sides[..side_count];
    spare.clear();
    let [mut inside, mut outside] = [Polygon::NONE; 2];
    for piece in pieces.iter() {
        let lies_aside = |side: &DVec3| piece.corners().iter().all(|corner| side.dot(*corner) <= 0.0);
        if side_count < 3 || sides.iter().any(lies_aside) {
            spare.push(*piece);
            continue;
        }
        let start = spare.len();
        let mut rest = *piece;
        for &inwards in sides {
            rest.split_into(inwards, 0.0, &mut inside, &mut outside);
            if !outside.is_empty() {
                spare.push(outside);
            }
            std::mem::swap(&mut rest, &mut inside);
            if rest.is_empty() {
                break;
            }
        }
        if rest.is_empty() {
            // Not covered at all: the piece stays whole.
            spare.truncate(start);
            spare.push(*piece);
        }
    }
    std::mem::swap(pieces, spare);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f64, height: f64) -> Polygon {
        let mut polygon = Polygon::NONE;
        // Counter-clockwise seen from below, where the origin is.
        for (x, z) in [(-half, -half), (half, -half), (half, half), (-half, half)] {
            polygon.push(DVec3::new(x, height, z));
        }
        polygon
    }

    #[test]
    fn a_square_overhead_has_the_closed_form_of_a_disk_that_grows_to_a_hemisphere() {
        assert!((square(1e6, 1.0).irradiance(DVec3::Y) - std::f64::consts::PI).abs() < 1e-5);
        // Far off: the solid angle is nearly area over distance squared.
        let small = square(0.005, 1.0).irradiance(DVec3::Y);
        assert!((small / 1e-4 - 1.0).abs() < 1e-3, "{small}");
    }

    #[test]
    fn what_lies_behind_an_occluder_is_taken_out_once() {
        let light = square(1.0, 2.0);
        let whole = light.irradiance(DVec3::Y);
        // At half the height, a square of half the size covers the light exactly.
        for (half, part) in [(0.5, 0.0), (0.25, 1.0 - square(0.5, 2.0).irradiance(DVec3::Y) / whole), (5.0, 0.0)] {
            let mut pieces = vec![light];
            let mut spare = Vec::new();
            for _ in 0..2 {
                subtract(&mut pieces, &square(half, 1.0), &mut spare);
            }
            let left: f64 = pieces.iter().map(|piece| piece.irradiance(DVec3::Y)).sum();
            assert!((left / whole - part).abs() < 1e-9, "{half}: {left} of {whole}");
        }
    }

    #[test]
    fn an_occluder_beside_leaves_the_piece_whole() {
        let mut aside = Polygon::NONE;
        for (x, z) in [(3.0, 0.0), (4.0, 0.0), (4.0, 1.0)] {
            aside.push(DVec3::new(x, 1.0, z));
        }
        let mut pieces = vec![square(1.0, 2.0)];
        subtract(&mut pieces, &aside, &mut Vec::new());
        assert_eq!(pieces.len(), 1);
        assert_eq!(pieces[0].corners(), square(1.0, 2.0).corners());
    }
}
