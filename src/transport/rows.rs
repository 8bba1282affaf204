//! T: the gather rays of every vertex (eq. 4), traced once and kept as sparse rows.
//!
//! One set of cosine-weighted rays a vertex serves all bounces. What a ray met is kept in 8 bytes, element and place in
//! it; 4 more keep a texture's value there. Reflectance is read at each bounce, so it may change. A bounce is then
//! E_{n+1} = T E_n: a sum over each row, with no ray traced.

use glam::{UVec2, UVec3, Vec2, Vec3, Vec3A};
use rayon::prelude::*;

use super::{
    blocks::{BLOCKS, Run, block_ends_of, blocks_of, squared_error},
    lights::{FinderCounts, Lights, area_to_solid_angle},
    origins::{VertexOrigins, VertexValues, origin_of_sample},
    sampling::{cosine_direction, cosine_pdf_solid_angle, frame},
    star::{HatRow, Star, thin_out},
};
use crate::{
    math::sequence::{Sampler, Sequence, Stream},
    scene::{Scene, Tessellation},
    trace::{Hit, Ray, RayTracer, SurfacePoint},
};

/// What one gather ray met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct RowEntry {
    element: u32,
    barycentric: [u16; 2],
}

impl RowEntry {
    fn place(&self) -> Vec2 {
        UVec2::from(self.barycentric.map(u32::from)).as_vec2() / 65535.0
    }

    /// 65535 times what leaves where the ray met the element, but for its texture.
    #[inline]
    fn between(&self, outgoing: &Outgoing) -> Vec3A {
        let [a, b, c] = &outgoing.corners[self.element as usize];
        let [u, v] = self.barycentric.map(i32::from);
        *a * (65535 - u - v) as f32 + *b * u as f32 + *c * v as f32
    }
}

/// The rows of a run of vertices.
#[derive(Clone, Debug, Default)]
pub struct RowChunk {
    entries: Vec<RowEntry>,
    /// For each entry what the texture multiplies reflectance with; empty in scenes without textures.
    tints: Vec<Tint>,
    /// For each vertex: where its entries end, and how many rays its value is the mean of (0 if it is buried).
    rows: Vec<(u32, u32)>,
    /// For each vertex and block of samples: where its entries end, counted from the row's start, and its rays.
    blocks: Vec<[(u32, u32); BLOCKS]>,
    /// For averages: whether some of a vertex's sample points are buried.
    partly_buried: Vec<bool>,
    /// Which materials an entry lies on.
    touched: Vec<bool>,
    /// For each vertex its weights at its sample points, and at those of direct light; for least squares.
    hats: Vec<[HatRow; 2]>,
    /// Rays that were traced for this chunk.
    pub rays: u64,
    /// Rays that needed no tracing: they start into their own surface.
    pub skipped: u64,
}

impl RowChunk {
    /// Bytes that the chunk occupies.
    pub fn bytes(&self) -> usize {
        let entries = self.entries.capacity() * size_of::<RowEntry>() + self.tints.capacity() * size_of::<Tint>();
        entries + self.rows.capacity() * size_of::<[(u32, u32); BLOCKS + 1]>()
    }

    /// For averages: whether some of each vertex's sample points are buried.
    pub fn partly_buried(&self) -> &[bool] {
        &self.partly_buried
    }

    /// Which of the scene's materials rays met; none that is black.
    pub fn touched_materials(&self) -> &[bool] {
        &self.touched
    }

    /// Takes the vertices' weights at their sample points ([`Star::hat_rows`]) out, for least squares.
    pub fn take_hat_rows(&mut self) -> Vec<[HatRow; 2]> {
        std::mem::take(&mut self.hats)
    }

    /// Moves every entry from its element and place to another.
    pub fn relocate(&mut self, locate: impl Fn(u32, Vec2) -> (u32, Vec2)) {
        for entry in &mut self.entries {
            let (element, place) = locate(entry.element, entry.place());
            *entry = RowEntry { element, barycentric: quantised(place) };
        }
    }

    /// One bounce: irradiance [W/m²] at each vertex of the chunk from what leaves the elements (eq. 4).
    pub fn apply(&self, outgoing: &Outgoing, mut receive: impl FnMut(usize, Vec3)) {
        let mut start = 0;
        for (index, &(end, rays)) in self.rows.iter().enumerate() {
            let sum = outgoing.sum(self, start..end as usize);
            start = end as usize;
            receive(index, if rays == 0 { Vec3::ZERO } else { sum / rays as f32 });
        }
    }

    /// The squared standard error of one bounce's irradiance at each vertex of the chunk, by the scatter of its blocks.
    pub fn squared_errors(&self, outgoing: &Outgoing, mut receive: impl FnMut(usize, Vec3)) {
        let mut start = 0;
        for (index, (&(end, _), blocks)) in self.rows.iter().zip(&self.blocks).enumerate() {
            let mut from = start;
            let means = blocks.map(|(end, rays)| {
                let entries = from..start + end as usize;
                from = entries.end;
                (outgoing.sum(self, entries), rays)
            });
            start = end as usize;
            receive(index, squared_error(means));
        }
    }

