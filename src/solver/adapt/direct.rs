//! Fine elements that follow direct light.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{COARSEST_EDGE, Coarse, FINEST_EDGE, FINEST_SAMPLED_EDGE, Making, edge_length, smooth::SmoothValues};
use crate::{
    scene::{Tessellation, mesh::interpolate, tessellate::Refinement},
    trace::{SurfacePoint, surface::lift},
    transport::{VertexOrigins, direct::ShadowRays, visible_light::Scratch},
};

pub(super) struct DirectElements<'a> {
    making: &'a Making<'a>,
    pub(super) refinement: Refinement,
    pub(super) tessellation: Tessellation,
    /// Direct irradiance [W/m²] at the vertices.
    pub(super) direct: Vec<Vec3>,
    pub(super) buried: Vec<bool>,
    pub(super) shadow_rays: ShadowRays,
    /// Mean direct light [W/m²] of what is lit.
    pub(super) scale: f32,
}

impl<'a> DirectElements<'a> {
    pub(super) fn new(making: &'a Making<'a>) -> Result<Self, String> {
        let refinement = Refinement::new(making.scene, &making.settings.tessellation())?;
        let tessellation = refinement.tessellation(making.scene);
        let (direct, buried, shadow_rays) = Default::default();
        Ok(Self { making, refinement, tessellation, direct, buried, shadow_rays, scale: 1.0 })
    }

    /// Cuts until direct light is near what the corners say, in every element.
    pub(super) fn follow_light(&mut self, tolerance: f32) -> Result<(), String> {
        let mut first_new = 0;
        loop {
            self.find_direct_light();
            let nodes: Vec<u32> = self.refinement.nodes().collect();
            let wanted = self.wanted(|scratch, element| {
                nodes[element as usize] >= first_new && self.direct_light_bends(element, tolerance, scratch)
            });
            first_new = self.refinement.node_count();
            if !self.cut(&wanted)? {
                return Ok(());
            }
        }
    }

    /// Cuts until the elements are no coarser than the coarse ones, nor than the bends of the smooth field on those.
    pub(super) fn follow_smooth_field(
        &mut self,
        coarse: &Coarse,
        field: &[Vec3],
        tolerance: f32,
    ) -> Result<(), String> {
        let smooth = SmoothValues::new(&coarse.smooth, &coarse.tessellation, field);
        let coarse = &coarse.tessellation;
        loop {
            let wanted = self.wanted(|_, element| {
                let fine = &self.tessellation;
                let middle = fine.corner_barycentrics[element as usize].iter().sum::<Vec2>() / 3.0;
                let below = coarse.locate(fine.scene_triangle[element as usize], middle).0;
                if fine.mesh.area(element) > 1.4 * coarse.mesh.area(below) {
                    return true;
                }
                let length = edge_length(fine, self.refinement.longest_edge(element));
                let [a, b, c] = coarse.mesh.triangles[below as usize];
                let edges = [[a, b], [b, c], [c, a]].map(|ends| edge_length(coarse, ends));
                let part = length / edges.into_iter().fold(0.0, f32::max);
                let left = smooth.largest_surplus(below) / self.scale * part * part;
                length > FINEST_EDGE && left * length > tolerance
            });
            if !self.cut(&wanted)? {
                return Ok(());
            }
            self.find_direct_light();
        }
    }

    /// The elements for which `is_wanted` says so.
    fn wanted(&self, is_wanted: impl Fn(&mut Scratch, u32) -> bool + Sync) -> Vec<u32> {
        (0..self.tessellation.mesh.triangles.len() as u32)
            .into_par_iter()
            .with_min_len(64)
            .map_init(Scratch::default, |scratch, element| is_wanted(scratch, element).then_some(element))
            .flatten()
            .collect()
    }

    fn cut(&mut self, wanted: &[u32]) -> Result<bool, String> {
        let is_cut = self.making.cut(&mut self.refinement, wanted)?;
        if is_cut {
            self.tessellation = self.refinement.tessellation(self.making.scene);
        }
        Ok(is_cut)
    }

