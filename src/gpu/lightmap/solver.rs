//! A solve: the order of the passes, and what is read back.

use std::time::{Duration, Instant};

use glam::{DVec3, Vec3, Vec4};
use wgpu::util::DeviceExt as _;

use super::{
    hemicube::{FACE_COUNT, HemicubePass, NEAR, SceneBuffers, TileLayout, delta_form_factors},
    patches::{BatchSettings, Face, LedgerSums, PATCHES_WGSL, Patches, PowerSums, Shooter},
};
use crate::{
    lightmap::{Atlas, GpuSettings, ShootingOrder},
    scene::{AreaLight, Scene},
};

/// The shader of the face matrices.
pub const FACES_WGSL: &str = include_str!("faces.wgsl");
/// The shader that chooses shooters.
pub const CHOOSE_WGSL: &str = include_str!("choose.wgsl");
/// The shader of the receiving texels.
pub const RECEIVE_WGSL: &str = include_str!("receive.wgsl");
/// The shader of the energy ledger.
pub const LEDGER_WGSL: &str = include_str!("ledger.wgsl");

/// Where the power went, so far, in watts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpuLedger {
    /// Power of all lights.
    pub emitted: DVec3,
    /// Power that arrived on front sides and was absorbed there.
    pub absorbed: DVec3,
    /// Power that left the scene, by the hemicubes' own weights.
    pub escaped: DVec3,
    /// Power that has still to be shot, by lights and by texels.
    pub unshot: DVec3,
    /// Shooters so far.
    pub shooters: u64,
    /// Submissions so far.
    pub batches: u64,
}

impl GpuLedger {
    /// The fraction of the emitted power that is still to be absorbed.
    pub fn unabsorbed(&self) -> f64 {
        crate::math::ratio_or_zero(self.unshot.element_sum(), self.emitted.element_sum())
    }

    /// (absorbed + escaped + unshot) / emitted - 1: how far the power is from being conserved. What is lost is light on
    /// back faces, and what the sums over texels miss.
    pub fn balance(&self) -> f64 {
        let known = self.absorbed + self.escaped + self.unshot;
        crate::math::ratio_or_zero(known.element_sum(), self.emitted.element_sum()) - 1.0
    }
}

/// The fields of a solve, by texel of the atlas [W/m²].
#[derive(Clone, Debug, PartialEq)]
pub struct TexelFields {
    /// Irradiance of the lights alone.
    pub direct: Vec<Vec3>,
    /// All irradiance so far.
    pub total: Vec<Vec3>,
}

/// Shooters of one batch, at most.
const MOST_SLOTS: u32 = 128;
/// What a batch should take.
const BATCH_TIME: Duration = Duration::from_millis(50);

/// One set of hemicubes with what depends on their resolution.
struct HemicubeSet {
    pass: HemicubePass,
    receive: wgpu::BindGroup,
    escaped: wgpu::BindGroup,
}

struct Pipelines {
    faces: wgpu::ComputePipeline,
    find_power: wgpu::ComputePipeline,
    choose: wgpu::ComputePipeline,
    choose_mesh: wgpu::ComputePipeline,
    take: wgpu::ComputePipeline,
    receive: wgpu::ComputePipeline,
    find_escaped: wgpu::ComputePipeline,
    add_up: wgpu::ComputePipeline,
}

struct Buffers {
    settings: wgpu::Buffer,
    receivers: wgpu::Buffer,
    groups: wgpu::Buffer,
    lamps: wgpu::Buffer,
    shooters: wgpu::Buffer,
    faces: wgpu::Buffer,
    irradiance: wgpu::Buffer,
    direct: wgpu::Buffer,
    unshot: wgpu::Buffer,
    sums: wgpu::Buffer,
    escaped: wgpu::Buffer,
    ledger: wgpu::Buffer,
    ledger_read: wgpu::Buffer,
}

struct BindGroups {
    faces: wgpu::BindGroup,
    find_power: wgpu::BindGroup,
    choose: wgpu::BindGroup,
    choose_mesh: wgpu::BindGroup,
    take: wgpu::BindGroup,
    add_up: wgpu::BindGroup,
}

