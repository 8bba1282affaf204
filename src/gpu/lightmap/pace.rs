//! How much work a submission holds: as much as takes some [`SUBMISSION_TIME`], because drivers end longer ones and
//! whoever else draws on the device has to wait.
//!
//! A batch of shooters is chosen at once, but drawn and received in as many submissions as it takes. Where they are cut
//! changes no bit of the solution: a texel adds the shooters up one by one, in their order.

use std::{ops::Range, time::Duration};

/// What a submission should take, if nothing else is asked for.
pub const SUBMISSION_TIME: Duration = Duration::from_millis(25);

/// The part of that which is left to hemicubes and receivers where shooters are chosen, too.
const BESIDE_CHOICE: f64 = 0.5;

/// Receivers of a submission are a multiple of this: the threads of a workgroup.
const GRAIN: u32 = 64;

/// What is put into one submission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Submission {
    /// The first of its batch: shooters are chosen, and the atlas of depth is cleared.
    pub begins: bool,
    /// Parts of the scene on faces that are drawn, by their number in the batch.
    pub draws: Range<u32>,
    /// Shooters that are received from; none if empty.
    pub slots: Range<u32>,
    /// Texels that receive.
    pub receivers: Range<u32>,
    /// All texels have received from these shooters: the ledger is brought up to date.
    pub completes: bool,
}

/// How far a batch has come.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Batch {
    /// Its shooters.
    pub slots: u32,
    draws_done: u32,
    slots_done: u32,
    receivers_done: u32,
}

impl Batch {
    /// Of so many shooters.
    pub fn new(slots: u32) -> Self {
        Self { slots, ..Self::default() }
    }

    /// True if nothing of it is left.
    pub fn is_done(&self) -> bool {
        self.slots_done == self.slots
    }

    /// Takes the next submission out of it.
    pub fn next(&mut self, pace: &Pace, receiver_count: u32) -> Submission {
        let begins = self.draws_done == 0;
        let budget = pace.submission_time.as_secs_f64() * if begins { BESIDE_CHOICE } else { 1.0 };
        let one_slot = f64::from(pace.draws_per_slot) * pace.per_draw + f64::from(receiver_count) * pace.per_pair;
        let whole = ((budget / one_slot) as u32).min(self.slots - self.slots_done);
        let is_between = self.draws_done == pace.draws_per_slot * self.slots_done;
        let mut submission = if is_between && whole > 0 {
            let slots = self.slots_done..self.slots_done + whole;
            let draws = pace.draws_per_slot * slots.start..pace.draws_per_slot * slots.end;
            Submission { begins, draws, slots, receivers: 0..receiver_count, completes: true }
        } else {
            self.part_of_a_slot(pace, budget, receiver_count)
        };
        submission.begins = begins;
        self.draws_done = submission.draws.end.max(self.draws_done);
        self.receivers_done = if submission.completes { 0 } else { submission.receivers.end };
        if submission.completes {
            self.slots_done = submission.slots.end;
        }
        submission
    }

    /// Some draws of one shooter; or, once all are drawn, some receivers.
    fn part_of_a_slot(&self, pace: &Pace, budget: f64, receiver_count: u32) -> Submission {
        let slot = self.slots_done;
        let last_draw = pace.draws_per_slot * (slot + 1);
        if self.draws_done < last_draw {
            let most = ((budget / pace.per_draw) as u32).max(1);
            let draws = self.draws_done..last_draw.min(self.draws_done.saturating_add(most));
            return Submission { begins: false, draws, slots: slot..slot, receivers: 0..0, completes: false };
        }
        let most = ((budget / pace.per_pair) as u32 / GRAIN * GRAIN).max(GRAIN);
        let end = receiver_count.min(self.receivers_done.saturating_add(most));
        Submission {
            begins: false,
            draws: last_draw..last_draw,
            slots: slot..slot + 1,
            receivers: self.receivers_done..end,
            completes: end == receiver_count,
        }
    }
}

/// What the parts of a submission take, by the last ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// What a submission should take.
    pub submission_time: Duration,
    /// Draws for a shooter: the faces of a hemicube, by the parts of the scene.
    pub draws_per_slot: u32,
    /// Seconds for one.
    pub per_draw: f64,
    /// Seconds for a texel to receive from one shooter.
    pub per_pair: f64,
}

