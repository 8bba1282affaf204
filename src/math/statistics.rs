//! Running mean and standard error of RGB samples.

use glam::DVec3;

/// Mean and variance of a stream of values, one pass, stable (Welford 1962).
#[derive(Clone, Copy, Debug, Default)]
pub struct RunningMean {
    count: u64,
    mean: DVec3,
    squared_deviations: DVec3,
}

impl RunningMean {
    /// Adds one value.
    pub fn add(&mut self, value: DVec3) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squared_deviations += before * (value - self.mean);
    }

    /// The mean so far; 0 of no values.
    pub fn mean(&self) -> DVec3 {
        self.mean
    }

    /// The standard error of the mean; 0 of fewer than two values.
    pub fn standard_error(&self) -> DVec3 {
        if self.count < 2 {
            return DVec3::ZERO;
        }
        let count = self.count as f64;
        (self.squared_deviations / (count * (count - 1.0))).map(f64::sqrt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_standard_error_of_one_to_four_are_known() {
        let mut running = RunningMean::default();
        for value in 1..=4 {
            running.add(DVec3::splat(f64::from(value)));
        }
        assert!((running.mean().x - 2.5).abs() < 1e-12);
        // Sample variance 5/3, over n = 4: sqrt(5/12).
        assert!((running.standard_error().x - (5.0_f64 / 12.0).sqrt()).abs() < 1e-12);
    }
}
