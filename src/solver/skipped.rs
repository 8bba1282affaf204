//! What a solve did not do, and what that would have taken.

use serde::{Deserialize, Serialize};

use super::solve::SolveReport;
use crate::transport::visible_light::ShadowRays;

/// Processor seconds, of all threads together, that skipped work would have taken by what the same work took in this very
/// solve: estimates. None where nothing of the kind was done, so that nothing is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SecondsSaved {
    /// Of shadow rays that needed no tracing, without what it took to know that.
    pub shadow_rays: Option<f64>,
    /// Of gather rays that needed no tracing.
    pub gather_rays: Option<f64>,
    /// Of gather rays that bounces took from kept rows.
    pub gather_rays_reused: Option<f64>,
    /// Of vertices at which indirect light was interpolated, if they sent as many rays as those that gathered.
    pub interpolated_vertices: Option<f64>,
}

impl SecondsSaved {
    pub(super) fn of(report: &SolveReport) -> Self {
        let saved = |skipped: u64, seconds: f64, done: u64| {
            (done > 0 && seconds > 0.0).then(|| seconds / done as f64 * skipped as f64)
        };
        let ShadowRays { timed, timed_nanoseconds, .. } = report.shadow_rays_by_sight;
        let by_gather_ray = |skipped| saved(skipped, report.gather_thread_seconds, report.gather_rays);
        Self {
            shadow_rays: saved(report.shadow_rays_skipped, 1e-9 * timed_nanoseconds as f64, timed),
            gather_rays: by_gather_ray(report.gather_rays_skipped),
            gather_rays_reused: by_gather_ray(report.gather_rays_reused),
            interpolated_vertices: saved(
                report.interpolated_vertices,
                report.gather_thread_seconds,
                report.gathered_vertices,
            ),
        }
    }
}

/// An estimate as the end of a line; nothing where there is none.
fn about(seconds: Option<f64>) -> String {
    match seconds {
        None => String::new(),
        Some(seconds) if seconds < 0.01 => String::from("; less than 0.01 s of processor time"),
        Some(seconds) if seconds < 10.0 => format!("; about {seconds:.2} s of processor time"),
        Some(seconds) => format!("; about {seconds:.0} s of processor time"),
    }
}

impl SolveReport {
    /// What was not done, a line for each kind that there is, with the time that it would have taken where that is known.
    pub fn skipped(&self) -> Vec<String> {
        let ShadowRays { below_horizon, hidden, partly_seen, fully_seen, .. } = self.shadow_rays_by_sight;
        let of = |count: u64| 100.0 * count as f64 / self.shadow_rays_skipped.max(1) as f64;
        let stages: Vec<String> = self.stages_skipped.iter().map(ToString::to_string).collect();
        let saved = self.seconds_saved;
        let lines = [
            (
                self.shadow_rays_skipped,
                format!(
                    "{} shadow rays: their light is fully seen ({:.0} %), seen in a known part ({:.0} %), hidden ({:.0} %), \
                     below the horizon ({:.0} %){}",
                    self.shadow_rays_skipped,
                    of(fully_seen),
                    of(partly_seen),
                    of(hidden),
                    of(below_horizon),
                    about(saved.shadow_rays)
                ),
            ),
            (
                self.gather_rays_skipped,
                format!("{} gather rays into their own surface{}", self.gather_rays_skipped, about(saved.gather_rays)),
            ),
            (
                self.gather_rays_reused,
                format!(
                    "{} gather rays again: kept rows were summed{}",
                    self.gather_rays_reused,
                    about(saved.gather_rays_reused)
                ),
            ),
            (
                self.interpolated_vertices,
                format!(
                    "gathering at {} vertices: the smooth field says it{}",
                    self.interpolated_vertices,
                    about(saved.interpolated_vertices)
                ),
            ),
            (u64::from(self.bounces_skipped), format!("{} bounces: nothing reflects", self.bounces_skipped)),
            (self.textures_untouched, format!("{} textures that no gather ray met", self.textures_untouched)),
            (stages.len() as u64, format!("stages: {}", stages.join(", "))),
        ];
        lines.into_iter().filter(|(count, _)| *count > 0).map(|(_, line)| line).collect()
    }
}
