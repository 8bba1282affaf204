//! From local units to the screen.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::scene::Camera;

/// Depth of the near plane in local units: a thousandth of the scene's size. There is no far plane. Nearer would do on
/// Vulkan, but OpenGL's depth, which wgpu maps from [-1, 1], would then have too few digits left.
pub const NEAR: f32 = 1e-3;

/// Local units to clip space, with wgpu's conventions: depth is reversed (1 at the near plane, 0 at infinity), so that
/// floating-point depth keeps its digits at any distance. `aspect` is width over height.
pub fn view_projection(camera: &Camera, aspect: f32) -> Mat4 {
    let focal = 1.0 / camera.tan_half_fov;
    let row = |axis: Vec3, scale: f32| (axis * scale).extend(-axis.dot(camera.position) * scale);
    let depth = row(camera.forward, 1.0);
    let nearness = Vec4::new(0.0, 0.0, 0.0, NEAR);
    Mat4::from_cols(row(camera.right, focal / aspect), row(camera.up, focal), nearness, depth).transpose()
}

/// Where a point in local units appears: (0,0) is the picture's top left corner and (1,1) the bottom right one, as in
/// [`Camera::direction`]. None for points behind the near plane; a point beside the picture lies outside [0, 1].
pub fn project(camera: &Camera, aspect: f32, point: Vec3) -> Option<Vec2> {
    let clip = view_projection(camera, aspect) * point.extend(1.0);
    (clip.w >= NEAR).then(|| Vec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LocalFrame, camera::CameraState};

    #[test]
    fn a_point_along_a_picture_direction_projects_to_that_point_of_the_picture() {
        let state = CameraState { position: [0.3, -0.2, 1.5], target: [0.1, 0.4, -0.7], ..CameraState::default() };
        let camera = state.to_local(&LocalFrame::default());
        for place in [Vec2::ZERO, Vec2::splat(0.5), Vec2::new(0.9, 0.2), Vec2::new(-0.4, 1.3)] {
            for distance in [0.01, 1.0, 50.0] {
                let point = camera.position + distance * camera.direction(place, 1.6);
                #[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
                let seen = project(&camera, 1.6, point).unwrap();
                assert!(seen.abs_diff_eq(place, 2e-4), "{seen} instead of {place} at {distance}");
            }
            assert_eq!(project(&camera, 1.6, camera.position - camera.direction(place, 1.6)), None);
        }
    }

    #[test]
    fn depth_is_one_at_the_near_plane_and_falls_towards_zero_for_ever() {
        let camera = CameraState::default().to_local(&LocalFrame::default());
        let depth = |distance: f32| {
            let clip = view_projection(&camera, 1.0) * (camera.position + distance * camera.forward).extend(1.0);
            clip.z / clip.w
        };
        assert!((depth(NEAR) - 1.0).abs() < 1e-3);
        assert!(depth(1.0) > depth(1.0001) && depth(100.0) > depth(100.01) && depth(1e6) > 0.0);
    }
}
