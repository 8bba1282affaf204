//! The solver: settings in, a solution out, as a job that can be watched.

pub mod settings;
pub mod solution;
pub mod state;

pub use settings::SolveSettings;
pub use solution::{Solution, SolutionInfo};
pub use state::State;
