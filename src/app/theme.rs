//! Colours of the window.

use egui::{Color32, Context, CornerRadius, FullOutput, Plugin, TextureId, TextureOptions, Theme, Visuals};

/// The ground of panels and plots. The window is cleared to it, and nothing is drawn there: on a software driver, filling
/// the panels took longer than drawing the views.
const GROUND: Color32 = Color32::from_gray(27);

/// Sets the colours. A software driver gets square corners: round ones are fans of slivers, and cost it three times as much.
pub(super) fn install(context: &Context, software_driver: bool) {
    context.set_theme(Theme::Dark);
    context.style_mut_of(Theme::Dark, |style| {
        style.visuals.panel_fill = Color32::TRANSPARENT;
        // Scrolled panels fade out in the colour of their ground: that is nothing here, but would be drawn.
        style.spacing.scroll.fade.strength = 0.0;
        if software_driver {
            square_corners(&mut style.visuals);
        }
    });
    if software_driver {
        // Dots of a font texture would be scaled.
        context.tessellation_options_mut(|options| options.prerasterized_discs = false);
        context.add_plugin(WholePixels);
    }
}

/// Letters lie on whole pixels, so that the nearest texel is what a filter of four would give: a quarter of the reads.
struct WholePixels;

impl Plugin for WholePixels {
    fn debug_name(&self) -> &'static str {
        "letters on whole pixels"
    }

    fn output_hook(&mut self, _: &Context, output: &mut FullOutput) {
        let letters = output.textures_delta.set.get_mut(&TextureId::default());
        for delta in letters.into_iter().flatten() {
            delta.options = TextureOptions::NEAREST;
        }
    }
}

fn square_corners(visuals: &mut Visuals) {
    let widgets = &mut visuals.widgets;
    for widget in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        widget.corner_radius = CornerRadius::ZERO;
    }
    visuals.window_corner_radius = CornerRadius::ZERO;
    visuals.menu_corner_radius = CornerRadius::ZERO;
}

/// Smooth edges of widgets, or hard ones, which a software driver draws in two thirds of the time.
pub(super) fn set_soft_edges(context: &Context, soft: bool) {
    context.tessellation_options_mut(|options| options.feathering = soft);
}

/// What the window is cleared to.
pub(super) fn clear_color() -> [f32; 4] {
    GROUND.to_normalized_gamma_f32()
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{ImageData, epaint::Primitive};

    /// A frame of text on a software driver: its triangles and the first picture of its letters.
    fn text_at_scale(pixels_per_point: f32) -> (Vec<egui::epaint::Mesh>, [usize; 2], TextureOptions) {
        let context = Context::default();
        install(&context, true);
        context.set_pixels_per_point(pixels_per_point);
        let mut output = FullOutput::default();
        for _ in 0..2 {
            output.append(context.run_ui(egui::RawInput::default(), |ui| {
                ui.label("Estimated error [%] by seconds");
                let _ = ui.button("Reset tone map");
            }));
        }
        let letters = &output.textures_delta.set[&TextureId::default()];
        let ImageData::Color(picture) = &letters[0].image;
        let meshes = context.tessellate(output.shapes, output.pixels_per_point).into_iter();
        let meshes = meshes.filter_map(|clipped| match clipped.primitive {
            Primitive::Mesh(mesh) => Some(mesh),
            Primitive::Callback(_) => None,
        });
        let text = (meshes.collect(), picture.size, letters[0].options);
        output.textures_delta.clear();
        text
    }

    #[test]
    fn letters_lie_on_whole_pixels_so_that_the_nearest_texel_is_the_filtered_one() {
        for scale in [1.0, 1.5, 2.0] {
            let (meshes, atlas_size, options) = text_at_scale(scale);
            assert_eq!(options, TextureOptions::NEAREST);
            let corners = meshes.iter().flat_map(|mesh| &mesh.vertices);
            let corners: Vec<_> = corners.filter(|corner| corner.uv != egui::epaint::WHITE_UV).collect();
            assert!(corners.len() > 4 * 30, "{} corners of letters at scale {scale}", corners.len());
            for corner in corners {
                let pixel = corner.pos * scale;
                let texel = corner.uv.to_vec2() * egui::vec2(atlas_size[0] as f32, atlas_size[1] as f32);
                for value in [pixel.x, pixel.y, texel.x, texel.y] {
                    assert!((value - value.round()).abs() < 1e-3, "{value} at scale {scale}");
                }
            }
        }
    }
}
