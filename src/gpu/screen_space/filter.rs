//! The depth- and normal-aware separable Gaussian filter.

/// The shader; comes after [`super::uniforms::SCREEN_WGSL`].
pub const FILTER_WGSL: &str = include_str!("filter.wgsl");
