//! Calling a student's function safely, and saying what a test found.

use std::fmt::Display;

use glam::{Mat3, Vec2, Vec3};

use crate::{
    check::chi_square::random_points,
    solver::faults::caught,
    student::{Functions, LightSample, PLACEHOLDERS},
};

/// Points of the unit square in each statistical test.
pub(super) const SAMPLE_COUNT: u32 = 100_000;

/// The functions under test, and the seed of the points they are tested with.
pub(super) struct Trial<'a> {
    pub functions: &'a Functions,
    pub seed: u64,
}

/// Why a task is not done.
pub(super) enum Problem {
    /// This function still returns its placeholder.
    NotDone(&'static str),
    Wrong(Failure),
}

/// A failed test.
pub(super) struct Failure {
    pub function: &'static str,
    pub test: &'static str,
    pub measured: String,
    pub expected: String,
    /// The mistake, where the test itself knows it.
    pub hint: Option<String>,
    /// What to say if the diagnosis knows no better.
    pub fallback: &'static str,
}

pub(super) type Check = Result<(), Problem>;

impl Failure {
    pub(super) fn new(function: &'static str, test: &'static str, measured: String, expected: &str) -> Self {
        let fallback = "no mistake that is known here: compare the function with the equation in its comment";
        Self { function, test, measured, expected: String::from(expected), hint: None, fallback }
    }

    pub(super) fn hint(self, hint: &str) -> Self {
        Self { hint: Some(String::from(hint)), ..self }
    }

    pub(super) fn fallback(self, fallback: &'static str) -> Self {
        Self { fallback, ..self }
    }

    pub(super) fn or_else(self, hint: Option<&str>) -> Self {
        Self { hint: self.hint.or(hint.map(String::from)), ..self }
    }
}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        Self::Wrong(failure)
    }
}

impl Trial<'_> {
    /// The points of the statistical tests.
    pub(super) fn points(&self) -> impl Iterator<Item = Vec2> + Clone {
        random_points(self.seed, SAMPLE_COUNT)
    }

    /// Corners, middles and sides of the unit square (where rounding crosses a limit first), then [`Trial::points`].
    pub(super) fn edges_and_points(&self) -> impl Iterator<Item = Vec2> + Clone {
        const STEPS: [f32; 7] = [0.0, 1e-7, 0.25, 0.5, 0.75, 1.0 - 1e-7, 1.0];
        let places = STEPS.into_iter().flat_map(|x| STEPS.map(|y| Vec2::new(x, y)));
        let sides = (1..100_u8).flat_map(|step| {
            let along = f32::from(step) / 100.0;
            [[along, 0.0], [along, 1.0], [0.0, along], [1.0, along]].map(Vec2::from_array)
        });
        places.chain(sides).chain(self.points())
    }
}

/// A value of which every number can be tested for being finite.
pub(super) trait Answer: std::fmt::Debug {
    fn finite(&self) -> bool;
}

impl Answer for f32 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

impl Answer for Vec2 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

impl Answer for Vec3 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

impl Answer for Mat3 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

impl Answer for LightSample {
    fn finite(&self) -> bool {
        self.position.is_finite() && self.normal.is_finite() && self.pdf_area.is_finite()
    }
}

/// Calls a student's function: a panic and a value that is not finite become failures that name function and input.
pub(super) fn call<Output: Answer>(
    function: &'static str,
    input: impl Display,
    body: impl FnOnce() -> Output,
) -> Result<Output, Problem> {
    match caught(body) {
        Ok(output) if output.finite() => Ok(output),
        Ok(output) => Err(Failure::new(function, "finite values", format!("{output:?} for {input}"), "finite numbers")
            .fallback("a value is NaN or infinite: look for 0/0, a division by 0, the square root of a negative number")
            .into()),
        Err(message) if message.starts_with("not yet implemented") || message.starts_with("not implemented") => {
            Err(Problem::NotDone(function))
        }
        Err(message) => {
            let failure = panicked(function, &message);
            Err(Failure { measured: format!("for {input}: {}", failure.measured), ..failure }.into())
        }
    }
}

/// The failure of a function that panicked.
pub(super) fn panicked(function: &'static str, message: &str) -> Failure {
    Failure::new(function, "no panic", format!("panic: {message}"), "a value for every input")
        .hint("the function panics: the message says why; an index out of range, an overflow, an assertion?")
}

/// Whether a function is still its placeholder: the same answers at all `inputs`.
fn is_placeholder<Input: Copy, Output: PartialEq>(
    inputs: &[Input],
    function: impl Fn(Input) -> Output,
    placeholder: impl Fn(Input) -> Output,
) -> bool {
    inputs.iter().all(|&input| caught(|| function(input)).is_ok_and(|answer| answer == placeholder(input)))
}

/// [`Problem::NotDone`] if `select(functions)` answers like `select(PLACEHOLDERS)` at all `inputs`.
pub(super) fn written<Input: Copy, Output: PartialEq>(
    trial: &Trial,
    name: &'static str,
    inputs: &[Input],
    answer: impl Fn(&Functions, Input) -> Output,
) -> Check {
    let is_unwritten =
        is_placeholder(inputs, |input| answer(trial.functions, input), |input| answer(&PLACEHOLDERS, input));
    if is_unwritten { Err(Problem::NotDone(name)) } else { Ok(()) }
}

/// Points at which a written function differs from its placeholder somewhere; none is special.
pub(super) const PLAIN_POINTS: [Vec2; 4] =
    [Vec2::new(0.1, 0.3), Vec2::new(0.7, 0.2), Vec2::new(0.35, 0.9), Vec2::new(0.8, 0.65)];

/// The value, if the function neither panics nor returns one that is not finite; for diagnoses.
pub(super) fn quiet<Output: Answer>(body: impl FnOnce() -> Output) -> Option<Output> {
    caught(body).ok().filter(Answer::finite)
}

/// Whether `value` is within `share` of `expected`, relatively.
pub(super) fn near(value: f32, expected: f32, share: f32) -> bool {
    (value - expected).abs() <= share * expected.abs()
}