/// A solve on a card, batch by batch. Between two batches it may be left alone for any time (pause), read, or dropped.
pub struct GpuSolver {
    device: wgpu::Device,
    queue: wgpu::Queue,
    settings: GpuSettings,
    patches: Patches,
    texel_count: usize,
    square_metres: f64,
    scene: SceneBuffers,
    pipelines: Pipelines,
    buffers: Buffers,
    groups: BindGroups,
    light_hemicubes: HemicubeSet,
    hemicubes: HemicubeSet,
    lamps_done: u32,
    batch: u32,
    ledger: GpuLedger,
}

impl GpuSolver {
    /// Uploads a scene. `settings` must have no problem.
    ///
    /// # Errors
    /// One line, if the lightmap is larger than the card takes.
    pub fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        scene: &Scene,
        atlas: &Atlas,
        light: Option<&AreaLight>,
        settings: &GpuSettings,
    ) -> Result<Self, String> {
        let patches = Patches::new(atlas, light, settings.group.ilog2(), settings.light_side);
        check_size(device, &patches)?;
        let pipelines = Pipelines::new(device);
        let buffers = Buffers::new(device, &patches);
        let groups = BindGroups::new(device, &pipelines, &buffers, &patches);
        let most = device.limits().max_texture_dimension_2d.min(4096);
        let set =
            |resolution| HemicubeSet::new(device, &pipelines, &buffers, TileLayout::new(resolution, MOST_SLOTS, most));
        let square_metres = scene.frame.square_metres_per_unit();
        let emitted = patches.emitted.as_dvec3() * square_metres;
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            settings: settings.clone(),
            texel_count: atlas.texels.len(),
            square_metres,
            scene: SceneBuffers::new(device, scene),
            light_hemicubes: set(settings.light_hemicube),
            hemicubes: set(settings.hemicube),
            pipelines,
            buffers,
            groups,
            patches,
            lamps_done: 0,
            batch: if settings.batch == 0 { 1 } else { settings.batch },
            ledger: GpuLedger { emitted, unshot: emitted, ..GpuLedger::default() },
        })
    }

    /// What is known of the power.
    pub fn ledger(&self) -> &GpuLedger {
        &self.ledger
    }

    /// True once the stop rule holds: all lights have shot, and what is unabsorbed is little enough. Or once every group
    /// has shot a hundred times on average: then texels are so coarse that they reflect what was not there.
    pub fn is_done(&self) -> bool {
        let lamps_left = self.lamps_done < self.patches.lamps.len() as u32;
        let most_shooters = self.patches.lamps.len() as u64 + 100 * self.patches.groups.len() as u64;
        let is_converged = self.ledger.unabsorbed() <= f64::from(self.settings.unabsorbed);
        !lamps_left && (is_converged || self.ledger.shooters >= most_shooters)
    }

    /// How far the solve is, 0 to 1, by the logarithm of what is unabsorbed.
    pub fn fraction(&self) -> f32 {
        let unabsorbed = self.ledger.unabsorbed();
        if unabsorbed <= 0.0 {
            return 1.0;
        }
        (unabsorbed.ln() / f64::from(self.settings.unabsorbed).ln()).clamp(0.0, 1.0) as f32
    }

    /// Texels that light arrives at, groups of them that shoot as one, and shooters that the lights are cut into.
    pub fn counts(&self) -> [usize; 3] {
        [self.patches.receivers.len(), self.patches.groups.len(), self.patches.lamps.len()]
    }

    /// Shoots one batch and waits for its ledger: about a twentieth of a second.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn step(&mut self) -> Result<(), String> {
        let started = Instant::now();
        let lamps_left = self.patches.lamps.len() as u32 - self.lamps_done;
        let from_lamps = lamps_left > 0;
        let set = if from_lamps { &self.light_hemicubes } else { &self.hemicubes };
        let mut slots = self.batch.clamp(1, set.pass.layout.slots);
        slots = slots.min(if from_lamps { lamps_left } else { self.patches.groups.len() as u32 });
        self.queue.write_buffer(&self.buffers.settings, 0, bytemuck::bytes_of(&self.batch_settings(set, slots)));
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if from_lamps {
            let stride = size_of::<Shooter>() as u64;
            let (first, bytes) = (u64::from(self.lamps_done) * stride, u64::from(slots) * stride);
            encoder.copy_buffer_to_buffer(&self.buffers.lamps, first, &self.buffers.shooters, 0, bytes);
            self.lamps_done += slots;
        } else {
            self.choose(&mut encoder, slots);
        }
        self.shoot(&mut encoder, set, slots);
        if from_lamps && slots == lamps_left {
            let size = self.buffers.irradiance.size();
            encoder.copy_buffer_to_buffer(&self.buffers.irradiance, 0, &self.buffers.direct, 0, size);
        }
        self.queue.submit([encoder.finish()]);
        self.read_ledger()?;
        self.pace(started.elapsed(), slots);
        Ok(())
    }

    fn batch_settings(&self, set: &HemicubeSet, slots: u32) -> BatchSettings {
        BatchSettings {
            receiver_count: self.patches.receivers.len() as u32,
            group_count: self.patches.groups.len() as u32,
            slot_count: slots,
            resolution: set.pass.layout.resolution,
            tiles_per_row: set.pass.layout.tiles_per_row,
            near: NEAR,
            bias: self.settings.bias,
            filtered: u32::from(!self.settings.no_filter),
        }
    }

    /// The groups of the most unshot power become the batch's shooters.
    fn choose(&self, encoder: &mut wgpu::CommandEncoder, slots: u32) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let tiles = (self.patches.groups.len() as u32).div_ceil(256);
        for (pipeline, group, count) in [
            (&self.pipelines.find_power, &self.groups.find_power, tiles),
            match self.settings.order {
                ShootingOrder::Brightest => (&self.pipelines.choose, &self.groups.choose, 1),
                ShootingOrder::Mesh => (&self.pipelines.choose_mesh, &self.groups.choose_mesh, 1),
            },
            (&self.pipelines.take, &self.groups.take, slots),
        ] {
            dispatch(&mut pass, pipeline, group, count);
        }
    }

    /// Hemicubes of the batch's shooters, then all that they give.
    fn shoot(&self, encoder: &mut wgpu::CommandEncoder, set: &HemicubeSet, slots: u32) {
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            dispatch(&mut pass, &self.pipelines.faces, &self.groups.faces, (slots * FACE_COUNT).div_ceil(64));
        }
        set.pass.draw(encoder, &self.scene, &self.buffers.faces, slots);
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let receivers = (self.patches.receivers.len() as u32).div_ceil(64);
            dispatch(&mut pass, &self.pipelines.receive, &set.receive, receivers);
            dispatch(&mut pass, &self.pipelines.find_escaped, &set.escaped, slots);
            dispatch(&mut pass, &self.pipelines.add_up, &self.groups.add_up, 1);
        }
        let bytes = size_of::<LedgerSums>() as u64;
        encoder.copy_buffer_to_buffer(&self.buffers.ledger, 0, &self.buffers.ledger_read, 0, bytes);
    }

    fn read_ledger(&mut self) -> Result<(), String> {
        let sums: LedgerSums = read(&self.device, &self.buffers.ledger_read)?[0];
        let watts = |power: Vec3| power.as_dvec3() * self.square_metres;
        let lamps = self.patches.lamps[self.lamps_done as usize..].iter();
        let waiting: Vec3 = lamps.map(|lamp| lamp.area * lamp.radiosity).sum();
        self.ledger = GpuLedger {
            emitted: self.ledger.emitted,
            absorbed: watts(sums.arrived - sums.reflected),
            escaped: watts(sums.escaped),
            unshot: watts(sums.unshot + waiting),
            shooters: u64::from(sums.shooters),
            batches: self.ledger.batches + 1,
        };
        Ok(())
    }

    /// As many shooters a batch as take about [`BATCH_TIME`].
    fn pace(&mut self, taken: Duration, slots: u32) {
        if self.settings.batch != 0 {
            return;
        }
        let one = taken.as_secs_f64() / f64::from(slots);
        let wanted = (BATCH_TIME.as_secs_f64() / one.max(1e-6)) as u32;
        self.batch = wanted.clamp(1, (2 * self.batch).min(MOST_SLOTS));
    }

    /// Reads the fields back, for a file or a comparison.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn fields(&self) -> Result<TexelFields, String> {
        let all_lamps = self.lamps_done == self.patches.lamps.len() as u32;
        let direct = if all_lamps { &self.buffers.direct } else { &self.buffers.irradiance };
        Ok(TexelFields { direct: self.texel_field(direct)?, total: self.texel_field(&self.buffers.irradiance)? })
    }

    fn texel_field(&self, buffer: &wgpu::Buffer) -> Result<Vec<Vec3>, String> {
        let mut field = vec![Vec3::ZERO; self.texel_count];
        let values: Vec<Vec4> = read_copy(&self.device, &self.queue, buffer)?;
        for (texel, value) in self.patches.texel_of_receiver.iter().zip(values) {
            field[*texel as usize] = value.truncate();
        }
        Ok(field)
    }
}

