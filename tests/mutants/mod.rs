//! Wrong versions of the student's functions, and right ones that are written differently: test data.
#![cfg(feature = "reference")]

pub(crate) mod direct;
pub(crate) mod gather;
pub(crate) mod later;
pub(crate) mod light;
pub(crate) mod right;
pub(crate) mod square;
pub(crate) mod texture_and_points;
pub(crate) mod triangle_and_basis;

use radiosity::student::{FUNCTIONS, Functions};

/// One wrong version: everything right but for one mistake.
pub(crate) struct Mutant {
    /// The mistake, in a few words.
    pub(crate) name: &'static str,
    /// The task that must find it.
    pub(crate) task: &'static str,
    /// Words of the right first hint.
    pub(crate) hint: &'static str,
    /// The functions with the mistake.
    pub(crate) functions: Functions,
}

/// A mutant made of the right functions with some replaced.
macro_rules! mutant {
    ($task:literal, $name:literal, $hint:literal, $($field:ident: $function:expr),+) => {
        $crate::mutants::Mutant {
            name: $name,
            task: $task,
            hint: $hint,
            functions: radiosity::student::Functions { $($field: $function,)+ ..radiosity::student::FUNCTIONS },
        }
    };
}
pub(crate) use mutant;

/// All wrong versions.
pub(crate) fn all() -> Vec<Mutant> {
    let mut mutants = triangle_and_basis::mutants();
    mutants.extend(square::mutants());
    mutants.extend(light::mutants());
    mutants.extend(direct::mutants());
    mutants.extend(gather::mutants());
    mutants.extend(texture_and_points::mutants());
    mutants.extend(later::mutants());
    mutants
}

/// The answers of the repository.
pub(crate) const ANSWERS: Functions = FUNCTIONS;
