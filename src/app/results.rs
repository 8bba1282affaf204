//! What the window knows of a solution, growing while it is solved.

use std::sync::Arc;

use glam::Vec3;

use super::solving::{Elements, SolveEvent, SolveInput};
use crate::solver::{
    Progress, Solution, SolveReport,
    energy::{BouncePower, Ledger},
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
    /// How far the solve has come.
    pub progress: Option<Progress>,
    /// The solution, once the solve has ended.
    pub solution: Option<Arc<Solution>>,
    /// Vertices that are buried, once the solve has ended.
    pub buried: Option<Arc<Vec<bool>>>,
    /// What the solve did, once it has ended.
    pub report: Option<Box<SolveReport>>,
}

impl Results {
    /// A solve that has only begun: darkness.
    pub fn begun(elements: Elements, input: SolveInput) -> Self {
        let total = Arc::new(vec![Vec3::ZERO; elements.tessellation.mesh.positions.len()]);
        Self {
            elements,
            input,
            total,
            bounces: Vec::new(),
            powers: Vec::new(),
            history: vec![[0.0, 1.0]],
            progress: None,
            solution: None,
            buried: None,
            report: None,
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
        Self { total, bounces, buried, solution: Some(solution), ..Self::begun(elements, input) }
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
                self.history.push([seconds, Ledger { emitted, bounces: self.powers.clone() }.unabsorbed()]);
            }
            SolveEvent::Finished { solution, total, report } => {
                self.powers.clone_from(&report.energy.bounces);
                self.total = total;
                self.buried = Some(Arc::new(solution.buried.clone()));
                self.solution = Some(solution);
                self.report = Some(report);
            }
            SolveEvent::Started(_) | SolveEvent::Remark(_) | SolveEvent::Fault(_) | SolveEvent::Failed(_) => {}
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
