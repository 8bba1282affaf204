//! Rows of form factors between patches, what is wrong with them, and the radiosity equation by Gauss-Seidel.

use glam::{DVec3, Vec3};
use serde::Serialize;

/// Form factors F_ij from every patch to those that it sees, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormFactors {
    /// Area of each patch.
    pub areas: Vec<f32>,
    /// Patch and form factor, by row.
    pub rows: Vec<Vec<(u32, f32)>>,
}

/// How good form factors are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FormFactorQuality {
    /// Form factors that are not 0.
    pub entries: usize,
    /// The least sum of a row; in a closed scene each is 1.
    pub least_row_sum: f64,
    /// The mean sum of a row, by area.
    pub mean_row_sum: f64,
    /// The greatest sum of a row.
    pub greatest_row_sum: f64,
    /// Σ |A_i F_ij - A_j F_ji| / Σ (A_i F_ij + A_j F_ji): 0 if reciprocity holds.
    pub reciprocity_error: f64,
}

impl FormFactors {
    /// Measures row sums and reciprocity; none if it was stopped.
    pub fn quality(&self, is_cancelled: &dyn Fn() -> bool) -> Option<FormFactorQuality> {
        let sums: Vec<f64> = self.row_sums().collect();
        let area: f64 = self.areas.iter().map(|area| f64::from(*area)).sum();
        let weighted: f64 = sums.iter().zip(&self.areas).map(|(sum, area)| sum * f64::from(*area)).sum();
        let exchange = |from: usize, factor: f32| f64::from(self.areas[from]) * f64::from(factor);
        let (mut apart, mut all) = (0.0, 0.0);
        // Rows are in order, so each is walked once while the numbers that look for themselves in it grow.
        let mut reached = vec![0; self.rows.len()];
        for (from, row) in self.rows.iter().enumerate() {
            if is_cancelled() {
                return None;
            }
            for &(to, factor) in row {
                let (there_row, place) = (&self.rows[to as usize], &mut reached[to as usize]);
                while there_row.get(*place).is_some_and(|(patch, _)| (*patch as usize) < from) {
                    *place += 1;
                }
                let found = there_row.get(*place).filter(|(patch, _)| *patch as usize == from);
                let there = exchange(from, factor);
                let back = exchange(to as usize, found.map_or(0.0, |(_, factor)| *factor));
                // A pair that both see is met twice.
                let share = if back > 0.0 { 0.5 } else { 1.0 };
                apart += share * (there - back).abs();
                all += share * (there + back);
            }
        }
        Some(FormFactorQuality {
            entries: self.rows.iter().map(Vec::len).sum(),
            least_row_sum: sums.iter().copied().fold(f64::INFINITY, f64::min),
            mean_row_sum: crate::math::ratio_or_zero(weighted, area),
            greatest_row_sum: sums.iter().copied().fold(0.0, f64::max),
            reciprocity_error: crate::math::ratio_or_zero(apart, all),
        })
    }

    fn row_sums(&self) -> impl Iterator<Item = f64> + '_ {
        self.rows.iter().map(|row| row.iter().fold(0.0, |sum, (_, factor)| sum + f64::from(*factor)))
    }

    /// F_ij; 0 for patches that are not seen. Rows are in order.
    pub fn factor(&self, from: u32, to: u32) -> f32 {
        let row = &self.rows[from as usize];
        row.binary_search_by_key(&to, |(patch, _)| *patch).map_or(0.0, |place| row[place].1)
    }

    /// Irradiance that the radiosity of all patches gives to one.
    pub fn gathered(&self, patch: usize, radiosity: &[Vec3]) -> Vec3 {
        self.rows[patch].iter().map(|(from, factor)| *factor * radiosity[*from as usize]).sum()
    }
}

/// Radiosity that grows to so many times what it began with has no end: of reflectances up to 0.999 it is at most a thousand.
const MOST_GROWTH: f64 = 1e4;

/// Patches that a sweep passes between two looks at whether it is cancelled.
const PATCHES_PER_LOOK: usize = 64;

