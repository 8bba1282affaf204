//! Which texels shoot as one: blocks of them, in a tree of blocks.

use glam::Vec3;

use super::patches::Group;
use crate::{
    lightmap::{Atlas, Texel, texels::block_key},
    scene::mesh::unit_or_zero,
};

/// A block shoots as one where every other surface is this many times its side away, or more: what stands nearer sees its
/// parts, and not its middle. On the Cornell box a smaller one errs more, and a larger one leaves all blocks small.
const FAR: f32 = 0.5;

/// No group is above this one.
const NO_PARENT: u32 = u32::MAX;

/// How large groups are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Levels {
    /// Blocks of 2^n texels a side may always shoot as one.
    pub(super) finest: u32,
    /// And none larger than these.
    pub(super) coarsest: u32,
    /// Blocks with something near may while their unshot power is no more than this, or a quarter of it for each level
    /// above the second: what is wrong with them is little then (Hanrahan, Salzman and Aupperle 1991, refinement by
    /// power). 0 for never.
    pub(super) near_power: f32,
}

/// Runs of texels that lie in one block, as a tree: a group comes before those that it is cut into, and may shoot instead of
/// them while its unshot power is no more than [`Group::most_power`].
pub(super) fn groups(atlas: &Atlas, texels: &[&Texel], levels: Levels) -> Vec<Group> {
    let mut found = Vec::new();
    let mut first = 0;
    let level = levels.coarsest.max(levels.finest);
    let key = |texel: &Texel| block_key(&atlas.charts, texel, level);
    for run in texels.chunk_by(|a, b| key(a) == key(b)) {
        split(atlas, run, levels, (first, level, NO_PARENT), &mut found);
        first += run.len() as u32;
    }
    found
}

/// One block as a group; and its four quarters, if something is near.
fn split(
    atlas: &Atlas,
    run: &[&Texel],
    levels: Levels,
    (first, level, parent): (u32, u32, u32),
    found: &mut Vec<Group>,
) {
    let mean_area = run.iter().map(|texel| texel.area).sum::<f32>() / run.len() as f32;
    let side = (1_u32 << level) as f32 * mean_area.sqrt();
    let is_leaf = level == levels.finest || run.iter().all(|texel| texel.clearance >= FAR * side);
    let mut parent = parent;
    if is_leaf || levels.near_power > 0.0 {
        let above = (level - levels.finest) as i32;
        let most_power = if is_leaf { f32::MAX } else { levels.near_power * 0.25_f32.powi(above - 1) };
        found.push(Group { most_power, parent, ..group(atlas, run, first) });
        parent = found.len() as u32 - 1;
    }
    if is_leaf {
        return;
    }
    let mut first = first;
    let key = |texel: &Texel| block_key(&atlas.charts, texel, level - 1);
    for quarter in run.chunk_by(|a, b| key(a) == key(b)) {
        split(atlas, quarter, levels, (first, level - 1, parent), found);
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
