//! What a picture of one size keeps on the card.

use super::{
    gather::Way,
    settings::{ScreenSettings, Weights},
};
use crate::gpu::mesh_view::LAYER_FORMATS;

/// A texture of one image for each layer, then one for each of the picture around, which fills its corner.
pub(super) struct Layered {
    pub(super) texture: wgpu::Texture,
    /// All layers, to be read.
    pub(super) all: wgpu::TextureView,
    /// Each by itself.
    pub(super) each: [wgpu::TextureView; 4],
}

/// Textures and buffers. A buffer of all layers holds the first layer's pixels row by row, then the second's, then those of
/// the picture around.
pub(super) struct Targets {
    pub(super) size: [u32; 2],
    pub(super) layers: u32,
    /// Columns and rows of the picture around; 0 if there is none.
    pub(super) surround: [u32; 2],
    pub(super) has_tail: bool,
    pub(super) normals: Layered,
    pub(super) reflectances: Layered,
    pub(super) depths: Layered,
    /// Depth of the last frame's first layer.
    pub(super) last_depth: wgpu::Texture,
    /// What taps read: normal and depth in a word.
    pub(super) surfaces: wgpu::Buffer,
    /// And radiosity in a word, by direct light and by each bounce in turn.
    pub(super) outgoing: [wgpu::Buffer; 2],
    pub(super) direct: wgpu::Buffer,
    /// What taps count for, by `kept.wgsl`, and how many words that takes.
    pub(super) kept: wgpu::Buffer,
    kept_words: u64,
    pub(super) weights: Weights,
    /// Mean irradiance of each bounce.
    pub(super) gathered: Vec<wgpu::Buffer>,
    pub(super) indirect: wgpu::Buffer,
    /// What the filter's first pass leaves.
    pub(super) half_filtered: wgpu::Buffer,
    /// Mean openness of the first layer, one number a pixel; the same to be filtered, and to be shown.
    pub(super) obscured: wgpu::Buffer,
    pub(super) obscured_words: wgpu::Buffer,
    pub(super) obscurance: wgpu::Buffer,
    /// Two that are written in turn.
    pub(super) pages: [wgpu::Buffer; 2],
}

/// Bytes of a pixel in a buffer.
const PIXEL_BYTES: u64 = 16;
/// Columns, rows, number of a page's pictures, and a spare word.
const PAGE_HEADER: u64 = 16;

impl Targets {
    /// True if it serves these settings.
    pub(super) fn is_for(&self, size: [u32; 2], settings: &ScreenSettings) -> bool {
        let is_same = self.layers == settings.layers() && self.has_tail != settings.no_tail;
        let is_same = is_same && self.surround == settings.surround_size(size);
        let is_same = is_same && self.kept_words == kept_words(settings, size) && self.weights == settings.weights;
        self.size == size && is_same && self.gathered.len() == bounces(settings)
    }

    /// The largest number of pixels that the device takes.
    pub(super) fn most_pixels(device: &wgpu::Device, settings: &ScreenSettings) -> u64 {
        let limits = device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        (bytes - PAGE_HEADER) / (PIXEL_BYTES * 2 * u64::from(settings.layers()))
    }

    pub(super) fn new(device: &wgpu::Device, [width, height]: [u32; 2], settings: &ScreenSettings) -> Self {
        use wgpu::{BufferUsages as Usage, TextureUsages as Use};
        let layers = settings.layers();
        let texture = |label, format, usage, layers| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: Use::TEXTURE_BINDING | usage,
                view_formats: &[],
            })
        };
        let layered = |label, format, usage| layered(texture(label, format, usage, 4));
        let drawn = Use::RENDER_ATTACHMENT;
        let depth_format = wgpu::TextureFormat::Depth32Float;
        let pixels = u64::from(width) * u64::from(height);
        let buffer = |label, bytes| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes,
                usage: Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let surround = settings.surround_size([width, height]);
        let kept = kept_words(settings, [width, height]);
        let entries = (pixels + u64::from(surround[0] * surround[1])) * u64::from(layers);
        let of_layers = |label| buffer(label, PIXEL_BYTES * entries);
        let words = |label, entries: u64| buffer(label, 4 * entries);
        let page = || buffer("screen page", PAGE_HEADER + PIXEL_BYTES * pixels);
        Self {
            size: [width, height],
            layers,
            surround,
            has_tail: !settings.no_tail,
            normals: layered("normals", LAYER_FORMATS[0], drawn),
            reflectances: layered("reflectances", LAYER_FORMATS[1], drawn),
            depths: layered("depths", depth_format, drawn | Use::COPY_SRC),
            last_depth: texture("last depth", depth_format, Use::COPY_DST, 1),
            surfaces: words("surfaces", entries),
            outgoing: ["outgoing", "outgoing next"].map(|label| words(label, entries)),
            kept: words("kept", kept.max(1)),
            kept_words: kept,
            weights: settings.weights,
            direct: of_layers("direct"),
            gathered: (0..bounces(settings)).map(|_| of_layers("gathered")).collect(),
            indirect: of_layers("indirect"),
            half_filtered: words("half filtered", pixels),
            obscured: words("obscured", pixels),
            obscured_words: words("obscured words", pixels),
            obscurance: buffer("obscurance", PIXEL_BYTES * pixels),
            pages: [page(), page()],
        }
    }

    /// Pixels of a picture.
    pub(super) fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// Pixels of a layer of the picture around.
    pub(super) fn surround_pixels(&self) -> u32 {
        self.surround[0] * self.surround[1]
    }

    /// Forgets what the last bounce gathered around the picture in frames before: it is gathered in still frames alone.
    pub(super) fn forget_tail_around(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(last) = self.gathered.last().filter(|_| self.surround_pixels() > 0) {
            encoder.clear_buffer(last, PIXEL_BYTES * u64::from(self.pixels() * self.layers), None);
        }
    }

    /// How a bounce's taps are weighed.
    pub(super) fn way(&self, bounce: usize) -> Way {
        match self.weights {
            Weights::Source => Way::Spiral,
            Weights::Integral if bounce > 0 && self.kept_words > 0 => Way::Kept,
            Weights::Integral => Way::Slices,
        }
    }

    /// Keeps the depth of the first layer for the next frame.
    pub(super) fn keep_depth(&self, encoder: &mut wgpu::CommandEncoder) {
        let size = self.last_depth.size();
        encoder.copy_texture_to_texture(self.depths.texture.as_image_copy(), self.last_depth.as_image_copy(), size);
    }
}

/// More than this is not kept: each bounce finds anew what its taps count for.
const MOST_KEPT_BYTES: u64 = 128 << 20;

/// Words of what the first bounce keeps of its taps: a word for each of them and two for each pixel that is gathered at; none
/// where no bounce follows, or they are too many.
pub(super) fn kept_words(settings: &ScreenSettings, size: [u32; 2]) -> u64 {
    let pixels = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
    let layers = u64::from(settings.layers());
    let entries = layers * (pixels(settings.grid(size)) + pixels(settings.surround_size(size)));
    let words = entries * (layers * u64::from(settings.taps) + 2);
    let is_kept = settings.bounces > 1 && settings.weights == Weights::Integral && 4 * words <= MOST_KEPT_BYTES;
    if is_kept { words } else { 0 }
}

fn bounces(settings: &ScreenSettings) -> usize {
    settings.bounces as usize
}

fn layered(texture: wgpu::Texture) -> Layered {
    let one = |layer| {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..wgpu::TextureViewDescriptor::default()
        })
    };
    let all = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    });
    Layered { all, each: [0, 1, 2, 3].map(one), texture }
}
