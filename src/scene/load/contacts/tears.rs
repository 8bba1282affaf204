//! Which corners belong together: pieces around one position, connected by edges along which nothing stands.

use std::collections::HashMap;

use super::{cut::Cuts, points::edge_key};
use crate::{math::sets::Sets, scene::load::merge::Faces};

/// For each corner `3 · triangle + place` of the cut faces the number of its fan at its position: corners of one position
/// and one normal share a vertex if it agrees. 0 where nothing stands.
pub(super) fn fans(cuts: &Cuts, cut: &Faces) -> Vec<u32> {
    let mut fans = vec![0; 3 * cut.corners.len()];
    // The corners around each position at which something stands.
    let mut around: HashMap<u32, Vec<u32>> = cuts.standing.keys().flatten().map(|&id| (id, Vec::new())).collect();
    let mut torn = Vec::new();
    for corner in 0..fans.len() as u32 {
        let id = cut.id(corner);
        if let Some(corners) = around.get_mut(&id) {
            if corners.is_empty() {
                torn.push(id);
            }
            corners.push(corner);
        }
    }
    for id in torn {
        number_fans(&around[&id], cuts, cut, &mut fans);
    }
    fans
}

/// Numbers the fans of the corners around one position.
fn number_fans(corners: &[u32], cuts: &Cuts, cut: &Faces, fans: &mut [u32]) {
    let mut groups = Sets::of_one(corners.len() as u32);
    // A corner's two edges, by their other ends with the normals there.
    let ends = |corner: u32| {
        let triangle = cut.corners[corner as usize / 3];
        [1, 2].map(|step| triangle[(corner as usize % 3 + step) % 3])
    };
    for one in 0..corners.len() {
        for other in 0..one {
            let (a, b) = (corners[one], corners[other]);
            let own = |corner: u32| cut.corners[corner as usize / 3][corner as usize % 3];
            if own(a).1 != own(b).1 {
                continue;
            }
            let shared = ends(a).into_iter().find(|end| ends(b).contains(end));
            let Some((end, _)) = shared else { continue };
            if !stands_between(a, b, edge_key(own(a).0, end), cuts) {
                groups.join(one as u32, other as u32);
            }
        }
    }
    for (corner, group) in corners.iter().zip(groups.into_lowest()) {
        fans[*corner as usize] = group;
    }
}

/// True if something else stands on either of two pieces along the edge that they share.
fn stands_between(a: u32, b: u32, edge: [u32; 2], cuts: &Cuts) -> bool {
    let [one, other] = [a, b].map(|corner| cuts.pieces[corner as usize / 3].face);
    cuts.standing.get(&edge).is_some_and(|standing| {
        standing.iter().any(|&[face, stands]| (face == one || face == other) && stands != one && stands != other)
    })
}
