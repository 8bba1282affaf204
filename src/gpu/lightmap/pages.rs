//! The pass that fills the pages of a lightmap on the card, so that views can read them there while a solve runs.

use glam::Vec3;
use wgpu::util::DeviceExt as _;

use super::{
    patches::Patches,
    pipelines::{compute_pipeline, module},
    resources::Buffers,
    rest::Rest,
    shaders::Shaders,
};
use crate::lightmap::{Atlas, dilate::Fill, fill_rings};

/// What the pages hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Stage {
    /// Irradiance, with what is added for the light that has still to be shot.
    #[default]
    Irradiance,
    /// Irradiance of the lights alone.
    Direct,
    /// Irradiance that was reflected at least once.
    Indirect,
    /// Radiosity that has still to be shot.
    Unshot,
    /// When a texel shot first: from yellow (early) by red to blue (late); grey if never.
    Order,
    /// How often a texel has shot: white for eight times or more.
    Used,
    /// Reflectance.
    Reflectance,
    /// Shading normals.
    Normals,
    /// Positions.
    Positions,
    /// Open area, relative to the largest texel's.
    Areas,
}

impl Stage {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Irradiance,
        Self::Direct,
        Self::Indirect,
        Self::Unshot,
        Self::Order,
        Self::Used,
        Self::Reflectance,
        Self::Normals,
        Self::Positions,
        Self::Areas,
    ];

    /// Its name, and what it is.
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Irradiance => {
                ("irradiance", "All irradiance, with what is added for the light that has still to be shot")
            }
            Self::Direct => ("direct", "Irradiance of the lights alone"),
            Self::Indirect => ("indirect", "Irradiance that was reflected at least once"),
            Self::Unshot => ("unshot", "Radiosity that texels have still to shoot"),
            Self::Order => ("order", "When a texel shot first: yellow early, red, blue late; grey if never"),
            Self::Used => ("shooters", "How often a texel has shot: white for eight times or more"),
            Self::Reflectance => ("reflectance", "Texel table: mean reflectance of the covered part"),
            Self::Normals => ("normals", "Texel table: shading normal as a colour"),
            Self::Positions => ("positions", "Texel table: position as a colour"),
            Self::Areas => ("areas", "Texel table: open area; white is the largest"),
        }
    }

    /// True if it is light, for the tone map; else a colour to be shown as it is.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Irradiance | Self::Direct | Self::Indirect | Self::Unshot)
    }
}

/// Uniforms, laid out as `PageSettings` in `pages.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PageSettings {
    /// Irradiance that is added everywhere.
    pub even: Vec3,
    /// A number of [`Stage`].
    pub stage: u32,
    /// How often what came since a remembered moment is added.
    pub trend: Vec3,
    /// Not used.
    pub spare: f32,
    /// Texels.
    pub receiver_count: u32,
    /// Shooters so far.
    pub shooter_count: u32,
    /// Area of the largest texel.
    pub largest_area: f32,
    /// Not used.
    pub spare_too: f32,
}

/// Bytes of the pages' head: columns, rows, pages and one more number, as u32.
const HEAD: usize = 16;
/// Fills of a ring are a multiple of this: the slices of a buffer that are bound begin at multiples of 256 bytes.
const RING_GRAIN: usize = 32;

/// The pages and what fills them.
pub(super) struct PagePass {
    pub(super) pages: wgpu::Buffer,
    uniforms: wgpu::Buffer,
    places: wgpu::Buffer,
    rings: wgpu::Buffer,
    /// First byte and bytes of each ring.
    ring_bytes: Vec<(u64, u64)>,
    passes: Passes,
    settings: PageSettings,
}

/// What depends on the shaders.
pub(super) struct Passes {
    place: wgpu::ComputePipeline,
    fill: wgpu::ComputePipeline,
    place_group: wgpu::BindGroup,
    fill_groups: Vec<wgpu::BindGroup>,
}

impl PagePass {
    /// Bytes of the pages of an atlas.
    pub(super) fn bytes(atlas: &Atlas) -> u64 {
        (HEAD + 16 * atlas.charts.pixel_count() + 8 * atlas.texels.len()) as u64
    }

