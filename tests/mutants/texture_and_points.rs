//! Wrong textures, and wrong sample points.

use glam::{Vec2, Vec3};
use radiosity::{
    math::color::srgb_to_linear,
    student::{SurfaceHit, World, low_discrepancy_point, sample_texture},
};

use super::{Mutant, mutant};

type Texels<'a> = &'a [[u8; 4]];

fn texel(texels: Texels, index: u32) -> Vec3 {
    let [red, green, blue, _] = texels[index as usize];
    Vec3::from([red, green, blue].map(|byte| srgb_to_linear(f32::from(byte) / 255.0)))
}

fn swapped(size: (u32, u32), texels: Texels, texcoord: Vec2) -> Vec3 {
    sample_texture(size, texels, Vec2::new(texcoord.y, texcoord.x))
}

fn clamped(size: (u32, u32), texels: Texels, texcoord: Vec2) -> Vec3 {
    sample_texture(size, texels, texcoord.clamp(Vec2::ZERO, Vec2::splat(0.999)))
}

fn beyond_the_end((width, height): (u32, u32), texels: Texels, texcoord: Vec2) -> Vec3 {
    let column = (texcoord.x * width as f32) as u32;
    let row = height - 1 - (texcoord.y * height as f32) as u32;
    texel(texels, row * width + column)
}

fn upside_down(size: (u32, u32), texels: Texels, texcoord: Vec2) -> Vec3 {
    sample_texture(size, texels, Vec2::new(texcoord.x, 1.0 - texcoord.y))
}

fn not_decoded((width, height): (u32, u32), texels: Texels, texcoord: Vec2) -> Vec3 {
    let place = (texcoord - texcoord.floor()) * Vec2::new(width as f32, height as f32);
    let row = height - 1 - (place.y as u32).min(height - 1);
    let [red, green, blue, _] = texels[(row * width + (place.x as u32).min(width - 1)) as usize];
    Vec3::new(f32::from(red), f32::from(green), f32::from(blue)) / 255.0
}

fn fraction_of_the_truncated(size: (u32, u32), texels: Texels, texcoord: Vec2) -> Vec3 {
    sample_texture(size, texels, (texcoord - texcoord.trunc()).abs())
}

fn texture_alone(world: &World, hit: &SurfaceHit) -> Vec3 {
    match hit.material.reflectance_texture {
        None => hit.material.reflectance,
        Some(index) => {
            let texture = &world.scene.textures[index as usize];
            sample_texture(texture.size(), texture.texels(), hit.texcoord)
        }
    }
}

fn whole_number_division(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    let columns = count.isqrt().max(1);
    let cell = Vec2::new(((index % columns) / columns) as f32, ((index / columns) / columns) as f32);
    (cell + jitter / columns as f32).min(Vec2::splat(1.0 - f32::EPSILON))
}

fn no_jitter(index: u32, count: u32, _: Vec2) -> Vec2 {
    radiosity::student::stratified_point(index, count, Vec2::splat(0.5))
}

fn squares_only(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    let columns = count.isqrt().max(1);
    let cell = Vec2::new((index % columns) as f32, (index / columns % columns) as f32);
    ((cell + jitter) / columns as f32).min(Vec2::splat(1.0 - f32::EPSILON))
}

fn jitter_not_scaled(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    let columns = count.isqrt().max(1) as f32;
    let cell = Vec2::new((index % columns as u32) as f32, (index / columns as u32) as f32) / columns;
    (cell + jitter).fract()
}

fn inverse(base: u32, mut index: u32) -> f32 {
    let (mut sum, mut scale) = (0.0, 1.0 / base as f32);
    while index > 0 {
        sum += (index % base) as f32 * scale;
        index /= base;
        scale /= base as f32;
    }
    sum.min(1.0 - f32::EPSILON)
}

fn one_base(index: u32) -> Vec2 {
    Vec2::splat(inverse(2, index))
}

fn bases_with_a_divisor(index: u32) -> Vec2 {
    Vec2::new(inverse(2, index), inverse(4, index))
}

fn first_digit_whole(index: u32) -> Vec2 {
    Vec2::new(2.0 * inverse(2, index), 3.0 * inverse(3, index))
}

fn by_count(index: u32) -> Vec2 {
    let share = index as f32 / u32::MAX as f32;
    Vec2::new(share, low_discrepancy_point(index).y * 0.1).min(Vec2::splat(1.0 - f32::EPSILON))
}

fn hashed(index: u32) -> Vec2 {
    let mix = |salt: u32| {
        let mut bits = (index ^ salt).wrapping_mul(0x9e37_79b9);
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x85eb_ca6b);
        bits = (bits ^ (bits >> 13)).wrapping_mul(0xc2b2_ae35);
        ((bits ^ (bits >> 16)) >> 8) as f32 / 16_777_216.0
    };
    Vec2::new(mix(0x1234), mix(0x0098_7654))
}

/// The wrong versions that the diagnosis was written with.
pub(crate) fn mutants() -> Vec<Mutant> {
    vec![
        mutant!("textures", "u and v swapped", "u and v are swapped", sample_texture: swapped),
        mutant!("textures", "no wrap, clamped", "does not repeat", sample_texture: clamped),
        mutant!("textures", "no wrap, beyond the end", "does not repeat", sample_texture: beyond_the_end),
        mutant!("textures", "v upside down", "upside down", sample_texture: upside_down),
        mutant!("textures", "sRGB not decoded", "not decoded", sample_texture: not_decoded),
        mutant!("textures", "truncated below 0", "mirrored or shifted below 0", sample_texture: fraction_of_the_truncated),
        mutant!("textures", "texture alone", "own reflectance is left out", surface_reflectance: texture_alone),
        mutant!("stratified", "whole-number division", "integer division", stratified_point: whole_number_division),
        mutant!("stratified", "no jitter", "jitter is not used", stratified_point: no_jitter),
        mutant!("stratified", "square numbers only", "square numbers work", stratified_point: squares_only),
        mutant!("stratified", "jitter not scaled", "not scaled", stratified_point: jitter_not_scaled),
        mutant!("qmc", "one base", "same: take another base", low_discrepancy_point: one_base),
        mutant!("qmc", "bases 2 and 4", "common divisor", low_discrepancy_point: bases_with_a_divisor),
        mutant!("qmc", "first digit a whole", "first digit counts a whole", low_discrepancy_point: first_digit_whole),
        mutant!("qmc", "index over count", "crowd in a corner", low_discrepancy_point: by_count),
        mutant!("qmc", "hashed", "no better than random", low_discrepancy_point: hashed),
    ]
}
