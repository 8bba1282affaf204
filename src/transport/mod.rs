//! The two operators of `E = E0 + T E` on elements: direct irradiance E0, and the transport T of reflected light.

#[cfg(feature = "reference")]
mod blocks;
#[cfg(feature = "reference")]
pub mod direct;
pub mod facing;
pub mod lamps;
pub mod lights;
pub mod origins;
mod polygon;
#[cfg(feature = "reference")]
pub mod rows;
#[cfg(feature = "reference")]
pub mod sampling;
mod silhouette;
#[cfg(feature = "reference")]
pub mod star;
#[cfg(feature = "reference")]
mod trace_rows;
pub mod visible_light;

pub use lights::Lights;
pub use origins::VertexOrigins;
#[cfg(feature = "reference")]
pub use polygon::polygon_form_factor;
#[cfg(feature = "reference")]
pub use rows::{RowChunk, bytes_per_ray};
#[cfg(feature = "reference")]
pub use trace_rows::Transport;
