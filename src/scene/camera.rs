//! A pinhole camera.

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::LocalFrame;

/// A pinhole camera in local units; made from [`CameraState`], which is in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye point.
    pub position: Vec3,
    /// Unit vector into the picture.
    pub forward: Vec3,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Unit vector to the top of the picture.
    pub up: Vec3,
    /// Tangent of half the vertical field of view.
    pub tan_half_fov: f32,
}

impl Camera {
    /// Direction (not unit length) through a point of the picture: (0,0) is the top left corner, (1,1) the bottom
    /// right one; `aspect` is width over height.
    pub fn direction(&self, picture_point: Vec2, aspect: f32) -> Vec3 {
        let x = (2.0 * picture_point.x - 1.0) * self.tan_half_fov * aspect;
        let y = (1.0 - 2.0 * picture_point.y) * self.tan_half_fov;
        self.forward + x * self.right + y * self.up
    }
}

/// The camera as people write it: in metres and degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CameraState {
    /// Eye point, in metres.
    pub position: [f64; 3],
    /// A point the camera looks at, in metres.
    pub target: [f64; 3],
    /// Up direction.
    pub up: [f64; 3],
    /// Vertical field of view, in degrees, above 0 and below 180.
    pub fov_degrees: f32,
}

impl Default for CameraState {
    fn default() -> Self {
        Self { position: [0.0, 0.0, 3.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_degrees: 45.0 }
    }
}

impl CameraState {
    /// A camera that sees the whole box from its open +z or -z side: used where a scene comes without a state.
    pub fn looking_at_bounds(minimum: DVec3, maximum: DVec3) -> Self {
        let centre = 0.5 * (minimum + maximum);
        let size = maximum - minimum;
        let fov_degrees = 45.0_f32;
        let distance = 0.6 * size.x.max(size.y) / f64::from((0.5 * fov_degrees).to_radians().tan()) + 0.5 * size.z;
        Self {
            position: (centre + DVec3::Z * distance).to_array(),
            target: centre.to_array(),
            up: [0.0, 1.0, 0.0],
            fov_degrees,
        }
    }

    /// The camera in a scene's local units. A degenerate view (eye = target, up along the view) is mended.
    pub fn to_local(&self, frame: &LocalFrame) -> Camera {
        let position = frame.point_to_local(DVec3::from_array(self.position));
        let target = frame.point_to_local(DVec3::from_array(self.target));
        let forward = (target - position).try_normalize().unwrap_or(Vec3::NEG_Z);
        let up = DVec3::from_array(self.up).as_vec3();
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        Camera {
            position,
            forward,
            right,
            up: right.cross(forward),
            tan_half_fov: (0.5 * self.fov_degrees.clamp(1.0, 179.0)).to_radians().tan(),
        }
    }
}
