//! What one view shows in one frame, and the uniforms that all its shaders share.

use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3, Vec4};

use super::{ViewGeometry, false_color, projection::view_projection};
use crate::{
    math::color::ToneMap,
    scene::{AreaLight, Camera, Material},
};

/// The uniforms' declaration in WGSL; every shader of a view begins with it.
pub const FRAME_WGSL: &str = include_str!("frame.wgsl");

/// Samples a pixel that a view can have: without and with smooth edges.
pub(super) const SAMPLE_COUNTS: [u32; 2] = [1, 4];

/// What colour a surface gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shading {
    /// Radiance that leaves the surface: emitted + ρE/π, reflectance textures per pixel.
    Radiosity,
    /// Irradiance, as the radiance E/π of a white surface.
    Irradiance,
    /// Reflectance, without tone map.
    Albedo,
    /// Shading normals: (n + 1)/2 as colour.
    Normals,
    /// The field's luminance in false colours ([`false_color::color`]). A scalar field is shown by giving its value
    /// to all three bands: that is its own luminance.
    FalseColor(FalseColorRange),
    /// The field's own values, as sRGB-coded colours.
    Plain,
}

/// A lightmap whose pages are on the card.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFrame {
    /// The pages: [`super::lightmap::GpuSolver::pages`].
    pub pages: wgpu::Buffer,
    /// The view is drawn again when this number differs from the last frame's.
    pub version: u64,
    /// The absolute difference to the field at the vertices is shown.
    pub difference: bool,
    /// The nearest texel, and not the four around.
    pub nearest: bool,
    /// The page is a picture of this view itself, of so many columns and rows
    /// ([`super::screen_space::ScreenRenderer::page`]); any geometry will do then.
    pub on_screen: Option<[u32; 2]>,
}

/// The values at the two ends of the false colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseColorRange {
    /// The value that gets the first colour; above 0 if `logarithmic`.
    pub minimum: f32,
    /// The value that gets the last colour.
    pub maximum: f32,
    /// Equal steps of colour are equal ratios.
    pub logarithmic: bool,
}

impl FalseColorRange {
    /// The place of a value in the range: 0 at `minimum`, 1 at `maximum`; not clamped. What the shader computes.
    pub fn place(&self, value: f32) -> f32 {
        let scale = |value: f32| if self.logarithmic { value.max(1e-30).log2() } else { value };
        let [low, high] = [scale(self.minimum), scale(self.maximum)];
        (scale(value) - low) / (high - low).max(1e-30)
    }
}

/// Everything that one view shows in one frame. Cheap to make: the large parts are shared.
#[derive(Clone)]
pub struct ViewFrame {
    /// Which view: each number has its own picture and its own copy of the field on the card.
    pub view: u64,
    /// The elements.
    pub geometry: Arc<ViewGeometry>,
    /// The materials as they are now: the scene's, with edited reflectances and emission. As many as the scene's, with
    /// the same textures. Uploaded again when this is another `Arc`.
    pub materials: Arc<Vec<Material>>,
    /// Irradiance [W/m²] at the tessellation's vertices. Where it is too short, 0 is shown.
    pub field: Arc<Vec<Vec3>>,
    /// The field is uploaded when this number or the geometry differs from the last frame's.
    pub field_version: u64,
    /// Instead of the field: a lightmap, for a geometry that knows its places ([`ViewGeometry::with_map`]).
    pub map: Option<MapFrame>,
    /// True for vertices that are buried: elements around them are hatched. Uploaded when this is another `Arc`.
    pub buried: Option<Arc<Vec<bool>>>,
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels. `paint_callback` sets it.
    pub size: [u32; 2],
    /// What colour a surface gets.
    pub shading: Shading,
    /// From radiance to colour.
    pub tone_map: ToneMap,
    /// Draws the elements' edges.
    pub wireframe: bool,
    /// Irradiance [W/m²] added for looking round an unlit scene, in the views of radiosity and irradiance; 0 for none.
    /// Surfaces get between a tenth and all of it, depending on their direction, so that shapes show.
    pub ambient: Vec3,
    /// The placed area light: drawn as a rectangle that shines to its front.
    pub light: Option<AreaLight>,
    /// sRGB-coded colour of the light's outline, 2 pixels wide; none without.
    pub light_outline: Option<Vec3>,
    /// Four samples a pixel along the edges of surfaces.
    pub antialias: bool,
    /// For a software driver whose time somebody else needs: a quarter of the pixels, magnified; and while only the field
    /// changes, no triangle is drawn again.
    pub saves_time: bool,
    /// For a driver that draws on the processor: a large geometry is drawn coarse at once, and then in parts while
    /// nothing changes, one a frame, until all of it takes the coarse picture's place.
    pub gradual: bool,
}