fn dispatch(pass: &mut wgpu::ComputePass<'_>, pipeline: &wgpu::ComputePipeline, group: &wgpu::BindGroup, count: u32) {
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, group, &[]);
    pass.dispatch_workgroups(count, 1, 1);
}

fn check_size(device: &wgpu::Device, patches: &Patches) -> Result<(), String> {
    let limits = device.limits();
    let most_bytes = limits.max_storage_buffer_binding_size / size_of::<super::patches::Receiver>() as u64;
    let most_groups = 64 * u64::from(limits.max_compute_workgroups_per_dimension);
    let most = most_bytes.min(most_groups);
    match patches.receivers.len() as u64 {
        0 => Err(String::from("the scene has no open surface to light")),
        count if count > most => Err(format!("{count} texels; this device takes {most}: ask for fewer")),
        _ => Ok(()),
    }
}

impl Pipelines {
    fn new(device: &wgpu::Device) -> Self {
        let module = |label, source: &str| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(format!("{PATCHES_WGSL}{source}").into()),
            })
        };
        let pipeline = |module: &wgpu::ShaderModule, entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let (choose, ledger) = (module("choose.wgsl", CHOOSE_WGSL), module("ledger.wgsl", LEDGER_WGSL));
        Self {
            faces: pipeline(&module("faces.wgsl", FACES_WGSL), "find_faces"),
            find_power: pipeline(&choose, "find_power"),
            choose: pipeline(&choose, "choose"),
            choose_mesh: pipeline(&choose, "choose_mesh"),
            take: pipeline(&choose, "take"),
            receive: pipeline(&module("receive.wgsl", RECEIVE_WGSL), "receive"),
            find_escaped: pipeline(&ledger, "find_escaped"),
            add_up: pipeline(&ledger, "add_up"),
        }
    }
}

