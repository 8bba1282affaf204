//! Textures as functions of the place, written as PNG.

use std::io::Cursor;

use glam::{DVec2, DVec3};
use image::{ImageFormat, Rgb, RgbImage};

use super::File;
use super::shapes::mix;

/// A picture of `width` by `height` texels; `colour` gives sRGB in [0, 1] at a place in texture coordinates (v up).
pub(super) fn png(path: &str, [width, height]: [u32; 2], colour: impl Fn(DVec2) -> DVec3) -> anyhow::Result<File> {
    let texel = |x: u32, y: u32| {
        let place = DVec2::new(f64::from(x) + 0.5, f64::from(height - y) - 0.5);
        let bytes = (colour(place / DVec2::new(f64::from(width), f64::from(height))) * 255.0).round();
        Rgb(bytes.to_array().map(|value| value.clamp(0.0, 255.0) as u8))
    };
    let mut bytes = Cursor::new(Vec::new());
    RgbImage::from_fn(width, height, texel).write_to(&mut bytes, ImageFormat::Png)?;
    Ok(File { path: String::from(path), bytes: bytes.into_inner() })
}

/// A colour from its hexadecimal name.
pub(super) fn hex(rgb: u32) -> DVec3 {
    let band = |shift: u32| f64::from(rgb >> shift & 255) / 255.0;
    DVec3::new(band(16), band(8), band(0))
}

/// A number in [0, 1) that depends on a lattice point alone.
pub(super) fn hash(x: i64, y: i64) -> f64 {
    let mut bits = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    bits = (bits ^ bits >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 32).wrapping_mul(0x94d0_49bb_1331_11eb);
    (bits >> 40) as f64 / (1_u64 << 24) as f64
}

/// Smooth noise in [0, 1] with `cells` lattice cells over the picture, which it repeats without a seam.
fn noise(place: DVec2, cells: i64) -> f64 {
    let scaled = place * cells as f64;
    let corner = scaled.floor();
    let share = scaled - corner;
    let share = share * share * (3.0 - 2.0 * share);
    let (x, y) = (corner.x as i64, corner.y as i64);
    let at = |x: i64, y: i64| hash(x.rem_euclid(cells), y.rem_euclid(cells) + 1000 * cells);
    mix(mix(at(x, y), at(x + 1, y), share.x), mix(at(x, y + 1), at(x + 1, y + 1), share.x), share.y)
}

/// Noise at four scales, about 1/2.
fn rough(place: DVec2) -> f64 {
    [(4, 0.4), (9, 0.3), (19, 0.2), (41, 0.1)].iter().map(|(cells, weight)| weight * noise(place, *cells)).sum()
}

/// Marble slabs, light and dark in turn, with a small red square at every meeting of corners. Repeats after 2 × 2.
pub(super) fn court_tiles(place: DVec2) -> DVec3 {
    let tile = place * 2.0;
    let inside = tile - tile.floor();
    let to_corner = (inside - 0.5).abs();
    let light = (tile.x as i64 + tile.y as i64) % 2 == 0;
    let (colour, vein_strength) = if to_corner.x + to_corner.y > 0.84 {
        (hex(0x9a4a3a), 0.08)
    } else if light {
        (hex(0xe2d8c4), 0.16)
    } else {
        (hex(0x8f9a94), 0.2)
    };
    let joint = to_corner.max_element() > 0.492 || (to_corner.x + to_corner.y - 0.84).abs() < 0.01;
    let bend = rough(place + DVec2::new(0.37, 0.11));
    let vein = 1.0 - (((tile.x + 1.7 * tile.y) * 2.0 + 5.0 * bend).sin().abs()).powf(0.35);
    if joint { hex(0x5c554c) } else { colour * (1.0 - vein_strength * vein - 0.12 * (bend - 0.5)) }
}

/// Terracotta bricks laid in a herringbone of 4 × 4 squares.
pub(super) fn gallery_tiles(place: DVec2) -> DVec3 {
    let square = (place * 8.0).floor();
    let inside = place * 8.0 - square;
    let (x, y) = (square.x as i64, square.y as i64);
    // Along the diagonal the bricks alternate: a lying one (two squares wide), then a standing one.
    let phase = (x - y).rem_euclid(4);
    let (brick, along) = match phase {
        0 => ((x, y), DVec2::new(inside.x / 2.0, inside.y)),
        1 => ((x - 1, y), DVec2::new((inside.x + 1.0) / 2.0, inside.y)),
        2 => ((x, y - 1), DVec2::new((inside.y + 1.0) / 2.0, inside.x)),
        _ => ((x, y), DVec2::new(inside.y / 2.0, inside.x)),
    };
    let edge = DVec2::new((along.x - 0.5).abs() * 2.0, (along.y - 0.5).abs());
    if edge.x > 0.96 || edge.y > 0.46 {
        return hex(0x8a7866);
    }
    let (a, b) = (brick.0.rem_euclid(8), brick.1.rem_euclid(8));
    hex(0xb0684a) * mix(0.82, 1.08, hash(a, b)) * mix(0.93, 1.05, rough(place))
}

