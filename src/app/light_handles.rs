//! Handles of the placed light: one in its middle moves it, one at the tip of its arrow turns it.

use egui::{Color32, Pos2, Rect, Sense, Stroke, Ui, Vec2 as Points};
use glam::{Quat, Vec3};

use crate::{
    gpu::project,
    scene::{AreaLight, Camera},
};

/// sRGB-coded colour of the light's outline and handles.
pub(super) const COLOUR: Vec3 = Vec3::new(1.0, 0.85, 0.3);
/// Radius of a handle, in points.
const RADIUS: f32 = 5.0;

/// Where a point in local units appears in a view.
pub(super) fn on_screen(rect: Rect, camera: &Camera, point: Vec3) -> Option<Pos2> {
    let place = project(camera, rect.aspect_ratio(), point)?;
    Some(rect.min + Points::new(place.x, place.y) * rect.size())
}

/// Draws the handles and returns the light as they were dragged, if they were.
pub(super) fn ui(ui: &mut Ui, rect: Rect, camera: &Camera, light: &AreaLight) -> Option<AreaLight> {
    let length = 0.5 * (light.half_extent_u.length() + light.half_extent_v.length());
    let tip = light.centre + length * light.normal();
    let [from, to] = [light.centre, tip].map(|end| on_screen(rect, camera, end));
    let [red, green, blue] = COLOUR.to_array().map(|value| (255.0 * value) as u8);
    let colour = Color32::from_rgb(red, green, blue);
    let painter = ui.painter().with_clip_rect(rect);
    if let (Some(from), Some(to)) = (from, to) {
        painter.line_segment([from, to], Stroke::new(1.5, colour));
    }
    let dragged = |name: &str, place: Option<Pos2>, tooltip: &str| {
        let place = place.filter(|place| rect.contains(*place))?;
        let area = Rect::from_center_size(place, Points::splat(4.0 * RADIUS));
        let id = ui.scope_id().with((name, rect.left().to_bits()));
        let response = ui.interact(area, id, Sense::drag()).on_hover_text(tooltip);
        let hot = response.hovered() || response.dragged();
        painter.circle_filled(place, RADIUS, if hot { Color32::WHITE } else { colour });
        painter.circle_stroke(place, RADIUS, Stroke::new(1.0, Color32::BLACK));
        let delta = response.drag_delta();
        (response.dragged() && delta != Points::ZERO).then_some(delta)
    };
    let moved = dragged("light's centre", from, "Drag to move the light, parallel to the picture");
    let turned = dragged("light's direction", to, "Drag to turn the light");
    let offset = |delta: Points, point: Vec3| {
        let depth = (point - camera.position).dot(camera.forward);
        let scale = 2.0 * camera.tan_half_fov * depth / rect.height();
        scale * (delta.x * camera.right - delta.y * camera.up)
    };
    if let Some(delta) = moved {
        return Some(AreaLight { centre: light.centre + offset(delta, light.centre), ..*light });
    }
    turned.map(|delta| turn(light, tip + offset(delta, tip)))
}

/// The light, turned so that it shines towards a point.
fn turn(light: &AreaLight, target: Vec3) -> AreaLight {
    let Some(direction) = (target - light.centre).try_normalize() else { return *light };
    let turn = Quat::from_rotation_arc(light.normal(), direction);
    AreaLight { half_extent_u: turn * light.half_extent_u, half_extent_v: turn * light.half_extent_v, ..*light }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_light_shines_towards_its_target_and_keeps_its_size() {
        let light = AreaLight {
            centre: Vec3::new(0.1, 0.2, 0.3),
            half_extent_u: Vec3::new(0.2, 0.0, 0.0),
            half_extent_v: Vec3::new(0.0, 0.0, 0.3),
            radiance: Vec3::ONE,
        };
        let turned = turn(&light, Vec3::new(1.1, 0.2, 0.3));
        assert!(turned.normal().distance(Vec3::X) < 1e-6, "{}", turned.normal());
        assert!((turned.area() - light.area()).abs() < 1e-6);
    }
}
