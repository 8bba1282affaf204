//! Rays through the tree: all boxes of a node, and all triangles of a block, at once.
//!
//! Compiled for each instruction set that has vectors, and chosen when the program runs (crate fearless_simd): that is
//! why functions here are generic over `Simd` and always inlined, closures too.

use fearless_simd::{f32x4, f32x16, mask32x16, prelude::*, u32x16};
use glam::Vec2;

use super::{
    Hit, Ray,
    triangle::ShearedLanes,
    wide_tree::{Block, IS_BLOCK, NO_CHILD, WIDTH, WideNode, WideTree},
};

/// A ray for box tests.
///
/// A side of a box is met at side × inverse - start, in one rounding. What that and the triangle test round off is covered
/// twice: boxes are padded in proportion to their own coordinates, and here they are widened in proportion to the origin's.
struct BoxRay<S: Simd> {
    inverse: [f32x16<S>; 3],
    /// (origin ± its rounding) / direction, for the side that is met first, and for the one that is met last.
    starts: [[f32x16<S>; 3]; 2],
    /// By axis: 1 if the higher side is met first.
    first_sides: [usize; 3],
}

impl<S: Simd> BoxRay<S> {
    #[inline(always)]
    fn new(simd: S, [origin, direction]: [f32x4<S>; 2]) -> Self {
        const LEAST_COMPONENT: f32 = 1e-12;
        const ROUNDING: f32 = 4.0 * f32::EPSILON;
        // With a component of 0 the difference of two infinities would arise; so little of one meets the same boxes.
        let is_small = direction.abs().simd_lt(f32x4::splat(simd, LEAST_COMPONENT));
        let least = f32x4::splat(simd, LEAST_COMPONENT).copysign(direction);
        let inverse = f32x4::splat(simd, 1.0) / is_small.select(least, direction);
        let widening = (origin.abs() * ROUNDING).copysign(direction);
        let (first, last) = ((origin + widening) * inverse, (origin - widening) * inverse);
        let downwards = inverse.simd_lt(f32x4::splat(simd, 0.0)).to_bitmask() as usize;
        Self {
            inverse: splat(simd, inverse),
            starts: [splat(simd, first), splat(simd, last)],
            first_sides: [downwards & 1, downwards >> 1 & 1, downwards >> 2 & 1],
        }
    }

    /// The distance at which each child's box is entered, 0 if the ray starts inside, and the set of those that it enters
    /// before `reach`.
    #[inline(always)]
    fn entered(&self, simd: S, node: &WideNode, reach: f32) -> (f32x16<S>, mask32x16<S>) {
        let (zero, reach) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, reach));
        let first = self.first(simd, node, 0).max(self.first(simd, node, 1)).max(self.first(simd, node, 2).max(zero));
        let last = self.last(simd, node, 0).min(self.last(simd, node, 1)).min(self.last(simd, node, 2).min(reach));
        (first, first.simd_le(last))
    }

    #[inline(always)]
    fn first(&self, simd: S, node: &WideNode, axis: usize) -> f32x16<S> {
        let sides = &node.bounds[axis][self.first_sides[axis] & 1];
        f32x16::load_array_ref(simd, sides).mul_sub(self.inverse[axis], self.starts[0][axis])
    }

    #[inline(always)]
    fn last(&self, simd: S, node: &WideNode, axis: usize) -> f32x16<S> {
        let sides = &node.bounds[axis][(self.first_sides[axis] & 1) ^ 1];
        f32x16::load_array_ref(simd, sides).mul_sub(self.inverse[axis], self.starts[1][axis])
    }
}

/// Origin and direction of a ray; the fourth lanes are 0.
#[inline(always)]
fn vectors<S: Simd>(simd: S, ray: &Ray) -> [f32x4<S>; 2] {
    let Ray { origin, direction, .. } = ray;
    [[origin.x, origin.y, origin.z, 0.0], [direction.x, direction.y, direction.z, 0.0]].map(
        #[inline(always)]
        |lanes| f32x4::load_array(simd, lanes),
    )
}

#[inline(always)]
fn splat<S: Simd>(simd: S, vector: f32x4<S>) -> [f32x16<S>; 3] {
    let [x, y, z, _] = vector.to_array();
    [f32x16::splat(simd, x), f32x16::splat(simd, y), f32x16::splat(simd, z)]
}

/// The numbers of the bits that are set.
struct Bits(u64);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lowest = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(lowest)
    }
}

/// The block of triangles that a child stands for.
#[inline(always)]
fn block_of(tree: &WideTree, child: u32) -> Option<&Block> {
    tree.blocks.get((child & !IS_BLOCK) as usize)
}