/// Solves B = M + ρ (E0 + F B) by Gauss-Seidel sweeps: each patch gathers from the newest values of all others. After each
/// sweep `watch` gets its number, the radiosity and the largest change of a band relative to the mean; it stops the sweeps
/// by returning false. Within one `is_cancelled` ends it, with what there is.
///
/// # Errors
/// One line, if the sweeps diverge: form factors so wrong that their rows sum to far more than 1 make light out of nothing.
pub fn gauss_seidel(
    factors: &FormFactors,
    emission: &[Vec3],
    reflectance: &[Vec3],
    direct: &[Vec3],
    is_cancelled: &dyn Fn() -> bool,
    mut watch: impl FnMut(u32, &[Vec3], f64) -> bool,
) -> Result<Vec<Vec3>, String> {
    let mean_of = |radiosity: &[Vec3]| {
        let sum: DVec3 = radiosity.iter().map(|value| value.as_dvec3()).sum();
        sum.element_sum() / (3 * radiosity.len().max(1)) as f64
    };
    let mut radiosity: Vec<Vec3> =
        emission.iter().zip(reflectance).zip(direct).map(|((m, rho), e)| *m + *rho * *e).collect();
    let first_mean = mean_of(&radiosity);
    for sweep in 1.. {
        let mut change = 0.0_f64;
        for patch in 0..radiosity.len() {
            if patch.is_multiple_of(PATCHES_PER_LOOK) && is_cancelled() {
                return Ok(radiosity);
            }
            let irradiance = direct[patch] + factors.gathered(patch, &radiosity);
            let value = emission[patch] + reflectance[patch] * irradiance;
            change = change.max(f64::from((value - radiosity[patch]).abs().max_element()));
            radiosity[patch] = value;
        }
        let mean = mean_of(&radiosity);
        if mean > MOST_GROWTH * first_mean {
            return Err(format!(
                "the sweeps diverge: the form factors of a patch sum to up to {:.2} instead of 1; cut finer, or take better \
                 ones (with --by rays, --kernel polygon)",
                factors.row_sums().fold(0.0, f64::max)
            ));
        }
        if !watch(sweep, &radiosity, crate::math::ratio_or_zero(change, mean)) {
            break;
        }
    }
    Ok(radiosity)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    /// Two patches of areas 1 and 2 that see nothing but each other: F_01 = 1, F_10 = 1/2 and the rest of patch 1 escapes.
    fn pair() -> FormFactors {
        FormFactors { areas: vec![1.0, 2.0], rows: vec![vec![(1, 1.0)], vec![(0, 0.5)]] }
    }

    #[test]
    fn row_sums_and_reciprocity_are_as_worked_out_by_hand() {
        let quality = pair().quality(&|| false).unwrap();
        assert_eq!((quality.least_row_sum, quality.greatest_row_sum, quality.entries), (0.5, 1.0, 2));
        assert!((quality.mean_row_sum - 2.0 / 3.0).abs() < 1e-12 && quality.reciprocity_error == 0.0);
        let wrong = FormFactors { rows: vec![vec![(1, 1.0)], vec![(0, 0.25)]], ..pair() };
        assert!((wrong.quality(&|| false).unwrap().reciprocity_error - 1.0 / 3.0).abs() < 1e-12); // |1 - 0.5| / 1.5
        let one_way = FormFactors { rows: vec![vec![(1, 1.0)], vec![]], ..pair() };
        assert_eq!(one_way.quality(&|| false).unwrap().reciprocity_error, 1.0);
    }

    #[test]
    fn gauss_seidel_solves_two_patches_exactly() {
        // B0 = 1 + 0.5 B1, B1 = 0.8 · 0.5 B0: B0 = 1 / (1 - 0.2) = 1.25, B1 = 0.5.
        let [emission, reflectance] = [[Vec3::ONE, Vec3::ZERO], [Vec3::splat(0.5), Vec3::splat(0.8)]];
        let mut sweeps = 0;
        let found = gauss_seidel(&pair(), &emission, &reflectance, &[Vec3::ZERO; 2], &|| false, |sweep, _, change| {
            sweeps = sweep;
            change > 1e-7 && sweep < 50
        })
        .unwrap();
        assert!(found[0].abs_diff_eq(Vec3::splat(1.25), 1e-6) && found[1].abs_diff_eq(Vec3::splat(0.5), 1e-6));
        assert!((5..20).contains(&sweeps), "a fifth is left after each sweep: {sweeps}");
    }

    #[test]
    fn form_factors_that_make_light_out_of_nothing_are_an_error_and_no_infinity() {
        // Each sweep makes it 0.8² · 2 · 2 = 2.56 times as much.
        let wrong = FormFactors { areas: vec![1.0; 2], rows: vec![vec![(1, 2.0)], vec![(0, 2.0)]] };
        let light = [Vec3::ONE; 2];
        let problem = gauss_seidel(&wrong, &light, &[Vec3::splat(0.8); 2], &light, &|| false, |_, _, _| true);
        assert!(problem.unwrap_err().contains("sum to up to 2.00 instead of 1"));
    }

    #[test]
    fn a_cancelled_sweep_keeps_what_the_ones_before_it_found() {
        let light = [Vec3::ONE; 2];
        let found = gauss_seidel(&pair(), &light, &[Vec3::splat(0.5); 2], &light, &|| true, |_, _, _| true);
        assert_eq!(found.unwrap(), [Vec3::splat(1.5); 2]); // M + ρ E0
    }
}
