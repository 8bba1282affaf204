//! Rays as the solver traces them, the same every time, by which ray tracers are timed; and a file of them for tracers
//! of other programs.
//!
//! The file is in the safetensors format (a little-endian binary file with a JSON header, which many languages read):
//!
//! | array | type | shape | meaning |
//! | --- | --- | --- | --- |
//! | `corners` | f32 | triangles, 3, 3 | corners of the scene's triangles, in local units |
//! | `SET.origins` | f32 | rays, 3 | where each ray starts |
//! | `SET.directions` | f32 | rays, 3 | unit vectors |
//! | `SET.max_distances` | f32 | rays | hits at this distance or beyond do not count; infinity for none |
//! | `SET.origin_triangles` | u32 | rays | the triangle that the ray leaves from, which it cannot hit |
//!
//! SET is `scattered`, `gathered` or `shadow`: see [`RaySets`].

use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use safetensors::{Dtype, SafeTensorError, tensor::TensorView};

use super::surface_points::area_uniform_points;
use crate::{
    scene::{AreaLight, Scene},
    trace::{Ray, SurfacePoint},
    transport::{
        Lights,
        sampling::{area_light_point, cosine_direction, frame, triangle_point},
    },
};

/// Gather rays that leave from one point, in [`RaySets::gathered`].
pub const RAYS_A_POINT: usize = 256;

/// Three kinds of rays, from points that are uniform by area over a scene's surfaces.
pub struct RaySets {
    /// One cosine-weighted ray a point.
    pub scattered: Vec<Ray>,
    /// [`RAYS_A_POINT`] cosine-weighted rays a point, in random order.
    pub gathered: Vec<Ray>,
    /// One ray a point to a random place on the lights, where neither faces away from the other. Empty without lights.
    pub shadow: Vec<Ray>,
}

impl RaySets {
    /// About `count` rays of each kind, a function of scene, light and seed alone.
    pub fn new(scene: &Scene, area_light: Option<AreaLight>, count: u32, seed: u64) -> Self {
        let lights = Lights::new(scene, area_light);
        let mut generator = SmallRng::seed_from_u64(seed);
        let points = |count, seed| -> Vec<SurfacePoint> {
            let places = area_uniform_points(scene, count, seed);
            places.into_iter().map(|(triangle, place)| SurfacePoint::new(scene, triangle, place)).collect()
        };
        let mut square = || Vec2::from_array(generator.random());
        let gather = |point: &SurfacePoint, square: Vec2| {
            point.ray((frame(point.shading_normal) * cosine_direction(square)).normalize())
        };
        let far = points(count, seed);
        let scattered = far.iter().filter_map(|point| gather(point, square())).collect();
        let near = points(count.div_ceil(RAYS_A_POINT as u32), seed + 1);
        let gathered = near.iter().flat_map(|point| std::iter::repeat_n(point, RAYS_A_POINT));
        let gathered = gathered.filter_map(|point| gather(point, square())).collect();
        let shadow = far.iter().filter_map(|point| {
            let (position, normal) = light_point(scene, &lights, square())?;
            let ray = point.ray_to(position)?;
            (ray.direction.dot(normal) < 0.0).then_some(ray)
        });
        Self { scattered, gathered, shadow: shadow.collect() }
    }

    /// The sets with their names.
    pub fn named(&self) -> [(&'static str, &[Ray]); 3] {
        [("scattered", &self.scattered), ("gathered", &self.gathered), ("shadow", &self.shadow)]
    }

    /// The bytes of a file with the scene's triangles and all rays.
    ///
    /// # Errors
    /// None that is known: what safetensors says of its own.
    pub fn encode(&self, scene: &Scene) -> Result<Vec<u8>, SafeTensorError> {
        let vectors = |vectors: &mut dyn Iterator<Item = Vec3>| -> Vec<u8> {
            vectors.flat_map(|vector| vector.to_array()).flat_map(f32::to_le_bytes).collect()
        };
        let triangle_count = scene.mesh.triangles.len();
        let corners = vectors(&mut (0..triangle_count as u32).flat_map(|triangle| scene.mesh.corners(triangle)));
        let mut arrays = vec![(String::from("corners"), Dtype::F32, vec![triangle_count, 3, 3], corners)];
        for (name, rays) in self.named() {
            let mut add = |part: &str, dtype, columns: &[usize], bytes| {
                arrays.push((format!("{name}.{part}"), dtype, [&[rays.len()], columns].concat(), bytes));
            };
            add("origins", Dtype::F32, &[3], vectors(&mut rays.iter().map(|ray| ray.origin)));
            add("directions", Dtype::F32, &[3], vectors(&mut rays.iter().map(|ray| ray.direction)));
            let reaches = rays.iter().flat_map(|ray| ray.max_distance.to_le_bytes()).collect();
            add("max_distances", Dtype::F32, &[], reaches);
            let triangles = rays.iter().flat_map(|ray| ray.origin_triangle.to_le_bytes()).collect();
            add("origin_triangles", Dtype::U32, &[], triangles);
        }
        let views = arrays
            .iter()
            .map(|(name, dtype, shape, bytes)| Ok((name.as_str(), TensorView::new(*dtype, shape.clone(), bytes)?)));
        safetensors::serialize(views.collect::<Result<Vec<_>, SafeTensorError>>()?, None)
    }
}

/// A random place on the area light, or without one on the emissive triangles, and the unit normal there.
fn light_point(scene: &Scene, lights: &Lights, square: Vec2) -> Option<(Vec3, Vec3)> {
    if let Some(light) = &lights.area_light {
        return Some((area_light_point(light, square), light.normal()));
    }
    let (triangle, stretched) = lights.emitters.choose(square.x)?;
    let (_, position) = triangle_point(scene.mesh.corners(triangle), Vec2::new(stretched, square.y));
    Some((position, scene.mesh.geometric_normal(triangle)))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use safetensors::SafeTensors;

    use super::*;
    use crate::scene::{LoadOptions, builtin};

    #[test]
    fn a_file_of_rays_holds_every_ray_and_the_same_seed_gives_the_same_bytes() {
        let scene = builtin::cornell(&LoadOptions::default()).unwrap();
        let light = AreaLight {
            centre: Vec3::new(0.0, 0.4, 0.0),
            half_extent_u: Vec3::X * 0.1,
            half_extent_v: Vec3::Z * 0.1,
            radiance: Vec3::ONE,
        };
        let light = Some(light);
        let sets = RaySets::new(&scene, light, 1000, 7);
        let bytes = sets.encode(&scene).unwrap();
        assert!(bytes == RaySets::new(&scene, light, 1000, 7).encode(&scene).unwrap());
        let file = SafeTensors::deserialize(&bytes).unwrap();
        assert_eq!(file.tensor("corners").unwrap().shape(), [scene.mesh.triangles.len(), 3, 3]);
        for (name, rays) in sets.named() {
            let origins = file.tensor(&format!("{name}.origins")).unwrap();
            assert_eq!(origins.shape(), [rays.len(), 3]);
            let last = rays.last().unwrap().origin.to_array().map(f32::to_le_bytes).concat();
            assert!(origins.data().ends_with(&last));
            assert_eq!(file.tensor(&format!("{name}.max_distances")).unwrap().shape(), [rays.len()]);
        }
        assert!(sets.scattered.len() > 990 && sets.gathered.len() > 990 && sets.shadow.len() > 50);
        assert!(sets.shadow.iter().all(|ray| ray.max_distance < 4.0));
    }
}
