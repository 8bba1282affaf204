//! The light that has still to be shot, in what is shown and written.

use glam::{DVec3, Vec3};

use super::{GpuLedger, GpuSolver};
use crate::{lightmap::Ambient, math::ratio_or_zero};

/// A moment is remembered whenever the unshot power has fallen to this part of what it was at the last one.
const STEP: f64 = 0.7;
/// No more than this many times what came since a remembered moment is added.
const MOST: f64 = 2.0;

/// The unshot power at the last two moments that are remembered [W]. The irradiance of the older one is in the buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moments {
    older: DVec3,
    newer: DVec3,
}

impl Moments {
    /// Both are now.
    pub(super) fn begin(unshot: DVec3) -> Self {
        Self { older: unshot, newer: unshot }
    }

    /// Takes a new one, if it is time to.
    pub(super) fn next(&mut self, unshot: DVec3) -> bool {
        let is_due = unshot.element_sum() <= STEP * self.newer.element_sum();
        if is_due {
            *self = Self { older: self.newer, newer: unshot };
        }
        is_due
    }

    /// How often what came since the older one has still to come, band by band: as unshot power fell, so light arrived, and
    /// so it will until nothing is left (Richardson's extrapolation, of first order).
    fn weights(&self, unshot: DVec3) -> Vec3 {
        let weight = |now: f64, before: f64| ratio_or_zero(now, (before - now).max(now / MOST));
        let weights = unshot.to_array().into_iter().zip(self.older.to_array()).map(|(now, before)| weight(now, before));
        Vec3::from_slice(&weights.map(|weight| weight as f32).collect::<Vec<_>>())
    }
}

/// What is added to irradiance: `even` [W/m²], and `trend` times what came since the older remembered moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rest {
    pub(super) even: Vec3,
    pub(super) trend: Vec3,
}

impl GpuSolver {
    /// What is added for the light that has still to be shot.
    pub(super) fn rest(&self) -> Rest {
        match self.settings.ambient {
            Ambient::Off => Rest::default(),
            Ambient::Even => Rest { even: self.even_rest(), ..Rest::default() },
            Ambient::Trend => Rest { trend: self.moments.weights(self.ledger.unshot), ..Rest::default() },
        }
    }

    /// What the light that has still to be shot will add to every texel in the mean: its power by the area of all
    /// texels, reflected over and over at their mean reflectance (Cohen, Chen, Wallace and Greenberg 1988, the ambient
    /// term); less the part that leaves the scene, as far as is known.
    fn even_rest(&self) -> Vec3 {
        let area = self.open_area();
        let reflected: Vec3 = self.patches.receivers.iter().map(|receiver| receiver.area * receiver.reflectance).sum();
        let GpuLedger { arrived, escaped, on_backs, unshot, .. } = self.ledger;
        let inside = ratio_or_zero(arrived.element_sum(), (arrived + escaped + on_backs).element_sum()) as f32;
        let mean = inside * (unshot / self.square_metres).as_vec3() / area;
        mean / (1.0 - inside * reflected / area)
    }

    /// Remembers the present irradiance now and then. Only between batches, so that the clock changes no bit of it.
    pub(super) fn remember(&mut self) {
        let lamps = self.patches.lamps.len() as u32;
        if self.settings.ambient != Ambient::Trend || !self.batch.is_done() || self.lamps_done < lamps {
            return;
        }
        let begins = self.from_lamps;
        if begins {
            self.moments = Moments::begin(self.ledger.unshot);
        } else if !self.moments.next(self.ledger.unshot) {
            return;
        }
        let Self { buffers, .. } = self;
        let size = buffers.irradiance.size();
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let older = if begins { &buffers.irradiance } else { &buffers.newer };
        encoder.copy_buffer_to_buffer(older, 0, &buffers.older, 0, size);
        encoder.copy_buffer_to_buffer(&buffers.irradiance, 0, &buffers.newer, 0, size);
        self.queue.submit([encoder.finish()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_comes_as_what_came_did() {
        // From 8 W to 4 W something came; of the last 4 W as much will come again.
        let moments = Moments::begin(DVec3::splat(8.0));
        assert_eq!(moments.weights(DVec3::splat(4.0)), Vec3::ONE);
        assert_eq!(moments.weights(DVec3::new(2.0, 0.0, 8.0)), Vec3::new(1.0 / 3.0, 0.0, 2.0));
    }

    #[test]
    fn a_moment_is_remembered_until_the_unshot_power_is_about_half() {
        let mut moments = Moments::begin(DVec3::ONE);
        let mut power = 1.0;
        for _ in 0..40 {
            power *= 0.93;
            moments.next(DVec3::splat(power));
            let part = power / moments.older.x;
            assert!(part > 0.7 * 0.7 * 0.93 * 0.93, "{part}");
        }
        assert!(power / moments.older.x < 0.7);
    }
}
