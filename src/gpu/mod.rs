//! Drawing on the graphics card: the view of a solution that the window shows.
//!
//! One pass is one Rust file and one shader beside it: [`mesh_view`] (the elements), [`wireframe`] (their edges over
//! it), [`light_view`] (the placed area light) and [`blit`] (a finished picture into the window); and for drivers on the
//! processor [`visibility`] and [`resolve`], by which pixels are coloured again without a triangle. [`viewer`] is the only
//! file that knows their order. What a pipeline is made for is a [`variant`]; passes over surfaces share how theirs are made. Group 0 of every shader of a view is `frame.wgsl`: camera, tone map, what is shown.
//!
//! A view of a field at the vertices needs no more than old OpenGL has: no storage buffers, no compute shaders. The field is
//! a stream of vertices that is written again when it changes. A view of a lightmap reads its pages where the solver left
//! them ([`frame::MapFrame`]); [`map_picture`] shows the pages themselves.

pub mod blit;
mod by_pixel;
#[cfg(feature = "app")]
pub mod callback;
pub mod coarse;
mod contents;
pub mod device;
pub mod false_color;
pub mod frame;
pub mod geometry;
pub mod light_view;
pub mod lightmap;
pub mod map_picture;
mod material_buffer;
pub mod mesh_buffers;
pub mod mesh_view;
mod part;
pub mod projection;
pub mod resolve;
pub mod screen_space;
mod surface_pipelines;
mod targets;
mod textures;
#[cfg(feature = "app")]
pub mod trouble;
pub mod variant;
pub mod viewer;
pub mod visibility;
pub mod wireframe;

#[cfg(feature = "app")]
pub use callback::{install, is_software, paint_callback, picture_callback};
pub use frame::{FalseColorRange, MapFrame, Shading, ViewFrame};
pub use geometry::ViewGeometry;
pub use projection::{project, view_projection};
pub use viewer::Viewer;
