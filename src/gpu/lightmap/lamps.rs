//! The lights as shooters.

use glam::Vec3;

use super::{
    groups::{Levels, groups},
    patches::{Group, Shooter},
};
use crate::{
    lightmap::{Atlas, Texel},
    scene::AreaLight,
};

/// More emissive groups than this shoot as larger ones.
const MOST_EMITTERS: usize = 1024;
/// An emissive surface of fewer texels than this has them cut.
const FEWEST_EMITTERS: usize = 32;

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

/// A shooter as `side`² smaller ones. Hemicubes do not stand in their middles, but so that no two have the same column or
/// row of a grid `side` times as fine (Chiu, Shirley and Wang 1994, multi-jittered sampling): a shadow's edge along a side
/// of the light then has `side`² steps and not `side`.
fn cut(whole: &Shooter, side: u32) -> Vec<Shooter> {
    let side = side.max(1);
    let offset = |place: f32| 2.0 * place / side as f32 - 1.0;
    let part = |index: u32| {
        let (column, row) = (index % side, index / side);
        let step = |x: f32, y: f32| offset(column as f32 + x) * whole.half_u + offset(row as f32 + y) * whole.half_v;
        let fine = |place: u32| (place as f32 + 0.5) / side as f32;
        Shooter {
            centre: whole.centre + step(0.5, 0.5),
            area: whole.area / (side * side) as f32,
            origin: whole.origin + step(fine(row), fine(column)),
            half_u: whole.half_u / side as f32,
            half_v: whole.half_v / side as f32,
            ..*whole
        }
    };
    (0..side * side).map(part).collect()
}

/// The emissive texels as shooters: in groups where there are many, cut where there are few.
pub(super) fn emitters(atlas: &Atlas, texels: &[&Texel]) -> Vec<Shooter> {
    let emissive: Vec<&Texel> = texels.iter().copied().filter(|texel| texel.emission.max_element() > 0.0).collect();
    let blocks = |level| groups(atlas, &emissive, Levels { finest: level, coarsest: level, near_power: 0.0 });
    let mut found = blocks(0);
    for level in 1..16 {
        if found.len() <= MOST_EMITTERS {
            break;
        }
        found = blocks(level);
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
