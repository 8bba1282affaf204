//! What a solve keeps on the card: pipelines, buffers and what binds them.

use glam::Vec4;
use wgpu::util::DeviceExt as _;

use super::{
    hemicube::{FACE_COUNT, HemicubePass, SceneBuffers, TileLayout, delta_form_factors},
    hemisphere::pixel_weights,
    patches::{BatchSettings, Face, LedgerSums, Patches, PowerSums, Receiver, Shooter},
    pipelines::{compute_pipeline, module},
    shaders::Shaders,
};
use crate::lightmap::Visibility;

/// Shooters of one batch, at most.
pub(super) const MOST_SLOTS: u32 = 128;

/// The compute pipelines.
pub(super) struct Pipelines {
    pub(super) faces: wgpu::ComputePipeline,
    pub(super) find_power: wgpu::ComputePipeline,
    pub(super) find_best: wgpu::ComputePipeline,
    pub(super) choose: wgpu::ComputePipeline,
    pub(super) choose_mesh: wgpu::ComputePipeline,
    pub(super) take: wgpu::ComputePipeline,
    pub(super) receive: wgpu::ComputePipeline,
    pub(super) find_lost: wgpu::ComputePipeline,
    pub(super) add_up: wgpu::ComputePipeline,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, shaders: &Shaders, visibility: Visibility) -> Self {
        let module = |label, source: &str| module(device, label, source);
        let pipeline = |module: &wgpu::ShaderModule, entry| compute_pipeline(device, module, entry);
        let receive = match visibility {
            Visibility::Hemicube => &shaders.receive,
            Visibility::Hemisphere => &shaders.receive_by_item,
        };
        let (choose, ledger) = (module("choose.wgsl", &shaders.choose), module("ledger.wgsl", &shaders.ledger));
        Self {
            faces: pipeline(&module("faces.wgsl", &shaders.faces), "find_faces"),
            find_power: pipeline(&choose, "find_power"),
            find_best: pipeline(&choose, "find_best"),
            choose: pipeline(&choose, "choose"),
            choose_mesh: pipeline(&choose, "choose_mesh"),
            take: pipeline(&choose, "take"),
            receive: pipeline(&module("receive.wgsl", receive), "receive"),
            find_lost: pipeline(&ledger, "find_lost"),
            add_up: pipeline(&ledger, "add_up"),
        }
    }
}

/// The buffers.
pub(super) struct Buffers {
    pub(super) settings: wgpu::Buffer,
    pub(super) receivers: wgpu::Buffer,
    pub(super) groups: wgpu::Buffer,
    pub(super) charts: wgpu::Buffer,
    pub(super) lamps: wgpu::Buffer,
    pub(super) shooters: wgpu::Buffer,
    pub(super) faces: wgpu::Buffer,
    pub(super) irradiance: wgpu::Buffer,
    pub(super) direct: wgpu::Buffer,
    /// Irradiance at the two moments that are remembered ([`super::rest`]).
    pub(super) older: wgpu::Buffer,
    pub(super) newer: wgpu::Buffer,
    pub(super) unshot: wgpu::Buffer,
    pub(super) shots: wgpu::Buffer,
    pub(super) sums: wgpu::Buffer,
    pub(super) lost: wgpu::Buffer,
    pub(super) ledger: wgpu::Buffer,
    pub(super) ledger_read: wgpu::Buffer,
    pub(super) power: wgpu::Buffer,
    pub(super) offered: wgpu::Buffer,
    pub(super) best_of_tile: wgpu::Buffer,
    pub(super) chosen: wgpu::Buffer,
    pub(super) order: wgpu::Buffer,
}

