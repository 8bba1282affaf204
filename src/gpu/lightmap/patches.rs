//! What the passes compute on: receivers (texels), groups of texels that shoot as one, and the lights, as plain data in
//! the layout of `patches.wgsl`.

use glam::{Vec3, Vec4};

use crate::{
    lightmap::{Atlas, Texel, texels::block_key},
    scene::{AreaLight, mesh::unit_or_zero},
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
    /// Not used.
    pub spare: f32,
    /// Unit normal that light is received about.
    pub shading_normal: Vec3,
    /// Not used.
    pub spare_too: f32,
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
    /// Not used.
    pub spare: f32,
    /// Unit vector in its plane.
    pub tangent: Vec3,
    /// Not used.
    pub spare_too: f32,
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
    /// Power that waits to be shot.
    pub unshot: Vec3,
    /// Not used.
    pub spare_three: f32,
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
    /// The groups, each a run of receivers.
    pub groups: Vec<Group>,
    /// The charts, each a run of groups.
    pub charts: Vec<ChartGroups>,
    /// The placed light and the emissive texels, cut into shooters.
    pub lamps: Vec<Shooter>,
    /// Emitted power [W per m² times local units²].
    pub emitted: Vec3,
}

/// More emissive groups than this shoot as larger ones.
const MOST_EMITTERS: usize = 1024;
/// An emissive surface of fewer texels than this has them cut.
const FEWEST_EMITTERS: usize = 32;

impl Patches {
    /// Groups are blocks of 2^n texels a side, n from the first of `levels`, where other surfaces are near, to the second;
    /// the placed light is cut into `lamp_side`² shooters.
    pub fn new(atlas: &Atlas, light: Option<&AreaLight>, levels: [u32; 2], lamp_side: u32) -> Self {
        let open: Vec<u32> =
            (0..atlas.texels.len() as u32).filter(|&index| is_open(&atlas.texels[index as usize])).collect();
        let texels: Vec<&Texel> = open.iter().map(|&index| &atlas.texels[index as usize]).collect();
        let receivers = texels.iter().map(|texel| receiver(texel)).collect();
        let groups = groups(atlas, &texels, levels);
        let mut lamps: Vec<Shooter> = light.map_or(Vec::new(), |light| lamps_of(light, lamp_side));
        lamps.extend(emitters(atlas, &texels));
        let emitted = lamps.iter().map(|lamp| lamp.area * lamp.radiosity).sum();
        let charts = charts(&groups);
        Self { receivers, texel_of_receiver: open, groups, charts, lamps, emitted }
    }
}

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
        shading_normal: texel.shading_normal,
        reflectance: texel.reflectance,
        ..Receiver::default()
    }
}

/// A block shoots as one where every other surface is this many times its side away, or more: what stands nearer sees its
/// parts, and not its middle. On the Cornell box a smaller one errs more, and a larger one leaves all blocks small.
const FAR: f32 = 0.5;

/// Runs of texels that lie in one block: of the second level where nothing is near, down to the first where something is.
fn groups(atlas: &Atlas, texels: &[&Texel], [finest, coarsest]: [u32; 2]) -> Vec<Group> {
    let mut found = Vec::new();
    let mut first = 0;
    let key = |texel: &Texel| block_key(&atlas.charts, texel, coarsest.max(finest));
    for run in texels.chunk_by(|a, b| key(a) == key(b)) {
        split(atlas, run, (first, coarsest.max(finest), finest), &mut found);
        first += run.len() as u32;
    }
    found
}

/// One block as a group, or its four quarters, if something is near.
fn split(atlas: &Atlas, run: &[&Texel], (first, level, finest): (u32, u32, u32), found: &mut Vec<Group>) {
    let mean_area = run.iter().map(|texel| texel.area).sum::<f32>() / run.len() as f32;
    let side = (1_u32 << level) as f32 * mean_area.sqrt();
    if level == finest || run.iter().all(|texel| texel.clearance >= FAR * side) {
        found.push(group(atlas, run, first));
        return;
    }
    let mut first = first;
    let key = |texel: &Texel| block_key(&atlas.charts, texel, level - 1);
    for quarter in run.chunk_by(|a, b| key(a) == key(b)) {
        split(atlas, quarter, (first, level - 1, finest), found);
        first += quarter.len() as u32;
    }
}

