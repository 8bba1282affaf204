//! Radiosity on the graphics card: progressive refinement (Cohen, Chen, Wallace and Greenberg 1988) over the texels of
//! a lightmap.
//!
//! A batch of shooters at a time: the lights first, then the groups of texels with the most unshot power, which the card
//! itself chooses (`choose.wgsl`). Each shooter's hemicube is drawn into one atlas of depth ([`hemicube`]); every texel
//! then receives from all shooters of the batch (`receive.wgsl`): the form factor to a parallelogram, exact where it is
//! near, times the part that is seen. Of all this only the ledger is read back; views read the pages where they are
//! (`pages.wgsl`).
//!
//! [`solver`] is the only file that knows the order of the passes.

pub mod cutouts;
pub mod fields;
mod groups;
pub mod hemicube;
pub mod hemisphere;
pub mod item_buffer;
pub mod lamps;
mod ledger;
pub mod pace;
pub mod pages;
pub mod patches;
pub(super) mod pipelines;
pub(super) mod readback;
mod resources;
mod rest;
pub mod shaders;
pub mod solver;
pub mod timing;

pub use ledger::GpuLedger;
pub use pages::Stage;
pub use solver::GpuSolver;