impl Buffers {
    pub(super) fn new(device: &wgpu::Device, patches: &Patches) -> Self {
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
            charts: filled("charts", bytemuck::cast_slice(&patches.charts), Usage::STORAGE),
            lamps: filled("lamps", bytemuck::cast_slice(lamps), Usage::COPY_SRC),
            shooters: zeros("shooters", slots * size_of::<Shooter>(), storage),
            faces: zeros("faces", slots * FACE_COUNT as usize * size_of::<Face>(), Usage::STORAGE | Usage::VERTEX),
            irradiance: zeros("irradiance", field, storage),
            direct: zeros("direct", field, storage),
            older: zeros("older", field, storage),
            newer: zeros("newer", field, storage),
            unshot: zeros("unshot", field, storage),
            shots: zeros("shots", 8 * texels, storage),
            sums: zeros("sums", texels.div_ceil(64) * size_of::<PowerSums>(), Usage::STORAGE),
            lost: zeros("lost", slots * 2 * size_of::<Vec4>(), Usage::STORAGE),
            ledger: zeros("ledger", size_of::<LedgerSums>(), storage),
            ledger_read: zeros("ledger read", size_of::<LedgerSums>(), Usage::COPY_DST | Usage::MAP_READ),
            power: zeros("power", 4 * patches.groups.len(), Usage::STORAGE),
            offered: zeros("offered", 4 * patches.groups.len(), Usage::STORAGE),
            best_of_tile: zeros("best of tile", 8 * patches.groups.len().div_ceil(256), Usage::STORAGE),
            chosen: zeros("chosen", 4 * slots, Usage::STORAGE),
            order: zeros("order", 16, Usage::STORAGE),
        }
    }
}

/// What binds the buffers to the pipelines that depend on no resolution.
pub(super) struct BindGroups {
    pub(super) faces: wgpu::BindGroup,
    pub(super) find_power: wgpu::BindGroup,
    pub(super) find_best: wgpu::BindGroup,
    pub(super) choose: wgpu::BindGroup,
    pub(super) choose_mesh: wgpu::BindGroup,
    pub(super) take: wgpu::BindGroup,
    pub(super) add_up: wgpu::BindGroup,
}

impl BindGroups {
    pub(super) fn new(device: &wgpu::Device, pipelines: &Pipelines, buffers: &Buffers) -> Self {
        let Buffers { settings, receivers, groups, shooters, faces, unshot, sums, lost, ledger, .. } = buffers;
        let Buffers { charts, power, offered, best_of_tile, chosen, order, shots, .. } = buffers;
        let bind = |pipeline, buffers: &[(u32, &wgpu::Buffer)]| bind(device, pipeline, buffers, &[]);
        Self {
            faces: bind(&pipelines.faces, &[(0, settings), (1, shooters), (2, faces)]),
            find_power: bind(
                &pipelines.find_power,
                &[(0, settings), (1, receivers), (2, groups), (3, unshot), (4, power)],
            ),
            find_best: bind(
                &pipelines.find_best,
                &[(0, settings), (2, groups), (4, power), (5, best_of_tile), (11, offered)],
            ),
            choose: bind(&pipelines.choose, &[(0, settings), (5, best_of_tile), (6, chosen), (11, offered)]),
            choose_mesh: bind(
                &pipelines.choose_mesh,
                &[(0, settings), (6, chosen), (8, charts), (9, order), (11, offered)],
            ),
            take: bind(
                &pipelines.take,
                &[(0, settings), (1, receivers), (2, groups), (3, unshot), (6, chosen), (7, shooters), (10, shots)],
            ),
            add_up: bind(&pipelines.add_up, &[(0, settings), (1, shooters), (2, sums), (4, lost), (5, ledger)]),
        }
    }
}

/// One set of hemicubes with what depends on their resolution.
pub(super) struct HemicubeSet {
    pub(super) pass: HemicubePass,
    pub(super) receive: wgpu::BindGroup,
    pub(super) lost: wgpu::BindGroup,
    weights: wgpu::Buffer,
}

impl HemicubeSet {
    pub(super) fn new(
        device: &wgpu::Device,
        shaders: &Shaders,
        pipelines: &Pipelines,
        buffers: &Buffers,
        (scene, layout): (&SceneBuffers, TileLayout),
    ) -> Self {
        let pass = HemicubePass::with_sides(device, shaders, scene, layout);
        let weights = match pass.hemispheres {
            None => delta_form_factors(layout.resolution),
            Some(_) => pixel_weights(layout.resolution),
        };
        let weights = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("delta form factors"),
            contents: bytemuck::cast_slice(&weights),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let (receive, lost) = Self::bind(device, pipelines, buffers, &pass, &weights);
        Self { pass, receive, lost, weights }
    }

