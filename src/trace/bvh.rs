//! The program's ray tracer: a tree with splits in space (`split_tree`), collapsed (`wide_tree`) and walked (`walk`) with
//! a watertight triangle test (`triangle`).

use std::sync::Arc;

use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3A};
use obvhs::{aabb::Aabb, bvh2::Bvh2};

use super::{
    Hit, NO_TRIANGLE, Ray, RayTracer,
    shaft::{Shaft, visit_triangles},
    split_tree, walk,
    wide_tree::WideTree,
};
use crate::scene::Scene;

/// How much a box is padded, as a fraction of its largest coordinate: more than its rounding error, and more than nothing,
/// as a flat wall's box has no thickness.
const BOX_PADDING: f32 = 1e-6;

/// Two faces in one place are met at distances that rounding makes differ by less than this part of the scene's largest
/// coordinate, at all but the flattest slants.
const BACK_BEHIND_FRONT: f32 = 4e-6;

/// A scene's triangles in a bounding volume hierarchy.
pub struct Tracer {
    scene: Arc<Scene>,
    tree: WideTree,
    /// The instructions that this machine has.
    level: Level,
    /// Whether hits on a triangle must be tested for cut-outs; empty if no triangle needs it.
    cut_outs: Vec<bool>,
    /// How much nearer than a front a back may be for the front to be met [the scene's units].
    back_behind: f32,
    /// Of a two-sided scene: the number of triangles of one side.
    sides_apart: Option<u32>,
}

/// The box, with more around it than it can be off by.
pub(super) fn padded(bounds: Aabb) -> Aabb {
    let padding = Vec3A::splat(BOX_PADDING * bounds.min.abs().max(bounds.max.abs()).max_element().max(1e-3));
    Aabb::new(bounds.min - padding, bounds.max + padding)
}

impl Tracer {
    /// Builds the tree over the scene's own triangles.
    pub fn new(scene: Arc<Scene>) -> Self {
        let count = traced_count(&scene);
        let binary = split_tree::build(count, |triangle| scene.mesh.corners(triangle));
        Self::over(scene, &binary)
    }

    /// Walks another binary tree than its own, which `build` makes from the triangles' boxes: at least one, one a leaf. The
    /// answers are the same for all trees.
    pub fn with_tree(scene: Arc<Scene>, build: impl FnOnce(&[Aabb]) -> Bvh2) -> Self {
        let box_of = |triangle| padded(Aabb::from_points(&scene.mesh.corners(triangle).map(Vec3A::from)));
        let boxes: Vec<Aabb> = (0..traced_count(&scene)).map(box_of).collect();
        let binary = if boxes.is_empty() { Bvh2::default() } else { build(&boxes) };
        Self::over(scene, &binary)
    }

    fn over(scene: Arc<Scene>, binary: &Bvh2) -> Self {
        let tree = WideTree::new(binary, |triangle| scene.mesh.corners(triangle));
        let count = traced_count(&scene);
        let mut cut_outs: Vec<bool> = (0..count).map(|id| scene.may_be_cut_out(id)).collect();
        if !cut_outs.contains(&true) {
            cut_outs = Vec::new();
        }
        let sides_apart = scene.two_sided.then_some(count);
        let largest =
            scene.mesh.positions.iter().fold(0.0_f32, |largest, point| largest.max(point.abs().max_element()));
        let back_behind = BACK_BEHIND_FRONT * largest;
        Self { scene, tree, level: Level::new(), cut_outs, back_behind, sides_apart }
    }

    /// The scene whose triangles are traced.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn may_be_cut_out(&self, triangle: u32) -> bool {
        self.cut_outs.get(triangle as usize) == Some(&true)
    }

    #[inline(always)]
    fn is_solid(&self, triangle: u32, barycentric: Vec2) -> bool {
        self.cut_outs.is_empty() || !self.may_be_cut_out(triangle) || !self.scene.is_cut_out(triangle, barycentric)
    }

    /// The side of a two-sided surface that a hit lies on; its flipped copy has corners (a, c, b).
    fn on_its_side(&self, hit: Hit) -> Hit {
        match self.sides_apart {
            Some(count) if !hit.front => Hit {
                triangle: hit.triangle + count,
                barycentric: Vec2::new(hit.barycentric.y, hit.barycentric.x),
                front: true,
                ..hit
            },
            _ => hit,
        }
    }

    /// The triangle to exclude, on the side that the tree holds.
    fn excluded(&self, origin_triangle: u32) -> u32 {
        match self.sides_apart {
            Some(count) if origin_triangle != NO_TRIANGLE => origin_triangle % count,
            _ => origin_triangle,
        }
    }
}

/// Triangles in the tree: of a two-sided scene, whose second half are the first half's copies, one side.
fn traced_count(scene: &Scene) -> u32 {
    let count = scene.mesh.triangles.len() as u32;
    if scene.two_sided { count / 2 } else { count }
}

/// What a walk remembers at first. Most need less; zeroing what all might need took a quarter of a short ray's time.
const SHORT_STACK: usize = 48;

/// Calls `walk` with a short stack, and with longer ones until that answers.
#[inline(always)]
fn with_stack<T: Copy + Default, R>(walk: impl Fn(&mut [T]) -> Option<R>) -> R {
    let mut short = [T::default(); SHORT_STACK];
    let mut long;
    let mut stack: &mut [T] = &mut short;
    loop {
        if let Some(answer) = walk(stack) {
            return answer;
        }
        long = vec![T::default(); 2 * stack.len()];
        stack = &mut long;
    }
}

impl RayTracer for Tracer {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let excluded = self.excluded(ray.origin_triangle);
        let hit = dispatch!(self.level, simd => with_stack(
            #[inline(always)]
            |stack| walk::closest_hit(
                simd, &self.tree, ray, excluded, self.back_behind, stack,
                #[inline(always)]
                |triangle, at| self.is_solid(triangle, at),
            ),
        ));
        hit.map(|hit| self.on_its_side(hit))
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let excluded = self.excluded(ray.origin_triangle);
        dispatch!(self.level, simd => with_stack(
            #[inline(always)]
            |stack| walk::is_occluded(
                simd, &self.tree, ray, excluded, stack,
                #[inline(always)]
                |triangle, at| self.is_solid(triangle, at),
            ),
        ))
    }

    fn triangles_in_shaft(
        &self,
        shaft: &Shaft,
        is_left_out: &dyn Fn(u32) -> bool,
        limit: usize,
        triangles: &mut Vec<u32>,
    ) -> bool {
        let mut all = true;
        visit_triangles(&self.tree, shaft, |triangle| {
            if is_left_out(triangle) || triangles.contains(&triangle) {
                return true;
            }
            all = triangles.len() < limit && !self.may_be_cut_out(triangle);
            triangles.push(triangle);
            all
        });
        all
    }
}
