//! A binary tree over triangles, built from the top by the surface area heuristic, in which a node is divided either
//! between triangles or in space: Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume Hierarchies" (HPG
//! 2009). A triangle that a plane cuts is in both halves, each time with the box of its part alone: so a large slanted
//! triangle does not fill the boxes of all that is near.

use glam::{Vec3, Vec3A};
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};

use super::{bvh::padded, wide_tree::LANES};

/// Planes that are looked at along an axis, plus one: at most so many, and of few parts fewer.
const BINS: usize = 32;

/// A split in space is looked for where the halves of the best split between triangles share more than this part of the
/// whole tree's area (the paper's alpha).
const LEAST_OVERLAP: f32 = 1e-4;

/// The most parts that splits add, as a share of the triangles.
const MOST_ADDED: f32 = 0.5;

/// From so many parts on the halves of a node are built side by side.
const PARALLEL_FROM: usize = 1024;

/// A triangle, or a part of one.
#[derive(Clone, Copy)]
struct Part {
    bounds: Aabb,
    triangle: u32,
}

enum Subtree {
    Leaf(Part),
    Node(Aabb, Box<[Self; 2]>),
}

/// What lies between two planes.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    /// Parts that begin here, and that end here.
    begun: usize,
    ended: usize,
}

/// A way to divide a node.
#[derive(Clone, Copy)]
struct Split {
    /// By the surface area heuristic, times half the node's area.
    cost: f32,
    axis: usize,
    /// The number of the first bin of the upper half.
    bin: usize,
    bounds: [Aabb; 2],
    counts: [usize; 2],
}

/// The bins of a node along an axis.
#[derive(Clone, Copy)]
struct Axis {
    axis: usize,
    low: f32,
    /// Of a bin.
    width: f32,
    bins: usize,
}

struct Builder<F> {
    corners_of: F,
    /// See [`LEAST_OVERLAP`]; as half of an area.
    least_overlap: f32,
}

/// Builds the tree of the triangles 0, 1, ... `count`; a leaf holds one part of one. The same on any number of threads.
pub(super) fn build(count: u32, corners_of: impl Fn(u32) -> [Vec3; 3] + Sync) -> Bvh2 {
    let whole = |triangle| Part { bounds: Aabb::from_points(&corners_of(triangle).map(Vec3A::from)), triangle };
    let parts: Vec<Part> = (0..count).map(whole).collect();
    if parts.is_empty() {
        return Bvh2::default();
    }
    let added = (MOST_ADDED * count as f32) as usize;
    let least_overlap = LEAST_OVERLAP * bounds_of(&parts).half_area();
    flattened(Builder { corners_of, least_overlap }.subtree(parts, added))
}

impl<F: Fn(u32) -> [Vec3; 3] + Sync> Builder<F> {
    /// The tree of these parts, at least one, with at most `added` more.
    fn subtree(&self, mut parts: Vec<Part>, added: usize) -> Subtree {
        if let [part] = parts[..] {
            return Subtree::Leaf(part);
        }
        let (bounds, before) = (bounds_of(&parts), parts.len());
        let between = split_between(&parts);
        let in_space = between
            .filter(|split| added > 0 && before > LANES && split.overlap() > self.least_overlap)
            .and_then(|between| Some((between, self.split_in_space(&parts, &bounds)?)))
            .filter(|(between, in_space)| in_space.cost < between.cost)
            .and_then(|(_, in_space)| self.halves_in_space(&parts, &bounds, &in_space))
            .filter(|[low, high]| low.len().max(high.len()) < before && low.len() + high.len() <= before + added);
        let [low, high] = in_space.unwrap_or_else(|| match between {
            Some(split) => {
                let axis = Axis::of_centres(&parts, split.axis);
                let (low, high) = parts.into_iter().partition(|part| axis.bin(part.centre(split.axis)) < split.bin);
                [low, high]
            }
            // All of one centre.
            None => {
                let high = parts.split_off(before / 2);
                [parts, high]
            }
        });
        let added = added - (low.len() + high.len() - before);
        let to_low = added * low.len() / (low.len() + high.len());
        let halves = if before < PARALLEL_FROM {
            [self.subtree(low, to_low), self.subtree(high, added - to_low)]
        } else {
            rayon::join(|| self.subtree(low, to_low), || self.subtree(high, added - to_low)).into()
        };
        Subtree::Node(bounds, Box::new(halves))
    }

