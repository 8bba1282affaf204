//! The outlines of flat surfaces, freed of the vertices that no surface needs.

use glam::{DVec3, Vec3};

use super::{FLAT, Faces, NONE, regions::Regions};

pub(super) struct Outlines {
    /// For each region its closed outlines, as corners: counter-clockwise around it, clockwise around its holes.
    pub(super) loops: Vec<Vec<Vec<u32>>>,
}

impl Outlines {
    pub(super) fn of(regions: &Regions, faces: &Faces, positions: &[Vec3]) -> Self {
        let whole = whole_loops(regions, faces.corners.len());
        let point = |corner: u32| positions[faces.id(corner) as usize].as_dvec3();
        let mut is_kept = vec![false; positions.len()];
        for triangle in (0..faces.corners.len() as u32).filter(|&one| regions.region_of[one as usize] == NONE) {
            faces.ids(triangle).into_iter().for_each(|id| is_kept[id as usize] = true);
        }
        keep_bends_and_repeats(&whole, faces, &point, &mut is_kept);
        // Straight by steps is not straight yet. Every round keeps more, and all loops see it.
        loop {
            let mut any = false;
            for outline in whole.iter().flatten() {
                any |= keep_crooked_runs(outline, faces, &point, &mut is_kept);
            }
            if !any {
                break;
            }
        }
        let kept = |outline: &Vec<u32>| -> Vec<u32> {
            outline.iter().copied().filter(|&corner| is_kept[faces.id(corner) as usize]).collect()
        };
        Self { loops: whole.iter().map(|outlines| outlines.iter().map(kept).collect()).collect() }
    }
}

/// The outlines with all their vertices.
fn whole_loops(regions: &Regions, triangle_count: usize) -> Vec<Vec<Vec<u32>>> {
    let following = |corner: u32| corner - corner % 3 + (corner + 1) % 3;
    let mut loops: Vec<Vec<Vec<u32>>> = regions.list.iter().map(|_| Vec::new()).collect();
    let mut is_seen = vec![false; 3 * triangle_count];
    for start in 0..3 * triangle_count as u32 {
        let region = regions.region_of[start as usize / 3];
        if region == NONE || is_seen[start as usize] || regions.inner_mate(start).is_some() {
            continue;
        }
        let mut outline = Vec::new();
        let mut corner = start;
        while !is_seen[corner as usize] {
            is_seen[corner as usize] = true;
            outline.push(corner);
            // Around the edge's end, from one triangle of the region to the next, to the next edge of the outline.
            corner = following(corner);
            while let Some(mate) = regions.inner_mate(corner) {
                corner = following(mate);
            }
        }
        loops[region as usize].push(outline);
    }
    loops
}

/// Keeps where an outline bends, and where one region's outline comes by twice.
fn keep_bends_and_repeats(whole: &[Vec<Vec<u32>>], faces: &Faces, point: &impl Fn(u32) -> DVec3, is_kept: &mut [bool]) {
    let mut last_region = vec![NONE; is_kept.len()];
    for (region, outlines) in whole.iter().enumerate() {
        for outline in outlines {
            for (place, &corner) in outline.iter().enumerate() {
                let before = point(outline[(place + outline.len() - 1) % outline.len()]);
                let after = point(outline[(place + 1) % outline.len()]);
                let id = faces.id(corner) as usize;
                let is_repeated = last_region[id] == region as u32;
                last_region[id] = region as u32;
                is_kept[id] |= is_repeated || !is_between(point(corner), before, after);
            }
        }
    }
}

/// Keeps all vertices of those runs between two kept ones that leave the straight line; true if there is one.
fn keep_crooked_runs(outline: &[u32], faces: &Faces, point: &impl Fn(u32) -> DVec3, is_kept: &mut [bool]) -> bool {
    let count = outline.len();
    let kept: Vec<usize> = (0..count).filter(|&place| is_kept[faces.id(outline[place]) as usize]).collect();
    let mut any = false;
    let mut keep = |place: usize| {
        let id = faces.id(outline[place % count]) as usize;
        any |= !is_kept[id];
        is_kept[id] = true;
    };
    if kept.len() < 3 {
        (0..count).for_each(keep);
        return any;
    }
    for (index, &from) in kept.iter().enumerate() {
        let to = if index + 1 < kept.len() { kept[index + 1] } else { kept[0] + count };
        let at = |place: usize| point(outline[place % count]);
        let along = at(to) - at(from);
        let mut inside = from + 1..to;
        let is_straight = inside.all(|place| {
            let goes_on = (at(place) - at(place - 1)).dot(along) > 0.0 && (at(to) - at(place)).dot(along) > 0.0;
            goes_on && is_between(at(place), at(from), at(to))
        });
        if !is_straight {
            (from + 1..to).for_each(&mut keep);
        }
    }
    any
}

/// True if a point lies on the line between two others.
fn is_between(point: DVec3, before: DVec3, after: DVec3) -> bool {
    let along = after - before;
    let (to_point, length) = (point - before, along.length());
    length > 0.0 && to_point.cross(along).length() <= FLAT * length && to_point.dot(along) > 0.0 && {
        (after - point).dot(along) > 0.0
    }
}
