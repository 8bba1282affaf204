//! From a point in space, given with its normal, to the triangle that it lies on.

use glam::{Vec2, Vec3};

use super::{Hit, NO_TRIANGLE, Ray, RayTracer};
use crate::scene::{Scene, mesh::unit_or_zero};

/// How far from the point a surface is looked for, in local units (a scene's half-extent is about 1), nearest first.
/// The first is some 100 times what a point loses as text of seven digits; the others find points that were taken
/// from a smooth surface beside the mesh.
const REACHES: [f32; 3] = [1e-5, 1e-4, 1e-3];

/// How many surfaces a short ray is followed through at one reach.
const MOST_LAYERS: u32 = 4;

/// What a point lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Located {
    /// A triangle of the scene, at these barycentric coordinates.
    On(u32, Vec2),
    /// What was left out of the scene, enclosed in solids: it is dark.
    Enclosed,
}

impl Located {
    /// The triangle and the barycentric coordinates, if there is a triangle.
    pub fn on(self) -> Option<(u32, Vec2)> {
        match self {
            Self::On(triangle, barycentric) => Some((triangle, barycentric)),
            Self::Enclosed => None,
        }
    }
}

/// The triangle at `position` whose front side faces along `normal`, and the barycentric coordinates there.
///
/// `position` is in local units; `normal` (unit length) may be an interpolated one. A short ray is shot down at the
/// surface from a little above it: one ray where the point lies on a single sheet. Among several faces in reach that
/// face along the normal, the nearest is taken; if none does, the first of the others. `None` if there is none at all.
pub fn locate_point(tracer: &impl RayTracer, scene: &Scene, position: Vec3, normal: Vec3) -> Option<Located> {
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
            return Some(Located::On(hit.triangle, hit.barycentric));
        }
        if is_enclosed(scene, position, normal, reach) {
            return Some(Located::Enclosed);
        }
    }
    facing_away.map(|hit| Located::On(hit.triangle, hit.barycentric))
}

/// True if the point lies on one of the scene's enclosed places, or within `reach` of one.
fn is_enclosed(scene: &Scene, position: Vec3, normal: Vec3, reach: f32) -> bool {
    scene.enclosed.iter().any(|corners| {
        let [a, b, c] = *corners;
        let own_normal = unit_or_zero((b - a).cross(c - a));
        let is_inside =
            |(from, to): (Vec3, Vec3)| own_normal.cross((to - from).normalize_or_zero()).dot(position - from) >= -reach;
        own_normal.dot(normal) > NEAR
            && own_normal.dot(position - a).abs() <= reach
            && [(a, b), (b, c), (c, a)].into_iter().all(is_inside)
    })
}

/// The least cosine between two normals that are the same.
const NEAR: f32 = 0.9;

/// True where the hit is on the front and the triangle's shading normal there is near the wanted one: tells the faces
/// that meet in a crease from each other.
fn faces_along(scene: &Scene, hit: &Hit, normal: Vec3) -> bool {
    hit.front && scene.mesh.shading_normal(hit.triangle, hit.barycentric).dot(normal) > NEAR
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{
        scene::{LoadOptions, load::load_from_memory},
        trace::Tracer,
    };

    /// A floor, a sheet a hair above it, and the floor's own underside; around them a frame 2 wide.
    fn sheets() -> Arc<Scene> {
        let mut obj = String::new();
        for (y, order) in [(0.0, "1 4 3 2"), (0.0, "5 6 7 8"), (0.00004, "9 12 11 10")] {
            for (x, z) in [(-1, -1), (1, -1), (1, 1), (-1, 1)] {
                obj += &format!("v {x} {y} {z}\n");
            }
            obj += &format!("f {order}\n");
        }
        obj += "v -1 -0.3 -1\nv 1 -0.3 -1\nv 1 0.9 -1\nv -1 0.9 -1\nf 13 14 15 16\n";
        Arc::new(load_from_memory("sheets", &obj, "", &LoadOptions::default()).unwrap())
    }

    #[test]
    fn of_sheets_that_lie_on_each_other_the_one_that_faces_along_the_normal_is_found() {
        let scene = sheets();
        let tracer = Tracer::new(scene.clone());
        for (y, normal) in [(0.0, Vec3::NEG_Y), (0.00004, Vec3::Y)] {
            for x in [-0.9, -0.31, 0.0, 0.4] {
                let position = scene.frame.point_to_local(glam::DVec3::new(x, y, 0.123));
                let (triangle, barycentric) = locate_point(&tracer, &scene, position, normal).unwrap().on().unwrap();
                assert!(scene.mesh.geometric_normal(triangle).dot(normal) > 0.99, "{y} {normal}");
                let apart = scene.mesh.position(triangle, barycentric).distance(position);
                assert!(apart < 1e-6, "{y} {normal} {x}: {apart} away");
            }
        }
        // What lies between the sheets is left out, as no light comes there.
        let between = scene.frame.point_to_local(glam::DVec3::new(0.2, 0.0, 0.1));
        assert_eq!(locate_point(&tracer, &scene, between, Vec3::Y), Some(Located::Enclosed));
        // The upper sheet has no underside: seen from below, its only face is taken for want of a better one.
        let under = scene.frame.point_to_local(glam::DVec3::new(0.2, 0.00004, 0.1));
        assert!(locate_point(&tracer, &scene, under, Vec3::NEG_Y).is_some());
    }

    #[test]
    fn points_beside_the_mesh_are_found_up_to_a_thousandth_and_no_further() {
        let scene = sheets();
        let tracer = Tracer::new(scene.clone());
        let wall = scene.frame.point_to_local(glam::DVec3::new(0.2, 0.5, -1.0));
        for offset in [0.0, 3e-6, -3e-5, 5e-4, -9e-4] {
            for normal in [Vec3::Z, Vec3::new(0.1, -0.2, 1.0).normalize()] {
                let found = locate_point(&tracer, &scene, wall + offset * Vec3::Z, normal);
                let (triangle, barycentric) = found.unwrap().on().unwrap();
                assert!(scene.mesh.position(triangle, barycentric).distance(wall) < 4e-4, "{offset} {normal}");
            }
        }
        assert_eq!(locate_point(&tracer, &scene, wall + 0.01 * Vec3::Z, Vec3::Z), None);
    }
}
