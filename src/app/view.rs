//! The views: one or two pictures of the scene by the same camera, with what is drawn over them.

use egui::{Align2, Color32, CornerRadius, FontId, Pos2, Rect, Sense, Stroke, Ui, Vec2 as Points};
use glam::Vec2;

use super::{
    elements::Elements,
    layout::Layout,
    light_handles,
    picked::Picked,
    vertex_rays,
    view_settings::{ViewField, ViewSettings},
};
use crate::{
    gpu::{Shading, ViewFrame, false_color, paint_callback},
    scene::AreaLight,
    solver::one_vertex::VertexRays,
};

/// Half the width of the divider's grip, in points.
const GRIP: f32 = 4.0;

/// What the pointer did in a view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Gestures {
    /// How far the picture was dragged, in points.
    pub(super) look: Option<Points>,
    /// How far the wheel was turned over it, in points.
    pub(super) wheel: f32,
    /// The point of the picture that was clicked, and the picture's aspect.
    pub(super) click: Option<(Vec2, f32)>,
    /// The light, in local units, as its handles were dragged.
    pub(super) light: Option<AreaLight>,
}

/// What the views show.
pub(super) struct Scenery<'a> {
    /// What is drawn in each view; of its parts, the views set `view`, `field`, `shading` (unless it is plain), `wireframe` and `buried`.
    pub(super) frames: [ViewFrame; 2],
    /// The fields of both.
    pub(super) fields: [&'a ViewField; 2],
    /// What they are called.
    pub(super) titles: [String; 2],
    /// The clicked point, with the elements it lies on.
    pub(super) picked: Option<(Picked, &'a Elements)>,
    /// The rays of one vertex.
    pub(super) rays: Option<&'a VertexRays>,
}

/// Draws one view, or two with a divider.
pub(super) fn ui(ui: &mut Ui, layout: &mut Layout, scenery: &Scenery<'_>) -> Gestures {
    let whole = ui.available_rect_before_wrap();
    let mut gestures = Gestures::default();
    if !layout.second_view {
        view_ui(ui, whole, &layout.views[0], scenery, 0, &mut gestures);
        return gestures;
    }
    let divider = whole.left() + layout.divider.clamp(0.1, 0.9) * whole.width();
    let left = Rect::from_min_max(whole.min, Pos2::new(divider - 1.0, whole.bottom()));
    let right = Rect::from_min_max(Pos2::new(divider + 1.0, whole.top()), whole.max);
    view_ui(ui, left, &layout.views[0], scenery, 0, &mut gestures);
    view_ui(ui, right, &layout.views[1], scenery, 1, &mut gestures);
    let grip = Rect::from_x_y_ranges(divider - GRIP..=divider + GRIP, whole.y_range());
    let response = ui.interact(grip, ui.scope_id().with("divider"), Sense::drag());
    let response = response.on_hover_and_drag_cursor(egui::CursorIcon::ResizeHorizontal);
    if let Some(pointer) = response.interact_pointer_pos() {
        layout.divider = ((pointer.x - whole.left()) / whole.width()).clamp(0.1, 0.9);
    }
    let colour = if response.hovered() || response.dragged() { Color32::WHITE } else { Color32::from_gray(130) };
    ui.painter().vline(divider, whole.y_range(), Stroke::new(2.0, colour));
    gestures
}

fn view_ui(
    ui: &mut Ui,
    rect: Rect,
    settings: &ViewSettings,
    scenery: &Scenery<'_>,
    number: usize,
    gestures: &mut Gestures,
) {
    let (field, mut frame) = (scenery.fields[number], scenery.frames[number].clone());
    frame.field.clone_from(&field.field);
    frame.field_version = field.version;
    if frame.shading != Shading::Plain {
        frame.shading = settings.shading(field.bright);
    }
    frame.wireframe = settings.wireframe;
    if !settings.buried {
        frame.buried = None;
    }
    frame.light_outline = frame.light.map(|_| light_handles::COLOUR);
    let (camera, light) = (frame.camera, frame.light);
    let response = ui.interact(rect, ui.scope_id().with(("view", number)), Sense::click_and_drag());
    ui.painter().add(paint_callback(rect, ui.ctx().pixels_per_point(), frame));
    if let Some(light) = light {
        gestures.light = gestures.light.or(light_handles::ui(ui, rect, &camera, &light));
    }
    let painter = ui.painter().with_clip_rect(rect);
    if let Some(rays) = scenery.rays {
        vertex_rays::draw(&painter, rect, &camera, rays);
    }
    if let Some((picked, elements)) = scenery.picked
        && let Some(place) = light_handles::on_screen(rect, &camera, picked.position(elements))
    {
        painter.circle_stroke(place, 5.0, Stroke::new(2.0, Color32::BLACK));
        painter.circle_stroke(place, 5.0, Stroke::new(1.0, Color32::WHITE));
    }
    label(&painter, rect.left_top() + Points::new(8.0, 8.0), Align2::LEFT_TOP, &scenery.titles[number]);
    if settings.has_legend() {
        legend(&painter, rect, settings, field.bright);
    }
    if response.dragged_by(egui::PointerButton::Primary) {
        gestures.look = Some(response.drag_delta());
    }
    if response.contains_pointer() {
        gestures.wheel += ui.input(|input| input.smooth_scroll_delta().y);
    }
    if response.clicked() {
        ui.ctx().memory_mut(|memory| {
            if let Some(focused) = memory.focused() {
                memory.surrender_focus(focused);
            }
        });
        gestures.click = response.interact_pointer_pos().map(|place| {
            let point = (place - rect.min) / rect.size();
            (Vec2::new(point.x, point.y), rect.aspect_ratio())
        });
    }
}

/// Text on a ground of its own, since pictures may be as bright as it.
fn label(painter: &egui::Painter, place: Pos2, anchor: Align2, text: &str) {
    let galley = painter.layout_no_wrap(String::from(text), FontId::proportional(13.0), Color32::from_gray(230));
    let rect = anchor.anchor_size(place, galley.size());
    painter.rect_filled(rect.expand2(Points::new(3.0, 1.0)), CornerRadius::ZERO, Color32::from_black_alpha(150));
    painter.galley(rect.min, galley, Color32::WHITE);
}

/// The false colours with their values, at the bottom left.
fn legend(painter: &egui::Painter, rect: Rect, settings: &ViewSettings, bright: f32) {
    const STEPS: usize = 64;
    let range = settings.range(bright);
    let bar = Rect::from_min_size(rect.left_bottom() + Points::new(12.0, -44.0), Points::new(220.0, 12.0));
    for step in 0..STEPS {
        let [red, green, blue] = false_color::color((step as f32 + 0.5) / STEPS as f32).to_array();
        let part = |step: usize| bar.left() + bar.width() * step as f32 / STEPS as f32;
        let cell = Rect::from_x_y_ranges(part(step)..=part(step + 1), bar.y_range());
        let colour = Color32::from_rgb((255.0 * red) as u8, (255.0 * green) as u8, (255.0 * blue) as u8);
        painter.rect_filled(cell, CornerRadius::ZERO, colour);
    }
    for (place, anchor) in [(0.0, Align2::LEFT_TOP), (0.5, Align2::CENTER_TOP), (1.0, Align2::RIGHT_TOP)] {
        let value = if range.logarithmic {
            range.minimum * (range.maximum / range.minimum).powf(place)
        } else {
            range.minimum + place * (range.maximum - range.minimum)
        };
        let foot = Pos2::new(bar.left() + place * bar.width(), bar.bottom() + 3.0);
        let text = if value != 0.0 && !(0.01..1000.0).contains(&value) {
            format!("{value:.1e}")
        } else {
            format!("{value:.3}")
        };
        label(painter, foot, anchor, &text);
    }
    label(painter, bar.right_center() + Points::new(10.0, 0.0), Align2::LEFT_CENTER, "W/m²");
}
