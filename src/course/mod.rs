//! The course around the assignment: the tree that is handed out, the archive that is handed in, the marks.

pub mod archive;
#[cfg(feature = "reference")]
pub mod grade;
pub mod handin;
#[cfg(feature = "reference")]
pub mod handout;
pub mod judge;
#[cfg(feature = "reference")]
mod markers;
#[cfg(feature = "reference")]
mod page;
pub mod tree;
