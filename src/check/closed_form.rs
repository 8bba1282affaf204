//! Answers known in closed form: what a solver must find.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

/// Irradiance in a closed box of one reflectance after `bounces` indirect bounces (eq. 5):
/// `direct (1 - ρ^(n+1)) / (1 - ρ)`, `direct` being the mean direct irradiance [W/m²] and `reflectance` in [0, 1).
pub fn furnace_irradiance(direct: f64, reflectance: f64, bounces: u32) -> f64 {
    direct * (1.0 - reflectance.powf(f64::from(bounces) + 1.0)) / (1.0 - reflectance)
}

/// Irradiance [W/m²] at `position` on a surface of unit normal `normal` from an unoccluded polygon (eq. 6).
///
/// `corners` are coplanar, in order, counter-clockwise seen from the side that shines; from behind there is no light.
/// Positions share one unit of length, which cancels. `radiance` [W/(m² sr)] is the same from all points in all
/// directions. The result is finite everywhere; on the polygon's own outline, where it jumps, it is one of the values
/// beside the jump or lies between them.
pub fn polygon_irradiance(position: Vec3, normal: Vec3, corners: &[Vec3], radiance: Vec3) -> Vec3 {
    let normal = normal.as_dvec3();
    // f64 from here: single coordinates differ exactly, and the sum of a far light's edges cancels.
    let seen: Vec<DVec3> = corners.iter().map(|corner| corner.as_dvec3() - position.as_dvec3()).collect();
    let above = clip_to_horizon(&seen, normal);
    let mut sum = 0.0;
    for (index, start) in above.iter().enumerate() {
        let end = above[(index + 1) % above.len()];
        // Clockwise as the receiver sees it is counter-clockwise from the light, hence end × start.
        let across = end.cross(*start);
        let length = across.length();
        if length > 0.0 {
            sum += length.atan2(start.dot(end)) * across.dot(normal) / length;
        }
    }
    // The sum is 2π times the form factor: never more than 2π but for rounding.
    radiance * (0.5 * sum.clamp(0.0, 2.0 * PI)) as f32
}

/// The part of a polygon above the plane through the origin with this normal (Sutherland and Hodgman 1974).
fn clip_to_horizon(corners: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut above = Vec::with_capacity(corners.len() + 1);
    for (index, &start) in corners.iter().enumerate() {
        let end = corners[(index + 1) % corners.len()];
        let (start_height, end_height) = (start.dot(normal), end.dot(normal));
        if start_height >= 0.0 {
            above.push(start);
        }
        if (start_height > 0.0 && end_height < 0.0) || (start_height < 0.0 && end_height > 0.0) {
            above.push(start.lerp(end, start_height / (start_height - end_height)));
        }
    }
    above
}

/// Form factor between two equal squares of side 1 that face each other at `distance` (> 0): 0.19982 at distance 1.
/// Source: Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11.
pub fn parallel_squares_form_factor(distance: f64) -> f64 {
    let side = 1.0 / distance;
    let squared = side * side;
    let hypotenuse = (1.0 + squared).sqrt();
    let logarithm = ((1.0 + squared) * (1.0 + squared) / (1.0 + 2.0 * squared)).sqrt().ln();
    let angles = 2.0 * side * (hypotenuse * (side / hypotenuse).atan() - side.atan());
    2.0 / (PI * squared) * (logarithm + angles)
}

