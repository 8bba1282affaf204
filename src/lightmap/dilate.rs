//! From the texels' values to pages without holes.

use glam::Vec3;

use super::{charts::Charts, texels::Texel};

/// Rings of texels around each chart that get values: what bilinear reads can reach, and one to spare.
const GUTTER: u32 = 2;
/// Buried texels deeper inside than this stay dark.
const MOST_RINGS: u32 = 64;

/// A pixel that takes the mean of some of its neighbours.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Fill {
    /// Its number ([`Charts::pixel`]).
    pub pixel: u32,
    /// A bit for each of [`AROUND`] that counts; 0 for an entry without meaning.
    pub neighbours: u32,
}

/// The pixels around one: columns to the right, rows down, weight.
pub const AROUND: [(i64, i64, f32); 8] =
    [(-1, 0, 1.0), (1, 0, 1.0), (0, -1, 1.0), (0, 1, 1.0), (-1, -1, 0.5), (1, -1, 0.5), (-1, 1, 0.5), (1, 1, 0.5)];

/// How pages are filled, ring by ring, whatever the values are: buried texels from the open ones, then the gutter around
/// each chart.
pub fn fill_rings(charts: &Charts, texels: &[Texel]) -> Vec<Vec<Fill>> {
    let mut is_known = vec![false; charts.pixel_count()];
    let mut buried = Vec::new();
    for texel in texels {
        let pixel = texel.pixel as usize;
        if texel.open > 0.0 { is_known[pixel] = true } else { buried.push(pixel) }
    }
    let mut rings = Vec::new();
    for _ in 0..MOST_RINGS {
        let (ring, others) = next_ring(charts, &mut is_known, buried);
        buried = others;
        if ring.is_empty() {
            break;
        }
        rings.push(ring);
    }
    buried.iter().for_each(|&pixel| is_known[pixel] = true);
    for _ in 0..GUTTER {
        let empty = (0..is_known.len()).filter(|&pixel| !is_known[pixel]).collect();
        rings.push(next_ring(charts, &mut is_known, empty).0);
    }
    rings
}

/// A field of the texel table on the pages, as one array ([`Charts::pixel`]): buried texels and the gutter take the mean of
/// their neighbours, ring by ring ([`fill_rings`]). The rest stays 0.
pub fn pages_of(charts: &Charts, texels: &[Texel], values: &[Vec3]) -> Vec<Vec3> {
    let mut pages = vec![Vec3::ZERO; charts.pixel_count()];
    for (texel, value) in texels.iter().zip(values).filter(|(texel, _)| texel.open > 0.0) {
        pages[texel.pixel as usize] = *value;
    }
    for ring in fill_rings(charts, texels) {
        for fill in ring {
            let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
            for (index, neighbour, weight) in neighbours(charts, fill.pixel as usize) {
                if fill.neighbours >> index & 1 == 1 {
                    sum += weight * pages[neighbour];
                    weights += weight;
                }
            }
            pages[fill.pixel as usize] = sum / weights;
        }
    }
    pages
}

/// Those of the pixels that have known neighbours, which are known from now on; and the others.
fn next_ring(charts: &Charts, is_known: &mut [bool], pixels: Vec<usize>) -> (Vec<Fill>, Vec<usize>) {
    let (mut ring, mut others) = (Vec::new(), Vec::new());
    for pixel in pixels {
        let known = neighbours(charts, pixel).filter(|(_, neighbour, _)| is_known[*neighbour]);
        let bits = known.fold(0, |bits, (index, ..)| bits | 1 << index);
        if bits == 0 { others.push(pixel) } else { ring.push(Fill { pixel: pixel as u32, neighbours: bits }) }
    }
    ring.iter().for_each(|fill| is_known[fill.pixel as usize] = true);
    (ring, others)
}

/// The pixels around one on its page: place in [`AROUND`], number, weight.
fn neighbours(charts: &Charts, pixel: usize) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
    let [page, column, row] = charts.place(pixel);
    let [width, height] = charts.page_size.map(i64::from);
    AROUND.into_iter().enumerate().filter_map(move |(index, (x, y, weight))| {
        let (x, y) = (i64::from(column) + x, i64::from(row) + y);
        let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
        is_inside.then(|| (index, charts.pixel(page, x as u32, y as u32), weight))
    })
}
