//! Which part of a triangle lies in which texel: exact areas and centroids, by clipping.
//!
//! The triangle is cut into the rows of the map and each row into texels (Sutherland and Hodgman 1974, "Reentrant
//! Polygon Clipping"), so that texels which a triangle only touches count with what they hold of it, and the parts of
//! a triangle add up to the whole.

use glam::{DVec2, Vec2};

/// The part of a triangle that lies in one texel.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Column and row of the texel.
    pub texel: [u32; 2],
    /// The part's share of the triangle's area, in (0, 1].
    pub share: f64,
    /// Centroid of the part, in barycentric coordinates (u, v) of the triangle.
    pub centroid: Vec2,
    /// Corners of the part, in texels.
    pub outline: Vec<DVec2>,
}

impl Piece {
    /// The whole texel in its place, if the triangle covers its middle.
    pub fn whole_texel(self, triangle: &TexelTriangle) -> Option<Self> {
        let middle = DVec2::new(f64::from(self.texel[0]), f64::from(self.texel[1])) + 0.5;
        let centroid = triangle.barycentric(middle);
        triangle.contains(middle).then(|| Self { share: 1.0 / triangle.area(), centroid, ..self })
    }
}

/// A triangle in texels, with the way back to its barycentric coordinates.
#[derive(Clone, Copy, Debug)]
pub struct TexelTriangle {
    corners: [DVec2; 3],
    /// Twice the signed area.
    determinant: f64,
}

impl TexelTriangle {
    /// The triangle with these corners, in texels; `None` without area, or with a corner that is not finite.
    pub fn new(corners: [Vec2; 3]) -> Option<Self> {
        let corners = corners.map(|corner| corner.as_dvec2());
        let [a, b, c] = corners;
        let determinant = (b - a).perp_dot(c - a);
        (determinant != 0.0 && determinant.is_finite()).then_some(Self { corners, determinant })
    }

    /// Area in texels.
    pub fn area(&self) -> f64 {
        0.5 * self.determinant.abs()
    }

    /// Barycentric coordinates (u, v) of a point.
    pub fn barycentric(&self, point: DVec2) -> Vec2 {
        let [a, b, c] = self.corners;
        let offset = point - a;
        let u = offset.perp_dot(c - a) / self.determinant;
        let v = (b - a).perp_dot(offset) / self.determinant;
        let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
        let sum = (u + v).max(1.0);
        DVec2::new(u / sum, v / sum).as_vec2()
    }

    /// True for a point of the triangle, edges included.
    pub fn contains(&self, point: DVec2) -> bool {
        let [a, b, c] = self.corners;
        let sides = [(a, b), (b, c), (c, a)];
        sides.into_iter().all(|(from, to)| (to - from).perp_dot(point - from) * self.determinant >= 0.0)
    }

    /// Change of the barycentric coordinates from one texel to the next, along the columns and along the rows.
    pub fn barycentric_steps(&self) -> [Vec2; 2] {
        let [a, b, c] = self.corners;
        let step = |axis: DVec2| DVec2::new(axis.perp_dot(c - a), (b - a).perp_dot(axis)) / self.determinant;
        [step(DVec2::X).as_vec2(), step(DVec2::Y).as_vec2()]
    }

    /// Visits the parts of the triangle, row by row. Parts outside of `width` times `height` texels are left out.
    pub fn for_each_piece(&self, [width, height]: [u32; 2], mut visit: impl FnMut(Piece)) {
        let range = |low: f64, high: f64, size: u32| {
            let first = low.floor().clamp(0.0, f64::from(size)) as u32;
            first..high.ceil().clamp(0.0, f64::from(size)) as u32
        };
        let bounds = |points: &[DVec2], axis: fn(&DVec2) -> f64| {
            points.iter().map(axis).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let (low, high) = bounds(&self.corners, |point| point.y);
        for row in range(low, high, height) {
            let strip = between(&self.corners, DVec2::Y, f64::from(row));
            let (low, high) = bounds(&strip, |point| point.x);
            for column in range(low, high, width) {
                let outline = between(&strip, DVec2::X, f64::from(column));
                let (area, centroid) = area_and_centroid(&outline);
                let share = area / self.determinant * 2.0;
                if share > 0.0 {
                    visit(Piece { texel: [column, row], share, centroid: self.barycentric(centroid), outline });
                }
            }
        }
    }
}

/// The part of a convex polygon with coordinates from `low` to `low + 1` along an axis.
fn between(polygon: &[DVec2], axis: DVec2, low: f64) -> Vec<DVec2> {
    clipped(&clipped(polygon, axis, low), -axis, -(low + 1.0))
}

/// The part of a convex polygon where `normal · point >= limit`.
fn clipped(polygon: &[DVec2], normal: DVec2, limit: f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, &point) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let (here, there) = (normal.dot(point) - limit, normal.dot(next) - limit);
        if here >= 0.0 {
            kept.push(point);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(point.lerp(next, here / (here - there)));
        }
    }
    kept
}