/// Form factor between two equal squares at a right angle that share an edge: 0.20004.
/// Source: Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-14, with w = h = l.
pub fn perpendicular_squares_form_factor() -> f64 {
    let root_two = 2.0_f64.sqrt();
    (0.5 * PI - root_two * (1.0 / root_two).atan() + 0.25 * 0.75_f64.ln()) / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square in the plane y = height, shining down.
    fn ceiling(height: f32) -> [Vec3; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, z]| Vec3::new(x, height, z))
    }

    /// Mean of irradiance / π over a square of n × n points: the form factor to a light of radiance 1.
    fn mean_form_factor(receiver: impl Fn(f32, f32) -> Vec3, normal: Vec3, light: &[Vec3]) -> f64 {
        let count = 100;
        let at = |index: u32| (index as f32 + 0.5) / count as f32;
        let mut sum = 0.0;
        for row in 0..count {
            for column in 0..count {
                let position = receiver(at(column), at(row));
                sum += f64::from(polygon_irradiance(position, normal, light, Vec3::ONE).x) / PI;
            }
        }
        sum / f64::from(count * count)
    }

    #[test]
    fn furnace_sums_its_geometric_series() {
        assert_eq!(furnace_irradiance(3.0, 0.0, 7), 3.0);
        assert!((furnace_irradiance(2.0, 0.5, 2) - 2.0 * (1.0 + 0.5 + 0.25)).abs() < 1e-12);
    }

    #[test]
    fn form_factors_of_squares_match_the_published_numbers_and_the_integral_of_lamberts_formula() {
        // Numbers to five digits in every textbook of heat transfer.
        assert!((parallel_squares_form_factor(1.0) - 0.19982).abs() < 1e-5);
        assert!((perpendicular_squares_form_factor() - 0.20004).abs() < 1e-5);
        for distance in [0.5_f32, 1.0, 3.0] {
            let integral = mean_form_factor(|x, z| Vec3::new(x, 0.0, z), Vec3::Y, &ceiling(distance));
            assert!((integral - parallel_squares_form_factor(f64::from(distance))).abs() < 1e-4, "at {distance}");
        }
        let wall = mean_form_factor(|x, y| Vec3::new(x, y, 0.0), Vec3::Z, &ceiling(1.0));
        assert!((wall - perpendicular_squares_form_factor()).abs() < 1e-3);
    }

    #[test]
    fn a_light_cut_by_the_horizon_gives_what_its_upper_part_gives() {
        let normal = Vec3::new(1.0, 1.0, 0.0).normalize();
        let position = Vec3::new(0.5, 0.5, 0.5); // the horizon meets y = 1 at x = 0
        let wide = [[-3.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-3.0, 1.0]].map(|[x, z]| Vec3::new(x, 1.0, z));
        let cut = polygon_irradiance(position, normal, &wide, Vec3::ONE);
        let upper = polygon_irradiance(position, normal, &ceiling(1.0), Vec3::ONE);
        assert!((cut - upper).abs().max_element() < 1e-6);
    }

    #[test]
    fn a_light_that_fills_the_hemisphere_gives_pi_and_none_from_behind_or_below() {
        let huge = ceiling(0.0).map(|corner| (corner - Vec3::new(0.5, 0.0, 0.5)) * 1e6 + Vec3::Y);
        let full = polygon_irradiance(Vec3::ZERO, Vec3::Y, &huge, Vec3::ONE);
        assert!((full.x - std::f32::consts::PI).abs() < 1e-4);
        assert_eq!(polygon_irradiance(2.0 * Vec3::Y, Vec3::NEG_Y, &huge, Vec3::ONE), Vec3::ZERO);
        assert_eq!(polygon_irradiance(Vec3::ZERO, Vec3::NEG_Y, &huge, Vec3::ONE), Vec3::ZERO);
    }

    #[test]
    fn a_far_light_is_a_point_light() {
        let height = 1000.0;
        let irradiance = polygon_irradiance(Vec3::new(0.5, 0.0, 0.5), Vec3::Y, &ceiling(height), Vec3::ONE);
        assert!((irradiance.x * height * height - 1.0).abs() < 1e-5); // L A / r²
    }

    #[test]
    fn on_edges_corners_and_horizon_the_result_is_finite_and_at_most_pi() {
        let light = ceiling(0.5);
        for x in [-0.5, 0.0, 0.25, 1.0] {
            for z in [0.0, 0.5, 1.0] {
                for normal in [Vec3::Y, Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y] {
                    let value = polygon_irradiance(Vec3::new(x, 0.5, z), normal, &light, Vec3::ONE).x;
                    assert!((0.0..=1.0001 * std::f32::consts::PI).contains(&value), "{x} {z} {normal}: {value}");
                }
            }
        }
        assert_eq!(polygon_irradiance(Vec3::ZERO, Vec3::Y, &[Vec3::Y; 4], Vec3::ONE), Vec3::ZERO);
        assert_eq!(polygon_irradiance(Vec3::ZERO, Vec3::Y, &[], Vec3::ONE), Vec3::ZERO);
    }
}
