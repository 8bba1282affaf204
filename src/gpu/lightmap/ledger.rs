//! Where the power went.

use glam::DVec3;

/// Where the power went, so far, in watts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpuLedger {
    /// Power of all lights.
    pub emitted: DVec3,
    /// Power that arrived on front sides.
    pub arrived: DVec3,
    /// Of that, the power that was absorbed.
    pub absorbed: DVec3,
    /// Power that left the scene, by the hemicubes' own weights.
    pub escaped: DVec3,
    /// Power that met back faces, by the hemicubes' own weights.
    pub on_backs: DVec3,
    /// Power that has still to be shot, by lights and by texels.
    pub unshot: DVec3,
    /// Shooters so far.
    pub shooters: u64,
    /// Batches of shooters that were chosen together, so far.
    pub batches: u64,
}

impl GpuLedger {
    /// The fraction of the emitted power that is still to be absorbed.
    pub fn unabsorbed(&self) -> f64 {
        crate::math::ratio_or_zero(self.unshot.element_sum(), self.emitted.element_sum())
    }

    /// The fraction of the emitted power that left the scene.
    pub fn escaped_part(&self) -> f64 {
        crate::math::ratio_or_zero(self.escaped.element_sum(), self.emitted.element_sum())
    }

    /// The fraction of the emitted power that met back faces.
    pub fn part_on_backs(&self) -> f64 {
        crate::math::ratio_or_zero(self.on_backs.element_sum(), self.emitted.element_sum())
    }

    /// (absorbed + escaped + on backs + unshot) / emitted - 1: how far the power is from being conserved, by what the sums
    /// over texels miss.
    pub fn balance(&self) -> f64 {
        let known = self.absorbed + self.escaped + self.on_backs + self.unshot;
        crate::math::ratio_or_zero(known.element_sum(), self.emitted.element_sum()) - 1.0
    }
}