    /// The best plane, parts that it cuts being in both halves.
    fn split_in_space(&self, parts: &[Part], bounds: &Aabb) -> Option<Split> {
        let along = |axis| {
            let bins_of = Axis::over(bounds.min[axis], bounds.max[axis], axis, BINS)?;
            let mut bins = [Bin::EMPTY; BINS];
            for part in parts {
                let first = bins_of.bin(part.bounds.min[axis]);
                let last = bins_of.bin(part.bounds.max[axis]).max(first);
                bins[first].begun += 1;
                bins[last].ended += 1;
                let mut rest = Some(*part);
                for (bin, into) in bins.iter_mut().enumerate().take(last).skip(first) {
                    let Some(part) = rest else { break };
                    let [low, high] = self.cut(&part, axis, bins_of.plane(bin + 1));
                    into.add(low);
                    rest = high;
                }
                bins[last].add(rest);
            }
            best_split(&bins_of, &bins)
        };
        cheapest((0..3).filter_map(along))
    }

    /// The parts below and above a plane. One that is cut stays whole where that is cheaper (the paper's section 4.4).
    fn halves_in_space(&self, parts: &[Part], bounds: &Aabb, split: &Split) -> Option<[Vec<Part>; 2]> {
        let Split { axis, bounds: mut sides, mut counts, .. } = *split;
        let plane = Axis::over(bounds.min[axis], bounds.max[axis], axis, BINS)?.plane(split.bin);
        let mut halves = [Vec::with_capacity(counts[0]), Vec::with_capacity(counts[1])];
        for part in parts {
            if part.bounds.max[axis] <= plane {
                halves[0].push(*part);
                continue;
            }
            if part.bounds.min[axis] >= plane {
                halves[1].push(*part);
                continue;
            }
            let cut = self.cut(part, axis, plane);
            let [Some(low), Some(high)] = cut else {
                halves[usize::from(cut[0].is_none())].push(*part);
                continue;
            };
            let whole = [0, 1].map(|side| {
                let (mut sides, mut counts) = (sides, counts);
                sides[side] = sides[side].union(&part.bounds);
                counts[1 - side] = counts[1 - side].saturating_sub(1);
                (cost(&sides, counts), side, sides, counts)
            });
            let cheaper = if whole[1].0 < whole[0].0 { whole[1] } else { whole[0] };
            if cheaper.0 < cost(&sides, counts) {
                (sides, counts) = (cheaper.2, cheaper.3);
                halves[cheaper.1].push(*part);
            } else {
                halves[0].push(low);
                halves[1].push(high);
            }
        }
        Some(halves)
    }

    /// The parts of a part below and above a plane.
    fn cut(&self, part: &Part, axis: usize, plane: f32) -> [Option<Part>; 2] {
        let corners = (self.corners_of)(part.triangle).map(|corner| (corner[axis], Vec3A::from(corner)));
        let (mut low, mut high) = (Aabb::INVALID, Aabb::INVALID);
        for (index, &(from_at, from)) in corners.iter().enumerate() {
            let (to_at, to) = corners[(index + 1) % 3];
            if from_at <= plane {
                low.extend(from);
            }
            if from_at >= plane {
                high.extend(from);
            }
            if (from_at < plane) != (to_at < plane) {
                let crossing = from + (to - from) * ((plane - from_at) / (to_at - from_at));
                low.extend(crossing);
                high.extend(crossing);
            }
        }
        low.max[axis] = low.max[axis].min(plane);
        high.min[axis] = high.min[axis].max(plane);
        [low, high].map(|side| {
            let bounds = side.intersection(&part.bounds);
            bounds.min.cmple(bounds.max).all().then_some(Part { bounds, ..*part })
        })
    }
}

