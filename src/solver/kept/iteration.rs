//! Ways to the converged field, sweep by sweep: g = R ρ (E0 + S g), where g is what rays gather, R their rows and S the
//! spread from the vertices that gather to those of the elements.
//!
//! All begin with one gather of direct light, g = R ρ E0, and end with one gather of all light (of which the Krylov
//! method knows the result). So the ledger's totals are exact whatever lies between: what left the surfaces is the light
//! before the last gather, what arrived that after.

use glam::{DVec3, Vec3};

use super::{
    Context, Kept,
    krylov::{Gmres, Known, add_scaled, norm},
};
use crate::{
    math::ratio_or_zero,
    solver::{settings::Iteration, solve::SolveReport},
};

/// Parts of the rows that Gauss-Seidel goes through, one after the other: a fixed number, so that the bits do not depend on the
/// threads. Each part sees what the parts before it gathered.
const PARTS: usize = 8;

/// Of the unshot power, a batch of shooting takes the vertices that have most, until they have this part together.
const SHOT_AT_ONCE: f64 = 0.5;

/// One way to the converged field, on its way.
pub(super) struct Sweeps<'a> {
    kept: &'a Kept,
    context: &'a Context<'a>,
    direct: &'a [Vec3],
    /// What rays gather of direct light, and its norm.
    of_direct: Vec<Vec3>,
    scale: DVec3,
    gathered: Vec<Vec3>,
    method: Method<'a>,
    /// What the Krylov method has found out of the rows.
    known: Known,
}

enum Method<'a> {
    GaussSeidel,
    Shooting(Shooting<'a>),
    Krylov(Gmres),
}

struct Shooting<'a> {
    /// Irradiance [W/m²] at the elements' vertices that is not yet reflected.
    unshot: Vec<Vec3>,
    /// Reflecting area of each vertex.
    weights: &'a [DVec3],
    /// The norm of the first unshot irradiance.
    scale: DVec3,
}

impl<'a> Sweeps<'a> {
    /// The first gather, of direct light. What is known of the rows from other light saves the Krylov method sweeps.
    pub(super) fn begin(
        kept: &'a Kept,
        context: &'a Context<'a>,
        direct: &'a [Vec3],
        iteration: Iteration,
        known: Option<&Known>,
        report: &mut SolveReport,
    ) -> Self {
        let of_direct = kept.gather(context, direct, report);
        let scale = norm(&of_direct);
        let mut gathered = of_direct.clone();
        let method = match iteration {
            Iteration::GaussSeidel => Method::GaussSeidel,
            Iteration::Shooting => {
                let unshot = kept.spread(of_direct.clone());
                let weights = kept.reflecting_areas();
                Method::Shooting(Shooting { scale: norm(&unshot), unshot, weights })
            }
            Iteration::Neumann | Iteration::Krylov => {
                let (start, residual) = known.unwrap_or(&Known::default()).start(&of_direct);
                gathered.clone_from(&start);
                Method::Krylov(Gmres::new(start, residual))
            }
        };
        Self { kept, context, direct, of_direct, scale, gathered, method, known: Known::default() }
    }

    /// How much is left before the first sweep.
    pub(super) fn left(&self) -> f64 {
        match &self.method {
            Method::Krylov(gmres) => largest_ratio(gmres.residual(), self.scale),
            Method::GaussSeidel | Method::Shooting(_) => 1.0,
        }
    }

    /// One sweep. Returns how much is left: the residual by the first gather, in the band where that is largest. The
    /// error of the whole, relative to all gathered light, is about as large.
    pub(super) fn sweep(&mut self, report: &mut SolveReport) -> f64 {
        match &mut self.method {
            Method::GaussSeidel => self.gauss_seidel(report),
            Method::Shooting(_) => self.shoot(report),
            Method::Krylov(_) => self.krylov(report),
        }
    }

    /// What rays gathered of all light, so far.
    pub(super) fn gathered(&self) -> Vec<Vec3> {
        match &self.method {
            Method::Krylov(gmres) => gmres.solution(),
            Method::GaussSeidel | Method::Shooting(_) => self.gathered.clone(),
        }
    }

