//! Pictures of a solution by ray casting on the CPU, so that none needs a GPU.
//!
//! Back faces are culled: a camera ray passes through them, so that one looks into a closed room from outside.
//! The placed area light is drawn as a rectangle, although it is not geometry: a lit room without its lamp looks wrong.

pub mod picture;
pub mod view;
mod visible;
mod wireframe;

pub use picture::{RenderSettings, Subject, render};
pub use view::View;
pub use visible::visible_points;
