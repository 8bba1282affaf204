//! A bounding volume hierarchy of nodes with many children, in the layout that `walk` reads: boxes side by side, so
//! that one instruction tests a whole row of them, and leaves of triangles likewise.
//!
//! It is a binary tree, collapsed at the least cost by the surface area heuristic: the dynamic program of
//! Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.

use glam::Vec3;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};

use super::NO_TRIANGLE;

/// Children of a node. With 8 of them rays took a tenth longer where a register holds 16, and as long where it holds 8:
/// most nodes are left by one child, so what counts is how many are met one after the other.
pub(super) const WIDTH: usize = 16;

/// Triangles of a block. With 4 of them rays took some 5 % longer.
pub(super) const LANES: usize = 8;

/// Set in a child that is a block of triangles.
pub(super) const IS_BLOCK: u32 = 1 << 31;

/// A child that is not there.
pub(super) const NO_CHILD: u32 = u32::MAX;

/// A node's cost, a block's being 1, as measured; costs from 1 to 2.2 give trees as fast.
const NODE_COST: f32 = 1.5;

/// The boxes of up to [`WIDTH`] children; the last are the likeliest to stop a ray soon.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct WideNode {
    /// By axis, side (low, high) and child. A child that is not there has its sides the wrong way round.
    pub(super) bounds: [[[f32; WIDTH]; 2]; 3],
    /// A node's number; or [`IS_BLOCK`] with a block's; or [`NO_CHILD`].
    pub(super) children: [u32; WIDTH],
}

/// Up to [`LANES`] triangles.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    /// By corner, axis and triangle; not a number where there is no triangle.
    pub(super) corners: [[[f32; LANES]; 3]; 3],
    /// The scene's triangles; [`NO_TRIANGLE`] where there is none.
    pub(super) triangles: [u32; LANES],
}

/// The tree. Nodes and blocks lie in the order of a walk, depth first. Without triangles it has no nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<WideNode>,
    pub(super) blocks: Vec<Block>,
}

/// What is known of a binary node's subtree.
#[derive(Clone, Copy)]
struct Subtree {
    /// The least cost of its triangles under at most 1, 2, ... [`WIDTH`] roots, times the area.
    costs: [f32; WIDTH],
    triangles: u32,
    /// How much of its box's area its triangles cover, at most all: by that a ray that enters the box is stopped.
    cover: f32,
    /// True if one block under one root costs least.
    is_block: bool,
}

impl WideTree {
    /// Collapses a binary tree whose leaves hold one triangle each, or a part of one; the corners of triangles are asked for.
    pub(super) fn new(binary: &Bvh2, corners_of: impl Fn(u32) -> [Vec3; 3]) -> Self {
        let mut tree = Self::default();
        if binary.nodes.is_empty() {
            return tree;
        }
        let builder = Builder { binary, subtrees: subtrees(binary, &corners_of) };
        let (mut open, mut roots) = (vec![Open { root: 0, parent: None }], Vec::new());
        while let Some(Open { root, parent }) = open.pop() {
            let index = tree.nodes.len() as u32;
            if let Some((parent, child)) = parent {
                tree.nodes[parent as usize].children[child] = index;
            }
            builder.children_of(root, &mut roots);
            let mut node = WideNode::EMPTY;
            for (child, &root) in roots.iter().enumerate() {
                node.set_box(child, builder.binary.nodes[root as usize].aabb());
                if builder.subtrees[root as usize].is_block {
                    node.children[child] = IS_BLOCK | tree.blocks.len() as u32;
                    tree.blocks.push(builder.block(root, &corners_of));
                }
            }
            tree.nodes.push(node);
            for (child, &root) in roots.iter().enumerate().rev() {
                if !builder.subtrees[root as usize].is_block {
                    open.push(Open { root, parent: Some((index, child)) });
                }
            }
        }
        tree
    }
}

/// A binary node that becomes a wide one.
struct Open {
    root: u32,
    parent: Option<(u32, usize)>,
}

/// The node's children, or `None` for a leaf.
fn halves(node: &Bvh2Node) -> Option<[u32; 2]> {
    (!node.is_leaf()).then_some([node.first_index, node.first_index + 1])
}

/// Binary nodes, each after its parent.
fn downwards(nodes: &[Bvh2Node]) -> Vec<u32> {
    let (mut order, mut stack) = (Vec::with_capacity(nodes.len()), vec![0]);
    while let Some(node) = stack.pop() {
        order.push(node);
        stack.extend(halves(&nodes[node as usize]).into_iter().flatten());
    }
    order
}

fn subtrees(binary: &Bvh2, corners_of: &impl Fn(u32) -> [Vec3; 3]) -> Vec<Subtree> {
    let none = Subtree { costs: [f32::INFINITY; WIDTH], triangles: 0, cover: 0.0, is_block: false };
    let mut subtrees = vec![none; binary.nodes.len()];
    for &index in downwards(&binary.nodes).iter().rev() {
        let node = &binary.nodes[index as usize];
        let area = node.aabb().half_area();
        subtrees[index as usize] = match halves(node) {
            None => {
                let [a, b, c] = corners_of(binary.primitive_indices[node.first_index as usize]);
                // Rays meet what is convex in proportion to its surface: half of a box's is to one side of a triangle as whole to whole.
                let cover = area.min(0.5 * (b - a).cross(c - a).length());
                Subtree { costs: [area; WIDTH], triangles: 1, cover, is_block: true }
            }
            Some([left, right]) => Subtree::joined(area, &subtrees[left as usize], &subtrees[right as usize]),
        };
    }
    subtrees
}