    /// Takes the rows of all other vertices out, and keeps the counts.
    pub fn retain_rows(&mut self, is_kept: impl Fn(usize) -> bool) {
        let (mut start, mut write) = (0, 0);
        for (index, (end, _)) in self.rows.iter_mut().enumerate() {
            let row = start..*end as usize;
            start = row.end;
            if is_kept(index) {
                move_entries((&mut self.entries, &mut self.tints), row.clone(), write);
                write += row.len();
            }
            *end = write as u32;
        }
        let (mut index, mut block_index) = (0.., 0..);
        self.rows.retain(|_| index.next().is_some_and(&is_kept));
        self.blocks.retain(|_| block_index.next().is_some_and(&is_kept));
        self.truncate(write);
        self.shrink_to_fit();
    }

    fn truncate(&mut self, entries: usize) {
        self.entries.truncate(entries);
        self.tints.truncate(entries);
    }

    fn shrink_to_fit(&mut self) {
        self.entries.shrink_to_fit();
        self.tints.shrink_to_fit();
    }

    /// Gives the rows' memory back and keeps the counts.
    pub fn forget_rows(&mut self) {
        (self.entries, self.tints, self.rows, self.blocks) = Default::default();
    }
}

/// The most bytes that one ray takes in a row of this scene.
pub fn bytes_per_ray(scene: &Scene) -> usize {
    size_of::<RowEntry>() + if scene.has_reflectance_textures() { size_of::<Tint>() } else { 0 }
}

/// A field as rows read it: the values of each element's corners side by side, since an entry's element is anywhere in
/// memory, and one look there costs less than four. Made once a bounce.
pub struct Outgoing {
    /// Radiosity [W/m²], textures left out.
    corners: Vec<[Vec3A; 3]>,
}

/// A colour in 11, 11 and 10 bits, by its square root: so each is right to 0.001.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Tint(u32);

impl Tint {
    const STEPS: Vec3 = Vec3::new(2047.0, 2047.0, 1023.0);

    fn new(color: Vec3) -> Self {
        let [r, g, b] = (color.clamp(Vec3::ZERO, Vec3::ONE).map(f32::sqrt) * Self::STEPS).round().to_array();
        Self(r as u32 | (g as u32) << 11 | (b as u32) << 22)
    }

    #[inline]
    fn color(self) -> Vec3A {
        let root =
            UVec3::new(self.0 & 2047, self.0 >> 11 & 2047, self.0 >> 22).as_vec3a() * (1.0 / Vec3A::from(Self::STEPS));
        root * root
    }
}

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
                self.origins.collect(self.scene, self.tessellation, vertex, &mut origins);
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
                chunk.entries.push(RowEntry { element, barycentric: quantised(barycentric) });
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

impl Outgoing {
    /// The light that leaves every element when this irradiance [W/m²] arrives at their vertices.
    pub fn new(scene: &Scene, elements: &Tessellation, irradiance: &[Vec3]) -> Self {
        let Tessellation { mesh, scene_triangle, .. } = elements;
        let at = |(element, corners): (usize, &[u32; 3])| {
            let reflectance = scene.material(scene_triangle[element]).reflectance;
            corners.map(|vertex| Vec3A::from(reflectance * irradiance[vertex as usize]))
        };
        Self { corners: mesh.triangles.par_iter().enumerate().with_min_len(1024).map(at).collect() }
    }

    /// The sum of B = ρ E at what some rays of a chunk met (eq. 4), E by barycentric interpolation.
    #[inline]
    fn sum(&self, chunk: &RowChunk, rays: std::ops::Range<usize>) -> Vec3 {
        let entries = &chunk.entries[rays.clone()];
        // Two sums, so that one addition need not wait for the one before.
        let mut sums = [Vec3A::ZERO; 2];
        if chunk.tints.is_empty() {
            for pair in entries.chunks(2) {
                sums.iter_mut().zip(pair).for_each(|(sum, entry)| *sum += entry.between(self));
            }
        } else {
            for (pair, tints) in entries.chunks(2).zip(chunk.tints[rays].chunks(2)) {
                let both = pair.iter().zip(tints);
                sums.iter_mut().zip(both).for_each(|(sum, (entry, tint))| *sum += tint.color() * entry.between(self));
            }
        }
        ((sums[0] + sums[1]) / 65535.0).into()
    }
}

/// Moves entries to an earlier place, with their tints if there are any.
fn move_entries((entries, tints): (&mut [RowEntry], &mut [Tint]), from: std::ops::Range<usize>, to: usize) {
    entries.copy_within(from.clone(), to);
    if !tints.is_empty() {
        tints.copy_within(from, to);
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

/// Barycentric coordinates in steps of 1/65535, inside the triangle.
fn quantised(barycentric: Vec2) -> [u16; 2] {
    let steps = (barycentric.clamp(Vec2::ZERO, Vec2::ONE) * 65535.0).round();
    let u = steps.x as u16;
    [u, (steps.y as u16).min(65535 - u)]
}
