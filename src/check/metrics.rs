//! How far a field is from the truth (design 7.1, 7.2), and whether two estimates agree within their noise.
//!
//! Each error is taken over all three bands at once and given relative to the mean of the true **total**, so that the
//! errors of the direct and the indirect part can be weighed against each other.

use glam::DVec3;
use serde::Serialize;

use crate::math::ratio_or_zero;

/// Lit points: the mean of the bands lies between these multiples of the mean over all points.
const LIT_RANGE: std::ops::RangeInclusive<f64> = 0.01..=10.0;

/// How one quantity differs from its truth over a set of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// `sqrt(mean |E - E_truth|²) / mean(total of the truth)`.
    pub relative_l2: f64,
    /// `(mean(E) - mean(E_truth)) / mean(total of the truth)`; for the total: ratio of the means - 1.
    pub bias: f64,
    /// The largest `|E - E_truth|` of any band, relative to the same mean.
    pub largest: f64,
}

/// The errors over one set of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PartErrors {
    /// How many points.
    pub point_count: usize,
    /// Mean of the true total over the points and bands [W/m²].
    pub mean_truth: f64,
    /// Direct and indirect light together.
    pub total: ErrorSummary,
    /// Bounce 0 alone.
    pub direct: ErrorSummary,
    /// All other bounces.
    pub indirect: ErrorSummary,
}

/// The field error of a solution (7.1), or its vertex error (7.2): it depends on where the points lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FieldErrors {
    /// Over all points.
    pub all: PartErrors,
    /// Over the lit points: without buried and unlit ones, and without the few beside an emitter.
    pub lit: PartErrors,
}

/// Irradiance at points [W/m²], three bands each.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Bounce 0.
    pub direct: &'a [DVec3],
    /// All bounces.
    pub total: &'a [DVec3],
}

/// The errors of `estimate` against `truth`, point by point. All four slices must have one length.
pub fn field_errors(estimate: Field, truth: Field) -> FieldErrors {
    let lit = lit_points(truth.total);
    let all: Vec<usize> = (0..truth.total.len()).collect();
    FieldErrors { all: part_errors(estimate, truth, &all), lit: part_errors(estimate, truth, &lit) }
}

/// The errors of each bounce alone, relative to the mean of the true total; of the bounces that both have.
pub fn bounce_errors(estimate: &[Vec<DVec3>], truth: &[Vec<DVec3>]) -> Vec<ErrorSummary> {
    let mean_of_total = truth.iter().map(|bounce| mean_of_bands(bounce.iter().copied())).sum();
    estimate.iter().zip(truth).map(|(estimate, truth)| summary(pairs(estimate, truth), mean_of_total)).collect()
}

/// Relative L2 difference of two fields: `sqrt(mean |a - b|²) / mean(b)`.
pub fn relative_l2(estimate: &[DVec3], truth: &[DVec3]) -> f64 {
    summary(pairs(estimate, truth), mean_of_bands(truth.iter().copied())).relative_l2
}

/// The points where the truth's mean of the bands lies between 1 % and 10 times the mean of all.
pub fn lit_points(truth: &[DVec3]) -> Vec<usize> {
    let mean = mean_of_bands(truth.iter().copied());
    let is_lit = |value: &DVec3| mean > 0.0 && LIT_RANGE.contains(&(value.element_sum() / 3.0 / mean));
    (0..truth.len()).filter(|&index| is_lit(&truth[index])).collect()
}

fn part_errors(estimate: Field, truth: Field, points: &[usize]) -> PartErrors {
    let at = |field: Field, index: usize| (field.direct[index], field.total[index]);
    let mean_truth = mean_of_bands(points.iter().map(|&index| truth.total[index]));
    let errors = |part: fn((DVec3, DVec3)) -> DVec3| {
        let pairs = points.iter().map(|&index| (part(at(estimate, index)), part(at(truth, index))));
        summary(pairs, mean_truth)
    };
    PartErrors {
        point_count: points.len(),
        mean_truth,
        total: errors(|(_, total)| total),
        direct: errors(|(direct, _)| direct),
        indirect: errors(|(direct, total)| total - direct),
    }
}

fn summary(pairs: impl Iterator<Item = (DVec3, DVec3)>, scale: f64) -> ErrorSummary {
    let (mut squares, mut sum, mut largest, mut count) = (0.0, 0.0, 0.0_f64, 0.0);
    for (estimate, truth) in pairs {
        let difference = estimate - truth;
        squares += difference.length_squared();
        sum += difference.element_sum();
        largest = largest.max(difference.abs().max_element());
        count += 3.0;
    }
    ErrorSummary {
        relative_l2: ratio_or_zero(ratio_or_zero(squares, count).sqrt(), scale),
        bias: ratio_or_zero(ratio_or_zero(sum, count), scale),
        largest: ratio_or_zero(largest, scale),
    }
}

fn pairs<'a>(estimate: &'a [DVec3], truth: &'a [DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + 'a {
    estimate.iter().copied().zip(truth.iter().copied())
}

fn mean_of_bands(values: impl Iterator<Item = DVec3>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value.element_sum(), count + 3.0));
    ratio_or_zero(sum, count)
}

