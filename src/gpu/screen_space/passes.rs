//! The compute passes over the picture's pixels, and what they are bound to.

use wgpu::util::DeviceExt as _;

use super::{
    filter::FILTER_WGSL,
    gather::{BounceUniforms, GATHER_WGSL, OBSCURANCE_WGSL, spiral},
    lamps::{LampPass, light_source},
    settings::{MOST_TAPS, ScreenSettings},
    show::{SHOW_WGSL, ShowUniforms},
    targets::Targets,
    uniforms::{SCREEN_WGSL, ScreenUniforms},
};
use crate::gpu::lightmap::pipelines::{compute_pipeline, module};

/// The passes of a frame, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pass {
    Shadows,
    FirstLayer,
    SecondLayer,
    Around,
    Light,
    Obscure,
    Gather,
    Filter,
    Show,
}

impl Pass {
    /// Their names in tables, in that order.
    pub(super) const NAMES: [&'static str; 9] = [
        "shadow maps",
        "G-buffer, first layer",
        "G-buffer, second layer",
        "G-buffer, around",
        "direct light",
        "obscurance",
        "gather",
        "filter",
        "buffer to show",
    ];
}

/// The pipelines.
pub(super) struct Pipelines {
    light: wgpu::ComputePipeline,
    gather: wgpu::ComputePipeline,
    obscure: wgpu::ComputePipeline,
    across: wgpu::ComputePipeline,
    down: wgpu::ComputePipeline,
    show: wgpu::ComputePipeline,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let screen = |label, source| module(device, label, &format!("{SCREEN_WGSL}{source}"));
        let filter = screen("filter.wgsl", FILTER_WGSL);
        let pipeline = |module: &wgpu::ShaderModule, entry| compute_pipeline(device, module, entry);
        Self {
            light: pipeline(&module(device, "light.wgsl", &light_source()), "light"),
            gather: pipeline(&screen("gather.wgsl", GATHER_WGSL), "gather"),
            obscure: pipeline(&screen("obscurance.wgsl", OBSCURANCE_WGSL), "obscure"),
            across: pipeline(&filter, "across"),
            down: pipeline(&filter, "down"),
            show: pipeline(&screen("show.wgsl", SHOW_WGSL), "write_page"),
        }
    }
}

/// Uniforms of all passes.
pub(super) struct Uniforms {
    pub(super) screen: wgpu::Buffer,
    pub(super) show: wgpu::Buffer,
    spiral: wgpu::Buffer,
    obscurance_spiral: wgpu::Buffer,
}

impl Uniforms {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let buffer = |label, bytes: usize| {
            let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents: &vec![0; bytes],
                usage,
            })
        };
        let spiral_bytes = 16 * MOST_TAPS as usize;
        Self {
            screen: buffer("screen", size_of::<ScreenUniforms>()),
            show: buffer("show", size_of::<ShowUniforms>()),
            spiral: buffer("spiral", spiral_bytes),
            obscurance_spiral: buffer("obscurance spiral", spiral_bytes),
        }
    }

    /// Takes the spirals of other settings.
    pub(super) fn set_spirals(&self, queue: &wgpu::Queue, settings: &ScreenSettings) {
        queue.write_buffer(&self.spiral, 0, bytemuck::cast_slice(&spiral(settings)));
        let settings = ScreenSettings { taps: settings.obscurance.max(1), turns: 0, ..settings.clone() };
        queue.write_buffer(&self.obscurance_spiral, 0, bytemuck::cast_slice(&spiral(&settings)));
    }
}

/// What the pipelines are bound to, for one picture.
pub(super) struct Groups {
    light: wgpu::BindGroup,
    gather: Vec<wgpu::BindGroup>,
    obscure: wgpu::BindGroup,
    /// Of light, and of obscurance.
    across: [wgpu::BindGroup; 2],
    down: [wgpu::BindGroup; 2],
    show: [wgpu::BindGroup; 2],
}

