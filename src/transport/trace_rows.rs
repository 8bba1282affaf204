//! The gather rays of every vertex are traced, and rows kept of what they met (`rows`).

use glam::Vec3;

use super::{
    blocks::{BLOCKS, Run, block_ends_of, blocks_of},
    lights::{FinderCounts, Lights, area_to_solid_angle},
    origins::{VertexOrigins, VertexValues, origin_of_sample},
    rows::{RowChunk, RowEntry, Tint, move_entries},
    sampling::{cosine_direction, cosine_pdf_solid_angle, frame},
    star::{Star, thin_out},
};
use crate::{
    math::sequence::{Sampler, Sequence, Stream},
    scene::{Scene, Tessellation},
    trace::{Hit, Ray, RayTracer, SurfacePoint},
};

/// What a row is traced and applied with.
pub struct Transport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Traces the gather rays.
    pub tracer: &'a dyn RayTracer,
    /// The elements whose vertices rays leave from.
    pub tessellation: &'a Tessellation,
    /// The elements whose field rays meet; mostly the same.
    pub targets: &'a Tessellation,
    /// Where rays start.
    pub origins: &'a VertexOrigins,
    /// What a vertex's value is the mean of.
    pub values: VertexValues,
    /// What shines: gather rays find a share of the emissive triangles' light.
    pub lights: &'a Lights,
    /// How that light is split.
    pub finders: FinderCounts,
    /// How directions are placed.
    pub sampler: Sampler,
    /// The solve's seed.
    pub seed: u64,
    /// Rays a vertex.
    pub rays: u32,
    /// Rays of each vertex, where they are not all the same.
    pub rays_of: Option<&'a [u32]>,
}

/// Rays between two looks at the cancel flag.
const RAYS_PER_LOOK: u32 = 4096;

