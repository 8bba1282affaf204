//! Mean reflectance of textured triangles.

use glam::{DVec3, Vec2, Vec3};

use super::Scene;

/// A triangle that covers more texels than this is sampled at so many points.
const MOST_POINTS: u32 = 512;

/// Mean reflectance over a triangle's area, cut-outs not left out: the material's without a texture, otherwise the mean
/// of as many evenly spread fixed points as the triangle covers texels, at least 1 and at most 512.
pub fn triangle_mean_reflectance(scene: &Scene, triangle: u32) -> Vec3 {
    let material = scene.material(triangle);
    let (Some(texture), Some(corners)) = (material.reflectance_texture, scene.mesh.texcoords.get(triangle as usize))
    else {
        return scene.reflectance(triangle, Vec2::splat(1.0 / 3.0));
    };
    let (width, height) = scene.textures[texture as usize].size();
    let count = point_count(corners.map(|texcoord| texcoord * Vec2::new(width as f32, height as f32)));
    let points = (0..count).map(|index| scene.reflectance(triangle, triangle_point(index)).as_dvec3());
    (points.sum::<DVec3>() / f64::from(count)).as_vec3()
}

/// Texels covered by a triangle with these corners, in texels: its area and, for thin ones, its longest edge.
fn point_count([a, b, c]: [Vec2; 3]) -> u32 {
    let area = 0.5 * (b - a).perp_dot(c - a).abs();
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    ((area + longest).ceil() as u32).clamp(1, MOST_POINTS)
}

/// Point `index` of the R2 sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), folded
/// into the triangle of barycentric coordinates. Its irrational steps never fall in with a texture that repeats.
fn triangle_point(index: u32) -> Vec2 {
    /// Powers -1 and -2 of the real root of x³ = x + 1.
    const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let [u, v] = STEPS.map(|step| (1.0 / 3.0 + f64::from(index) * step).fract());
    let folded = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
    Vec2::from_array(folded.map(|value| value as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::texture::{Texture, TextureFilter};
    use crate::scene::{LoadOptions, load};

    /// A triangle under a black and white checkerboard, its corners at 0, (`span`, 0), (0, `span`) repeats.
    fn checkered(span: f32) -> Scene {
        let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt {span} 0\nvt 0 {span}\nusemtl a\nf 1/1 2/2 3/3\n");
        #[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
        let mut scene =
            load::load_from_memory("checkered", &obj, "newmtl a\nKd 0.8 0.4 0.2\n", &LoadOptions::default()).unwrap();
        let texel = |x: u32, y: u32| if (x + y).is_multiple_of(2) { [255; 4] } else { [0, 0, 0, 255] };
        let texels = (0..64).map(|index| texel(index % 8, index / 8)).collect();
        scene.textures = vec![Texture::new(String::from("checkers"), 8, 8, texels, TextureFilter::Nearest)];
        scene.materials[0].reflectance_texture = Some(0);
        scene
    }

    #[test]
    fn the_mean_over_a_repeating_checkerboard_is_half_of_the_colour() {
        // A triangle of whole repeats covers 50 % white plus or minus the half squares of its long side.
        for span in [1.0, 8.0, 64.0, 1000.0] {
            let mean = triangle_mean_reflectance(&checkered(span), 0);
            let tolerance = if span < 2.0 { 0.1 } else { 0.02 };
            assert!(mean.abs_diff_eq(Vec3::new(0.4, 0.2, 0.1), tolerance), "{span}: {mean}");
        }
    }

    #[test]
    fn a_triangle_within_one_texel_or_without_texture_has_one_reflectance() {
        let mut scene = checkered(0.01);
        assert_eq!(triangle_mean_reflectance(&scene, 0), scene.reflectance(0, Vec2::splat(0.3)));
        scene.materials[0].reflectance_texture = None;
        assert_eq!(triangle_mean_reflectance(&scene, 0), Vec3::new(0.8, 0.4, 0.2));
    }
}
