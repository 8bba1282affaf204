//! Where a scene without a state file is looked at from: a room from inside, all else from outside.

use std::{f32::consts::TAU, sync::Arc};

use glam::Vec3;

use crate::{
    scene::{Scene, camera::CameraState},
    trace::{RayTracer as _, Tracer, surface::free_ray},
};

/// Rays around the middle of a scene, by rows of directions from pole to pole and around.
const ROWS: u32 = 10;
const AROUND: u32 = 20;

/// Of those so many must meet fronts: a box with one open side has five sixths.
const LEAST_FRONTS: f32 = 0.9;

/// A room is looked at from so far back towards the wall behind.
const BACK: f32 = 0.9;

/// The camera for a scene.
pub(super) fn first_camera(scene: &Arc<Scene>) -> CameraState {
    let (minimum, maximum) = scene.bounds_in_metres();
    let outside = CameraState::looking_at_bounds(minimum, maximum);
    if scene.mesh.triangles.is_empty() {
        return outside;
    }
    let tracer = Tracer::new(Arc::clone(scene));
    let middle = scene.frame.point_to_local(0.5 * (minimum + maximum));
    let front = |direction: Vec3| tracer.closest_hit(&free_ray(middle, direction)).filter(|hit| hit.front);
    // Rows of one height cut slices of one area off a sphere (Archimedes).
    let direction = |row: u32, place: u32| {
        let height = 1.0 - (2.0 * row as f32 + 1.0) / ROWS as f32;
        let angle = TAU * (place as f32 + 0.5) / AROUND as f32;
        let radius = (1.0 - height * height).sqrt();
        Vec3::new(radius * angle.cos(), height, radius * angle.sin())
    };
    let all = (0..ROWS * AROUND).map(|index| direction(index / AROUND, index % AROUND));
    let fronts = all.filter(|direction| front(*direction).is_some()).count();
    if (fronts as f32) < LEAST_FRONTS * (ROWS * AROUND) as f32 {
        return outside;
    }
    let level = (0..AROUND).map(|place| {
        let (sine, cosine) = (TAU * place as f32 / AROUND as f32).sin_cos();
        Vec3::new(cosine, 0.0, sine)
    });
    let free = |direction: Vec3| front(direction).map_or(0.0, |hit| hit.distance);
    let longest = level.max_by(|a, b| (free(*a) + free(-*a)).total_cmp(&(free(*b) + free(-*b))));
    let forward = longest.unwrap_or(Vec3::NEG_Z);
    let position = middle - BACK * free(-forward) * forward;
    let metres = |local: Vec3| scene.frame.point_to_metres(local).to_array();
    CameraState { position: metres(position), target: metres(position + forward), fov_degrees: 65.0, ..outside }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;
    use crate::scene::{LoadOptions, builtin, load::load_from_memory};

    /// A box from (0, 0, 0) to (4, 2, 1), seen from inside, or turned inside out.
    fn room(is_turned: bool, more: &str) -> Arc<Scene> {
        let corners = "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nv 0 0 1\nv 4 0 1\nv 4 2 1\nv 0 2 1\n";
        let faces = ["1 2 3 4", "8 7 6 5", "5 6 2 1", "4 3 7 8", "5 1 4 8", "2 6 7 3"];
        let turned = |face: &str| face.split(' ').rev().collect::<Vec<_>>().join(" ");
        let face = |face: &str| format!("f {}\n", if is_turned { turned(face) } else { String::from(face) });
        let text = format!("{corners}{}{more}", faces.map(face).concat());
        Arc::new(load_from_memory("room", &text, "", &LoadOptions::default()).unwrap())
    }

    fn is_inside(camera: &CameraState) -> bool {
        camera.position.iter().zip([4.0, 2.0, 1.0]).all(|(place, size)| *place > 0.0 && *place < size)
    }

    #[test]
    fn a_room_is_looked_at_from_inside_along_its_longest_way() {
        let camera = first_camera(&room(false, ""));
        assert!(is_inside(&camera), "{camera:?}");
        let way: Vec<f64> = camera.target.iter().zip(camera.position).map(|(to, from)| to - from).collect();
        assert!(way[0].abs() > 3.0 * way[2].abs() && way[1].abs() < 1e-6, "{way:?}");
        // It stands in the end that it looks away from.
        assert!((camera.position[0] - 2.0) * way[0] < 0.0, "{camera:?}");
    }

    #[test]
    fn an_object_on_a_plane_and_a_box_with_an_open_side_are_looked_at_from_outside() {
        let plane = "v -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\nf 12 11 10 9\n";
        for scene in [room(true, ""), room(true, plane), Arc::new(builtin::cornell(&LoadOptions::default()).unwrap())] {
            let (minimum, maximum) = scene.bounds_in_metres();
            assert_eq!(first_camera(&scene), CameraState::looking_at_bounds(minimum, maximum));
        }
    }
}
