//! What the window knows of a solution, growing while it is solved.

use std::sync::Arc;

use glam::Vec3;

use super::{
    elements::Elements,
    solving::{SolveEvent, SolveInput},
};
#[cfg(feature = "reference")]
use crate::solver::Kept;
use crate::{
    files::truth_comparison::TruthComparison,
    math::ratio_or_zero,
    solver::{
        Progress, Solution, SolveReport,
        energy::{BouncePower, Ledger},
    },
};

/// A field of irradiance at the vertices of the elements.
pub type Field = Arc<Vec<Vec3>>;

/// A solution, whole or on its way.
#[derive(Clone)]
pub struct Results {
    /// The elements it lives on.
    pub elements: Elements,
    /// What it was solved with.
    pub input: SolveInput,
    /// All bounces together, as far as they are known, in W/m².
    pub total: Field,
    /// Each complete bounce alone, in W/m²; bounce 0 is direct light.
    pub bounces: Vec<Field>,
    /// The power of each complete bounce.
    pub powers: Vec<BouncePower>,
    /// Seconds since ENTER, and the fraction of the emitted power then still unabsorbed.
    pub history: Vec<[f64; 2]>,
    /// For each complete bounce: seconds since ENTER, and the estimate of the mean irradiance that is still missing,
    /// as a part of the whole ([`missing_part`]).
    pub missing: Vec<[f64; 2]>,
    /// The standard error at each vertex, in W/m², the same in all bands; once all bounces are done.
    pub sampling_error: Option<Field>,
    /// The root of its mean square over the area, relative to the mean irradiance.
    pub relative_sampling_error: Option<f64>,
    /// The comparison with a truth.
    pub truth: Option<Arc<TruthView>>,
    /// How far the solve has come.
    pub progress: Option<Progress>,
    /// The solution, once the solve has ended.
    pub solution: Option<Arc<Solution>>,
    /// Vertices that are buried, once the solve has ended.
    pub buried: Option<Arc<Vec<bool>>>,
    /// What the solve did, once it has ended.
    pub report: Option<Box<SolveReport>>,
    /// The rows of the solve, to be lit again.
    #[cfg(feature = "reference")]
    pub kept: Option<Arc<Kept>>,
    /// The rows were lit again since the solve: the elements follow an earlier light.
    pub relit: bool,
}

/// A comparison with a truth, as the window shows it.
pub struct TruthView {
    /// The file's name.
    pub name: String,
    /// What was found.
    pub comparison: TruthComparison,
    /// The error near each vertex, in W/m², the same in all bands: the mean over the points on the elements around it;
    /// passed on from neighbours where there are none.
    pub field: Field,
}

/// The part of all irradiance that the bounces after the last one would add: a geometric series of the last ratio.
pub fn missing_part(powers: &[BouncePower]) -> f64 {
    let arriving = |power: &BouncePower| power.arriving.element_sum();
    let Some(last) = powers.last() else { return 1.0 };
    let before = powers.len().checked_sub(2).map(|index| arriving(&powers[index]));
    let ratio = before.map_or(ratio_or_zero(last.reflected.element_sum(), arriving(last)), |before| {
        ratio_or_zero(arriving(last), before)
    });
    let ratio = ratio.clamp(0.0, 0.999);
    let rest = arriving(last) * ratio / (1.0 - ratio);
    ratio_or_zero(rest, powers.iter().map(arriving).sum::<f64>() + rest)
}

impl Results {
    /// The estimated error after each complete bounce: seconds since ENTER, and what is missing together with the
    /// sampling error, relative to the mean irradiance.
    pub fn estimated_errors(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let sampling = self.relative_sampling_error.unwrap_or(0.0);
        self.missing.iter().map(move |[seconds, missing]| [*seconds, missing.hypot(sampling)])
    }

    /// A solve that has only begun.
    pub fn begun(elements: Elements, total: Field, input: SolveInput) -> Self {
        Self {
            elements,
            input,
            total,
            bounces: Vec::new(),
            powers: Vec::new(),
            history: vec![[0.0, 1.0]],
            missing: Vec::new(),
            sampling_error: None,
            relative_sampling_error: None,
            truth: None,
            progress: None,
            solution: None,
            buried: None,
            report: None,
            #[cfg(feature = "reference")]
            kept: None,
            relit: false,
        }
    }

