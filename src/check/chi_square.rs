//! Pearson's chi-square test of a sampler against its density.

use glam::{UVec2, Vec2};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Fewer expected samples than this and a cell is pooled with others: the statistic is chi-square distributed only
/// where cells are well filled (Cochran 1954).
const SMALLEST_EXPECTATION: f64 = 5.0;

/// Each cell's density is the mean over this many points squared.
const POINTS_A_CELL_SIDE: u32 = 8;

/// An equal-area map between a domain and the unit square, which is then cut into cells.
pub struct Chart<'a, T> {
    /// From the domain to [0, 1]². Must be worked out apart from the sampler under test.
    pub to_square: Box<dyn Fn(T) -> Vec2 + 'a>,
    /// From [0, 1]² to the domain.
    pub from_square: Box<dyn Fn(Vec2) -> T + 'a>,
    /// Measure of the whole domain, in the density's own measure (area, solid angle).
    pub measure: f64,
}

/// How one test is done.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquareSettings {
    /// Columns and rows of cells.
    pub cells: UVec2,
    /// Chance that one of all the tests rejects a right sampler.
    pub significance: f64,
    /// How many tests share that chance (Šidák 1967).
    pub test_count: u32,
}

/// What a test found.
#[derive(Clone, Debug)]
pub struct ChiSquareReport {
    /// Why the sampler is rejected, in words; `None` where it passes.
    pub rejection: Option<String>,
    /// The chance that a right sampler differs from its density by this much or more.
    pub p_value: f64,
    /// Samples counted in each cell, row by row.
    pub observed: Vec<u64>,
    /// Samples expected in each cell, row by row.
    pub expected: Vec<f64>,
}

/// Tests whether `samples` follow `pdf`. Samples outside the chart's square count as samples of zero density.
pub fn chi_square<T: Copy>(
    settings: &ChiSquareSettings,
    chart: &Chart<T>,
    samples: impl Iterator<Item = T>,
    pdf: impl Fn(T) -> f32,
) -> ChiSquareReport {
    let (observed, outside) = count_samples(settings.cells, chart, samples);
    let sample_count = observed.iter().sum::<u64>() + outside;
    let probabilities = cell_probabilities(settings.cells, chart, pdf);
    let expected: Vec<f64> = probabilities.iter().map(|probability| probability * sample_count as f64).collect();
    let report = |rejection: Option<String>, p_value| ChiSquareReport {
        rejection,
        p_value,
        observed: observed.clone(),
        expected: expected.clone(),
    };
    if outside > 0 {
        return report(Some(format!("{outside} samples outside the domain")), 0.0);
    }
    if let Some(cell) = (0..observed.len()).find(|&cell| expected[cell] <= 0.0 && observed[cell] > 0) {
        return report(Some(format!("{} samples in cell {cell}, where the density is 0", observed[cell])), 0.0);
    }
    let total: f64 = probabilities.iter().sum();
    if (total - 1.0).abs() > 0.01 {
        return report(Some(format!("the density integrates to {total:.4}, not to 1")), 0.0);
    }
    let pairs = pooled(&observed, &expected);
    let statistic: f64 =
        pairs.iter().map(|(observed, expected)| (observed - expected) * (observed - expected) / expected).sum();
    let Ok(distribution) = ChiSquared::new(pairs.len() as f64 - 1.0) else {
        return report(Some(String::from("fewer than two cells expect a sample: take more samples")), 0.0);
    };
    let p_value = distribution.sf(statistic);
    let threshold = 1.0 - (1.0 - settings.significance).powf(1.0 / f64::from(settings.test_count.max(1)));
    let rejection = (p_value.is_nan() || p_value < threshold).then(|| {
        format!("chi-square {statistic:.1} over {} cells: p-value {p_value:.2e} below {threshold:.2e}", pairs.len())
    });
    report(rejection, p_value)
}

/// `count` independent uniform points in [0, 1)², the same for the same seed.
pub fn random_points(seed: u64, count: u32) -> impl Iterator<Item = Vec2> + Clone {
    let mut generator = SmallRng::seed_from_u64(seed);
    (0..count).map(move |_| Vec2::new(generator.random(), generator.random()))
}

/// Samples in each cell, and samples in none.
fn count_samples<T: Copy>(cells: UVec2, chart: &Chart<T>, samples: impl Iterator<Item = T>) -> (Vec<u64>, u64) {
    let mut observed = vec![0; (cells.x * cells.y) as usize];
    let mut outside = 0;
    for sample in samples {
        let place = (chart.to_square)(sample);
        if place.cmpge(Vec2::ZERO).all() && place.cmple(Vec2::ONE).all() {
            let cell = (place * cells.as_vec2()).as_uvec2().min(cells - 1);
            observed[(cell.y * cells.x + cell.x) as usize] += 1;
        } else {
            outside += 1; // NaN comes here as well
        }
    }
    (observed, outside)
}

