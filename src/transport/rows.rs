//! T: the gather rays of every vertex (eq. 4), traced once (`trace_rows`) and kept as sparse rows.
//!
//! One set of cosine-weighted rays a vertex serves all bounces. What a ray met is kept in 8 bytes, element and place in
//! it; 4 more keep a texture's value there. Reflectance is read at each bounce, so it may change. A bounce is then
//! E_{n+1} = T E_n: a sum over each row, with no ray traced.

use glam::{UVec2, UVec3, Vec2, Vec3, Vec3A};
use rayon::prelude::*;

use super::{
    blocks::{BLOCKS, squared_error},
    star::HatRow,
};
use crate::scene::{Scene, Tessellation};

/// What one gather ray met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RowEntry {
    element: u32,
    barycentric: [u16; 2],
}

impl RowEntry {
    pub(super) fn new(element: u32, place: Vec2) -> Self {
        Self { element, barycentric: quantised(place) }
    }

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
    pub(super) entries: Vec<RowEntry>,
    /// For each entry what the texture multiplies reflectance with; empty in scenes without textures.
    pub(super) tints: Vec<Tint>,
    /// For each vertex: where its entries end, and how many rays its value is the mean of (0 if it is buried).
    pub(super) rows: Vec<(u32, u32)>,
    /// For each vertex and block of samples: where its entries end, counted from the row's start, and its rays.
    pub(super) blocks: Vec<[(u32, u32); BLOCKS]>,
    /// For averages: whether some of a vertex's sample points are buried.
    pub(super) partly_buried: Vec<bool>,
    /// Which materials an entry lies on.
    pub(super) touched: Vec<bool>,
    /// For each vertex its weights at its sample points, and at those of direct light; for least squares.
    pub(super) hats: Vec<[HatRow; 2]>,
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

    /// Takes the vertices' weights at their sample points (`Star::hat_rows`) out, for least squares.
    pub fn take_hat_rows(&mut self) -> Vec<[HatRow; 2]> {
        std::mem::take(&mut self.hats)
    }

    /// Moves every entry from its element and place to another.
    pub fn relocate(&mut self, locate: impl Fn(u32, Vec2) -> (u32, Vec2)) {
        for entry in &mut self.entries {
            let (element, place) = locate(entry.element, entry.place());
            *entry = RowEntry::new(element, place);
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

    pub(super) fn truncate(&mut self, entries: usize) {
        self.entries.truncate(entries);
        self.tints.truncate(entries);
    }

    pub(super) fn shrink_to_fit(&mut self) {
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
pub(super) struct Tint(u32);

impl Tint {
    const STEPS: Vec3 = Vec3::new(2047.0, 2047.0, 1023.0);

    pub(super) fn new(color: Vec3) -> Self {
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
pub(super) fn move_entries((entries, tints): (&mut [RowEntry], &mut [Tint]), from: std::ops::Range<usize>, to: usize) {
    entries.copy_within(from.clone(), to);
    if !tints.is_empty() {
        tints.copy_within(from, to);
    }
}

/// Barycentric coordinates in steps of 1/65535, inside the triangle.
fn quantised(barycentric: Vec2) -> [u16; 2] {
    let steps = (barycentric.clamp(Vec2::ZERO, Vec2::ONE) * 65535.0).round();
    let u = steps.x as u16;
    [u, (steps.y as u16).min(65535 - u)]
}
