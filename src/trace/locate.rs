//! From a point in space, given with its normal, to the triangle that it lies on.

use glam::{Vec2, Vec3};

use super::{Hit, NO_TRIANGLE, Ray, RayTracer};
use crate::scene::Scene;

/// How far from the point a surface is looked for, in local units (a scene's half-extent is about 1), nearest first.
/// The first is some 100 times what a point loses as text of seven digits; the others find points that were taken
/// from a smooth surface beside the mesh.
const REACHES: [f32; 3] = [1e-5, 1e-4, 1e-3];

/// How many surfaces a short ray is followed through at one reach.
const MOST_LAYERS: u32 = 4;

/// The triangle at `position` whose front side faces along `normal`, and the barycentric coordinates there.
///
/// `position` is in local units; `normal` (unit length) may be an interpolated one. A short ray is shot down at the
/// surface from a little above it: one ray where the point lies on a single sheet. Among several faces in reach that
/// face along the normal, the nearest is taken; if none does, the first of the others. `None` if there is none at all.
pub fn locate_point(tracer: &impl RayTracer, scene: &Scene, position: Vec3, normal: Vec3) -> Option<(u32, Vec2)> {
    let mut facing_away = None;
    for reach in REACHES {
        let near = 0.1 * reach;
        let mut nearest: Option<(f32, Hit)> = None;
        // Heights are above the point; each ray starts a little above the last hit, as faces may lie on each other.
        let mut height = reach;
        let mut left_out = NO_TRIANGLE;
        for _ in 0..MOST_LAYERS {
            let ray = Ray {
                origin: position + height * normal,
                direction: -normal,
                max_distance: height + reach,
                origin_triangle: left_out,
            };
            let Some(hit) = tracer.closest_hit(&ray) else {
                break;
            };
            let hit_height = height - hit.distance;
            if !faces_along(scene, &hit, normal) {
                facing_away = facing_away.or(Some(hit));
            } else if nearest.is_none_or(|(found, _)| hit_height.abs() < found.abs()) {
                nearest = Some((hit_height, hit));
            }
            if nearest.is_some_and(|(found, _)| found <= near) {
                break; // whatever comes lies lower
            }
            (height, left_out) = (hit_height + near, hit.triangle);
        }
        if let Some((_, hit)) = nearest {
            return Some((hit.triangle, hit.barycentric));
        }
    }
    facing_away.map(|hit| (hit.triangle, hit.barycentric))
}

/// True where the hit is on the front and the triangle's shading normal there is near the wanted one: tells the faces
/// that meet in a crease from each other.
fn faces_along(scene: &Scene, hit: &Hit, normal: Vec3) -> bool {
    const NEAR: f32 = 0.9;
    hit.front && scene.mesh.shading_normal(hit.triangle, hit.barycentric).dot(normal) > NEAR
}
