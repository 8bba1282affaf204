//! Rooms: surfaces between which light can go, by whatever way.
//!
//! What a hemicube's pixels show is coarse at the foot of a wall, and lets some light through there. Into a room that no ray
//! reaches from any other surface none is let at all.

use crate::{math::sets::Sets, scene::Mesh};

/// For each triangle the number of its room, from pairs of triangles that see each other; those that share a vertex are in
/// one room, too.
pub(super) fn rooms(mesh: &Mesh, sights: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut rooms = Sets::of_one(mesh.triangles.len() as u32);
    let mut first_at = vec![u32::MAX; mesh.positions.len()];
    for (triangle, corners) in (0..).zip(&mesh.triangles) {
        for &vertex in corners {
            let first = &mut first_at[vertex as usize];
            if *first == u32::MAX {
                *first = triangle;
            } else {
                rooms.join(*first, triangle);
            }
        }
    }
    sights.for_each(|[one, other]| rooms.join(one, other));
    rooms.into_lowest()
}
