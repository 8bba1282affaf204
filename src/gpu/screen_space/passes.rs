//! The compute passes over the picture's pixels, and what they are bound to.

use std::cell::OnceCell;

use wgpu::util::DeviceExt as _;

use super::{
    filter::FILTER_WGSL,
    gather::{BounceUniforms, GATHER_WGSL, OBSCURANCE_WGSL, Way, spiral},
    lamps::{LampPass, light_source},
    settings::{MOST_TAPS, ScreenSettings},
    show::{SHOW_WGSL, ShowUniforms},
    targets::Targets,
    uniforms::{SCREEN_WGSL, ScreenUniforms},
};
use crate::gpu::lightmap::pipelines::{compute_pipeline, compute_pipeline_with, module};

/// The passes of a frame, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Shadow maps of the lamps.
    Shadows,
    /// The nearest surfaces.
    FirstLayer,
    /// What lies behind them.
    SecondLayer,
    /// All layers of the picture around.
    Around,
    /// Unpacking of the G-buffer, and direct light.
    Light,
    /// Ambient obscurance.
    Obscure,
    /// The bounces.
    Gather,
    /// Both halves of the filter.
    Filter,
    /// The buffer that is shown.
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
    /// By layers and ways, once they were asked for.
    gather: [[OnceCell<wgpu::ComputePipeline>; Way::COUNT]; 2],
    gather_module: wgpu::ShaderModule,
    obscure: [OnceCell<wgpu::ComputePipeline>; 2],
    obscure_module: wgpu::ShaderModule,
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
            gather: Default::default(),
            gather_module: screen("gather.wgsl", GATHER_WGSL),
            obscure: Default::default(),
            obscure_module: screen("obscurance.wgsl", OBSCURANCE_WGSL),
            across: pipeline(&filter, "across"),
            down: pipeline(&filter, "down"),
            show: pipeline(&screen("show.wgsl", SHOW_WGSL), "write_page"),
        }
    }
}

impl Pipelines {
    /// A bounce over so many layers. They are constants of the shader, so that a software driver has no loop over one.
    fn gather(&self, device: &wgpu::Device, layers: u32, way: Way) -> &wgpu::ComputePipeline {
        let constants = [("LAYERS", f64::from(layers)), ("WAY", f64::from(way as u32))];
        self.gather[layers as usize - 1][way as usize]
            .get_or_init(|| compute_pipeline_with(device, &self.gather_module, "gather", &constants))
    }

    fn obscure(&self, device: &wgpu::Device, layers: u32) -> &wgpu::ComputePipeline {
        let constants = [("LAYERS", f64::from(layers))];
        self.obscure[layers as usize - 1]
            .get_or_init(|| compute_pipeline_with(device, &self.obscure_module, "obscure", &constants))
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
    gather: Vec<(wgpu::ComputePipeline, wgpu::BindGroup)>,
    obscure: (wgpu::ComputePipeline, wgpu::BindGroup),
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
        let screen = (0, &uniforms.screen);
        let Targets { normals, depths, reflectances, surfaces, outgoing, .. } = targets;
        let light =
            [screen, (1, &lamps.settings), (2, &lamps.lamps), (7, &targets.direct), (8, surfaces), (9, &outgoing[0])];
        let light_views = [(3, lamps.depth()), (4, &normals.all), (5, &reflectances.all), (6, &depths.all)];
        let bounces = targets.gathered.len();
        let gather = (0..bounces).map(|bounce| {
            let numbers = bounce_uniforms(device, bounce, targets);
            let last = if bounce + 1 < bounces { &targets.gathered[bounces - 1] } else { &targets.direct };
            let [from, to] = [bounce, bounce + 1].map(|number| &outgoing[number % 2]);
            let taps = [screen, (4, surfaces), (5, from), (6, to), (11, &uniforms.spiral), (13, &targets.kept)];
            let means = [(7, &targets.gathered[bounce]), (8, &targets.indirect), (9, last), (10, &targets.obscurance)];
            let buffers = [&taps[..], &means, &[(12, &numbers)]].concat();
            let here = [(1, &normals.all), (2, &depths.all), (3, &reflectances.all)];
            let pipeline = pipelines.gather(device, targets.layers, targets.way(bounce));
            (pipeline.clone(), bind(device, pipeline, &buffers, &here))
        });
        let obscured = [(3, &uniforms.obscurance_spiral), (4, &targets.obscured), (5, &targets.obscured_words)];
        let obscured = [&obscured[..], &[screen, (6, &targets.obscurance)]].concat();
        let obscure = pipelines.obscure(device, targets.layers);
        let filtered = [&outgoing[bounces % 2], &targets.obscured_words];
        let (half, surfaces) = (&targets.half_filtered, (1, surfaces));
        let shown =
            [screen, (1, &uniforms.show), (5, &targets.direct), (6, &targets.indirect), (7, &targets.obscurance)];
        let shown_views = [(2, &normals.all), (3, &reflectances.all), (4, &depths.all)];
        Self {
            light: bind(device, &pipelines.light, &light, &light_views),
            gather: gather.collect(),
            obscure: (obscure.clone(), bind(device, obscure, &obscured, &[(1, &normals.all), (2, &depths.all)])),
            across: filtered
                .map(|source| bind(device, &pipelines.across, &[screen, surfaces, (2, source), (3, half)], &[])),
            down: [&targets.indirect, &targets.obscurance]
                .map(|target| bind(device, &pipelines.down, &[screen, surfaces, (2, half), (4, target)], &[])),
            show: [0, 1].map(|page: usize| {
                let page = (8, &targets.pages[page]);
                bind(device, &pipelines.show, &[&shown[..], &[page]].concat(), &shown_views)
            }),
        }
    }

    /// Records a pass over so many pixels from the uniforms' first one.
    pub(super) fn record(&self, pass: &mut wgpu::ComputePass<'_>, pipelines: &Pipelines, what: Dispatch, pixels: u32) {
        let (pipeline, group) = match what {
            Dispatch::Light => (&pipelines.light, &self.light),
            Dispatch::Gather(bounce) => (&self.gather[bounce].0, &self.gather[bounce].1),
            Dispatch::Obscure => (&self.obscure.0, &self.obscure.1),
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
