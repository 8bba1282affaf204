//! What lies at a clicked point of the surface.

use std::{f32::consts::TAU, sync::Arc};

use egui::Ui;
use glam::{Vec2, Vec3};

use super::{
    elements::Elements,
    results::{Field, Results},
};
use crate::{
    math::{
        color::luminance,
        sequence::{Sampler, Sequence, Stream},
    },
    scene::{Camera, mesh::interpolate},
    trace::{NO_TRIANGLE, Ray, RayTracer as _, SurfacePoint},
};

/// Back faces that a click goes through.
const MAX_PASSED_FACES: u32 = 64;
/// Rays that tell where a point's light comes from.
const SHARE_RAYS: u32 = 1024;

/// A point of the surface, by its scene triangle: elements may change under it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// The scene's triangle.
    pub triangle: u32,
    /// Where in it.
    pub barycentric: Vec2,
}

/// Where the light at a point comes from, for as long as point and solution stay.
#[derive(Default)]
pub(super) struct KnownShares {
    of: Option<(Picked, Field)>,
    shares: Vec<(String, f32)>,
}

impl KnownShares {
    /// [`Picked::shares`] of a complete solution; nothing before.
    pub(super) fn find(&mut self, picked: Option<Picked>, results: Option<&Results>) -> Vec<(String, f32)> {
        let solved = results.filter(|results| results.solution.is_some());
        let (Some(picked), Some(results)) = (picked, solved) else { return Vec::new() };
        let is_same = |(point, total): &(Picked, Field)| *point == picked && Arc::ptr_eq(total, &results.total);
        if !self.of.as_ref().is_some_and(is_same) {
            self.shares = picked.shares(&results.elements, results);
            self.of = Some((picked, Arc::clone(&results.total)));
        }
        self.shares.clone()
    }
}

impl Picked {
    /// The first front face seen through a point of the picture: (0,0) is its top left corner, (1,1) the bottom right.
    pub fn new(elements: &Elements, camera: &Camera, picture_point: Vec2, aspect: f32) -> Option<Self> {
        let direction = camera.direction(picture_point, aspect).try_normalize()?;
        let mut ray =
            Ray { origin: camera.position, direction, max_distance: f32::INFINITY, origin_triangle: NO_TRIANGLE };
        for _ in 0..MAX_PASSED_FACES {
            let hit = elements.tracer.closest_hit(&ray)?;
            if hit.front {
                return Some(Self { triangle: hit.triangle, barycentric: hit.barycentric });
            }
            ray.origin += hit.distance * direction;
            ray.origin_triangle = hit.triangle;
        }
        None
    }

    /// The point in local units.
    pub fn position(&self, elements: &Elements) -> Vec3 {
        elements.scene.mesh.position(self.triangle, self.barycentric)
    }

