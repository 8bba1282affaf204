//! The elements of a tessellation as patches of constant radiosity, for form factors.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::form_factors::FormFactors;
use crate::{
    scene::{Scene, Tessellation, mesh::interpolate, reflectance::triangle_mean_reflectance},
    trace::surface::lift,
};

/// Patches, in the order of the elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// Middle, lifted off the surface by its rounding error, and unit normal [local units].
    pub places: Vec<(Vec3, Vec3)>,
    /// Area without the holes that textures cut [local units²].
    pub areas: Vec<f32>,
    /// Emission M [W/m²].
    pub emission: Vec<Vec3>,
    /// Mean reflectance.
    pub reflectance: Vec<Vec3>,
}

impl Patches {
    /// Of all elements of a scene.
    pub fn new(scene: &Scene, tessellation: &Tessellation) -> Self {
        let mesh = &tessellation.mesh;
        let elements = 0..mesh.triangles.len() as u32;
        let place = |element: u32| {
            let corners = mesh.corners(element);
            let normal = scene.mesh.geometric_normal(tessellation.scene_triangle[element as usize]);
            (lift(corners.iter().sum::<Vec3>() / 3.0, normal, corners), normal)
        };
        let of_triangle = |triangle: u32| {
            let emission = std::f32::consts::PI * scene.material(triangle).emitted_radiance;
            (emission, triangle_mean_reflectance(scene, triangle))
        };
        let known: Vec<(Vec3, Vec3)> = (0..scene.mesh.triangles.len() as u32).map(of_triangle).collect();
        let (emission, reflectance) =
            tessellation.scene_triangle.iter().map(|triangle| known[*triangle as usize]).unzip();
        let area = |element: u32| mesh.area(element) * opaque_share(scene, tessellation, element);
        Self {
            places: elements.clone().map(place).collect(),
            areas: elements.map(area).collect(),
            emission,
            reflectance,
        }
    }

    /// Irradiance of the lights alone (the placed one's is `placed`), and all other, at the vertices of the elements, from
    /// the radiosity of the patches: a vertex takes the mean of the patches around it, by area [W/m²].
    pub fn irradiance_at_vertices(
        &self,
        tessellation: &Tessellation,
        factors: &FormFactors,
        placed: &[Vec3],
        radiosity: &[Vec3],
    ) -> [Vec<Vec3>; 2] {
        let patches = 0..self.areas.len();
        let emitted: Vec<Vec3> =
            patches.clone().into_par_iter().map(|patch| factors.gathered(patch, &self.emission)).collect();
        let direct: Vec<Vec3> = placed.iter().zip(&emitted).map(|(placed, emitted)| *placed + *emitted).collect();
        let indirect: Vec<Vec3> = patches
            .into_par_iter()
            .map(|patch| (factors.gathered(patch, radiosity) - emitted[patch]).max(Vec3::ZERO))
            .collect();
        [direct, indirect].map(|field| self.at_vertices(tessellation, &field))
    }

    fn at_vertices(&self, tessellation: &Tessellation, field: &[Vec3]) -> Vec<Vec3> {
        let mesh = &tessellation.mesh;
        let mut sums = vec![(Vec3::ZERO, 0.0); mesh.positions.len()];
        for ((corners, value), area) in mesh.triangles.iter().zip(field).zip(&self.areas) {
            for vertex in corners {
                let (sum, whole) = &mut sums[*vertex as usize];
                *sum += *area * *value;
                *whole += area;
            }
        }
        sums.into_iter().map(|(sum, whole)| if whole > 0.0 { sum / whole } else { Vec3::ZERO }).collect()
    }
}

/// The part of an element that is no hole, by the points of a grid.
fn opaque_share(scene: &Scene, tessellation: &Tessellation, element: u32) -> f32 {
    const SIDE: u32 = 16;
    let triangle = tessellation.scene_triangle[element as usize];
    if !scene.may_be_cut_out(triangle) {
        return 1.0;
    }
    let corners = tessellation.corner_barycentrics[element as usize];
    let thirds = |index: u32| (index as f32 + 1.0 / 3.0) / SIDE as f32;
    let points = (0..SIDE).flat_map(|row| (0..SIDE - row).map(move |column| (thirds(column), thirds(row))));
    let (mut opaque, mut all) = (0, 0);
    for (u, v) in points {
        opaque += u32::from(!scene.is_cut_out(triangle, interpolate(corners, Vec2::new(u, v))));
        all += 1;
    }
    opaque as f32 / all as f32
}