impl Groups {
    pub(super) fn new(
        device: &wgpu::Device,
        pipelines: &Pipelines,
        (uniforms, lamps, targets): (&Uniforms, &LampPass, &Targets),
    ) -> Self {
        let (screen, geometry) = (&uniforms.screen, &targets.geometry);
        let light = [
            (0, screen),
            (1, &lamps.settings),
            (2, &lamps.lamps),
            (7, geometry),
            (8, &targets.reflectance),
            (9, &targets.direct),
            (10, &targets.outgoing[0]),
        ];
        let light_views =
            [(3, lamps.depth()), (4, &targets.normals.all), (5, &targets.reflectances.all), (6, &targets.depths.all)];
        let group = |pipeline, buffers: &[(u32, &wgpu::Buffer)]| bind(device, pipeline, buffers, &[]);
        let bounces = targets.gathered.len();
        let gather = (0..bounces).map(|bounce| {
            let numbers = bounce_uniforms(device, bounce, targets);
            let last = if bounce + 1 < bounces { &targets.gathered[bounces - 1] } else { &targets.direct };
            let from = &targets.outgoing[bounce % 2];
            let taps = [(0, screen), (1, geometry), (2, from), (3, &targets.gathered[bounce]), (4, &uniforms.spiral)];
            let next = &targets.outgoing[(bounce + 1) % 2];
            let rest = [(5, &numbers), (6, &targets.reflectance), (7, next), (8, &targets.indirect), (9, last)];
            group(&pipelines.gather, &[&taps[..], &rest, &[(10, &targets.obscurance)]].concat())
        });
        let obscured = [(2, &targets.obscured), (5, &targets.obscured_words), (6, &targets.obscurance)];
        let taps = [(0, screen), (1, geometry), (3, &uniforms.obscurance_spiral), (4, &targets.outgoing[0])];
        let filtered = [&targets.outgoing[bounces % 2], &targets.obscured_words];
        let (half, surfaces) = (&targets.half_filtered, (4, &targets.outgoing[0]));
        let shown = [(2, geometry), (3, &targets.reflectance), (4, &targets.direct), (5, &targets.indirect)];
        Self {
            light: bind(device, &pipelines.light, &light, &light_views),
            gather: gather.collect(),
            obscure: group(&pipelines.obscure, &[&obscured[..], &taps].concat()),
            across: filtered.map(|source| group(&pipelines.across, &[(0, screen), (1, source), (2, half), surfaces])),
            down: [&targets.indirect, &targets.obscurance]
                .map(|target| group(&pipelines.down, &[(0, screen), (1, half), (3, target), surfaces])),
            show: [0, 1].map(|page: usize| {
                let rest = [(0, screen), (1, &uniforms.show), (6, &targets.obscurance), (7, &targets.pages[page])];
                group(&pipelines.show, &[&rest[..], &shown].concat())
            }),
        }
    }

    /// Records a pass over so many pixels from the uniforms' first one.
    pub(super) fn record(&self, pass: &mut wgpu::ComputePass<'_>, pipelines: &Pipelines, what: Dispatch, pixels: u32) {
        let (pipeline, group) = match what {
            Dispatch::Light => (&pipelines.light, &self.light),
            Dispatch::Gather(bounce) => (&pipelines.gather, &self.gather[bounce]),
            Dispatch::Obscure => (&pipelines.obscure, &self.obscure),
            Dispatch::Across(field) => (&pipelines.across, &self.across[field as usize]),
            Dispatch::Down(field) => (&pipelines.down, &self.down[field as usize]),
            Dispatch::Show(page) => (&pipelines.show, &self.show[page]),
        };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(pixels.div_ceil(64), 1, 1);
    }
}

fn bounce_uniforms(device: &wgpu::Device, bounce: usize, targets: &Targets) -> wgpu::Buffer {
    let bounces = targets.gathered.len();
    let is_fed = targets.has_tail && bounces > 1;
    let numbers = BounceUniforms {
        is_first: u32::from(bounce == 0),
        is_last: u32::from(bounce + 1 == bounces),
        feeds_last: u32::from(is_fed && bounce + 2 == bounces),
        is_fed: u32::from(is_fed && bounce + 1 == bounces),
    };
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("bounce"),
        contents: bytemuck::bytes_of(&numbers),
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

/// What is filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filtered {
    Light,
    Obscurance,
}

/// A pass over pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dispatch {
    Light,
    /// A bounce, by its number.
    Gather(usize),
    Obscure,
    /// The filter's two passes.
    Across(Filtered),
    Down(Filtered),
    /// Into one of the pages.
    Show(usize),
}

/// Bindings in group 0.
pub(super) fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    buffers: &[(u32, &wgpu::Buffer)],
    views: &[(u32, &wgpu::TextureView)],
) -> wgpu::BindGroup {
    let buffers = buffers.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding()));
    let views = views.iter().map(|(binding, view)| (*binding, wgpu::BindingResource::TextureView(view)));
    let entries: Vec<_> =
        buffers.chain(views).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}