    /// Direct light at the vertices that have come since the last call, from those origins that are not buried.
    fn find_direct_light(&mut self) {
        let Making { scene, tracer, .. } = *self.making;
        let tessellation = &self.tessellation;
        let (known, count) = (self.direct.len() as u32, tessellation.mesh.positions.len() as u32);
        let origins = VertexOrigins::new(tessellation);
        let context = self.making.direct_context();
        let found: Vec<(Vec3, bool, ShadowRays)> = (known..count)
            .into_par_iter()
            .with_min_len(64)
            .map_init(
                || (Scratch::default(), Vec::new()),
                |(scratch, starts), vertex| {
                    origins.collect(scene, tessellation, vertex, starts);
                    let (mut sum, mut used, mut rays) = (Vec3::ZERO, 0, ShadowRays::default());
                    for origin in starts.iter() {
                        let irradiance = context.irradiance_at(origin, scratch, &mut rays);
                        if irradiance != Vec3::ZERO || !origin.is_buried(tracer) {
                            sum += irradiance;
                            used += 1;
                        }
                    }
                    (sum / (used as f32).max(1.0), used == 0 && !starts.is_empty(), rays)
                },
            )
            .collect();
        for (irradiance, is_buried, rays) in found {
            self.direct.push(irradiance);
            self.buried.push(is_buried);
            self.shadow_rays.traced += rays.traced;
            self.shadow_rays.skipped += rays.skipped;
        }
        self.scale = mean_of_lit(&self.direct, &tessellation.vertex_areas());
    }

    /// True if an element is too coarse for direct light: at its middle, or in the middle of its longest edge.
    fn direct_light_bends(&self, element: u32, tolerance: f32, scratch: &mut Scratch) -> bool {
        let corners = self.tessellation.mesh.triangles[element as usize];
        let ends = self.refinement.longest_edge(element);
        let length = edge_length(&self.tessellation, ends);
        if length > COARSEST_EDGE {
            return true;
        }
        let free = corners.iter().filter(|&&vertex| !self.buried[vertex as usize]);
        let (sum, count) =
            free.fold((Vec3::ZERO, 0.0), |(sum, count), &vertex| (sum + self.direct[vertex as usize], count + 1.0));
        if length < FINEST_EDGE || count == 0.0 || self.making.lights.is_empty() {
            return false;
        }
        let values =
            corners.map(|vertex| if self.buried[vertex as usize] { sum / count } else { self.direct[vertex as usize] });
        let opposite = corners.iter().position(|vertex| !ends.contains(vertex)).unwrap_or(0);
        let middle = Vec3::splat(1.0 / 3.0);
        let edge_middle = (0.5 * (Vec3::ONE - Vec3::AXES[opposite])).lerp(middle, 0.01);
        let context = self.making.direct_context();
        [edge_middle, middle].into_iter().any(|weights| {
            let place = Vec2::new(weights.y, weights.z);
            let point = self.point_in_element(element, place);
            let mut rays = ShadowRays::default();
            let found = context.irradiance_at(&point, scratch, &mut rays);
            let finest = if rays.traced > 0 { FINEST_SAMPLED_EDGE } else { FINEST_EDGE };
            let difference = (found - interpolate(values, place)).abs().max_element() / self.scale;
            difference * length > tolerance
                && length > finest
                && (found != Vec3::ZERO || !point.is_buried(self.making.tracer))
        })
    }

    fn point_in_element(&self, element: u32, place: Vec2) -> SurfacePoint {
        let (mesh, scene) = (&self.tessellation.mesh, self.making.scene);
        let triangle = self.tessellation.scene_triangle[element as usize];
        let geometric_normal = scene.mesh.geometric_normal(triangle);
        let normals = mesh.triangles[element as usize].map(|vertex| mesh.normals[vertex as usize]);
        let position = interpolate(mesh.corners(element), place);
        SurfacePoint {
            origin: lift(position, geometric_normal, scene.mesh.corners(triangle)),
            geometric_normal,
            shading_normal: interpolate(normals, place).normalize_or(geometric_normal),
            triangle,
        }
    }
}

/// The area mean of what is not dark; 1 if all is dark.
fn mean_of_lit(field: &[Vec3], areas: &[f32]) -> f32 {
    let lit = field.iter().zip(areas).filter(|(value, _)| value.max_element() > 0.0);
    let (sum, area) = lit.fold((0.0_f64, 0.0_f64), |(sum, area), (value, share)| {
        (sum + f64::from(value.element_sum() / 3.0 * share), area + f64::from(*share))
    });
    if sum > 0.0 { (sum / area) as f32 } else { 1.0 }
}
