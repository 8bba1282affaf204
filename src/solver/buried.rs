//! Values for buried vertices.

use glam::Vec3;

use crate::{scene::Mesh, transport::VertexOrigins};

/// The value of each buried vertex that shares an element with one that is not buried: the mean of those. So an
/// element half under an object shows what its free corners see. Vertices deeper inside stay as they are: nothing
/// reaches them.
pub(super) fn fill_buried(mesh: &Mesh, origins: &VertexOrigins, field: &[Vec3], buried: &[bool]) -> Vec<(usize, Vec3)> {
    let mean_of_free = |vertex: usize| {
        let around = origins.elements_around(vertex as u32).iter();
        let corners = around.flat_map(|&element| mesh.triangles[element as usize]);
        let (mut sum, mut count) = (Vec3::ZERO, 0.0_f32);
        for corner in corners.map(|corner| corner as usize).filter(|&corner| !buried[corner]) {
            sum += field[corner];
            count += 1.0;
        }
        (count > 0.0).then(|| sum / count)
    };
    let vertices = (0..field.len()).filter(|&vertex| buried[vertex]);
    vertices.filter_map(|vertex| mean_of_free(vertex).map(|value| (vertex, value))).collect()
}
