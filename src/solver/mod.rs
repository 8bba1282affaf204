//! The solver: settings in, a solution out, as a job that can be watched.

pub mod settings;
pub mod solution;
pub mod solution_file;

pub use settings::SolveSettings;
pub use solution::{Solution, SolutionInfo};