impl Part {
    fn centre(&self, axis: usize) -> f32 {
        0.5 * self.bounds.min[axis] + 0.5 * self.bounds.max[axis]
    }
}

impl Bin {
    const EMPTY: Self = Self { bounds: Aabb::INVALID, begun: 0, ended: 0 };

    fn add(&mut self, part: Option<Part>) {
        self.bounds = part.map_or(self.bounds, |part| self.bounds.union(&part.bounds));
    }
}

impl Split {
    /// Half the area that both sides share.
    fn overlap(&self) -> f32 {
        let shared = self.bounds[0].intersection(&self.bounds[1]);
        if shared.min.cmple(shared.max).all() { shared.half_area() } else { 0.0 }
    }
}

impl Axis {
    /// None where there is nothing to divide.
    fn over(low: f32, high: f32, axis: usize, bins: usize) -> Option<Self> {
        let width = (high - low) / bins as f32;
        (width > 0.0 && width.is_finite()).then_some(Self { axis, low, width, bins })
    }

    fn of_centres(parts: &[Part], axis: usize) -> Self {
        let centres = parts.iter().map(|part| part.centre(axis));
        let (low, high) = centres.fold((f32::MAX, f32::MIN), |(low, high), at| (low.min(at), high.max(at)));
        Self::over(low, high, axis, BINS.min(2 * parts.len())).unwrap_or(Self {
            axis,
            low,
            width: f32::INFINITY,
            bins: 1,
        })
    }

    fn bin(&self, place: f32) -> usize {
        (((place - self.low) / self.width) as usize).min(self.bins - 1)
    }

    fn plane(&self, bin: usize) -> f32 {
        self.low + self.width * bin as f32
    }
}

/// The best way to divide the parts without cutting any, by their centres.
fn split_between(parts: &[Part]) -> Option<Split> {
    let along = |axis| {
        let bins_of = Axis::of_centres(parts, axis);
        let mut bins = [Bin::EMPTY; BINS];
        for part in parts {
            let bin = &mut bins[bins_of.bin(part.centre(axis))];
            bin.add(Some(*part));
            bin.begun += 1;
            bin.ended += 1;
        }
        best_split(&bins_of, &bins)
    };
    cheapest((0..3).filter_map(along))
}

