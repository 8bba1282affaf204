//! The field that is linear on each element and lies nearest to what was sampled, from area-averaged vertices.
//!
//! Kavan, Bargteil and Sloan 2011, "Least Squares Vertex Baking", without their term against bends: the vertex values v
//! that make ∫ (Σ_j b_j v_j - E)² dA least satisfy Σ_j M_ij v_j = ∫ b_i E dA, M_ij = ∫ b_i b_j dA. Divided by
//! ∫ b_i dA the right side is eq. 7, and a row of M the mean weights at the vertex's own sample points: so a field that
//! is linear comes out exactly, whatever points were drawn.

use glam::Vec3;
use rayon::prelude::*;

use crate::transport::star::HatRow;

/// The eigenvalues of a row-normalised mass matrix of linear triangles lie between 1/4 and 1 (Wathen 1987, "Realistic
/// eigenvalue bounds for the Galerkin mass matrix"): with this step an error shrinks to 0.6 of itself.
const STEP: f32 = 1.6;
/// 0.6 to this power is below a unit in the last place.
const STEPS: usize = 32;

/// The vertex values [W/m²] whose averages these are; a vertex with an empty row keeps its own, and all do without rows.
/// Values may lie below 0 where light ends sharply.
pub(super) fn from_averages(rows: &[HatRow], averages: Vec<Vec3>) -> Vec<Vec3> {
    if rows.is_empty() {
        return averages;
    }
    let mut values = averages.clone();
    for _ in 0..STEPS {
        let step = |vertex: usize| {
            if rows[vertex].is_empty() {
                return values[vertex];
            }
            let mean: Vec3 = rows[vertex].iter().map(|&(other, weight)| weight * values[other as usize]).sum();
            values[vertex] + STEP * (averages[vertex] - mean)
        };
        values = (0..values.len()).into_par_iter().with_min_len(1024).map(step).collect();
    }
    values
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{
        math::sequence::Sampler,
        scene::{LoadOptions, Tessellation, builtin, tessellate::TessellationOptions},
        trace::Tracer,
        transport::{Lights, Transport, VertexOrigins, lights::FinderCounts, origins::VertexValues, star::Star},
    };

    /// The rows of the Cornell box's vertices, all sample points used.
    fn rows() -> anyhow::Result<(Tessellation, Vec<HatRow>)> {
        let scene = Arc::new(builtin::cornell(&LoadOptions::default())?);
        let options = TessellationOptions { subdivide: 2, max_edge: None };
        let tessellation = Tessellation::new(&scene, &options).map_err(anyhow::Error::msg)?;
        let (origins, lights) = (VertexOrigins::new(&tessellation), Lights::new(&scene, None));
        let transport = Transport {
            scene: &scene,
            tracer: &Tracer::new(Arc::clone(&scene)),
            tessellation: &tessellation,
            targets: &tessellation,
            origins: &origins,
            values: VertexValues::LeastSquares,
            lights: &lights,
            finders: FinderCounts { gather: 256, light: 64 },
            sampler: Sampler::Sobol,
            seed: 1,
            rays: 256,
            rays_of: None,
        };
        let (mut star, mut points) = (Star::default(), Vec::new());
        let mut row = |vertex: u32| {
            star.collect(&transport, vertex, &mut points);
            assert_eq!(points.len(), 256);
            let [of_gather, _] = star.hat_rows(&tessellation, |_| true);
            of_gather
        };
        let rows = (0..tessellation.mesh.positions.len() as u32).map(&mut row).collect();
        Ok((tessellation, rows))
    }

    #[test]
    fn sampled_rows_are_those_of_the_mass_matrix() -> anyhow::Result<()> {
        let (tessellation, rows) = rows()?;
        let mesh = &tessellation.mesh;
        let mut worst = 0.0_f32;
        for (vertex, row) in rows.iter().enumerate() {
            // ∫ b_i² dA = A/6 and ∫ b_i b_j dA = A/12 on each element, ∫ b_i dA = A/3.
            let around = |wanted: u32| {
                let elements = (0..mesh.triangles.len() as u32).filter(|&element| {
                    let corners = mesh.triangles[element as usize];
                    corners.contains(&(vertex as u32)) && corners.contains(&wanted)
                });
                elements.map(|element| mesh.area(element)).sum::<f32>()
            };
            let total = around(vertex as u32);
            for &(other, weight) in row {
                let exact = if other == vertex as u32 { 0.5 } else { around(other) / total / 4.0 };
                worst = worst.max((weight - exact).abs());
            }
        }
        assert!(worst < 0.01, "off by {worst}");
        Ok(())
    }

    #[test]
    fn a_field_that_is_linear_on_every_element_comes_out_of_its_averages() -> anyhow::Result<()> {
        let (tessellation, rows) = rows()?;
        let value =
            |position: &Vec3| Vec3::new(1.0, 2.0, 3.0) + 5.0 * (41.0 * *position).map(|angle| angle.sin().abs());
        let field: Vec<Vec3> = tessellation.mesh.positions.iter().map(value).collect();
        let mean = |row: &HatRow| row.iter().map(|&(other, weight)| weight * field[other as usize]).sum::<Vec3>();
        let averages: Vec<Vec3> = rows.iter().map(mean).collect();
        let moved =
            averages.iter().zip(&field).map(|(average, value)| (*average - *value).length()).fold(0.0, f32::max);
        assert!(moved > 0.5, "averages smooth such a field: {moved}");
        for (found, expected) in from_averages(&rows, averages).iter().zip(&field) {
            assert!(found.abs_diff_eq(*expected, 1e-3), "{found} for {expected}");
        }
        Ok(())
    }
}
