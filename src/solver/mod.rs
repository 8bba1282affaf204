//! The solver: settings in, a solution out, as a job that can be watched.

#[cfg(feature = "reference")]
mod adapt;
mod buried;
pub mod energy;
pub mod faults;
pub mod form_factors;
#[cfg(feature = "reference")]
mod gather;
pub mod job;
#[cfg(feature = "reference")]
pub mod kept;
#[cfg(feature = "reference")]
mod least_squares;
pub mod lightmap_solution;
pub mod monitor;
pub mod one_vertex;
#[cfg(feature = "reference")]
pub mod patch_rays;
pub mod patches;
pub mod reconstruct;
pub mod settings;
mod skipped;
pub mod solution;
pub mod solution_file;
pub mod solve;
pub mod state;
pub mod student_engine;

pub use job::Job;
#[cfg(feature = "reference")]
pub use kept::Kept;
pub use lightmap_solution::LightmapSolution;
pub use monitor::{LiveField, Message, Monitor, Progress, Stage};
pub use reconstruct::{PointIrradiance, Reconstruction, Reconstructor};
pub use settings::{Engine, Iteration, SolveSettings};
pub use skipped::SecondsSaved;
pub use solution::{Solution, SolutionInfo};
pub use solve::{EndedBy, Problem, SolveReport, Solved, solve, solve_with};
pub use state::State;