    fn bind(
        device: &wgpu::Device,
        pipelines: &Pipelines,
        buffers: &Buffers,
        pass: &HemicubePass,
        weights: &wgpu::Buffer,
    ) -> (wgpu::BindGroup, wgpu::BindGroup) {
        let Buffers { settings, receivers, shooters, irradiance, unshot, sums, lost, .. } = buffers;
        let (depth, sides) = ((6, &pass.depth), pass.sides.as_ref().map(|sides| (7, sides)));
        let seen = sides.filter(|_| pass.hemispheres.is_some()).unwrap_or(depth);
        let lost_through: Vec<_> = std::iter::once(depth).chain(sides).collect();
        let receive = [(0, settings), (1, shooters), (2, receivers), (3, irradiance), (4, unshot), (5, sums)];
        let find_lost = [(0, settings), (1, shooters), (3, weights), (4, lost)];
        (
            bind(device, &pipelines.receive, &receive, &[seen]),
            bind(device, &pipelines.find_lost, &find_lost, &lost_through),
        )
    }

    /// The same with other shaders.
    pub(super) fn reloaded(
        &self,
        device: &wgpu::Device,
        shaders: &Shaders,
        pipelines: &Pipelines,
        (buffers, scene): (&Buffers, &SceneBuffers),
    ) -> Self {
        let pass = self.pass.reloaded(device, shaders, scene);
        let (receive, lost) = Self::bind(device, pipelines, buffers, &pass, &self.weights);
        Self { pass, receive, lost, weights: self.weights.clone() }
    }
}

/// Buffers and textures by binding.
fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    buffers: &[(u32, &wgpu::Buffer)],
    textures: &[(u32, &wgpu::TextureView)],
) -> wgpu::BindGroup {
    let mut entries: Vec<_> = buffers
        .iter()
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
        .collect();
    let textures = textures.iter().map(|&(binding, view)| (binding, wgpu::BindingResource::TextureView(view)));
    entries.extend(textures.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }));
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

/// Bytes that a solve keeps on the device: the texels, the scene's triangles, and the atlases of depth and of sides or items.
pub(super) fn device_bytes(
    patches: &Patches,
    scene: &crate::scene::Scene,
    layouts: &[TileLayout],
    visibility: Visibility,
) -> u64 {
    let texels = patches.receivers.len() as u64;
    let fields = 5 * size_of::<Vec4>() as u64;
    let groups = patches.groups.len() as u64 * (size_of::<super::patches::Group>() as u64 + 8);
    let lamps = (patches.lamps.len() as u64 + u64::from(MOST_SLOTS)) * size_of::<Shooter>() as u64;
    let pixels: u64 = layouts.iter().map(|layout| layout.size().map(u64::from).iter().product::<u64>()).sum();
    let (pixel, triangle) = if visibility == Visibility::Hemisphere { (8, 36) } else { (5, 0) };
    let scene_bytes = SceneBuffers::bytes(scene) + triangle * scene.mesh.triangles.len() as u64;
    texels * (size_of::<Receiver>() as u64 + fields + 9) + groups + lamps + pixel * pixels + scene_bytes
}

/// Refuses what the device cannot hold.
pub(super) fn check_size(
    device: &wgpu::Device,
    patches: &Patches,
    bytes: u64,
    most_mebibytes: u32,
) -> Result<(), String> {
    let limits = device.limits();
    let binding = limits.max_storage_buffer_binding_size;
    let most_bytes = binding / size_of::<Receiver>() as u64;
    if size_of_val(patches.groups.as_slice()) as u64 > binding {
        return Err(format!(
            "{} groups of texels are more than this device takes: ask for fewer texels, or larger groups",
            patches.groups.len()
        ));
    }
    let most_groups = 64 * u64::from(limits.max_compute_workgroups_per_dimension);
    let most = most_bytes.min(most_groups);
    let mebibytes = bytes.div_ceil(1 << 20);
    match patches.receivers.len() as u64 {
        0 => Err(String::from("the scene has no open surface to light")),
        count if count > most => Err(format!("{count} texels; this device takes {most}: ask for fewer")),
        count if mebibytes > u64::from(most_mebibytes) => Err(format!(
            "{count} texels need {mebibytes} MiB on the device, more than the {most_mebibytes} MiB that are allowed: \
             ask for fewer texels, or allow more (device-memory)"
        )),
        _ => Ok(()),
    }
}
