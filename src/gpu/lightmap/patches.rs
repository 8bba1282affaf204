//! What the passes compute on: receivers (texels), groups of texels that shoot as one, and the lights, as plain data in
//! the layout of `patches.wgsl`.

use glam::{Vec3, Vec4};

use super::{
    groups::{Levels, groups},
    lamps::{emitters, lamps_of},
};
use crate::{
    lightmap::{Atlas, GpuSettings, ShootingOrder, Texel},
    scene::AreaLight,
};

/// Uniforms of a submission, laid out as `Settings` in `patches.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct BatchSettings {
    /// Texels.
    pub receiver_count: u32,
    /// Groups of texels.
    pub group_count: u32,
    /// Shooters of this batch.
    pub slot_count: u32,
    /// Pixels along a hemicube's top.
    pub resolution: u32,
    /// Hemicubes side by side in the depth atlas.
    pub tiles_per_row: u32,
    /// Distance of the near plane [local units].
    pub near: f32,
    /// Depth that a receiver may lie behind what a pixel shows and be seen, in pixels.
    pub bias: f32,
    /// 1 for percentage-closer filtering over four pixels, else 0.
    pub filtered: u32,
    /// First shooter of this submission.
    pub first_slot: u32,
    /// Shooter after the last one of this submission.
    pub end_slot: u32,
    /// First texel of this submission.
    pub first_receiver: u32,
    /// Texel after the last one of this submission.
    pub end_receiver: u32,
    /// Shooters before this batch.
    pub shooter_count: u32,
    /// How light fades with distance: a number of [`crate::lightmap::Attenuation`].
    pub attenuation: u32,
    /// Mean area of a group, for attenuations that know no other.
    pub patch_area: f32,
    /// Not used.
    pub spare: u32,
}

/// A texel that light arrives at.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Receiver {
    /// Middle of its open part.
    pub position: Vec3,
    /// Open area.
    pub area: f32,
    /// Unit normal of its plane.
    pub geometric_normal: Vec3,
    /// The triangle of its largest part.
    pub triangle: u32,
    /// Unit normal that light is received about.
    pub shading_normal: Vec3,
    /// The number of its room.
    pub room: u32,
    /// Reflectance.
    pub reflectance: Vec3,
    /// Not used.
    pub spare_again: f32,
}

/// Texels that shoot as one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Group {
    /// Middle of its texels.
    pub centre: Vec3,
    /// Open area of its texels.
    pub area: f32,
    /// Where its hemicube stands: the position of the texel nearest to the middle.
    pub origin: Vec3,
    /// Its first texel.
    pub first: u32,
    /// Unit normal.
    pub normal: Vec3,
    /// Its texels.
    pub count: u32,
    /// From its middle to the middle of a side.
    pub half_u: Vec3,
    /// The chart it lies in.
    pub chart: u32,
    /// From its middle to the middle of the next side.
    pub half_v: Vec3,
    /// With more unshot power than this its parts shoot, and not it [W per m² times local units², bands together].
    pub most_power: f32,
    /// Unit vector in its plane.
    pub tangent: Vec3,
    /// The group that it is a part of; `u32::MAX` if there is none.
    pub parent: u32,
}

/// A patch that shoots: a parallelogram of one radiosity.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Shooter {
    /// Middle.
    pub centre: Vec3,
    /// Area; 0 if nothing shoots.
    pub area: f32,
    /// Where its hemicube stands.
    pub origin: Vec3,
    /// Its first texel.
    pub first: u32,
    /// Unit normal.
    pub normal: Vec3,
    /// Its texels; none for a light.
    pub count: u32,
    /// From its middle to the middle of a side.
    pub half_u: Vec3,
    /// Not used.
    pub spare_three: f32,
    /// From its middle to the middle of the next side.
    pub half_v: Vec3,
    /// Not used.
    pub spare_four: f32,
    /// Unit vector in its plane.
    pub tangent: Vec3,
    /// Not used.
    pub spare_five: f32,
    /// Radiosity that it shoots [W/m²].
    pub radiosity: Vec3,
    /// Not used.
    pub spare_six: f32,
}

/// The matrix of a hemicube's face, which the vertex shader reads by instance.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Face {
    /// Row that gives x.
    pub x: Vec4,
    /// Row that gives y.
    pub y: Vec4,
    /// Row that gives w.
    pub w: Vec4,
}

