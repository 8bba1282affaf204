//! The scene as one camera sees it, lit in screen space: what a real-time approximation gives, beside what is true.
//!
//! A deep G-buffer ([`g_buffer`]: normals, reflectance and depth of two layers) is lit by the lights' pieces ([`lamps`],
//! `light.wgsl`); bounces are gathered from taps of the picture itself, and of a coarse one around it ([`gather`]), and
//! filtered ([`filter`]). After Mara, McGuire, Nowrouzezahrai and Luebke 2014, "Fast global illumination approximations on
//! deep G-buffers".
//!
//! [`renderer`] is the only file that knows the order of the passes.

pub mod filter;
pub mod g_buffer;
pub mod gather;
pub mod lamps;
pub mod pace;
mod passes;
mod picture;
pub mod quality;
pub mod renderer;
pub mod settings;
pub mod show;
mod targets;
pub mod uniforms;
pub mod view;

pub use passes::Pass;
pub use renderer::ScreenRenderer;
pub use settings::{ScreenSettings, SecondLayer, Weights};
pub use show::ShownBuffer;
pub use view::{ScreenFields, ScreenView};