    /// The vertex of the elements that is nearest within the point's own element.
    pub fn nearest_vertex(&self, elements: &Elements) -> u32 {
        let (element, local) = elements.tessellation.locate(self.triangle, self.barycentric);
        let corners = elements.tessellation.mesh.triangles[element as usize];
        let weights = [1.0 - local.x - local.y, local.x, local.y];
        let nearest = (0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
        corners[nearest]
    }

    /// Where the light at the point comes from: parts of its irradiance (luminance), the largest first. Direct light is
    /// one part; the rest is gathered by rays and told by the material that reflects it.
    pub fn shares(&self, elements: &Elements, results: &Results) -> Vec<(String, f32)> {
        let scene = &elements.scene;
        let at = |field: &[Vec3], triangle, place| elements.tessellation.interpolate(field, triangle, place);
        let from = SurfacePoint::new(scene, self.triangle, self.barycentric).on_curve(
            scene,
            self.barycentric,
            &*elements.tracer,
        );
        let sequence = Sequence::new(Sampler::Sobol, 1, self.triangle, Stream::Hemisphere, SHARE_RAYS);
        let mut reflected = vec![0.0; scene.materials.len()];
        for index in 0..SHARE_RAYS {
            // Uniform over the sphere and mirrored to the upper half, so that the cosine becomes a weight.
            let sample = sequence.sample_2d(index);
            let height = 1.0 - 2.0 * sample.y;
            let across = (1.0 - height * height).max(0.0).sqrt() * Vec2::from_angle(TAU * sample.x);
            let on_sphere = across.extend(height);
            let cosine = on_sphere.dot(from.shading_normal);
            let (direction, weight) = (on_sphere * cosine.signum(), 2.0 * cosine.abs() / SHARE_RAYS as f32);
            let hit = from.ray(direction).and_then(|ray| elements.tracer.closest_hit(&ray)).filter(|hit| hit.front);
            if let Some(hit) = hit {
                let irradiance = at(&results.total, hit.triangle, hit.barycentric);
                let radiosity = scene.reflectance(hit.triangle, hit.barycentric) * irradiance;
                reflected[scene.mesh.material_indices[hit.triangle as usize] as usize] += weight * luminance(radiosity);
            }
        }
        let direct =
            results.bounces.first().map_or(0.0, |direct| luminance(at(direct, self.triangle, self.barycentric)));
        let named = reflected.into_iter().zip(&scene.materials).map(|(part, material)| (material.name.clone(), part));
        let mut shares: Vec<(String, f32)> = named.chain([(String::from("lights, directly"), direct)]).collect();
        let sum: f32 = shares.iter().map(|(_, part)| part).sum();
        shares.retain(|(_, part)| *part > 0.0);
        shares.iter_mut().for_each(|(_, part)| *part /= sum);
        shares.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        shares
    }

    /// Draws what is known of the point. False once it is to be forgotten.
    pub fn ui(&self, ui: &mut Ui, elements: &Elements, results: Option<&Results>, shares: &[(String, f32)]) -> bool {
        let scene = &elements.scene;
        let place = scene.frame.point_to_metres(self.position(elements));
        let reflectance = scene.reflectance(self.triangle, self.barycentric);
        let (element, local) = elements.tessellation.locate(self.triangle, self.barycentric);
        let vertices = elements.tessellation.mesh.triangles[element as usize];
        let stays = ui.horizontal(|ui| {
            ui.strong(&scene.material(self.triangle).name);
            !ui.small_button("x").on_hover_text("Forget the point").clicked()
        });
        ui.label(format!("at {:.3}, {:.3}, {:.3} m", place.x, place.y, place.z));
        ui.label(format!("reflectance {}", triple(reflectance)));
        let Some(results) = results else { return stays.inner };
        let at = |field: &[Vec3]| interpolate(vertices.map(|vertex| field[vertex as usize]), local);
        let total = at(&results.total);
        ui.label(format!("irradiance {} W/m²", triple(total)));
        let sum = total.element_sum().max(1e-30);
        egui::Grid::new("point's bounces").num_columns(3).striped(true).show(ui, |ui| {
            for (bounce, field) in results.bounces.iter().enumerate() {
                let value = at(field);
                ui.label(if bounce == 0 { String::from("direct") } else { format!("bounce {bounce}") });
                ui.label(triple(value));
                ui.label(format!("{:.1} %", 100.0 * value.element_sum() / sum));
                ui.end_row();
            }
        });
        if !shares.is_empty() {
            ui.label("Its light comes from").on_hover_text("Parts of the luminance, by the material that reflects it");
            egui::Grid::new("point's shares").num_columns(2).striped(true).show(ui, |ui| {
                for (name, part) in shares.iter().take(8) {
                    ui.label(name);
                    ui.label(format!("{:.1} %", 100.0 * part));
                    ui.end_row();
                }
            });
        }
        egui::CollapsingHeader::new("Its vertices").show(ui, |ui| {
            for vertex in vertices {
                let buried = results.solution.as_ref().is_some_and(|solution| solution.buried[vertex as usize]);
                let remark = if buried { ", buried" } else { "" };
                ui.label(format!("{vertex}: {}{remark}", triple(results.total[vertex as usize])));
            }
        });
        stays.inner
    }
}

fn triple(value: Vec3) -> String {
    format!("{:.3} {:.3} {:.3}", value.x, value.y, value.z)
}