/// Sums of power by workgroup, laid out as `PowerSums` in `patches.wgsl` [W per m² times local units²].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PowerSums {
    /// Arrived in this batch.
    pub arrived: Vec3,
    /// Not used.
    pub spare: f32,
    /// Of that, reflected.
    pub reflected: Vec3,
    /// Not used.
    pub spare_too: f32,
    /// Waiting to be shot.
    pub unshot: Vec3,
    /// Not used.
    pub spare_three: f32,
}

/// The only thing that is read back while a solve runs, laid out as `Ledger` in `ledger.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct LedgerSums {
    /// Power that arrived on front sides so far.
    pub arrived: Vec3,
    /// Shooters so far.
    pub shooters: u32,
    /// Of the arrived power, reflected.
    pub reflected: Vec3,
    /// Not used.
    pub spare: f32,
    /// Power that left through pixels which show nothing.
    pub escaped: Vec3,
    /// Not used.
    pub spare_too: f32,
    /// Power through pixels that show back faces.
    pub on_backs: Vec3,
    /// Not used.
    pub spare_three: f32,
    /// Power that waits to be shot.
    pub unshot: Vec3,
    /// Not used.
    pub spare_four: f32,
}

/// The groups of one chart, laid out as `ChartGroups` in `choose.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ChartGroups {
    /// Its first group.
    pub first: u32,
    /// Its groups.
    pub count: u32,
    /// Their area.
    pub area: f32,
    /// Not used.
    pub spare: f32,
}

/// Everything that a solve uploads.
#[derive(Clone, Debug)]
pub struct Patches {
    /// The atlas's open texels, in their order.
    pub receivers: Vec<Receiver>,
    /// The number of each receiver's texel in the atlas.
    pub texel_of_receiver: Vec<u32>,
    /// The groups, each a run of receivers; some are parts of others.
    pub groups: Vec<Group>,
    /// The charts, each a run of groups.
    pub charts: Vec<ChartGroups>,
    /// The placed light and the emissive texels, cut into shooters.
    pub lamps: Vec<Shooter>,
    /// Emitted power [W per m² times local units²].
    pub emitted: Vec3,
}

impl Patches {
    /// As the settings say, for the placed light, if there is one, and for what emits.
    pub fn new(atlas: &Atlas, light: Option<&AreaLight>, settings: &GpuSettings) -> Self {
        let open: Vec<u32> =
            (0..atlas.texels.len() as u32).filter(|&index| is_open(&atlas.texels[index as usize])).collect();
        let texels: Vec<&Texel> = open.iter().map(|&index| &atlas.texels[index as usize]).collect();
        let receivers = texels.iter().map(|texel| receiver(texel)).collect();
        let mut lamps: Vec<Shooter> = light.map_or(Vec::new(), |light| lamps_of(light, settings.light_side));
        lamps.extend(emitters(atlas, &texels));
        let emitted: Vec3 = lamps.iter().map(|lamp| lamp.area * lamp.radiosity).sum();
        let near_power = match settings.order {
            ShootingOrder::Brightest => NEAR_POWER * emitted.element_sum(),
            ShootingOrder::Mesh => 0.0,
        };
        let levels = Levels { finest: settings.group.ilog2(), coarsest: settings.far_group.ilog2(), near_power };
        let groups = groups(atlas, &texels, levels);
        let charts = charts(&groups);
        Self { receivers, texel_of_receiver: open, groups, charts, lamps, emitted }
    }

    /// Groups that are cut no further.
    pub(super) fn leaves(&self) -> impl Iterator<Item = &Group> {
        self.groups.iter().filter(|group| group.most_power == f32::MAX)
    }
}

/// Blocks of twice the finest side shoot as one, even where something is near, while they have no more than this part of the
/// emitted power.
const NEAR_POWER: f32 = 7e-4;

fn charts(groups: &[Group]) -> Vec<ChartGroups> {
    let mut first = 0;
    let runs = groups.chunk_by(|a, b| a.chart == b.chart);
    runs.map(|run| {
        let area = run.iter().map(|group| group.area).sum();
        let chart = ChartGroups { first, count: run.len() as u32, area, spare: 0.0 };
        first += chart.count;
        chart
    })
    .collect()
}

fn is_open(texel: &Texel) -> bool {
    texel.open_area() > 0.0 && texel.position.is_finite() && texel.geometric_normal != Vec3::ZERO
}

fn receiver(texel: &Texel) -> Receiver {
    Receiver {
        position: texel.position,
        area: texel.open_area(),
        geometric_normal: texel.geometric_normal,
        triangle: texel.triangle,
        shading_normal: texel.shading_normal,
        room: texel.room,
        reflectance: texel.reflectance,
        ..Receiver::default()
    }
}
