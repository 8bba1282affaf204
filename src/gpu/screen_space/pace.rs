//! A frame in submissions: each step in one, or in several where it takes long, because whoever else draws on the device
//! has to wait. Where they are cut changes no bit of the picture.

use std::{collections::VecDeque, ops::Range, time::Duration};

use super::{
    g_buffer::Layer,
    passes::{Dispatch, Pass},
};

/// What a submission should take, if nothing else is asked for.
pub const SUBMISSION_TIME: Duration = Duration::from_millis(40);

/// Units of a dispatch, at most: WebGPU's largest number of workgroups, of 64.
const MOST_UNITS: u32 = 65_535 * 64;

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    /// Faces of shadow maps.
    Shadows,
    /// Triangles of a layer.
    Surface(Layer),
    /// Pixels.
    Pixels(Dispatch),
}

/// A part of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Step {
    pub(super) work: Work,
    /// Faces, triangles or pixels.
    pub(super) units: Range<u32>,
}

impl Step {
    pub(super) fn new(work: Work, units: u32) -> Self {
        Self { work, units: 0..units }
    }

    pub(super) fn pass(&self) -> Pass {
        match self.work {
            Work::Shadows => Pass::Shadows,
            Work::Surface(Layer::First) => Pass::FirstLayer,
            Work::Surface(Layer::Around | Layer::BehindAround) => Pass::Around,
            Work::Surface(_) => Pass::SecondLayer,
            Work::Pixels(Dispatch::Light) => Pass::Light,
            Work::Pixels(Dispatch::Gather(_)) => Pass::Gather,
            Work::Pixels(Dispatch::Obscure) => Pass::Obscure,
            Work::Pixels(Dispatch::Across(_) | Dispatch::Down(_)) => Pass::Filter,
            Work::Pixels(Dispatch::Show(_)) => Pass::Show,
        }
    }

    /// Parts are multiples of so many units.
    fn grain(&self) -> u32 {
        match self.work {
            Work::Shadows => 1,
            Work::Surface(_) => 1024,
            Work::Pixels(_) => 64,
        }
    }
}

/// Seconds a unit of each pass takes, by the last submissions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pace {
    pub(super) submission_time: Duration,
    per_unit: [f64; Pass::NAMES.len()],
}

impl Pace {
    /// A cautious guess, before anything was measured. `scene_triangles` are drawn for each face of a shadow map.
    pub(super) fn new(scene_triangles: u32) -> Self {
        let per_face = 2e-7 * f64::from(scene_triangles) + 1e-3;
        let per_unit = [per_face, 3e-7, 3e-7, 3e-7, 1e-6, 1e-6, 1e-6, 2e-7, 5e-8];
        Self { submission_time: SUBMISSION_TIME, per_unit }
    }

    /// Takes the next submission out of a frame: a step, or a part of it.
    pub(super) fn next(&self, frame: &mut VecDeque<Step>) -> Option<Step> {
        let step = frame.pop_front()?;
        let per_unit = self.per_unit[step.pass() as usize];
        let most = (self.submission_time.as_secs_f64() / per_unit).min(f64::from(MOST_UNITS)) as u32;
        let most = (most / step.grain() * step.grain()).max(step.grain());
        let end = step.units.start.saturating_add(most).min(step.units.end);
        if end < step.units.end {
            frame.push_front(Step { work: step.work, units: end..step.units.end });
        }
        Some(Step { units: step.units.start..end, ..step })
    }

    /// Learns what a submission took. What is slower than thought counts at once, what is faster by half.
    pub(super) fn learn(&mut self, step: &Step, taken: Duration) {
        let per_unit = &mut self.per_unit[step.pass() as usize];
        let ratio = taken.as_secs_f64() / (f64::from(step.units.len() as u32) * *per_unit);
        if ratio.is_finite() {
            *per_unit *= if ratio > 1.0 { ratio.min(8.0) } else { ratio.max(0.05).sqrt() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_of_a_frame_is_done_once_and_in_order_at_any_pace() {
        for milliseconds in [1, 7, 40, 5000] {
            let pace = Pace { submission_time: Duration::from_millis(milliseconds), ..Pace::new(1000) };
            let works = [
                (Work::Shadows, 20),
                (Work::Surface(Layer::First), 300_000),
                (Work::Pixels(Dispatch::Light), 230_400),
                (Work::Pixels(Dispatch::Gather(0)), 230_400),
                (Work::Pixels(Dispatch::Show(0)), 230_400),
            ];
            let mut frame: VecDeque<Step> = works.iter().map(|(work, units)| Step::new(*work, *units)).collect();
            let done: Vec<Step> = std::iter::from_fn(|| pace.next(&mut frame)).collect();
            for (work, units) in works {
                let parts: Vec<&Step> = done.iter().filter(|step| step.work == work).collect();
                let ends: Vec<u32> = parts.iter().map(|step| step.units.end).collect();
                let starts: Vec<u32> = parts.iter().map(|step| step.units.start).collect();
                assert_eq!(starts[0], 0);
                assert_eq!(starts[1..], ends[..ends.len() - 1], "{work:?} at {milliseconds} ms");
                assert_eq!(ends[ends.len() - 1], units);
            }
            let order: Vec<usize> = done.iter().map(|step| step.pass() as usize).collect();
            assert!(order.is_sorted(), "{order:?}");
        }
    }

    #[test]
    fn submissions_come_to_take_what_they_should_however_wrong_the_first_guess() {
        for truth in [3e-9, 3e-7, 3e-5] {
            let mut pace = Pace::new(1000);
            let mut times = Vec::new();
            for _ in 0..20 {
                let mut frame = VecDeque::from([Step::new(Work::Pixels(Dispatch::Gather(0)), 1 << 20)]);
                while let Some(step) = pace.next(&mut frame) {
                    let seconds = truth * f64::from(step.units.len() as u32);
                    pace.learn(&step, Duration::from_secs_f64(seconds));
                    times.push(seconds);
                }
            }
            let late = &times[times.len() / 2..];
            assert!(late.iter().all(|seconds| *seconds < 0.1), "{late:?}");
        }
    }
}
