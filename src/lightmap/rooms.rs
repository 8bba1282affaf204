//! Rooms: surfaces between which light can go, by whatever way.
//!
//! What a hemicube's pixels show is coarse at the foot of a wall, and lets some light through there. Into a room that no ray
//! reaches from any other surface none is let at all.

use crate::scene::Mesh;

/// For each triangle the number of its room, from pairs of triangles that see each other; those that share a vertex are in
/// one room, too.
pub(super) fn rooms(mesh: &Mesh, sights: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let mut first_at = vec![u32::MAX; mesh.positions.len()];
    for (triangle, corners) in (0..).zip(&mesh.triangles) {
        for &vertex in corners {
            let first = &mut first_at[vertex as usize];
            if *first == u32::MAX {
                *first = triangle;
            } else {
                join(&mut parents, *first, triangle);
            }
        }
    }
    sights.for_each(|[one, other]| join(&mut parents, one, other));
    (0..parents.len() as u32).map(|triangle| root(&mut parents, triangle)).collect()
}

fn join(parents: &mut [u32], one: u32, other: u32) {
    let (one, other) = (root(parents, one), root(parents, other));
    parents[one.max(other) as usize] = one.min(other);
}

/// The first member of a set (union-find with path halving).
fn root(parents: &mut [u32], mut member: u32) -> u32 {
    while parents[member as usize] != member {
        let above = parents[parents[member as usize] as usize];
        parents[member as usize] = above;
        member = above;
    }
    member
}
