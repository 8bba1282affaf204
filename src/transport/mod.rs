//! The two operators of `E = E0 + T E` on elements: direct irradiance E0, and the transport T of reflected light.

pub mod direct;
pub mod lights;
pub mod origins;
pub mod rows;
pub mod sampling;

pub use lights::Lights;
pub use origins::VertexOrigins;
pub use rows::{RowChunk, Transport};