/// Ashlar: courses of blocks of sandstone, each course shifted by half a block. Four courses a picture.
pub(super) fn masonry(place: DVec2) -> DVec3 {
    let course = (place.y * 4.0).floor();
    let along = place.x * 2.0 + if course as i64 % 2 == 0 { 0.0 } else { 0.5 };
    let (block, height) = (along.floor(), place.y * 4.0 - course);
    let joint = (along - block - 0.5).abs() > 0.49 || (height - 0.5).abs() > 0.48;
    let tint = hash((block as i64).rem_euclid(2) + 7, course as i64 + 13);
    let stone = hex(0xd6bd92).lerp(hex(0xc4a880), tint);
    if joint { hex(0x9c8767) } else { stone * mix(0.92, 1.06, rough(place)) }
}

/// The emblem in the middle of a banner: how far a place is inside of it, in units of its radius; below 0 outside.
type Emblem = fn(DVec2) -> f64;

pub(super) fn sun(place: DVec2) -> f64 {
    let (radius, angle) = (place.length(), place.y.atan2(place.x));
    let rays = 0.62 + 0.38 * (8.0 * angle).cos().max(0.0).sqrt();
    if radius < 0.46 { 0.46 - radius } else { (rays - radius).min(radius - 0.56) }
}

pub(super) fn star(place: DVec2) -> f64 {
    let turned = DVec2::new(place.x + place.y, place.x - place.y) / 2.0_f64.sqrt();
    let square = |point: DVec2| 0.66 - point.abs().max_element();
    let hole = place.length() - 0.3;
    square(place).max(square(turned)).min(hole).max(0.18 - place.length())
}

pub(super) fn leaf(place: DVec2) -> f64 {
    let petal = |quarter: f64| {
        let (sine, cosine) = (quarter * std::f64::consts::FRAC_PI_2).sin_cos();
        let turned = DVec2::new(place.x * cosine - place.y * sine, place.x * sine + place.y * cosine);
        0.5 - (turned - DVec2::new(0.5, 0.0)).length() - 0.7 * turned.y.abs()
    };
    (0..4).map(|quarter| petal(f64::from(quarter))).fold(-1.0, f64::max)
}

/// A banner, twice as high as wide: cloth, a border, the emblem, and chevrons below.
pub(super) fn banner(place: DVec2, cloth: u32, thread: u32, emblem: Emblem) -> DVec3 {
    let metre = DVec2::new(place.x, 3.0 * place.y);
    let to_edge = metre.x.min(1.0 - metre.x).min(3.0 - metre.y);
    let border = (0.06..0.1).contains(&to_edge) || (0.115..0.13).contains(&to_edge);
    let chevron = ((metre.y - 0.9 * (metre.x - 0.5).abs()) * 5.0).rem_euclid(1.0) < 0.45;
    let low = metre.y - 0.9 * (metre.x - 0.5).abs() < 0.75 && to_edge > 0.13;
    let inside = emblem((metre - DVec2::new(0.5, 1.85)) / 0.36) > 0.0;
    let colour = if border || inside || (low && chevron) { hex(thread) } else { hex(cloth) };
    let weave = 0.5 + 0.5 * ((metre.x * 400.0).sin() * (metre.y * 400.0).sin()).signum();
    colour * mix(0.95, 1.0, weave) * mix(0.94, 1.04, rough(place))
}

/// Opacity of the banners: their lower edge ends in five points.
pub(super) fn banner_hem(place: DVec2) -> DVec3 {
    let tooth = (place.x * 5.0).rem_euclid(1.0);
    let hem = 0.075 * (2.0 * tooth - 1.0).abs();
    DVec3::splat(if place.y > hem { 1.0 } else { 0.0 })
}

/// The bold wall: quarter discs in primary colours, turned at random, on a coloured square each.
pub(super) fn bold_wall(place: DVec2) -> DVec3 {
    const COLOURS: [u32; 5] = [0xd8232a, 0x1c6fc4, 0xf2b705, 0x14924a, 0xe8e2d4];
    let square = (place * 4.0).floor();
    let (x, y) = (square.x as i64, square.y as i64);
    let pick = |seed: i64| COLOURS[(hash(x + 16 * seed, y) * 5.0) as usize];
    let quarter = (hash(x + 64, y + 5) * 4.0) as u32;
    let corner = DVec2::new(f64::from(quarter & 1), f64::from(quarter >> 1));
    let radius = (place * 4.0 - square).distance(corner);
    let rings = [pick(1), if pick(2) == pick(1) { 0xe8e2d4 } else { pick(2) }];
    hex(if radius < 0.4 || radius > 0.9 { rings[0] } else { rings[1] })
}
