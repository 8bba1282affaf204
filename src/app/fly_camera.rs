//! A camera that is flown by keys and turned by dragging.

use glam::{DQuat, DVec3, Vec3};

use crate::scene::{Scene, area_light::AreaLightState, camera::CameraState};

/// Radians that one point of dragging turns.
const RADIANS_PER_POINT: f64 = 0.004;
/// How near the view may come to straight up or down, in radians.
const POLE_DISTANCE: f64 = 0.02;

/// A camera in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyCamera {
    /// Eye point, in metres.
    pub position: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// Unit vector that stays up.
    pub up: DVec3,
    /// Vertical field of view, in degrees.
    pub fov_degrees: f32,
    /// Metres a second.
    pub speed: f64,
}

impl FlyCamera {
    /// The camera of a state; its speed crosses the scene in some four seconds.
    pub fn new(state: &CameraState, scene: &Scene) -> Self {
        let (low, high) = scene.bounds_in_metres();
        let mut camera = Self {
            position: DVec3::ZERO,
            forward: DVec3::NEG_Z,
            up: DVec3::Y,
            fov_degrees: 45.0,
            speed: (0.25 * (high - low).max_element()).max(1e-9),
        };
        camera.set(state);
        camera
    }

    /// Takes over position, direction and field of view; the speed stays.
    pub fn set(&mut self, state: &CameraState) {
        self.position = DVec3::from_array(state.position);
        self.up = DVec3::from_array(state.up).try_normalize().unwrap_or(DVec3::Y);
        self.forward = (DVec3::from_array(state.target) - self.position).try_normalize().unwrap_or(DVec3::NEG_Z);
        self.fov_degrees = state.fov_degrees;
    }

    /// The camera as a state file has it; the target lies one second of flight ahead.
    pub fn state(&self) -> CameraState {
        CameraState {
            position: self.position.to_array(),
            target: (self.position + self.forward * self.speed.max(1e-9)).to_array(),
            up: self.up.to_array(),
            fov_degrees: self.fov_degrees,
        }
    }

    /// Unit vector to the right of the picture.
    pub fn right(&self) -> DVec3 {
        self.forward.cross(self.up).try_normalize().unwrap_or_else(|| self.forward.any_orthonormal_vector())
    }

    /// Flies for `seconds` along `direction`: x to the right, y up, z into the picture.
    pub fn fly(&mut self, direction: Vec3, seconds: f64) {
        let direction = direction.as_dvec3();
        let along = direction.x * self.right() + direction.y * self.up + direction.z * self.forward;
        self.position += along.normalize_or_zero() * self.speed * seconds;
    }

    /// Turns as if the picture were dragged by so many points to the right and down.
    pub fn look(&mut self, right: f32, down: f32) {
        let yaw = DQuat::from_axis_angle(self.up, f64::from(right) * RADIANS_PER_POINT);
        let elevation = self.forward.angle_between(self.up);
        let limit = std::f64::consts::PI - POLE_DISTANCE;
        let turned = (elevation - f64::from(down) * RADIANS_PER_POINT).clamp(POLE_DISTANCE, limit);
        let pitch = DQuat::from_axis_angle(self.right(), elevation - turned);
        self.forward = (yaw * (pitch * self.forward)).try_normalize().unwrap_or(self.forward);
    }

    /// The light at the camera, facing where it looks; its size and radiance stay.
    pub fn place(&self, light: &AreaLightState) -> AreaLightState {
        let length = |vector: [f64; 3]| DVec3::from_array(vector).length();
        let right = self.right();
        let up = right.cross(self.forward);
        // u × v is the direction of the light: up × right = forward for a right-handed (right, up, -forward).
        AreaLightState {
            centre: self.position.to_array(),
            u: (up * length(light.u)).to_array(),
            v: (right * length(light.v)).to_array(),
            radiance: light.radiance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> FlyCamera {
        FlyCamera {
            position: DVec3::new(1.0, 2.0, 3.0),
            forward: DVec3::NEG_Z,
            up: DVec3::Y,
            fov_degrees: 40.0,
            speed: 2.0,
        }
    }

    #[test]
    fn flying_goes_along_the_axes_of_the_picture_at_the_set_speed() {
        let mut flown = camera();
        flown.fly(Vec3::new(0.0, 0.0, 1.0), 0.5);
        flown.fly(Vec3::new(1.0, 0.0, 0.0), 1.0);
        flown.fly(Vec3::new(0.0, -1.0, 0.0), 0.25);
        assert!(flown.position.abs_diff_eq(DVec3::new(3.0, 1.5, 2.0), 1e-12), "{:?}", flown.position);
    }

    #[test]
    fn dragging_to_the_right_turns_the_view_to_the_left_and_it_never_tips_over() {
        let mut turned = camera();
        turned.look(10.0, 0.0);
        assert!(turned.forward.x < 0.0 && turned.forward.y.abs() < 1e-12);
        turned.look(0.0, 10.0);
        assert!(turned.forward.y > 0.0, "dragging down shows what is above");
        turned.look(0.0, 1e6);
        assert!(turned.forward.y > 0.99 && turned.forward.is_normalized());
        turned.look(0.0, -1e6);
        assert!(turned.forward.y < -0.99 && turned.right().is_normalized());
    }

    #[test]
    fn a_light_placed_at_the_camera_shines_where_it_looks_and_keeps_its_size() {
        let light = AreaLightState { u: [0.3, 0.0, 0.0], v: [0.0, 0.0, 0.7], ..AreaLightState::default() };
        let placed = camera().place(&light);
        let (u, v) = (DVec3::from_array(placed.u), DVec3::from_array(placed.v));
        assert!(u.cross(v).normalize().abs_diff_eq(DVec3::NEG_Z, 1e-12));
        assert!((u.length() - 0.3).abs() < 1e-12 && (v.length() - 0.7).abs() < 1e-12);
        assert_eq!(placed.centre, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn a_state_made_from_the_camera_gives_the_same_view() {
        let first = camera();
        let mut second = camera();
        second.set(&first.state());
        assert!(second.forward.abs_diff_eq(first.forward, 1e-12) && second.position == first.position);
    }
}
