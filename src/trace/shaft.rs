//! What can come between a point and a light: the triangles that touch a pyramid around the light with its apex at the
//! point.

use glam::Vec3;

use super::{
    NO_TRIANGLE,
    wide_tree::{IS_BLOCK, NO_CHILD, WideTree},
};

/// How far a triangle must lie outside of a side to be left out, in local units: more than f32 rounding, so that
/// nothing that blocks is missed.
const MARGIN: f32 = 1e-6;

/// A half-space: points with `normal · point > offset` lie outside.
#[derive(Clone, Copy, Debug)]
struct Side {
    normal: Vec3,
    offset: f32,
}

/// The convex space between a point and a light.
#[derive(Clone, Debug)]
pub struct Shaft {
    sides: [Side; Shaft::MOST_SIDES + 2],
    count: usize,
}

impl Shaft {
    /// Planes through the apex.
    pub const MOST_SIDES: usize = 4;

    /// The shaft from `apex`, which lies on a surface with unit normal `surface_normal` and above which alone is
    /// looked, between planes through the apex with unit normals `sides`, which point outwards (0 for none), up to the plane
    /// through `end` with unit normal `end_normal`, which faces the apex.
    pub fn new(
        apex: Vec3,
        surface_normal: Vec3,
        sides: [Vec3; Self::MOST_SIDES],
        (end, end_normal): (Vec3, Vec3),
    ) -> Self {
        let none = Side { normal: Vec3::ZERO, offset: f32::INFINITY };
        let mut shaft = Self { sides: [none; Self::MOST_SIDES + 2], count: 0 };
        // What lies in the surface's or in the light's own plane blocks nothing.
        shaft.add(-surface_normal, -surface_normal.dot(apex));
        shaft.add(-end_normal, -end_normal.dot(end) - MARGIN);
        for normal in sides {
            shaft.add(normal, normal.dot(apex) + MARGIN);
        }
        shaft
    }

    fn add(&mut self, normal: Vec3, offset: f32) {
        if normal != Vec3::ZERO {
            self.sides[self.count] = Side { normal, offset };
            self.count += 1;
        }
    }

    /// False if one side has the whole box on its outer side.
    fn touches_box(&self, low: Vec3, high: Vec3) -> bool {
        self.sides[..self.count].iter().all(|side| {
            let innermost = Vec3::select(side.normal.cmpgt(Vec3::ZERO), low, high);
            side.normal.dot(innermost) <= side.offset
        })
    }

    /// False if one side has the whole triangle on its outer side. On the sides of the surface and of the light a
    /// triangle that only touches them is out.
    pub fn touches_triangle(&self, corners: &[Vec3; 3]) -> bool {
        self.sides[..self.count].iter().all(|side| corners.iter().any(|corner| side.normal.dot(*corner) < side.offset))
    }
}

/// Calls `visit` with each triangle of the tree that touches the shaft, until it returns false.
pub(super) fn visit_triangles(tree: &WideTree, shaft: &Shaft, mut visit: impl FnMut(u32) -> bool) {
    let mut stack = vec![0];
    while let Some(index) = stack.pop() {
        if let Some(node) = tree.nodes.get(index as usize) {
            // Those that are not there come last.
            for (child, &index) in node.children.iter().enumerate().take_while(|&(_, &index)| index != NO_CHILD) {
                let [low, high] = node.child_box(child);
                if shaft.touches_box(low, high) {
                    stack.push(index);
                }
            }
        } else if let Some(block) = tree.blocks.get((index & !IS_BLOCK) as usize) {
            for (lane, &triangle) in block.triangles.iter().enumerate().take_while(|&(_, &id)| id != NO_TRIANGLE) {
                if shaft.touches_triangle(&block.corners(lane)) && !visit(triangle) {
                    return;
                }
            }
        }
    }
}
