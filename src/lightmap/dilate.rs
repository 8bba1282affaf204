//! From the texels' values to pages without holes.

use glam::Vec3;

use super::{charts::Charts, texels::Texel};

/// Rings of texels around each chart that get values: what bilinear reads can reach, and one to spare.
const GUTTER: u32 = 2;
/// Buried texels deeper inside than this stay dark.
const MOST_RINGS: u32 = 64;

/// A field of the texel table on the pages, as one array ([`Charts::pixel`]): buried texels take the mean of their
/// neighbours, ring by ring from the open ones, and so does the gutter around each chart. The rest stays 0.
pub fn pages_of(charts: &Charts, texels: &[Texel], values: &[Vec3]) -> Vec<Vec3> {
    let mut pages = vec![Vec3::ZERO; charts.pixel_count()];
    let mut is_known = vec![false; pages.len()];
    let mut buried = Vec::new();
    for (texel, value) in texels.iter().zip(values) {
        let pixel = texel.pixel as usize;
        if texel.open > 0.0 {
            (pages[pixel], is_known[pixel]) = (*value, true);
        } else {
            buried.push(pixel);
        }
    }
    for _ in 0..MOST_RINGS {
        let waiting = buried.len();
        buried = fill(charts, &mut pages, &mut is_known, buried);
        if buried.is_empty() || buried.len() == waiting {
            break;
        }
    }
    buried.iter().for_each(|&pixel| is_known[pixel] = true);
    for _ in 0..GUTTER {
        let empty = (0..pages.len()).filter(|&pixel| !is_known[pixel]).collect();
        fill(charts, &mut pages, &mut is_known, empty);
    }
    pages
}

/// Gives the pixels that have known neighbours their mean; returns the others.
fn fill(charts: &Charts, pages: &mut [Vec3], is_known: &mut [bool], pixels: Vec<usize>) -> Vec<usize> {
    let mut found = Vec::new();
    let mut others = Vec::new();
    for pixel in pixels {
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for (neighbour, weight) in neighbours(charts, pixel) {
            if is_known[neighbour] {
                sum += weight * pages[neighbour];
                weights += weight;
            }
        }
        if weights > 0.0 { found.push((pixel, sum / weights)) } else { others.push(pixel) }
    }
    for (pixel, value) in found {
        (pages[pixel], is_known[pixel]) = (value, true);
    }
    others
}

/// The texels around one on its page: four at its sides, and the four at its corners for half.
fn neighbours(charts: &Charts, pixel: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
    const AROUND: [(i64, i64, f32); 8] =
        [(-1, 0, 1.0), (1, 0, 1.0), (0, -1, 1.0), (0, 1, 1.0), (-1, -1, 0.5), (1, -1, 0.5), (-1, 1, 0.5), (1, 1, 0.5)];
    let [page, column, row] = charts.place(pixel);
    let [width, height] = charts.page_size.map(i64::from);
    AROUND.into_iter().filter_map(move |(x, y, weight)| {
        let (x, y) = (i64::from(column) + x, i64::from(row) + y);
        let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
        is_inside.then(|| (charts.pixel(page, x as u32, y as u32), weight))
    })
}