impl ViewFrame {
    /// Width and height in pixels of the picture that is drawn.
    pub(super) fn picture_size(&self) -> [u32; 2] {
        if self.saves_time { self.size.map(|pixels| pixels.div_ceil(2)) } else { self.size }
    }

    /// Samples a pixel.
    pub(super) fn samples(&self) -> u32 {
        SAMPLE_COUNTS[usize::from(self.antialias)]
    }
}

/// Uniforms of a frame, laid out as `FrameUniforms` in `frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct FrameUniforms {
    /// Local units to clip space.
    pub view_projection: Mat4,
    /// Eye point.
    pub eye: Vec3,
    /// Width in pixels of the light's outline.
    pub outline_width: f32,
    /// Length of a typical edge of the elements, in local units.
    pub typical_edge: f32,
    /// Width and height of a pixel at depth 1, in local units.
    pub pixel_size: f32,
    /// 2^exposure / white.
    pub exposure_scale: f32,
    /// 1 / gamma.
    pub inverse_gamma: f32,
    /// Irradiance added for looking round; w unused.
    pub ambient: Vec4,
    /// xy: ends of the false colours. zw: texels of a page on the screen for each pixel.
    pub range: Vec4,
    /// The light's centre; w unused.
    pub light_centre: Vec4,
    /// The light's half-extent u; w unused.
    pub light_u: Vec4,
    /// The light's half-extent v; w unused.
    pub light_v: Vec4,
    /// sRGB-coded colour of the side that shines; w unused.
    pub light_color: Vec4,
    /// Colour of the outline; w unused.
    pub outline_color: Vec4,
    /// Stops of the false colours; w unused.
    pub false_colors: [Vec4; false_color::STOPS.len()],
}

impl FrameUniforms {
    /// The uniforms of a frame.
    pub fn new(frame: &ViewFrame) -> Self {
        let [width, height] = frame.size.map(|pixels| pixels.max(1) as f32);
        let ends = match frame.shading {
            Shading::FalseColor(range) => Vec2::new(range.minimum, range.maximum),
            _ => Vec2::ZERO,
        };
        let page = frame
            .map
            .as_ref()
            .and_then(|map| map.on_screen)
            .map_or(Vec2::ZERO, |size| Vec2::from(size.map(|texels| texels as f32)));
        let no_light = AreaLight {
            centre: Vec3::ZERO,
            half_extent_u: Vec3::ZERO,
            half_extent_v: Vec3::ZERO,
            radiance: Vec3::ZERO,
        };
        let light = frame.light.unwrap_or(no_light);
        Self {
            view_projection: view_projection(&frame.camera, width / height),
            eye: frame.camera.position,
            outline_width: if frame.light_outline.is_some() { 2.0 } else { 0.0 },
            typical_edge: frame.geometry.typical_edge(),
            pixel_size: 2.0 * frame.camera.tan_half_fov / height,
            exposure_scale: frame.tone_map.scale(),
            inverse_gamma: frame.tone_map.inverse_gamma(),
            ambient: frame.ambient.extend(0.0),
            range: ends.extend(page.x / width).extend(page.y / height),
            light_centre: light.centre.extend(0.0),
            light_u: light.half_extent_u.extend(0.0),
            light_v: light.half_extent_v.extend(0.0),
            light_color: frame.tone_map.apply(light.radiance).extend(0.0),
            outline_color: frame.light_outline.unwrap_or(Vec3::ONE).extend(0.0),
            false_colors: std::array::from_fn(|index| false_color::stop(index).extend(0.0)),
        }
    }
}
