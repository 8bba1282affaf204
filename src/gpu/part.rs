//! A picture in parts, for a geometry that takes a driver too long to draw at once.

use std::ops::Range;

/// So many triangles or edges take a driver on the processor some 30 milliseconds.
const LARGEST: u32 = 100_000;

/// What is drawn in one frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) triangles: Range<u32>,
    /// Of the wireframe.
    pub(super) edges: Range<u32>,
    pub(super) is_first: bool,
    pub(super) is_last: bool,
}

impl Part {
    /// Everything at once.
    pub(super) fn whole(triangles: u32, edges: u32) -> Self {
        Self { triangles: 0..triangles, edges: 0..edges, is_first: true, is_last: true }
    }

    /// Part `number` of these triangles and, after them, edges.
    pub(super) fn numbered(number: u32, triangles: u32, edges: u32) -> Self {
        let part = |all: u32, start: u32| start.min(all)..start.saturating_add(LARGEST).min(all);
        let start = number.saturating_mul(LARGEST);
        let (of_triangles, of_edges) = (triangles.div_ceil(LARGEST), edges.div_ceil(LARGEST));
        let after = number.checked_sub(of_triangles).map(|number| number * LARGEST);
        Self {
            triangles: part(triangles, start),
            edges: after.map_or(0..0, |start| part(edges, start)),
            is_first: number == 0,
            is_last: number + 1 >= of_triangles + of_edges,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_picture_hold_every_triangle_and_then_every_edge_once() {
        for (triangles, edges) in [(1, 0), (100_000, 0), (250_001, 0), (250_000, 350_000), (300_000, 100_001)] {
            let mut parts = vec![Part::numbered(0, triangles, edges)];
            while !parts[parts.len() - 1].is_last {
                parts.push(Part::numbered(parts.len() as u32, triangles, edges));
            }
            assert!(parts.iter().enumerate().all(|(number, part)| part.is_first == (number == 0)));
            for (of_part, all) in [
                ((|part| part.triangles.clone()) as fn(&Part) -> Range<u32>, triangles),
                (|part| part.edges.clone(), edges),
            ] {
                let drawn: Vec<u32> = parts.iter().flat_map(of_part).collect();
                assert!(
                    drawn.iter().copied().eq(0..all),
                    "{triangles} triangles, {edges} edges: {} drawn",
                    drawn.len()
                );
            }
            let first_edges = parts.iter().position(|part| !part.edges.is_empty()).unwrap_or(parts.len());
            assert!(
                parts[first_edges..].iter().all(|part| part.triangles.is_empty()),
                "edges hide behind all triangles"
            );
        }
    }
}
