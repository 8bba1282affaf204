//! A row's samples: in runs by where they start, and in blocks that tell the sampling error of their mean.

use glam::Vec3;

use crate::trace::surface::is_buried_by;

/// A row is made of this many blocks of consecutive samples, which tell its sampling error: see [`squared_error`].
pub(super) const BLOCKS: usize = 4;

/// The rays that left from one origin.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Run {
    pub(super) rays: u32,
    /// Those that could be traced, and of them those that met back faces.
    pub(super) traced: u32,
    pub(super) back_hits: u32,
    pub(super) entries: u32,
    pub(super) emission: Vec3,
}

impl Run {
    pub(super) fn is_buried(&self) -> bool {
        is_buried_by(self.back_hits, self.traced)
    }
}

/// The sample that each block ends before.
pub(super) fn block_ends_of(count: u32) -> [u32; BLOCKS] {
    std::array::from_fn(|block| (u64::from(count) * (block as u64 + 1)).div_ceil(BLOCKS as u64) as u32)
}

/// The squared standard error of the mean of all samples, from the sums over blocks of samples and their numbers: the
/// blocks are taken as repetitions of one experiment, so it is the variance of their means over their number. Blocks of
/// stratified or Sobol points err less together than so many repetitions would: there it is rather too large.
pub(super) fn squared_error(blocks: [(Vec3, u32); BLOCKS]) -> Vec3 {
    let used = || blocks.iter().filter(|(_, count)| *count > 0).map(|(sum, count)| *sum / *count as f32);
    let count = used().count() as f32;
    if count < 2.0 {
        return Vec3::ZERO;
    }
    let mean = used().sum::<Vec3>() / count;
    used().map(|value| (value - mean) * (value - mean)).sum::<Vec3>() / (count * (count - 1.0))
}

/// Each block's end among the entries, and its rays, once buried origins are taken out of the row.
pub(super) fn blocks_of(sample_count: u32, ends: [u32; BLOCKS], runs: &[Run]) -> [(u32, u32); BLOCKS] {
    let kept_before = |position: u32, length: fn(&Run) -> u32| {
        let (mut start, mut kept) = (0, 0);
        for run in runs {
            let inside = position.saturating_sub(start).min(length(run));
            kept += if run.is_buried() { 0 } else { inside };
            start += length(run);
        }
        kept
    };
    let (sample_ends, mut rays) = (block_ends_of(sample_count), 0);
    std::array::from_fn(|block| {
        let before = rays;
        rays = kept_before(sample_ends[block], |run| run.rays);
        (kept_before(ends[block], |run| run.entries), rays - before)
    })
}