/// An estimate at each point with its standard error [W/m²].
#[derive(Clone, Copy, Debug)]
pub struct Estimates<'a> {
    /// The values.
    pub values: &'a [DVec3],
    /// The standard error of each value.
    pub standard_errors: &'a [DVec3],
}

/// Whether two independent estimates of one field agree within their noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Agreement {
    /// Difference of the means over all points, per band, in its own standard errors.
    pub mean_difference: [f64; 3],
    /// The largest difference at one point and band, in combined standard errors.
    pub largest: f64,
    /// The point of the largest difference.
    pub largest_at: usize,
    /// Mean of the squared differences in combined standard errors: 1 if both errors are right.
    pub mean_square: f64,
}

/// Compares two estimates of one field, point by point. `floor` [W/m²] is added to each combined standard error: the
/// rounding of the files, and the light of paths so rare that neither estimate knows its own error.
pub fn agreement(first: Estimates, second: Estimates, floor: f64) -> Agreement {
    let mut result = Agreement::default();
    let (mut sum, mut variance, mut squares) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for (index, (a, b)) in pairs(first.values, second.values).enumerate() {
        let (error_a, error_b) = (first.standard_errors[index], second.standard_errors[index]);
        let point_variance = error_a * error_a + error_b * error_b;
        let normalised = (a - b) / (point_variance.map(f64::sqrt) + floor);
        sum += a - b;
        variance += point_variance;
        squares += normalised.length_squared();
        if normalised.abs().max_element() > result.largest {
            (result.largest, result.largest_at) = (normalised.abs().max_element(), index);
        }
    }
    let count = first.values.len() as f64;
    result.mean_difference = (sum / (variance.map(f64::sqrt) + floor)).to_array();
    result.mean_square = ratio_or_zero(squares, 3.0 * count);
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_small_field_are_as_worked_out_by_hand() {
        let truth = [DVec3::splat(1.0), DVec3::splat(3.0)];
        let estimate = [DVec3::splat(1.5), DVec3::splat(2.5)];
        let half = [DVec3::splat(0.5), DVec3::splat(1.0)];
        let errors = field_errors(Field { direct: &half, total: &estimate }, Field { direct: &half, total: &truth });
        assert_eq!(errors.all.mean_truth, 2.0);
        assert_eq!(errors.all.total, ErrorSummary { relative_l2: 0.25, bias: 0.0, largest: 0.25 });
        assert_eq!(errors.all.direct, ErrorSummary::default());
        assert_eq!(errors.all.indirect, errors.all.total);
        let brighter = truth.map(|value| 1.1 * value);
        let bias = field_errors(Field { direct: &half, total: &brighter }, Field { direct: &half, total: &truth });
        assert!((bias.all.total.bias - 0.1).abs() < 1e-12);
        assert!((relative_l2(&estimate, &truth) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn the_error_of_a_bounce_is_weighed_by_the_total() {
        let constant = |value: f64| vec![DVec3::splat(value); 2];
        let errors = bounce_errors(&[constant(3.0), constant(1.5), constant(9.0)], &[constant(3.0), constant(1.0)]);
        assert_eq!(
            errors,
            [
                ErrorSummary::default(),
                ErrorSummary { relative_l2: 0.125, bias: 0.125, largest: 0.125 }, // 0.5 of 3 + 1
            ]
        );
    }

    #[test]
    fn one_band_counts_a_third() {
        // sqrt(3² / 3 bands) over a mean of 1.
        assert!((relative_l2(&[DVec3::new(4.0, 1.0, 1.0)], &[DVec3::ONE]) - 3.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn lit_points_leave_out_the_dark_and_the_glaring() {
        let mut truth = vec![DVec3::ONE; 98];
        truth.push(DVec3::splat(1e-3));
        truth.push(DVec3::splat(100.0));
        assert_eq!(lit_points(&truth), (0..98).collect::<Vec<_>>());
        assert!(lit_points(&[DVec3::ZERO; 3]).is_empty());
    }

    #[test]
    fn no_points_and_no_light_give_zeros_not_nan() {
        let nothing = Field { direct: &[], total: &[] };
        assert_eq!(field_errors(nothing, nothing), FieldErrors::default());
        let dark = Field { direct: &[DVec3::ZERO], total: &[DVec3::ZERO] };
        assert_eq!(field_errors(dark, dark).all.total, ErrorSummary::default());
    }

    #[test]
    fn agreement_counts_in_combined_standard_errors() {
        let (a, b) = ([DVec3::splat(1.0), DVec3::splat(1.0)], [DVec3::splat(1.0), DVec3::splat(2.0)]);
        let errors = [DVec3::splat(0.3), DVec3::splat(0.3)];
        let others = [DVec3::splat(0.4), DVec3::splat(0.4)]; // combined: 0.5
        let found = agreement(
            Estimates { values: &a, standard_errors: &errors },
            Estimates { values: &b, standard_errors: &others },
            0.0,
        );
        assert!((found.largest - 2.0).abs() < 1e-12 && found.largest_at == 1);
        assert!((found.mean_difference[0] + 2.0_f64.sqrt()).abs() < 1e-12); // -1 over sqrt(0.25 + 0.25)
        assert!((found.mean_square - 2.0).abs() < 1e-12);
    }
}
