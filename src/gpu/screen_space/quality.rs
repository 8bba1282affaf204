//! What gives way while something moves, so that a frame takes no longer than it may.

use std::time::Duration;

use super::settings::ScreenSettings;

/// Steps down from full quality: pixels along each side and taps, as parts of what the settings say. Each has about half of
/// the work of the one before. Fewer taps than half save little and are seen.
const LEVELS: [(f32, f32); 8] =
    [(1.0, 1.0), (1.0, 0.5), (0.7, 0.5), (0.5, 0.5), (0.35, 0.5), (0.25, 0.5), (0.18, 0.5), (0.125, 0.5)];
/// Below this part of the budget a finer level is tried.
const ROOM: f32 = 0.4;
/// Above so many times the budget a coarser level is taken at once, and two steps down; else after a second such frame: one
/// alone may have waited for somebody else's work.
const FAR_ABOVE: f32 = 3.0;

/// The level that moving frames are drawn at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quality {
    level: usize,
    /// The last frame took too long.
    was_above: bool,
}

impl Quality {
    /// Settings and size of a moving frame. The layers stay, so that what was made for them is used again.
    pub fn apply(self, settings: &ScreenSettings, size: [u32; 2]) -> (ScreenSettings, [u32; 2]) {
        let (scale, taps) = LEVELS[self.level];
        let fewer = |count: u32| if count == 0 { 0 } else { ((count as f32 * taps) as u32).max(1) };
        let smaller = ScreenSettings {
            taps: fewer(settings.taps),
            obscurance: fewer(settings.obscurance),
            // Wider in the picture than in full size: it has fewer pixels to take the noise out of.
            filter: (settings.filter as f32 * scale.sqrt()).ceil() as u32,
            ..settings.clone()
        };
        (smaller, size.map(|pixels| ((pixels as f32 * scale) as u32).max(1)))
    }

    /// Learns what a moving frame took.
    pub fn learn(&mut self, taken: Duration, budget: Duration) {
        let part = taken.as_secs_f32() / budget.as_secs_f32().max(1e-3);
        let (is_above, is_far_above) = (part > 1.0, part > FAR_ABOVE);
        if is_above && (is_far_above || self.was_above) {
            self.level = (self.level + 1 + usize::from(is_far_above)).min(LEVELS.len() - 1);
            self.was_above = false;
        } else {
            self.level -= usize::from(part < ROOM && self.level > 0);
            self.was_above = is_above;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moving_frames_come_to_keep_their_budget_and_get_finer_again_when_they_can() {
        let settings = ScreenSettings::default();
        let seconds = |quality: Quality, per_pixel_and_tap: f64| {
            let (settings, [width, height]) = quality.apply(&settings, [1280, 800]);
            per_pixel_and_tap * f64::from(width * height * settings.taps)
        };
        let budget = Duration::from_millis(50);
        let mut quality = Quality::default();
        for _ in 0..12 {
            quality.learn(Duration::from_secs_f64(seconds(quality, 2e-8)), budget);
        }
        assert!(seconds(quality, 2e-8) <= 0.05 && quality != Quality::default(), "{quality:?}");
        for _ in 0..12 {
            quality.learn(Duration::from_secs_f64(seconds(quality, 1e-10)), budget);
        }
        assert_eq!(quality, Quality::default());
    }

    #[test]
    fn one_slow_frame_alone_makes_nothing_coarser_and_a_very_slow_one_does_at_once() {
        let budget = Duration::from_millis(50);
        let mut quality = Quality::default();
        for milliseconds in [80, 30, 80, 30] {
            quality.learn(Duration::from_millis(milliseconds), budget);
            assert_eq!(quality.level, 0);
        }
        quality.learn(Duration::from_millis(500), budget);
        assert_eq!(quality.level, 2);
    }
}