impl Transport<'_> {
    /// Traces the rows of `vertices` and appends them to `chunk`. `receive` gets, for each vertex, the origins that are
    /// not buried and, from each, the gather rays' share of direct irradiance from emissive triangles. Returns false
    /// if `is_cancelled` said so; the chunk then ends with the last whole row.
    pub fn trace(
        &self,
        vertices: impl Iterator<Item = u32>,
        chunk: &mut RowChunk,
        is_cancelled: &dyn Fn() -> bool,
        mut receive: impl FnMut(u32, &[SurfacePoint], &[Vec3]),
    ) -> bool {
        let (mut origins, mut runs, mut found) = (Vec::new(), Vec::new(), Vec::new());
        chunk.touched.resize(self.scene.materials.len(), false);
        let mut star = Star::default();
        for vertex in vertices {
            if self.averages() {
                star.collect(self, vertex, &mut origins);
            } else {
                self.origins.collect((self.scene, self.tracer), self.tessellation, vertex, &mut origins);
            }
            let start = chunk.entries.len();
            runs.clear();
            runs.resize(origins.len(), Run::default());
            let mut block_ends = [0; BLOCKS];
            if !self.trace_row(vertex, &origins, chunk, &mut runs, &mut block_ends, is_cancelled) {
                chunk.truncate(start);
                return false;
            }
            chunk.blocks.push(blocks_of(self.rays_of(vertex), block_ends, &runs));
            if self.averages() {
                chunk.partly_buried.push(runs.iter().any(Run::is_buried));
            }
            if self.values == VertexValues::LeastSquares {
                chunk.hats.push(star.hat_rows(self.tessellation, |place| !runs[place].is_buried()));
            }
            drop_buried(chunk, start, &mut origins, &mut runs);
            let rays: u32 = runs.iter().map(|run| run.rays).sum();
            chunk.rows.push((chunk.entries.len() as u32, rays));
            found.clear();
            found.extend(runs.iter().map(|run| run.emission / rays.max(1) as f32));
            if self.averages() {
                thin_out(&mut origins, &mut found);
            }
            receive(vertex, &origins, &found);
        }
        chunk.shrink_to_fit();
        true
    }

    fn averages(&self) -> bool {
        self.values != VertexValues::Point
    }

    fn trace_row(
        &self,
        vertex: u32,
        origins: &[SurfacePoint],
        chunk: &mut RowChunk,
        runs: &mut [Run],
        block_ends: &mut [u32; BLOCKS],
        is_cancelled: &dyn Fn() -> bool,
    ) -> bool {
        let start = chunk.entries.len();
        let Some(first) = origins.first() else {
            return true;
        };
        let rays = self.rays_of(vertex);
        let sequence = Sequence::new(self.sampler, self.seed, vertex, Stream::Hemisphere, rays);
        let basis = frame(first.shading_normal);
        let (sample_ends, mut block) = (block_ends_of(rays), 0);
        let has_textures = self.scene.has_reflectance_textures();
        for index in 0..rays {
            if index % RAYS_PER_LOOK == 0 && is_cancelled() {
                return false;
            }
            while index == sample_ends[block] {
                block_ends[block] = (chunk.entries.len() - start) as u32;
                block += 1;
            }
            let place = origin_of_sample(index, rays, origins.len());
            let basis = if self.averages() { frame(origins[place].shading_normal) } else { basis };
            let direction = basis * cosine_direction(sequence.sample_2d(index));
            let run = &mut runs[place];
            run.rays += 1;
            let Some(ray) = origins[place].ray(direction) else {
                chunk.skipped += 1;
                continue;
            };
            chunk.rays += 1;
            run.traced += 1;
            let Some(hit) = self.tracer.closest_hit(&ray) else { continue };
            if !hit.front {
                // A single ray does not tell whether its point is buried.
                run.back_hits += u32::from(!self.averages() || origins[place].is_buried(self.tracer));
                continue;
            }
            run.emission += self.emission(&origins[place], &ray, &hit);
            if self.reflects(hit.triangle) {
                let (element, barycentric) = self.targets.locate(hit.triangle, hit.barycentric);
                chunk.entries.push(RowEntry::new(element, barycentric));
                if has_textures {
                    chunk.tints.push(Tint::new(self.scene.texture_color(hit.triangle, hit.barycentric)));
                }
                run.entries += 1;
                chunk.touched[self.scene.mesh.material_indices[hit.triangle as usize] as usize] = true;
            }
        }
        block_ends[block..].fill((chunk.entries.len() - start) as u32);
        true
    }

    /// Rays of a vertex.
    pub fn rays_of(&self, vertex: u32) -> u32 {
        self.rays_of.map_or(self.rays, |rays| rays[vertex as usize])
    }

    /// The gather rays' share of π L at an emissive hit: with cosine-weighted rays, L cosθ / pdf = π L.
    fn emission(&self, from: &SurfacePoint, ray: &Ray, hit: &Hit) -> Vec3 {
        let radiance = self.scene.material(hit.triangle).emitted_radiance;
        if radiance.max_element() <= 0.0 {
            return Vec3::ZERO;
        }
        let cosine_light = ray.direction.dot(self.scene.mesh.geometric_normal(hit.triangle)).abs();
        let light_pdf = area_to_solid_angle(self.lights.emitters.pdf_area(radiance), hit.distance, cosine_light);
        let gather_pdf = cosine_pdf_solid_angle(ray.direction.dot(from.shading_normal));
        std::f32::consts::PI * self.finders.gather_share(gather_pdf, light_pdf) * radiance
    }

    /// False for a black material: what hits it is absorbed, and needs no entry.
    fn reflects(&self, triangle: u32) -> bool {
        self.scene.material(triangle).reflectance.max_element() > 0.0
    }
}

/// Takes buried origins, their runs, and their entries from `start` on, out of a row.
fn drop_buried(chunk: &mut RowChunk, start: usize, origins: &mut Vec<SurfacePoint>, runs: &mut Vec<Run>) {
    if !runs.iter().any(Run::is_buried) {
        return;
    }
    let (mut read, mut write) = (start, start);
    for run in runs.iter() {
        let next = read + run.entries as usize;
        if !run.is_buried() {
            move_entries((&mut chunk.entries, &mut chunk.tints), read..next, write);
            write += run.entries as usize;
        }
        read = next;
    }
    chunk.truncate(write);
    let mut buried = runs.iter().map(Run::is_buried);
    origins.retain(|_| buried.next() != Some(true));
    runs.retain(|run| !run.is_buried());
}
