//! Sample points in the unit square, each a pure function of (seed, element, stream, sample).
//!
//! Nothing is shared between threads and nothing comes from the clock, so a solution has the same bits on any
//! number of threads. Different elements and streams are decorrelated by hashing their numbers into the key.

use std::f32::consts::PI;

use clap::ValueEnum;
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use serde::{Deserialize, Serialize};

/// How sample points are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampler {
    /// Independent uniform points: error falls as N^-1/2.
    Random,
    /// One jittered point in each of N cells of equal area.
    Stratified,
    /// Owen-scrambled Sobol points (Burley 2020, "Practical Hash-based Owen Scrambling").
    Sobol,
}

/// What a sequence is for: streams of one element are independent of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Points on the placed area light.
    AreaLight,
    /// Points on emissive triangles.
    Emitters,
    /// Directions of the gather.
    Hemisphere,
    /// Points on surfaces.
    Surface,
}

/// The points of one element and stream.
#[derive(Clone, Copy, Debug)]
pub struct Sequence {
    sampler: Sampler,
    key: u64,
    sample_count: u32,
}

/// sobol_burley's points are defined for indices below this; further blocks take another scramble.
const SOBOL_BLOCK: u32 = 1 << 16;

impl Sequence {
    /// The sequence of `element` for `stream`; `sample_count` is how many points will be drawn (it sets the cells of
    /// [`Sampler::Stratified`]).
    pub fn new(sampler: Sampler, seed: u64, element: u32, stream: Stream, sample_count: u32) -> Self {
        let key = mix(mix(seed) ^ mix((u64::from(element) << 8) | stream as u64));
        Self { sampler, key, sample_count }
    }

    /// Point `index` (below the sample count) in [0, 1)².
    pub fn sample_2d(&self, index: u32) -> Vec2 {
        match self.sampler {
            Sampler::Random => self.random_2d(index),
            Sampler::Stratified => stratum(index, self.sample_count, self.random_2d(index)),
            Sampler::Sobol => {
                let [x, y, ..] = self.sobol_4d(index);
                Vec2::new(x, y)
            }
        }
    }

    /// Point `index` (below the sample count) in [0, 1)⁴, as two pairs: the first is [`Self::sample_2d`]. Sobol points
    /// are spread over all four dimensions at once, stratified ones over each pair, whose cells meet in another order.
    pub fn sample_4d(&self, index: u32) -> (Vec2, Vec2) {
        if self.sampler == Sampler::Sobol {
            let [x, y, z, w] = self.sobol_4d(index);
            return (Vec2::new(x, y), Vec2::new(z, w));
        }
        let other = Self { key: mix(self.key), ..*self };
        let place = match self.sampler {
            Sampler::Stratified => shuffled(index, self.sample_count, other.key),
            _ => index,
        };
        (self.sample_2d(index), other.sample_2d(place))
    }

    fn sobol_4d(&self, index: u32) -> [f32; 4] {
        let scramble = mix(self.key.wrapping_add(u64::from(index / SOBOL_BLOCK))) as u32;
        sobol_burley::sample_4d(index % SOBOL_BLOCK, 0, scramble)
    }

    fn random_2d(&self, index: u32) -> Vec2 {
        let mut generator = SmallRng::seed_from_u64(self.key ^ mix(u64::from(index)));
        Vec2::new(generator.random(), generator.random())
    }
}

/// Moves `jitter` in [0,1)² into cell `index` of `count` cells of area 1/count that tile the square.
fn stratum(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    // <answer>
    let per_row = count.isqrt().max(1);
    let (row, column) = (index / per_row, index % per_row);
    let full_rows = count / per_row;
    let cells_in_row = if row < full_rows { per_row } else { count % per_row };
    let row_start = (row * per_row) as f32 / count as f32;
    let x = (column as f32 + jitter.x) / cells_in_row as f32;
    let y = row_start + jitter.y * cells_in_row as f32 / count as f32;
    Vec2::new(x, y).min(Vec2::splat(1.0 - f32::EPSILON))
    // </answer> if index < count { jitter } else { Vec2::ZERO }
}

/// Where `index` comes to when the numbers below `count` are shuffled: by hashing within the next power of two until the
/// number is below `count` (cycle walking, as in Kensler 2013, "Correlated Multi-Jittered Sampling").
fn shuffled(index: u32, count: u32, key: u64) -> u32 {
    let bits = u32::BITS - count.saturating_sub(1).leading_zeros();
    let mask = ((1_u64 << bits) - 1) as u32;
    let (add, half) = ((key >> 32) as u32, bits.div_ceil(2).max(1));
    let mut place = index;
    loop {
        // Each step is a bijection of the numbers up to the mask.
        for factor in [key as u32 | 1, 0x85eb_ca6b, 0xc2b2_ae35] {
            place = place.wrapping_add(add).wrapping_mul(factor) & mask;
            place ^= place >> half;
        }
        if place < count || count == 0 {
            return place;
        }
    }
}