fn group(atlas: &Atlas, texels: &[&Texel], first: u32) -> Group {
    let area: f32 = texels.iter().map(|texel| texel.open_area()).sum();
    let mean = |value: &dyn Fn(&Texel) -> Vec3| -> Vec3 {
        texels.iter().map(|texel| texel.open_area() * value(texel)).sum::<Vec3>() / area
    };
    let centre = mean(&|texel| texel.position);
    let nearest = texels
        .iter()
        .min_by(|a, b| a.position.distance_squared(centre).total_cmp(&b.position.distance_squared(centre)));
    let nearest = nearest.map_or((centre, Vec3::Z), |texel| (texel.position, texel.geometric_normal));
    let normal = unit_or_zero(mean(&|texel| texel.geometric_normal));
    let normal = if normal == Vec3::ZERO { nearest.1 } else { normal };
    // The block's sides, cut down to its open area.
    let places = texels.iter().map(|texel| atlas.charts.place(texel.pixel as usize));
    let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
    for [_, column, row] in places {
        low = [low[0].min(column), low[1].min(row)];
        high = [high[0].max(column + 1), high[1].max(row + 1)];
    }
    let half = |axis: usize| 0.5 * (high[axis] - low[axis]) as f32 * mean(&|texel| texel.steps[axis]);
    let (half_u, half_v) = of_area(half(0), half(1), area, normal);
    Group {
        centre,
        area,
        origin: nearest.0,
        first,
        normal,
        count: texels.len() as u32,
        half_u,
        chart: texels[0].chart,
        half_v,
        tangent: normal.any_orthonormal_vector(),
        ..Group::default()
    }
}

/// Two half sides brought to an area; a square where they have none.
fn of_area(half_u: Vec3, half_v: Vec3, area: f32, normal: Vec3) -> (Vec3, Vec3) {
    let scale = (area / (4.0 * half_u.cross(half_v).length())).sqrt();
    if scale.is_finite() && scale > 0.0 {
        return (scale * half_u, scale * half_v);
    }
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    (0.5 * area.sqrt() * tangent, 0.5 * area.sqrt() * bitangent)
}

/// The placed light as `side`² shooters; none if it does not shine.
pub fn lamps_of(light: &AreaLight, side: u32) -> Vec<Shooter> {
    let normal = light.normal();
    if normal == Vec3::ZERO || light.radiance.max_element() <= 0.0 {
        return Vec::new();
    }
    let whole = Shooter {
        centre: light.centre,
        area: light.area(),
        origin: light.centre,
        normal,
        half_u: light.half_extent_u,
        half_v: light.half_extent_v,
        tangent: normal.any_orthonormal_vector(),
        radiosity: std::f32::consts::PI * light.radiance,
        ..Shooter::default()
    };
    cut(&whole, side)
}

/// A shooter as `side`² smaller ones.
fn cut(whole: &Shooter, side: u32) -> Vec<Shooter> {
    let side = side.max(1);
    let offset = |index: u32| (2.0 * index as f32 + 1.0) / side as f32 - 1.0;
    let part = |index: u32| {
        let step = offset(index % side) * whole.half_u + offset(index / side) * whole.half_v;
        Shooter {
            centre: whole.centre + step,
            area: whole.area / (side * side) as f32,
            origin: whole.origin + step,
            half_u: whole.half_u / side as f32,
            half_v: whole.half_v / side as f32,
            ..*whole
        }
    };
    (0..side * side).map(part).collect()
}

/// The emissive texels as shooters: in groups where there are many, cut where there are few.
fn emitters(atlas: &Atlas, texels: &[&Texel]) -> Vec<Shooter> {
    let emissive: Vec<&Texel> = texels.iter().copied().filter(|texel| texel.emission.max_element() > 0.0).collect();
    let mut found = groups(atlas, &emissive, [0; 2]);
    for level in 1..16 {
        if found.len() <= MOST_EMITTERS {
            break;
        }
        found = groups(atlas, &emissive, [level; 2]);
    }
    let side = if found.is_empty() { 1 } else { (FEWEST_EMITTERS as f32 / found.len() as f32).sqrt().ceil() as u32 };
    let shooter = |group: &Group| {
        let run = &emissive[group.first as usize..(group.first + group.count) as usize];
        let power: Vec3 = run.iter().map(|texel| texel.open_area() * texel.emission).sum();
        Shooter {
            centre: group.centre,
            area: group.area,
            origin: group.origin,
            normal: group.normal,
            half_u: group.half_u,
            half_v: group.half_v,
            tangent: group.tangent,
            radiosity: power / group.area,
            ..Shooter::default()
        }
    };
    found.iter().flat_map(|group| cut(&shooter(group), side)).collect()
}
