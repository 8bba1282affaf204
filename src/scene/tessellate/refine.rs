//! Elements cut round by round, where whoever computes on them asks for it.

use glam::Vec2;

use super::{
    MAX_ELEMENTS, Tessellation, Vertices,
    bisect::{self, Cutter},
    uniform,
};
use crate::scene::Scene;

/// Elements that can still be cut, by longest-edge bisection and without T-junctions. Vertices and nodes keep their
/// numbers from round to round; elements do not.
pub struct Refinement {
    vertices: Vertices,
    cutter: Cutter,
    /// For each round the number of elements asked for, and those elements.
    cuts: Vec<u32>,
}

impl Refinement {
    /// Starts from a scene's own triangles.
    pub fn new(scene: &Scene) -> Self {
        let vertices = Vertices::of(&scene.mesh);
        let mut cutter = Cutter::new(uniform::whole(&scene.mesh), &vertices);
        cutter.name_leaves();
        Self { vertices, cutter, cuts: Vec::new() }
    }

    /// Cuts each of these elements at its longest edge, and around them what must be cut with them. False, and nothing
    /// is cut, if there would be more than [`MAX_ELEMENTS`].
    pub fn cut(&mut self, elements: &[u32]) -> bool {
        if !self.cutter.mark_items(elements) {
            return true;
        }
        if self.cutter.count_after_cut() > MAX_ELEMENTS {
            return false;
        }
        self.cuts.push(elements.len() as u32);
        self.cuts.extend(elements);
        self.cutter.cut(&mut self.vertices);
        self.cutter.name_leaves();
        true
    }

    /// How many elements there would be after [`Refinement::cut`].
    pub fn count_after_cut(&mut self, elements: &[u32]) -> u64 {
        self.cutter.mark_items(elements);
        self.cutter.count_after_cut()
    }

    /// The elements as they are now.
    pub fn tessellation(&self, scene: &Scene) -> Tessellation {
        let elements = self.cutter.items.iter().map(|item| item.element);
        let mut tessellation = Tessellation::of_elements(scene, &self.vertices, elements);
        tessellation.cuts.clone_from(&self.cuts);
        tessellation.nodes.clone_from(&self.cutter.nodes);
        tessellation
    }

    /// The node of each element, in order: what an element is known by in later rounds.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.cutter.items.iter().map(|item| item.node)
    }

    /// How many nodes there are: those of later rounds have this number or a higher one.
    pub fn node_count(&self) -> u32 {
        self.cutter.nodes.len() as u32
    }

    /// The ends of an element's longest edge: where it would be cut.
    pub fn longest_edge(&self, element: u32) -> [u32; 2] {
        let item = &self.cutter.items[element as usize];
        let edge = self.cutter.longest_edge(item);
        [item.element.vertices[edge], item.element.vertices[(edge + 1) % 3]]
    }

    /// The ends of the edge that each vertex is the midpoint of; of the scene's own vertices, themselves.
    pub fn parents(&self) -> &[[u32; 2]] {
        &self.vertices.parents
    }

    /// The element that now holds a point of a node, and the point's barycentric coordinates in it.
    pub fn locate_in_node(&self, node: u32, barycentric: Vec2) -> (u32, Vec2) {
        bisect::descend(&self.cutter.nodes, node, barycentric)
    }

    /// Cuts as another refinement did.
    pub(super) fn replay(scene: &Scene, cuts: &[u32]) -> Result<Tessellation, String> {
        let other = || String::from("the elements were cut from another scene");
        let mut refinement = Self::new(scene);
        let mut rest = cuts;
        while let Some((&count, after)) = rest.split_first() {
            let (elements, after) = after.split_at_checked(count as usize).ok_or_else(other)?;
            if count == 0 || elements.iter().any(|&element| element as usize >= refinement.cutter.items.len()) {
                return Err(other());
            }
            if !refinement.cut(elements) {
                return Err(other());
            }
            rest = after;
        }
        Ok(refinement.tessellation(scene))
    }
}
