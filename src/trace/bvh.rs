//! The program's ray tracer: a compressed wide BVH from obvhs with our own watertight triangle test.
//!
//! obvhs's triangle test lets rays through at shared edges, and its boxes are exact, so a flat wall's box has no
//! thickness. So the test is `triangle.rs`'s, and every box is padded by more than its rounding error.

use std::{sync::Arc, time::Duration};

use glam::{Vec2, Vec3, Vec3A};
use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    cwbvh::{CwBvh, builder::build_cwbvh},
    ray::RayHit,
};

use super::{
    Hit, NO_TRIANGLE, Ray, RayTracer,
    shaft::{Shaft, visit_slots},
    triangle::ShearedRay,
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
    /// `None` for a scene without triangles.
    tree: Option<CwBvh>,
    /// Corners in the tree's order, so that a leaf reads memory in a row.
    corners: Vec<[Vec3; 3]>,
    /// Triangle of the scene for each of `corners`.
    triangle_ids: Vec<u32>,
    /// Whether hits on a triangle must be tested for cut-outs, in the tree's order; empty if no triangle needs it.
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
        if traced.is_empty() {
            let (corners, triangle_ids, cut_outs) = Default::default();
            return Self { scene, tree: None, corners, triangle_ids, cut_outs, sides_apart };
        }
        let tree = build_cwbvh(&traced, parameters, &mut Duration::default());
        let triangle_ids = tree.primitive_indices.clone();
        let corners = triangle_ids.iter().map(|&id| traced[id as usize].0).collect();
        let mut cut_outs: Vec<bool> = triangle_ids.iter().map(|&id| scene.may_be_cut_out(id)).collect();
        if !cut_outs.contains(&true) {
            cut_outs = Vec::new();
        }
        Self { scene, tree: Some(tree), corners, triangle_ids, cut_outs, sides_apart }
    }

    /// The scene whose triangles are traced.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The hit of `ray` with the triangle in `slot` of the tree's order.
    #[inline]
    fn intersect(&self, ray: &ShearedRay, slot: usize, max_distance: f32, excluded: u32) -> Option<Hit> {
        let triangle = self.triangle_ids[slot];
        if triangle == excluded {
            return None;
        }
        let hit = ray.intersect(&self.corners[slot], max_distance)?;
        if self.cut_outs.get(slot) == Some(&true) && self.scene.is_cut_out(triangle, hit.barycentric) {
            return None;
        }
        Some(Hit { triangle, barycentric: hit.barycentric, distance: hit.distance, front: hit.front })
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

/// How far behind its origin a ray enters the tree. The tree's box test ignores boxes that are left within 1e-4 of the
/// start, so a wall that near would be missed; a start this much earlier leaves every box in front later than that.
const HEAD_START: f32 = 2e-4;

/// A ray for the tree. Adding 0 turns a component of -0 into +0: the box test takes -0 for positive in one place and
/// for negative in another, and would miss every box.
fn tree_ray(ray: &Ray) -> obvhs::ray::Ray {
    let direction = ray.direction + Vec3::ZERO;
    let origin = ray.origin - HEAD_START * direction;
    obvhs::ray::Ray::new(origin.into(), direction.into(), 0.0, ray.max_distance + HEAD_START)
}

impl RayTracer for Tracer {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let tree = self.tree.as_ref()?;
        let sheared = ShearedRay::new(ray.origin, ray.direction);
        let excluded = self.excluded(ray.origin_triangle);
        let mut closest: Option<Hit> = None;
        tree.ray_traverse(tree_ray(ray), &mut RayHit::none(), |_, slot| {
            // Of equal distances the lowest triangle wins, so that every build gives the same answer.
            let reach = closest.map_or(ray.max_distance, |nearest| nearest.distance.next_up());
            let Some(hit) = self.intersect(&sheared, slot, reach, excluded) else {
                return f32::INFINITY;
            };
            if closest.is_none_or(|nearest| (hit.distance, hit.triangle) < (nearest.distance, nearest.triangle)) {
                closest = Some(hit);
            }
            hit.distance + HEAD_START
        });
        closest.map(|hit| self.on_its_side(hit))
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let Some(tree) = &self.tree else {
            return false;
        };
        let sheared = ShearedRay::new(ray.origin, ray.direction);
        let excluded = self.excluded(ray.origin_triangle);
        !tree.ray_traverse_miss(tree_ray(ray), |_, slot| {
            // Any number below the tree's end of the ray stands for a hit.
            if self.intersect(&sheared, slot, ray.max_distance, excluded).is_some() { 0.0 } else { f32::INFINITY }
        })
    }

    fn triangles_in_shaft(&self, shaft: &Shaft, limit: usize, triangles: &mut Vec<u32>) -> bool {
        let mut all = true;
        if let Some(tree) = &self.tree {
            visit_slots(tree, shaft, |slot| {
                if shaft.touches_triangle(&self.corners[slot]) {
                    all = triangles.len() < limit && self.cut_outs.get(slot) != Some(&true);
                    triangles.push(self.triangle_ids[slot]);
                }
                all
            });
        }
        all
    }
}
