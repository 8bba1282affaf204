//! The program's ray tracer: a tree that obvhs builds, collapsed (`wide_tree`) and walked (`walk`) by our own code with
//! a watertight triangle test (`triangle`).
//!
//! obvhs's triangle test lets rays through at shared edges, and its boxes are exact, so a flat wall's box has no
//! thickness: every box is padded by more than its rounding error.

use std::{sync::Arc, time::Duration};

use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3, Vec3A};
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb, bvh2::builder::build_bvh2};

use super::{
    Hit, NO_TRIANGLE, Ray, RayTracer,
    shaft::{Shaft, visit_triangles},
    walk,
    wide_tree::WideTree,
};
use crate::scene::Scene;

/// How trees are built unless a caller says otherwise. The presets' `search_depth_threshold` makes bad leaves on
/// regular meshes; at 0 the tree of a tessellated room was traced three times as fast.
pub const DEFAULT_BUILD: BvhBuildParams =
    BvhBuildParams { search_depth_threshold: 0, ..BvhBuildParams::medium_build() };

/// How much a box is padded, as a fraction of its largest coordinate.
const BOX_PADDING: f32 = 1e-6;

/// A scene's triangles in a bounding volume hierarchy.
pub struct Tracer {
    scene: Arc<Scene>,
    tree: WideTree,
    /// The instructions that this machine has.
    level: Level,
    /// Whether hits on a triangle must be tested for cut-outs; empty if no triangle needs it.
    cut_outs: Vec<bool>,
    /// Of a two-sided scene: the number of triangles of one side.
    sides_apart: Option<u32>,
}

struct PaddedTriangle([Vec3; 3]);

impl Boundable for PaddedTriangle {
    fn aabb(&self) -> Aabb {
        let mut bounds = Aabb::from_points(&self.0.map(Vec3A::from));
        let padding = Vec3A::splat(BOX_PADDING * bounds.min.abs().max(bounds.max.abs()).max_element().max(1e-3));
        bounds.min -= padding;
        bounds.max += padding;
        bounds
    }
}

impl Tracer {
    /// Builds the tree over the scene's own triangles.
    pub fn new(scene: Arc<Scene>) -> Self {
        Self::with_build(scene, DEFAULT_BUILD)
    }

    /// Builds the tree with other parameters. The answers are the same for all.
    pub fn with_build(scene: Arc<Scene>, parameters: BvhBuildParams) -> Self {
        let triangle_count = scene.mesh.triangles.len() as u32;
        let sides_apart = scene.two_sided.then_some(triangle_count / 2);
        let traced: Vec<PaddedTriangle> =
            (0..sides_apart.unwrap_or(triangle_count)).map(|id| PaddedTriangle(scene.mesh.corners(id))).collect();
        let tree = if traced.is_empty() {
            WideTree::default()
        } else {
            // The tree makes leaves of several triangles by itself.
            let parameters = BvhBuildParams { max_prims_per_leaf: 1, ..parameters };
            let binary = build_bvh2(&traced, parameters, &mut Duration::default());
            WideTree::new(&binary, |triangle| traced[triangle as usize].0)
        };
        let mut cut_outs: Vec<bool> = (0..traced.len() as u32).map(|id| scene.may_be_cut_out(id)).collect();
        if !cut_outs.contains(&true) {
            cut_outs = Vec::new();
        }
        Self { scene, tree, level: Level::new(), cut_outs, sides_apart }
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

/// What a walk remembers without asking for memory; scenes that were looked at need about 110.
const STACK_SIZE: usize = 128;

impl RayTracer for Tracer {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let excluded = self.excluded(ray.origin_triangle);
        let hit = dispatch!(self.level, simd => {
            let (mut array, mut list) = ([0; STACK_SIZE], Vec::new());
            let stack = stack_of(&mut array, &mut list, self.tree.stack_size);
            walk::closest_hit(simd, &self.tree, ray, excluded, stack, |triangle, at| self.is_solid(triangle, at))
        });
        hit.map(|hit| self.on_its_side(hit))
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let excluded = self.excluded(ray.origin_triangle);
        dispatch!(self.level, simd => {
            let (mut array, mut list) = ([0; STACK_SIZE], Vec::new());
            let stack = stack_of(&mut array, &mut list, self.tree.stack_size);
            walk::is_occluded(simd, &self.tree, ray, excluded, stack, |triangle, at| self.is_solid(triangle, at))
        })
    }

    fn triangles_in_shaft(&self, shaft: &Shaft, limit: usize, triangles: &mut Vec<u32>) -> bool {
        let mut all = true;
        visit_triangles(&self.tree, shaft, |triangle| {
            all = triangles.len() < limit && !self.may_be_cut_out(triangle);
            triangles.push(triangle);
            all
        });
        all
    }
}

/// The array, or where that is too short the list, made as long as it takes.
#[inline(always)]
fn stack_of<'a, T: Copy + Default>(array: &'a mut [T], list: &'a mut Vec<T>, size: usize) -> &'a mut [T] {
    if size <= array.len() {
        return array;
    }
    list.resize(size, T::default());
    list
}