    pub(super) fn new(
        device: &wgpu::Device,
        shaders: &Shaders,
        buffers: &Buffers,
        atlas: &Atlas,
        patches: &Patches,
    ) -> Self {
        let filled = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let charts = &atlas.charts;
        let place_of = |texel: &u32| {
            let texel = &atlas.texels[*texel as usize];
            [texel.pixel, texel.chart.wrapping_add(1)]
        };
        let places: Vec<[u32; 2]> = patches.texel_of_receiver.iter().map(place_of).collect();
        let mut fills: Vec<Fill> = Vec::new();
        let mut ring_bytes = Vec::new();
        for ring in fill_rings(charts, &atlas.texels).iter().filter(|ring| !ring.is_empty()) {
            ring_bytes.push((size_of_val(fills.as_slice()) as u64, size_of_val(ring.as_slice()) as u64));
            fills.extend(ring);
            fills.resize(fills.len().next_multiple_of(RING_GRAIN), Fill::default());
        }
        fills.resize(fills.len().max(RING_GRAIN), Fill::default());
        let pages = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("pages"),
            size: (HEAD + 16 * charts.pixel_count()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: true,
        });
        let [width, height] = charts.page_size;
        if let Ok(mut mapped) = pages.slice(..HEAD as u64).get_mapped_range_mut() {
            mapped.copy_from_slice(bytemuck::cast_slice(&[width, height, charts.page_count, 0]));
        }
        pages.unmap();
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("page settings"),
            size: size_of::<PageSettings>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let places = filled("places", bytemuck::cast_slice(&places), wgpu::BufferUsages::STORAGE);
        let rings = filled("rings", bytemuck::cast_slice(&fills), wgpu::BufferUsages::STORAGE);
        let held = Held { buffers, uniforms: &uniforms, places: &places, pages: &pages, rings: &rings };
        let passes = held.passes(device, shaders, &ring_bytes);
        let largest_area = patches.receivers.iter().fold(0.0_f32, |largest, receiver| largest.max(receiver.area));
        let receiver_count = patches.receivers.len() as u32;
        let settings = PageSettings { receiver_count, largest_area, ..PageSettings::default() };
        Self { pages, uniforms, places, rings, ring_bytes, passes, settings }
    }

    /// The passes with other shaders.
    pub(super) fn passes(&self, device: &wgpu::Device, shaders: &Shaders, buffers: &Buffers) -> Passes {
        let Self { uniforms, places, pages, rings, ring_bytes, .. } = self;
        Held { buffers, uniforms, places, pages, rings }.passes(device, shaders, ring_bytes)
    }

    /// Takes the passes of other shaders.
    pub(super) fn set_passes(&mut self, passes: Passes) {
        self.passes = passes;
    }

    /// Fills the pages.
    pub(super) fn record(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::ComputePass<'_>,
        (stage, shooters, Rest { even, trend }): (Stage, u64, Rest),
    ) {
        let stage = stage as u32;
        let settings = PageSettings { stage, shooter_count: shooters as u32, even, trend, ..self.settings };
        queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&settings));
        pass.set_pipeline(&self.passes.place);
        pass.set_bind_group(0, &self.passes.place_group, &[]);
        pass.dispatch_workgroups(self.settings.receiver_count.div_ceil(64), 1, 1);
        pass.set_pipeline(&self.passes.fill);
        for (group, (_, bytes)) in self.passes.fill_groups.iter().zip(&self.ring_bytes) {
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups((bytes / size_of::<Fill>() as u64).div_ceil(64) as u32, 1, 1);
        }
    }
}

/// The buffers that the passes bind.
struct Held<'a> {
    buffers: &'a Buffers,
    uniforms: &'a wgpu::Buffer,
    places: &'a wgpu::Buffer,
    pages: &'a wgpu::Buffer,
    rings: &'a wgpu::Buffer,
}

impl Held<'_> {
    fn passes(&self, device: &wgpu::Device, shaders: &Shaders, ring_bytes: &[(u64, u64)]) -> Passes {
        let module = module(device, "pages.wgsl", &shaders.pages);
        let [place, fill] = ["place", "fill"].map(|entry| compute_pipeline(device, &module, entry));
        let Buffers { receivers, irradiance, direct, unshot, shots, older, .. } = self.buffers;
        let group = |pipeline: &wgpu::ComputePipeline, entries: &[wgpu::BindGroupEntry<'_>]| {
            let layout = pipeline.get_bind_group_layout(0);
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("pages"), layout: &layout, entries })
        };
        let whole = [self.uniforms, receivers, irradiance, direct, unshot, shots, self.places, self.pages];
        let entries = (0..).zip(whole).chain([(9, older)]);
        let entries: Vec<_> = entries
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let ring = |(offset, bytes): &(u64, u64)| {
            let slice =
                wgpu::BufferBinding { buffer: self.rings, offset: *offset, size: wgpu::BufferSize::new(*bytes) };
            let pages = wgpu::BindGroupEntry { binding: 7, resource: self.pages.as_entire_binding() };
            group(&fill, &[pages, wgpu::BindGroupEntry { binding: 8, resource: wgpu::BindingResource::Buffer(slice) }])
        };
        let (place_group, fill_groups) = (group(&place, &entries), ring_bytes.iter().map(ring).collect());
        Passes { place, fill, place_group, fill_groups }
    }
}