impl Subtree {
    fn joined(area: f32, left: &Self, right: &Self) -> Self {
        let triangles = left.triangles + right.triangles;
        let mut costs = [f32::INFINITY; WIDTH];
        // More roots than triangles are of no use.
        let most = WIDTH.min(triangles as usize);
        for roots in 2..=most {
            costs[roots - 1] = costs[roots - 2].min(cheapest_split(left, right, roots).0);
        }
        let node = costs[most - 1] + area * NODE_COST;
        let is_block = triangles as usize <= LANES && area <= node;
        costs[0] = if is_block { area } else { node };
        for roots in 1..WIDTH {
            costs[roots] = costs[roots].min(costs[roots - 1]);
        }
        Self { costs, triangles, cover: area.min(left.cover + right.cover), is_block }
    }
}

/// The least cost of two subtrees under exactly this many roots, at least two, and how many of them are the left's.
fn cheapest_split(left: &Subtree, right: &Subtree, roots: usize) -> (f32, usize) {
    let lowest = (roots - 1).saturating_sub(right.triangles as usize).max(1);
    let highest = (roots - 1).min(left.triangles as usize);
    let mut cheapest = (f32::INFINITY, lowest);
    for of_left in lowest..=highest {
        let cost = left.costs[of_left - 1] + right.costs[roots - of_left - 1];
        if cost < cheapest.0 {
            cheapest = (cost, of_left);
        }
    }
    cheapest
}

struct Builder<'a> {
    binary: &'a Bvh2,
    subtrees: Vec<Subtree>,
}

impl Builder<'_> {
    /// The binary nodes that become the children of a wide node. A walk that wants any hit begins at the last: children
    /// are in the order of how likely they stop a ray that enters them, over the cost to find out.
    fn children_of(&self, node: u32, children: &mut Vec<u32>) {
        children.clear();
        match halves(&self.binary.nodes[node as usize]) {
            Some(halves) if !self.subtrees[node as usize].is_block => self.split(halves, WIDTH, children),
            _ => children.push(node),
        }
        let promise = |node: &u32| {
            let subtree = &self.subtrees[*node as usize];
            subtree.cover / subtree.costs[0].max(f32::MIN_POSITIVE)
        };
        children.sort_by(|a, b| promise(a).total_cmp(&promise(b)));
    }

    fn split(&self, [left, right]: [u32; 2], most: usize, roots: &mut Vec<u32>) {
        let (of_left, of_right) = (&self.subtrees[left as usize], &self.subtrees[right as usize]);
        let most = most.min((of_left.triangles + of_right.triangles) as usize);
        let split = |count: usize| (count, cheapest_split(of_left, of_right, count));
        let best = (2..=most).map(split).min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
        let (count, (_, left_count)) = best.unwrap_or((2, (0.0, 1)));
        self.take(left, left_count, roots);
        self.take(right, count - left_count, roots);
    }

    /// Adds a subtree under at most `most` roots.
    fn take(&self, node: u32, most: usize, roots: &mut Vec<u32>) {
        let costs = &self.subtrees[node as usize].costs;
        match halves(&self.binary.nodes[node as usize]) {
            Some(halves) if most > 1 && costs[most - 1] < costs[0] => self.split(halves, most, roots),
            _ => roots.push(node),
        }
    }

    fn block(&self, root: u32, corners_of: &impl Fn(u32) -> [Vec3; 3]) -> Block {
        let mut block = Block::EMPTY;
        let (mut lane, mut stack) = (0, vec![root]);
        while let Some(node) = stack.pop() {
            let node = &self.binary.nodes[node as usize];
            if let Some(halves) = halves(node) {
                stack.extend(halves);
                continue;
            }
            let triangle = self.binary.primitive_indices[node.first_index as usize];
            for (corner, position) in corners_of(triangle).into_iter().enumerate() {
                for (axis, value) in position.to_array().into_iter().enumerate() {
                    block.corners[corner][axis][lane] = value;
                }
            }
            block.triangles[lane] = triangle;
            lane += 1;
        }
        block
    }
}

impl WideNode {
    const EMPTY: Self = Self { bounds: [[[f32::MAX; WIDTH], [f32::MIN; WIDTH]]; 3], children: [NO_CHILD; WIDTH] };

    fn set_box(&mut self, child: usize, bounds: &Aabb) {
        for (axis, [low, high]) in self.bounds.iter_mut().enumerate() {
            (low[child], high[child]) = (bounds.min[axis], bounds.max[axis]);
        }
    }

    /// The box of a child: its lowest and its highest corner.
    #[inline]
    pub(super) fn child_box(&self, child: usize) -> [Vec3; 2] {
        let [x, y, z] = &self.bounds;
        [Vec3::new(x[0][child], y[0][child], z[0][child]), Vec3::new(x[1][child], y[1][child], z[1][child])]
    }
}

impl Block {
    const EMPTY: Self = Self { corners: [[[f32::NAN; LANES]; 3]; 3], triangles: [NO_TRIANGLE; LANES] };

    /// The corners of one of its triangles.
    #[inline]
    pub(super) fn corners(&self, lane: usize) -> [Vec3; 3] {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = &self.corners;
        [
            Vec3::new(ax[lane], ay[lane], az[lane]),
            Vec3::new(bx[lane], by[lane], bz[lane]),
            Vec3::new(cx[lane], cy[lane], cz[lane]),
        ]
    }
}
