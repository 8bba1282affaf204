//! Judging: statistical tests of samplers, answers known in closed form, a reference path tracer, error metrics,
//! and the assignment's tasks.

pub mod chi_square;
pub mod closed_form;
#[cfg(feature = "reference")]
mod emitters;
pub mod jacobian;
pub mod metrics;
#[cfg(feature = "reference")]
pub mod path_tracer;
pub mod picture_errors;
#[cfg(feature = "reference")]
pub mod ray_sets;
#[cfg(feature = "reference")]
pub mod stress;
pub mod surface_points;
pub mod tasks;
pub mod truth_file;