/// A bijective 64-bit hash (the finaliser of SplitMix64, Steele, Lea and Flood 2014).
fn mix(value: u64) -> u64 {
    let mut bits = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

/// Direction `index` of `count` about +z that are spread over the hemisphere by the cosine, without a random number: a
/// spiral (Vogel 1979, "A better way to construct the sunflower head"), each turn as wide as its share of the cosine asks.
pub fn spiral_direction(index: u32, count: u32) -> Vec3 {
    let squared = (index as f32 + 0.5) / count as f32;
    let (sine, cosine) = (PI * (3.0 - 5.0_f32.sqrt()) * index as f32).sin_cos();
    Vec3::new(squared.sqrt() * cosine, squared.sqrt() * sine, (1.0 - squared).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Sampler; 3] = [Sampler::Random, Sampler::Stratified, Sampler::Sobol];

    #[test]
    fn every_sampler_repeats_and_differs_between_elements_seeds_and_streams() {
        for sampler in ALL {
            let point = |seed, element, stream| Sequence::new(sampler, seed, element, stream, 64).sample_2d(5);
            let first = point(1, 2, Stream::Hemisphere);
            assert_eq!(first, point(1, 2, Stream::Hemisphere));
            assert_ne!(first, point(1, 3, Stream::Hemisphere));
            assert_ne!(first, point(257, 2, Stream::Hemisphere));
            assert_ne!(first, point(1 << 40 | 1, 2, Stream::Hemisphere), "the whole 64-bit seed counts");
            assert_ne!(first, point(1, 2, Stream::AreaLight));
        }
    }

    // <answer>
    #[test]
    fn stratified_cells_hold_one_point_each_for_any_count() {
        for count in [1_u32, 2, 3, 7, 16, 31, 100, 257] {
            // The cell of a point is found again from its own coordinates.
            let per_row = count.isqrt();
            let mut seen = vec![false; count as usize];
            let sequence = Sequence::new(Sampler::Stratified, 9, 0, Stream::Hemisphere, count);
            for index in 0..count {
                let point = sequence.sample_2d(index);
                let row = ((point.y * count as f32 / per_row as f32) as u32).min(count.div_ceil(per_row) - 1);
                let in_row = per_row.min(count - row * per_row);
                let column = (point.x * in_row as f32) as u32;
                let cell = (row * per_row + column) as usize;
                assert!(!seen[cell], "{count}: cell {cell} twice");
                seen[cell] = true;
            }
        }
    }

    #[test]
    fn pairs_of_four_dimensions_fill_their_cells_in_different_orders() {
        for sampler in [Sampler::Stratified, Sampler::Sobol] {
            let sequence = Sequence::new(sampler, 5, 3, Stream::Hemisphere, 256);
            let cell = |point: Vec2| (point.y * 8.0) as usize * 8 + (point.x * 8.0) as usize;
            let pairs: Vec<(usize, usize)> = (0..256)
                .map(|index| {
                    let (first, second) = sequence.sample_4d(index);
                    assert_eq!(first, sequence.sample_2d(index));
                    (cell(first), cell(second))
                })
                .collect();
            // 256 points, 8 x 8 cells, four in each; and a quarter of the first pair's square meets all of the second's.
            for of_pair in [|pair: &(usize, usize)| pair.0, |pair: &(usize, usize)| pair.1] {
                let mut cells: Vec<usize> = pairs.iter().map(of_pair).collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..256).map(|index| index / 4).collect::<Vec<_>>(), "{sampler:?}");
            }
            let quarter = |cell: usize| (cell / 32) * 2 + cell % 8 / 4;
            let mut met = [[0; 4]; 4];
            pairs.iter().for_each(|&(first, second)| met[quarter(first)][quarter(second)] += 1);
            assert!(met.as_flattened().iter().all(|&count| (8..=24).contains(&count)), "{sampler:?}: {met:?}");
        }
    }
    // </answer>

    #[test]
    fn sobol_quarters_are_filled_evenly_even_past_one_block() {
        let sequence = Sequence::new(Sampler::Sobol, 3, 1, Stream::Hemisphere, 4 * SOBOL_BLOCK);
        let mut counts = [0_u32; 4];
        for index in SOBOL_BLOCK..SOBOL_BLOCK + 1024 {
            let point = sequence.sample_2d(index);
            assert!(point.min_element() >= 0.0 && point.max_element() < 1.0);
            counts[(point.x >= 0.5) as usize * 2 + (point.y >= 0.5) as usize] += 1;
        }
        assert_eq!(counts, [256; 4]); // a (0, m, 2)-net in base 2
    }
}