fn cheapest(splits: impl Iterator<Item = Split>) -> Option<Split> {
    splits.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn best_split(bins_of: &Axis, bins: &[Bin; BINS]) -> Option<Split> {
    let mut above = [(Aabb::INVALID, 0); BINS];
    let mut high = (Aabb::INVALID, 0);
    for bin in (1..bins_of.bins).rev() {
        high = (high.0.union(&bins[bin].bounds), high.1 + bins[bin].ended);
        above[bin] = high;
    }
    let mut low = (Aabb::INVALID, 0);
    cheapest((1..bins_of.bins).filter_map(|bin| {
        low = (low.0.union(&bins[bin - 1].bounds), low.1 + bins[bin - 1].begun);
        let (low, high) = (low, above[bin]);
        let cost = cost(&[low.0, high.0], [low.1, high.1]);
        let split = Split { cost, axis: bins_of.axis, bin, bounds: [low.0, high.0], counts: [low.1, high.1] };
        (low.1 > 0 && high.1 > 0).then_some(split)
    }))
}

fn cost(sides: &[Aabb; 2], counts: [usize; 2]) -> f32 {
    sides[0].half_area() * counts[0] as f32 + sides[1].half_area() * counts[1] as f32
}

fn bounds_of(parts: &[Part]) -> Aabb {
    parts.iter().fold(Aabb::INVALID, |bounds, part| bounds.union(&part.bounds))
}

fn flattened(root: Subtree) -> Bvh2 {
    let mut tree = Bvh2 { nodes: vec![Bvh2Node::default()], uses_spatial_splits: true, ..Bvh2::default() };
    let mut open = vec![(0, root)];
    while let Some((index, subtree)) = open.pop() {
        tree.nodes[index] = match subtree {
            Subtree::Leaf(Part { bounds, triangle }) => {
                tree.primitive_indices.push(triangle);
                Bvh2Node::new(padded(bounds), 1, tree.primitive_indices.len() as u32 - 1)
            }
            Subtree::Node(bounds, halves) => {
                let first = tree.nodes.len();
                tree.nodes.extend([Bvh2Node::default(); 2]);
                open.extend(halves.into_iter().enumerate().map(|(half, subtree)| (first + half, subtree)));
                Bvh2Node::new(padded(bounds), 0, first as u32)
            }
        };
    }
    tree
}

#[cfg(test)]
mod tests {
    use glam::Vec2;
    use rand::{RngExt, SeedableRng, rngs::SmallRng};

    use super::*;

    /// Large slanted triangles, needles, and small triangles among them.
    fn soup(count: usize) -> Vec<[Vec3; 3]> {
        let mut generator = SmallRng::seed_from_u64(3);
        let mut place = move || 2.0 * Vec3::from_array(generator.random()) - 1.0;
        let triangle = |index| {
            let (a, b, c) = (place(), place(), place());
            match index % 4 {
                0 => [a, b, c],
                1 => [a, b, a + 1e-5 * c],
                _ => [a, a + 0.05 * b, a + 0.05 * c],
            }
        };
        (0..count).map(triangle).collect()
    }

    #[test]
    fn every_point_of_every_triangle_lies_in_a_leaf_of_it_and_in_all_boxes_above() {
        let triangles = soup(2000);
        let tree = build(triangles.len() as u32, |triangle| triangles[triangle as usize]);
        let parts = tree.primitive_indices.len();
        // Without splits there are 2000; the cap is on the safe side of what this soup wants.
        assert!(parts > 2200 && parts <= 3000, "{parts} parts");
        let mut generator = SmallRng::seed_from_u64(4);
        for (index, [a, b, c]) in triangles.iter().enumerate() {
            for _ in 0..20 {
                let mut place = Vec2::from_array(generator.random());
                if place.element_sum() > 1.0 {
                    place = 1.0 - place;
                }
                let point = Vec3A::from(a + (b - a) * place.x + (c - a) * place.y);
                assert!(leads_to(&tree, 0, point, index as u32), "{point} of triangle {index}");
            }
        }
    }

    fn leads_to(tree: &Bvh2, node: u32, point: Vec3A, triangle: u32) -> bool {
        let node = &tree.nodes[node as usize];
        let is_inside = node.aabb().min.cmple(point).all() && point.cmple(node.aabb().max).all();
        is_inside
            && match node.is_leaf() {
                true => tree.primitive_indices[node.first_index as usize] == triangle,
                false => (0..2).any(|half| leads_to(tree, node.first_index + half, point, triangle)),
            }
    }

    #[test]
    fn triangles_that_all_lie_in_one_place_are_divided_in_halves() {
        let tree = build(5000, |_| [Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert_eq!(tree.primitive_indices.len(), 5000);
        let mut deepest = vec![(0, 1)];
        let mut depth = 0;
        while let Some((node, at)) = deepest.pop() {
            depth = depth.max(at);
            let node = &tree.nodes[node as usize];
            if !node.is_leaf() {
                deepest.extend([(node.first_index, at + 1), (node.first_index + 1, at + 1)]);
            }
        }
        assert_eq!(depth, 14); // 2^13 > 5000
    }
}