    /// A solution from a file.
    pub fn of_solution(elements: Elements, solution: Arc<Solution>, total: Field) -> Self {
        let info = &solution.info;
        let input = SolveInput {
            light: info.light,
            settings: info.settings.clone(),
            materials: Arc::new(elements.scene.materials.clone()),
        };
        let bounces = solution.bounces.iter().cloned().map(Arc::new).collect();
        let buried = Some(Arc::new(solution.buried.clone()));
        Self { bounces, buried, solution: Some(solution), ..Self::begun(elements, total, input) }
    }

    /// The same rows under another light.
    #[cfg(feature = "reference")]
    pub fn lit_again(
        &self,
        elements: Elements,
        solution: Arc<Solution>,
        report: Box<SolveReport>,
        input: SolveInput,
    ) -> Self {
        let total = Arc::new(solution.total());
        let powers = report.energy.bounces.clone();
        let relit = Self::of_solution(elements, solution, total);
        Self { input, powers, report: Some(report), kept: self.kept.clone(), relit: true, ..relit }
    }

    /// Gives the rows' memory back.
    pub fn forget_rows(&mut self) {
        #[cfg(feature = "reference")]
        {
            self.kept = None;
        }
    }

    /// Takes in what a solve tells.
    pub fn take(&mut self, event: SolveEvent) {
        match event {
            SolveEvent::Progress(progress) => self.progress = Some(progress),
            SolveEvent::Bounce { irradiance, power, seconds } => {
                self.bounces.push(irradiance);
                self.powers.push(power);
                // All that leaves the lights either arrives or escapes.
                let emitted = self.powers[0].arriving + self.powers[0].escaped;
                self.missing.push([seconds, missing_part(&self.powers)]);
                self.history.push([
                    seconds,
                    Ledger { emitted, bounces: self.powers.clone(), iteration: self.input.settings.iteration_in_use() }
                        .unabsorbed(),
                ]);
            }
            SolveEvent::SamplingError { field, relative } => {
                self.sampling_error = Some(field);
                self.relative_sampling_error = Some(relative);
            }
            SolveEvent::Finished {
                solution,
                total,
                report,
                #[cfg(feature = "reference")]
                kept,
            } => {
                self.powers.clone_from(&report.energy.bounces);
                self.total = total;
                self.buried = Some(Arc::new(solution.buried.clone()));
                self.solution = Some(solution);
                self.report = Some(report);
                #[cfg(feature = "reference")]
                {
                    self.kept = kept;
                }
            }
            #[cfg(feature = "reference")]
            SolveEvent::Relit { .. } => {}
            SolveEvent::Elements(..) | SolveEvent::Remark(_) | SolveEvent::Fault(_) | SolveEvent::Failed(_) => {}
        }
    }

    /// The sum of the bounces from `first` to `last`, as far as they are known, in W/m².
    pub fn sum(&self, first: usize, last: usize) -> Field {
        let mut sum = vec![Vec3::ZERO; self.total.len()];
        for bounce in self.bounces.iter().take(last.saturating_add(1)).skip(first) {
            for (total, value) in sum.iter_mut().zip(bounce.iter()) {
                *total += *value;
            }
        }
        Arc::new(sum)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn what_is_missing_of_a_geometric_series_is_known_after_every_bounce() {
        // Bounces of 1, 1/2, 1/4, ...: all of it is 2, and after n + 1 of them 2^-n is missing.
        let power = |arriving: f64| BouncePower {
            arriving: DVec3::splat(arriving),
            absorbed: DVec3::splat(0.5 * arriving),
            reflected: DVec3::splat(0.5 * arriving),
            escaped: DVec3::ZERO,
        };
        let powers: Vec<BouncePower> = (0..5).map(|bounce| power(0.5_f64.powi(bounce))).collect();
        for bounces in 1..=5 {
            let missing = missing_part(&powers[..bounces]);
            assert!((missing - 0.5_f64.powi(bounces as i32)).abs() < 1e-12, "{bounces}: {missing}");
        }
        assert_eq!(missing_part(&[]), 1.0);
    }
}