    /// The last gather, of all light: what rays gather of it, and what was found out of the rows.
    pub(super) fn end(mut self, report: &mut SolveReport) -> (Vec<Vec3>, Known) {
        let gathered = match &self.method {
            // The residual is the difference that it makes.
            Method::Krylov(gmres) => {
                let mut gathered = gmres.solution();
                add_scaled(&mut gathered, &gmres.rest(), DVec3::ONE);
                gathered
            }
            Method::GaussSeidel | Method::Shooting(_) => {
                let gathered = self.kept.gather(self.context, &self.field(self.gathered()), report);
                self.known.add(gathered.clone(), self.of_direct);
                gathered
            }
        };
        (gathered, self.known)
    }

    fn field(&self, gathered: Vec<Vec3>) -> Vec<Vec3> {
        let mut field = self.kept.spread(gathered);
        field.iter_mut().zip(self.direct).for_each(|(sum, direct)| *sum += *direct);
        field
    }

    fn gauss_seidel(&mut self, report: &mut SolveReport) -> f64 {
        let mut change = self.gathered.clone();
        for part in 0..PARTS {
            let field = self.field(self.gathered.clone());
            self.kept.gather_part(self.context, &field, (part, PARTS), &mut self.gathered, report);
        }
        add_scaled(&mut change, &self.gathered, -DVec3::ONE);
        largest_ratio(norm(&change), self.scale)
    }

    /// Shoots until half of the unshot power is left: in batches of the vertices that have most (Southwell's rule), each with its basis
    /// function: linear in the elements around it.
    fn shoot(&mut self, report: &mut SolveReport) -> f64 {
        let Method::Shooting(shooting) = &mut self.method else { return 0.0 };
        let goal = 0.5 * shooting.power();
        while shooting.power() > goal && !self.context.is_cancelled() {
            let batch = shooting.take_brightest();
            let arrived = self.kept.gather(self.context, &batch, report);
            add_scaled(&mut self.gathered, &arrived, DVec3::ONE);
            add_scaled(&mut shooting.unshot, &self.kept.spread(arrived), DVec3::ONE);
        }
        largest_ratio(norm(&shooting.unshot), shooting.scale)
    }

    fn krylov(&mut self, report: &mut SolveReport) -> f64 {
        let Method::Krylov(gmres) = &mut self.method else { return 0.0 };
        let (kept, context) = (self.kept, self.context);
        if gmres.is_full() {
            let start = gmres.solution();
            let mut residual = kept.gather(context, &kept.spread(start.clone()), report);
            add_scaled(&mut residual, &self.of_direct, DVec3::ONE);
            add_scaled(&mut residual, &start, -DVec3::ONE);
            *gmres = Gmres::new(start, residual);
        }
        gmres.step(
            |vector| {
                let mut product = kept.gather(context, &kept.spread(vector.to_vec()), report);
                product.iter_mut().zip(vector).for_each(|(product, value)| *product = *value - *product);
                product
            },
            &mut self.known,
        );
        largest_ratio(gmres.residual(), self.scale)
    }
}

impl Shooting<'_> {
    /// All unshot power, in all bands.
    fn power(&self) -> f64 {
        self.unshot.iter().zip(self.weights).map(|(unshot, weight)| power_of(*unshot, *weight)).sum()
    }

    /// What the vertices with most unshot power shoot; the others are 0.
    fn take_brightest(&mut self) -> Vec<Vec3> {
        let mut powers: Vec<(f64, usize)> =
            self.unshot.iter().zip(self.weights).map(|(unshot, weight)| power_of(*unshot, *weight)).zip(0..).collect();
        powers.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let goal = SHOT_AT_ONCE * powers.iter().map(|(power, _)| power).sum::<f64>();
        let mut batch = vec![Vec3::ZERO; self.unshot.len()];
        let mut taken = 0.0;
        for (power, vertex) in powers {
            if taken >= goal {
                break;
            }
            taken += power;
            batch[vertex] = std::mem::take(&mut self.unshot[vertex]);
        }
        batch
    }
}

fn power_of(unshot: Vec3, weight: DVec3) -> f64 {
    (unshot.as_dvec3().abs() * weight).element_sum()
}

fn largest_ratio(left: DVec3, scale: DVec3) -> f64 {
    (0..3).map(|band| ratio_or_zero(left[band], scale[band])).fold(0.0, f64::max)
}