/// The density's integral over each cell, by the midpoint rule.
fn cell_probabilities<T>(cells: UVec2, chart: &Chart<T>, pdf: impl Fn(T) -> f32) -> Vec<f64> {
    let fine = cells * POINTS_A_CELL_SIDE;
    let weight = chart.measure / (f64::from(fine.x) * f64::from(fine.y));
    let mut probabilities = vec![0.0; (cells.x * cells.y) as usize];
    for y in 0..fine.y {
        for x in 0..fine.x {
            let place = (UVec2::new(x, y).as_vec2() + 0.5) / fine.as_vec2();
            let cell = (y / POINTS_A_CELL_SIDE) * cells.x + x / POINTS_A_CELL_SIDE;
            probabilities[cell as usize] += weight * f64::from(pdf((chart.from_square)(place)));
        }
    }
    probabilities
}

/// (observed, expected) of the cells that expect anything, the least expected ones pooled until each pool is large
/// enough.
fn pooled(observed: &[u64], expected: &[f64]) -> Vec<(f64, f64)> {
    let mut order: Vec<usize> = (0..expected.len()).filter(|&cell| expected[cell] > 0.0).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let mut pairs: Vec<(f64, f64)> = Vec::with_capacity(order.len());
    let mut pool = (0.0, 0.0);
    for cell in order {
        pool = (pool.0 + observed[cell] as f64, pool.1 + expected[cell]);
        if pool.1 >= SMALLEST_EXPECTATION {
            pairs.push(std::mem::take(&mut pool));
        }
    }
    if let Some(last) = pairs.last_mut() {
        *last = (last.0 + pool.0, last.1 + pool.1);
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: ChiSquareSettings =
        ChiSquareSettings { cells: UVec2::new(10, 10), significance: 0.01, test_count: 1 };

    fn square() -> Chart<'static, Vec2> {
        Chart { to_square: Box::new(|point| point), from_square: Box::new(|point| point), measure: 1.0 }
    }

    #[test]
    fn p_values_of_right_samplers_are_spread_evenly() {
        let settings = ChiSquareSettings { cells: UVec2::new(5, 5), ..SETTINGS };
        let p_values: Vec<f64> =
            (0..200).map(|seed| chi_square(&settings, &square(), random_points(seed, 1000), |_| 1.0).p_value).collect();
        // Uniform in [0, 1] if the statistic is right: mean 1/2 with standard error 0.29/sqrt(200) = 0.02.
        assert!((p_values.iter().sum::<f64>() / 200.0 - 0.5).abs() < 0.07);
        assert!(p_values.iter().filter(|&&p_value| p_value < 0.1).count().abs_diff(20) < 14);
    }

    #[test]
    fn cells_that_expect_too_few_are_pooled_and_none_is_lost() {
        let pairs = pooled(&[1, 2, 3, 400, 0], &[2.0, 2.0, 2.0, 400.0, 0.0]);
        assert_eq!(pairs, [(6.0, 6.0), (400.0, 400.0)]);
        let last_is_small = pooled(&[7, 3], &[1.0, 9.0]);
        assert_eq!(last_is_small, [(10.0, 10.0)]);
    }

    #[test]
    fn a_sample_where_the_density_is_zero_rejects_at_once() {
        let left_half = |point: Vec2| if point.x < 0.5 { 2.0 } else { 0.0 };
        let samples = random_points(1, 1000).map(|point| point * Vec2::new(0.5, 1.0));
        let right = chi_square(&SETTINGS, &square(), samples.clone(), left_half);
        assert_eq!(right.rejection, None);
        let one_astray = samples.chain([Vec2::new(0.75, 0.5)]);
        let wrong = chi_square(&SETTINGS, &square(), one_astray, left_half);
        assert!(wrong.rejection.is_some_and(|reason| reason.contains("the density is 0")));
    }

    #[test]
    fn samples_that_are_not_numbers_or_none_at_all_are_rejected() {
        let broken = random_points(1, 1000).map(|point| (point - 0.1).sqrt());
        assert!(chi_square(&SETTINGS, &square(), broken, |_| 1.0).rejection.is_some());
        assert!(chi_square(&SETTINGS, &square(), std::iter::empty(), |_| 1.0).rejection.is_some());
    }
}