impl Buffers {
    fn new(device: &wgpu::Device, patches: &Patches) -> Self {
        use wgpu::BufferUsages as Usage;
        let zeros = |label, bytes: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes.max(16) as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let filled = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let texels = patches.receivers.len();
        let field = texels * size_of::<Vec4>();
        let slots = MOST_SLOTS as usize;
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let lamps = if patches.lamps.is_empty() { &[Shooter::default()][..] } else { &patches.lamps };
        Self {
            settings: zeros("settings", size_of::<BatchSettings>(), Usage::UNIFORM | Usage::COPY_DST),
            receivers: filled("receivers", bytemuck::cast_slice(&patches.receivers), Usage::STORAGE),
            groups: filled("groups", bytemuck::cast_slice(&patches.groups), Usage::STORAGE),
            lamps: filled("lamps", bytemuck::cast_slice(lamps), Usage::COPY_SRC),
            shooters: zeros("shooters", slots * size_of::<Shooter>(), storage),
            faces: zeros("faces", slots * FACE_COUNT as usize * size_of::<Face>(), Usage::STORAGE | Usage::VERTEX),
            irradiance: zeros("irradiance", field, storage),
            direct: zeros("direct", field, storage),
            unshot: zeros("unshot", field, storage),
            sums: zeros("sums", texels.div_ceil(64) * size_of::<PowerSums>(), Usage::STORAGE),
            escaped: zeros("escaped", slots * size_of::<Vec4>(), Usage::STORAGE),
            ledger: zeros("ledger", size_of::<LedgerSums>(), storage),
            ledger_read: zeros("ledger read", size_of::<LedgerSums>(), Usage::COPY_DST | Usage::MAP_READ),
        }
    }
}

