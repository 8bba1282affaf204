//! A bounce: its shader, and the spiral that taps lie on for the source's weights and for obscurance (Mara et al. 2014;
//! Nielsen 2015, section 2.3.3).

use std::f32::consts::TAU;

use glam::Vec4;

use super::settings::{MOST_TAPS, ScreenSettings};

/// The shader of a bounce; comes after [`super::uniforms::SCREEN_WGSL`].
pub const GATHER_WGSL: &str = concat!(
    include_str!("gather.wgsl"),
    include_str!("line.wgsl"),
    include_str!("slices.wgsl"),
    include_str!("kept.wgsl"),
    include_str!("spiral.wgsl")
);
/// The shader of the ambient obscurance, on the same spiral.
pub const OBSCURANCE_WGSL: &str = include_str!("obscurance.wgsl");

/// How taps are weighed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// By slices; what taps count for may be kept.
    Slices,
    /// By what the first bounce kept.
    Kept,
    /// As the source does.
    Spiral,
}

impl Way {
    pub(super) const COUNT: usize = 3;
}

/// Laid out as `Bounce` in `gather.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct BounceUniforms {
    /// 1: the sum over the bounces begins.
    pub is_first: u32,
    /// 1: nothing follows, and the filter takes the sum.
    pub is_last: u32,
    /// 1: the last bounce comes next, and gathers from what it gathered in the frames before, too.
    pub feeds_last: u32,
    /// 1: the last bounce, fed in this way.
    pub is_fed: u32,
}

/// Cosine and sine of each tap's angle. The shader turns them by an angle of each pixel's own, and gives tap i of n the
/// radius R (i + ψ) / n, ψ in [0, 1) of each pixel's own.
pub fn spiral(settings: &ScreenSettings) -> [Vec4; MOST_TAPS as usize] {
    let (taps, turns) = (settings.taps as f32, settings.spiral_turns() as f32);
    std::array::from_fn(|tap| {
        let angle = TAU * turns * tap as f32 / taps;
        Vec4::new(angle.cos(), angle.sin(), 0.0, 0.0)
    })
}