/// The nearest hit of a ray at less than its largest distance. Of equal distances the lowest triangle wins, so that every
/// tree gives the same answer. Faces that turn their backs to each other in one place, as the two sides of a card do, are
/// met at distances that differ by rounding: a front wins against a back that is nearer by less than `back_behind`. `excluded` is not hit, nor is what `is_solid` says no to. `stack` is scratch; the answer
/// is not known, `None`, where it is too short.
#[inline(always)]
pub(super) fn closest_hit<S: Simd>(
    simd: S,
    tree: &WideTree,
    ray: &Ray,
    excluded: u32,
    back_behind: f32,
    stack: &mut [u64],
    is_solid: impl Fn(u32, Vec2) -> bool,
) -> Option<Option<Hit>> {
    let vectors = vectors(simd, ray);
    let boxes = BoxRay::new(simd, vectors);
    let sheared = ShearedLanes::new(simd, vectors);
    // A hit must be less than this, by distance and then by triangle.
    let mut nearest = Hit { triangle: 0, barycentric: Vec2::ZERO, distance: ray.max_distance, front: false };
    // The largest rank of interest: the distance, with `back_behind` added for a back.
    let mut reach = ray.max_distance + back_behind;
    let (mut is_hit, mut height, mut current) = (false, 0, 0);
    loop {
        while let Some(node) = tree.nodes.get(current as usize) {
            let (entered, children) = boxes.entered(simd, node, reach);
            if height + WIDTH > stack.len() {
                return None;
            }
            (current, height) = nearest_child(node, entered, children.to_bitmask(), stack, height);
        }
        if let Some(block) = block_of(tree, current) {
            let hits = sheared.meet(simd, block, reach);
            for lane in Bits(hits.lanes) {
                let Some(hit) = sheared.hit(ray, &hits, block, lane, reach) else { continue };
                let rank = if hit.front { hit.distance } else { hit.distance + back_behind };
                let is_nearer = (rank, hit.triangle) < (reach, nearest.triangle) && hit.distance < ray.max_distance;
                let is_asked = is_nearer || hit.distance < nearest.distance;
                if is_asked && hit.triangle != excluded && is_solid(hit.triangle, hit.barycentric) {
                    // Whichever side is met, the distance is that of the nearest.
                    let distance = hit.distance.min(nearest.distance);
                    if is_nearer {
                        (nearest, reach, is_hit) = (hit, rank, true);
                    }
                    nearest.distance = distance;
                }
            }
        }
        loop {
            if height == 0 {
                return Some(is_hit.then_some(nearest));
            }
            height -= 1;
            if f32::from_bits((stack[height] >> 32) as u32) <= reach {
                current = stack[height] as u32;
                break;
            }
        }
    }
}

/// The child that is entered first, or [`NO_CHILD`]. The others go to the stack, the farthest first.
#[inline(always)]
fn nearest_child<S: Simd>(
    node: &WideNode,
    entered: f32x16<S>,
    children: u64,
    stack: &mut [u64],
    mut height: usize,
) -> (u32, usize) {
    let mut children = Bits(children);
    let Some(first) = children.next() else {
        return (NO_CHILD, height);
    };
    if children.0 == 0 {
        return (node.children[first % WIDTH], height);
    }
    let entered = entered.to_array();
    // The distance in the upper half: numbers that are not negative keep their order as bits.
    let packed =
        |child: usize| u64::from(entered[child % WIDTH].to_bits()) << 32 | u64::from(node.children[child % WIDTH]);
    let (mut nearest, bottom) = (packed(first), height);
    for child in children {
        let other = packed(child);
        let farther = nearest.max(other);
        nearest = nearest.min(other);
        let mut place = height;
        while place > bottom && stack[place - 1] < farther {
            stack[place] = stack[place - 1];
            place -= 1;
        }
        stack[place] = farther;
        height += 1;
    }
    (nearest as u32, height)
}

/// True if the ray hits anything at less than its largest distance; the rest as for [`closest_hit`].
#[inline(always)]
pub(super) fn is_occluded<S: Simd>(
    simd: S,
    tree: &WideTree,
    ray: &Ray,
    excluded: u32,
    stack: &mut [u32],
    is_solid: impl Fn(u32, Vec2) -> bool,
) -> Option<bool> {
    let vectors = vectors(simd, ray);
    let boxes = BoxRay::new(simd, vectors);
    let sheared = ShearedLanes::new(simd, vectors);
    let (mut height, mut current) = (0, 0);
    loop {
        while let Some(node) = tree.nodes.get(current as usize) {
            let (_, entered) = boxes.entered(simd, node, ray.max_distance);
            let children = entered.to_bitmask();
            if children == 0 {
                current = NO_CHILD;
                break;
            }
            // The last is looked at now. It goes to the stack too, with all in one store, but is not counted there.
            current = node.children[children.ilog2() as usize % WIDTH];
            let entered = simd.compress_u32x16(u32x16::load_array_ref(simd, &node.children), entered);
            entered.store_array(stack[height..].first_chunk_mut::<WIDTH>()?);
            height += children.count_ones() as usize - 1;
        }
        if let Some(block) = block_of(tree, current) {
            let hits = sheared.meet(simd, block, ray.max_distance);
            for lane in Bits(hits.lanes) {
                let Some(hit) = sheared.hit(ray, &hits, block, lane, ray.max_distance) else { continue };
                let is_near = hit.distance < ray.max_distance && hit.triangle != excluded;
                if is_near && is_solid(hit.triangle, hit.barycentric) {
                    return Some(true);
                }
            }
        }
        if height == 0 {
            return Some(false);
        }
        height -= 1;
        current = stack[height];
    }
}
