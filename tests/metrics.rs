//! The error metrics on fields whose errors are known beforehand.

mod common;

use glam::DVec3;
use proptest::prelude::*;
use radiosity::check::{
    metrics::{Estimates, Field, agreement, field_errors, lit_points, relative_l2},
    truth_file,
};

/// Total irradiance of positive values, of three bands, at 2 to 50 points.
fn fields() -> impl Strategy<Value = Vec<DVec3>> {
    proptest::collection::vec(proptest::array::uniform3(0.01..10.0_f64).prop_map(DVec3::from_array), 2..50)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_field_scaled_by_a_factor_has_that_bias_whatever_the_unit(truth in fields(), factor in 0.5..2.0_f64) {
        let estimate: Vec<DVec3> = truth.iter().map(|value| factor * value).collect();
        let half = |values: &[DVec3]| values.iter().map(|value| 0.5 * value).collect::<Vec<_>>();
        let (direct, true_direct) = (half(&estimate), half(&truth));
        let errors = |unit: f64| {
            let scaled = |values: &[DVec3]| values.iter().map(|value| unit * value).collect::<Vec<_>>();
            field_errors(
                Field { direct: &scaled(&direct), total: &scaled(&estimate) },
                Field { direct: &scaled(&true_direct), total: &scaled(&truth) },
            )
        };
        let found = errors(1.0).all;
        prop_assert!((found.total.bias - (factor - 1.0)).abs() < 1e-9);
        // Half of the light is direct, so each part has half of the error.
        prop_assert!((found.direct.relative_l2 - 0.5 * found.total.relative_l2).abs() < 1e-9);
        prop_assert!((found.indirect.relative_l2 - 0.5 * found.total.relative_l2).abs() < 1e-9);
        let other_unit = errors(1e-3).all;
        prop_assert!((other_unit.total.relative_l2 - found.total.relative_l2).abs() < 1e-9);
    }

    #[test]
    fn the_error_of_a_constant_offset_is_the_offset_over_the_mean(truth in fields(), offset in 0.001..5.0_f64) {
        let estimate: Vec<DVec3> = truth.iter().map(|value| value + offset).collect();
        let mean = truth.iter().map(|value| value.element_sum()).sum::<f64>() / (3.0 * truth.len() as f64);
        prop_assert!((relative_l2(&estimate, &truth) - offset / mean).abs() < 1e-9);
    }
}

#[test]
fn dark_and_glaring_points_count_in_all_points_alone() {
    let mut truth = vec![DVec3::ONE; 98];
    truth.extend([DVec3::ZERO, DVec3::splat(50.0)]);
    let mut estimate = truth.clone();
    estimate[98] = DVec3::ONE;
    estimate[99] = DVec3::splat(40.0);
    let direct = vec![DVec3::ZERO; 100];
    let errors = field_errors(Field { direct: &direct, total: &estimate }, Field { direct: &direct, total: &truth });
    assert_eq!((errors.all.point_count, errors.lit.point_count), (100, 98));
    assert_eq!(errors.lit.total.relative_l2, 0.0);
    // sqrt((1² + 10²) / 100 points) over a mean of 1.48.
    assert!((errors.all.total.relative_l2 - 1.01_f64.sqrt() / 1.48).abs() < 1e-12);
    assert!((errors.all.total.largest - 10.0 / 1.48).abs() < 1e-12);
}

#[test]
fn shared_truths_are_read_and_differ_from_themselves_by_nothing() {
    // Points of each file, as its README counts them.
    for (name, count) in [("cornell", 4096), ("cornell-original", 2048), ("sponza", 2048), ("staircase", 2048)] {
        let Some(path) = common::shared(&format!("truth/{name}.csv")) else {
            return;
        };
        let file = truth_file::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let values = file.values.unwrap_or_default();
        assert_eq!((file.points.len(), values.len()), (count, count), "{name}");
        let total: Vec<DVec3> = values.iter().map(|value| value.total).collect();
        assert!(values.iter().all(|value| {
            let parts = value.direct + value.bounce1 + value.bounce2;
            parts.cmple(value.total * 1.0001 + 1e-6).all()
        }));
        let lit = lit_points(&total).len();
        assert!(lit > count / 3 && lit < count, "{name}: {lit}");
        let noise: Vec<DVec3> = values.iter().map(|value| value.standard_error).collect();
        let estimates = Estimates { values: &total, standard_errors: &noise };
        assert_eq!(agreement(estimates, estimates, 1e-9).largest, 0.0);
    }
}