/// Signed area and centroid of a polygon; the mean of its corners where it has no area.
fn area_and_centroid(polygon: &[DVec2]) -> (f64, DVec2) {
    let Some(&origin) = polygon.first() else {
        return (0.0, DVec2::ZERO);
    };
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for corners in polygon.windows(2) {
        let (from, to) = (corners[0] - origin, corners[1] - origin);
        let part = 0.5 * from.perp_dot(to);
        area += part;
        moment += part * (from + to) / 3.0;
    }
    (area, if area == 0.0 { origin } else { origin + moment / area })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    fn pieces(corners: [Vec2; 3], size: [u32; 2]) -> Vec<Piece> {
        let mut pieces = Vec::new();
        TexelTriangle::new(corners).unwrap().for_each_piece(size, |piece| pieces.push(piece));
        pieces
    }

    #[test]
    fn half_a_square_of_two_texels_has_the_areas_and_centroids_worked_out_by_hand() {
        // Three texels: one whole, two halves. The triangle's area is 2 texels.
        let found = pieces([Vec2::ZERO, Vec2::new(2.0, 0.0), Vec2::new(0.0, 2.0)], [2, 2]);
        let seen: Vec<_> = found.iter().map(|piece| (piece.texel, piece.share)).collect();
        assert_eq!(seen, [([0, 0], 0.5), ([1, 0], 0.25), ([0, 1], 0.25)]);
        // A whole texel's centroid is its middle (0.5, 0.5) = barycentric (1/4, 1/4); the half in column 1 has its at
        // (1 + 1/3, 1/3) = (2/3, 1/6).
        assert!(found[0].centroid.abs_diff_eq(Vec2::splat(0.25), 1e-7));
        assert!(found[1].centroid.abs_diff_eq(Vec2::new(2.0 / 3.0, 1.0 / 6.0), 1e-6));
    }

    #[test]
    fn the_parts_of_any_triangle_add_up_to_it_whichever_way_it_turns() {
        let corners = [Vec2::new(0.3, 7.9), Vec2::new(12.7, 0.2), Vec2::new(5.1, 14.6)];
        for corners in [corners, [corners[1], corners[0], corners[2]]] {
            let found = pieces(corners, [16, 16]);
            let total: f64 = found.iter().map(|piece| piece.share).sum();
            assert!((total - 1.0).abs() < 1e-12, "{total}");
            // The weighted mean of the centroids is the triangle's own.
            let mean: DVec2 = found.iter().map(|piece| piece.share * piece.centroid.as_dvec2()).sum();
            assert!(mean.abs_diff_eq(DVec2::splat(1.0 / 3.0), 1e-6), "{mean}");
        }
    }

    #[test]
    fn a_sliver_that_passes_between_all_texel_centres_is_found() {
        let found = pieces([Vec2::new(0.0, 1.01), Vec2::new(9.0, 1.02), Vec2::new(9.0, 1.03)], [9, 9]);
        assert_eq!(found.len(), 9);
        assert!((found.iter().map(|piece| piece.share).sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn without_coverage_texels_count_whole_where_their_middle_lies_inside() {
        // Of the half square of two texels a side, one middle lies inside and two on the edge: three whole texels of one
        // each, where the triangle has an area of two.
        let corners = [Vec2::ZERO, Vec2::new(2.0, 0.0), Vec2::new(0.0, 2.0)];
        let triangle = TexelTriangle::new(corners).unwrap();
        let whole: Vec<Piece> =
            pieces(corners, [2, 2]).into_iter().filter_map(|piece| piece.whole_texel(&triangle)).collect();
        assert_eq!(whole.iter().map(|piece| piece.texel).collect::<Vec<_>>(), [[0, 0], [1, 0], [0, 1]]);
        assert!(whole.iter().all(|piece| piece.share * triangle.area() == 1.0));
        // A sliver between all middles has none.
        let sliver = [Vec2::new(0.0, 1.01), Vec2::new(9.0, 1.02), Vec2::new(9.0, 1.03)];
        let triangle = TexelTriangle::new(sliver).unwrap();
        assert!(pieces(sliver, [9, 9]).into_iter().all(|piece| piece.whole_texel(&triangle).is_none()));
    }

    #[test]
    fn triangles_without_area_have_no_parts() {
        assert!(TexelTriangle::new([Vec2::ZERO, Vec2::ONE, Vec2::splat(2.0)]).is_none());
        assert!(TexelTriangle::new([Vec2::ZERO, Vec2::new(f32::NAN, 1.0), Vec2::X]).is_none());
    }
}