impl Pace {
    /// A cautious guess, before anything was measured.
    pub fn new(draws_per_slot: u32, triangles: u32, resolution: u32) -> Self {
        let (pixels, submission_time) = (f64::from(resolution).powi(2), SUBMISSION_TIME);
        let per_draw = 2e-7 * f64::from(triangles) + 2e-8 * pixels;
        Self { submission_time, draws_per_slot, per_draw, per_pair: 5e-7 }
    }

    /// Learns what a submission took. What is slower than thought counts at once, what is faster by half.
    pub fn learn(&mut self, submission: &Submission, taken: Duration) {
        let pairs = f64::from(submission.receivers.len() as u32) * f64::from(submission.slots.len() as u32);
        let draws = f64::from(submission.draws.len() as u32);
        let expected = draws * self.per_draw + pairs * self.per_pair;
        let ratio = taken.as_secs_f64() / expected;
        if !ratio.is_finite() {
            return;
        }
        let factor = if ratio > 1.0 { ratio.min(8.0) } else { ratio.max(0.05).sqrt() };
        if draws > 0.0 {
            self.per_draw *= factor;
        }
        if pairs > 0.0 {
            self.per_pair *= factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All submissions of a batch at a pace, without measuring.
    fn submissions(slots: u32, pace: &Pace, receivers: u32) -> Vec<Submission> {
        let mut batch = Batch::new(slots);
        let mut found = Vec::new();
        while !batch.is_done() {
            found.push(batch.next(pace, receivers));
        }
        found
    }

    #[test]
    fn every_part_is_drawn_once_and_every_pair_received_once_and_after_its_faces_at_any_pace() {
        const RECEIVERS: u32 = 1000;
        for (per_draw, per_pair) in [(1e-6, 1e-9), (1e-3, 1e-6), (0.03, 1e-6), (0.03, 1e-4), (1.0, 1.0)] {
            let mut drawn = [0; 7 * 10];
            let mut received = vec![0; 7 * RECEIVERS as usize];
            let found = submissions(7, &Pace { per_draw, per_pair, ..Pace::new(10, 0, 64) }, RECEIVERS);
            for submission in &found {
                submission.draws.clone().for_each(|draw| drawn[draw as usize] += 1);
                for slot in submission.slots.clone() {
                    assert!((10 * slot..10 * slot + 10).all(|draw| drawn[draw as usize] == 1), "{submission:?}");
                    submission.receivers.clone().for_each(|one| received[(slot * RECEIVERS + one) as usize] += 1);
                }
            }
            assert!(drawn.iter().chain(&received).all(|count| *count == 1), "{per_draw}, {per_pair}");
            assert!(found[0].begins && found.iter().skip(1).all(|submission| !submission.begins));
        }
    }

    #[test]
    fn submissions_come_to_take_what_they_should_however_wrong_the_first_guess() {
        for (per_draw, per_pair) in [(2e-5, 1e-8), (2e-3, 1e-7), (0.02, 1e-6)] {
            let (truth, mut pace) = (Pace { per_draw, per_pair, ..Pace::new(5, 0, 64) }, Pace::new(5, 1000, 64));
            let seconds = |submission: &Submission| {
                let pairs = submission.slots.len() * submission.receivers.len();
                submission.draws.len() as f64 * truth.per_draw + pairs as f64 * truth.per_pair
            };
            let mut times = Vec::new();
            for _ in 0..20 {
                let mut batch = Batch::new(64);
                while !batch.is_done() {
                    let submission = batch.next(&pace, 100_000);
                    times.push(seconds(&submission));
                    pace.learn(&submission, Duration::from_secs_f64(times[times.len() - 1]));
                }
            }
            let late = &times[times.len() / 2..];
            let longest = late.iter().copied().fold(0.0, f64::max);
            assert!(longest < 0.1, "{longest} s");
            assert!(late.iter().sum::<f64>() / late.len() as f64 > 0.01, "too many small ones");
        }
    }
}