fn bind(device: &wgpu::Device, pipeline: &wgpu::ComputePipeline, buffers: &[(u32, &wgpu::Buffer)]) -> wgpu::BindGroup {
    let entries: Vec<_> = buffers
        .iter()
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

fn bind_with_depth(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    buffers: &[(u32, &wgpu::Buffer)],
    depth: &wgpu::TextureView,
) -> wgpu::BindGroup {
    let mut entries: Vec<_> = buffers
        .iter()
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
        .collect();
    entries.push(wgpu::BindGroupEntry { binding: 6, resource: wgpu::BindingResource::TextureView(depth) });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

impl BindGroups {
    fn new(device: &wgpu::Device, pipelines: &Pipelines, buffers: &Buffers, patches: &Patches) -> Self {
        let scratch = |label, bytes: usize| {
            let usage = wgpu::BufferUsages::STORAGE;
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes.max(16) as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let power = scratch("power", 4 * patches.groups.len());
        let best = scratch("best of tile", 8 * patches.groups.len().div_ceil(256));
        let chosen = scratch("chosen", 4 * MOST_SLOTS as usize);
        let order = scratch("order", 16);
        let charts = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("charts"),
            contents: bytemuck::cast_slice(&patches.charts),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let Buffers { settings, receivers, groups, shooters, faces, unshot, sums, escaped, ledger, .. } = buffers;
        Self {
            faces: bind(device, &pipelines.faces, &[(0, settings), (1, shooters), (2, faces)]),
            find_power: bind(
                device,
                &pipelines.find_power,
                &[(0, settings), (1, receivers), (2, groups), (3, unshot), (4, &power), (5, &best)],
            ),
            choose: bind(device, &pipelines.choose, &[(0, settings), (4, &power), (5, &best), (6, &chosen)]),
            choose_mesh: bind(
                device,
                &pipelines.choose_mesh,
                &[(0, settings), (4, &power), (6, &chosen), (8, &charts), (9, &order)],
            ),
            take: bind(
                device,
                &pipelines.take,
                &[(1, receivers), (2, groups), (3, unshot), (6, &chosen), (7, shooters)],
            ),
            add_up: bind(
                device,
                &pipelines.add_up,
                &[(0, settings), (1, shooters), (2, sums), (4, escaped), (5, ledger)],
            ),
        }
    }
}

impl HemicubeSet {
    fn new(device: &wgpu::Device, pipelines: &Pipelines, buffers: &Buffers, layout: TileLayout) -> Self {
        let pass = HemicubePass::new(device, layout);
        let weights = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("delta form factors"),
            contents: bytemuck::cast_slice(&delta_form_factors(layout.resolution)),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let Buffers { settings, receivers, shooters, irradiance, unshot, sums, escaped, .. } = buffers;
        let receive = [(0, settings), (1, shooters), (2, receivers), (3, irradiance), (4, unshot), (5, sums)];
        let find_escaped = [(0, settings), (1, shooters), (3, &weights), (4, escaped)];
        Self {
            receive: bind_with_depth(device, &pipelines.receive, &receive, &pass.depth),
            escaped: bind_with_depth(device, &pipelines.find_escaped, &find_escaped, &pass.depth),
            pass,
        }
    }
}

/// Reads a buffer that can be mapped. Waits for the card.
fn read<T: bytemuck::Pod>(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<T>, String> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {}); // a failure shows in get_mapped_range
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| format!("the graphics driver failed: {error}"))?;
    let values = {
        let mapped = buffer.slice(..).get_mapped_range().map_err(|error| format!("the device was lost: {error}"))?;
        bytemuck::pod_collect_to_vec(&mapped)
    };
    buffer.unmap();
    Ok(values)
}

/// Reads any buffer, by way of a copy.
pub(super) fn read_copy<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, String> {
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read"),
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    queue.submit([encoder.finish()]);
    read(device, &copy)
}
