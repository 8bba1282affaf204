//! Between the file's metres and local units.

use glam::{DVec3, Vec3};

/// `metres = origin + metres_per_unit · local`. The factor is a power of two, so scaling is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    /// The local origin, in metres.
    pub origin: DVec3,
    /// Metres in one local unit: a power of two.
    pub metres_per_unit: f64,
}

impl Default for LocalFrame {
    fn default() -> Self {
        Self { origin: DVec3::ZERO, metres_per_unit: 1.0 }
    }
}

impl LocalFrame {
    /// The frame of a bounding box in metres: its centre, and a scale that brings its largest half-extent into
    /// (1/2, 1]. A box of one point keeps the scale 1.
    pub fn of_bounds(minimum: DVec3, maximum: DVec3) -> Self {
        let half_extent = (0.5 * maximum - 0.5 * minimum).max_element();
        let metres_per_unit = if half_extent > 0.0 { half_extent.log2().ceil().exp2() } else { 1.0 };
        Self { origin: 0.5 * minimum + 0.5 * maximum, metres_per_unit }
    }

    /// A point in metres, in local units.
    pub fn point_to_local(&self, metres: DVec3) -> Vec3 {
        ((metres - self.origin) / self.metres_per_unit).as_vec3()
    }

    /// A point in local units, in metres.
    pub fn point_to_metres(&self, local: Vec3) -> DVec3 {
        local.as_dvec3() * self.metres_per_unit + self.origin
    }

    /// A vector (no origin) in metres, in local units.
    pub fn vector_to_local(&self, metres: DVec3) -> Vec3 {
        (metres / self.metres_per_unit).as_vec3()
    }

    /// A vector in local units, in metres.
    pub fn vector_to_metres(&self, local: Vec3) -> DVec3 {
        local.as_dvec3() * self.metres_per_unit
    }

    /// Square metres in one local unit of area.
    pub fn square_metres_per_unit(&self) -> f64 {
        self.metres_per_unit * self.metres_per_unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_scaled_by_a_power_of_two_and_moved_has_the_same_local_points() {
        let corner = DVec3::new(1.25, 3.5, 2.0);
        let local = |scale: f64, shift: DVec3| {
            let frame = LocalFrame::of_bounds(shift - corner * scale, shift + corner * scale);
            (frame.point_to_local(shift + corner * scale), frame.point_to_metres(Vec3::ONE))
        };
        let (near, _) = local(1.0, DVec3::ZERO);
        assert!((0.5..=1.0).contains(&near.abs().max_element()));
        assert_eq!(near, local(2.0_f64.powi(20), DVec3::ZERO).0);
        assert_eq!(near, local(1.0, DVec3::splat(1048576.0)).0);
    }
}
