//! Points on a scene's surfaces, where fields are judged.

use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng, rngs::SmallRng};

use super::truth_file::TruthPoint;
use crate::{
    scene::Scene,
    trace::{Located, NO_TRIANGLE, RayTracer, SurfacePoint, locate_point},
};

/// The least barycentric weight of a point that rays leave from. On an edge in a crease they would start in the other wall's
/// plane, where half of them meet it at once or pass it by rounding. This is far more than rounding where a triangle is
/// larger than 1/100 of the scene, and moves the point by no more than 1/10,000 of the triangle.
const LEAST_WEIGHT: f32 = 1e-4;

/// A point of a scene triangle: its number and barycentric coordinates.
pub type TrianglePoint = (u32, Vec2);

/// `count` points, uniform by area over all surfaces (not in the holes of cut-outs), the same for the same seed.
/// Empty if no surface has an area.
pub fn area_uniform_points(scene: &Scene, count: u32, seed: u64) -> Vec<TrianglePoint> {
    let mut area = 0.0;
    let cumulative: Vec<f64> = (0..scene.mesh.triangles.len() as u32)
        .map(|triangle| {
            area += f64::from(scene.mesh.area(triangle));
            area
        })
        .collect();
    if area <= 0.0 {
        return Vec::new();
    }
    let mut generator = SmallRng::seed_from_u64(seed);
    let mut draw = || {
        let choice = generator.random::<f64>() * area;
        let triangle = cumulative.partition_point(|&sum| sum <= choice).min(cumulative.len() - 1) as u32;
        // Uniform over the triangle (Osada et al. 2002).
        let root = generator.random::<f32>().sqrt();
        let share = generator.random::<f32>();
        (triangle, Vec2::new(root * (1.0 - share), root * share))
    };
    // A scene of holes alone would never fill the count, hence the limit.
    let tries = u64::from(count) * 100;
    let is_surface = |&(triangle, barycentric): &TrianglePoint| {
        !(scene.may_be_cut_out(triangle) && scene.is_cut_out(triangle, barycentric))
    };
    (0..tries).map(|_| draw()).filter(is_surface).take(count as usize).collect()
}

/// The point of a file that lies on a triangle, in metres.
pub fn truth_point(scene: &Scene, (triangle, barycentric): TrianglePoint) -> TruthPoint {
    TruthPoint {
        position: scene.frame.point_to_metres(scene.mesh.position(triangle, barycentric)),
        normal: scene.mesh.shading_normal(triangle, barycentric).as_dvec3(),
    }
}

/// What a file's point lies on; `None` if it lies on no surface.
pub fn locate(scene: &Scene, tracer: &impl RayTracer, point: &TruthPoint) -> Option<Located> {
    locate_point(tracer, scene, scene.frame.point_to_local(point.position), point.normal.as_vec3())
}

/// Where rays leave from for a file's point, about the file's own normal; from an edge a little inside. A point on no
/// surface stays where it is. `tracer` must hold the same scene.
pub fn ray_origin(
    scene: &Scene,
    tracer: &dyn RayTracer,
    point: &TruthPoint,
    on: Option<TrianglePoint>,
) -> SurfacePoint {
    let shading_normal = point.normal.as_vec3();
    match on {
        Some((triangle, barycentric)) => {
            let weights = Vec3::new(1.0 - barycentric.element_sum(), barycentric.x, barycentric.y);
            let inside = weights.max(Vec3::splat(LEAST_WEIGHT));
            let barycentric = Vec2::new(inside.y, inside.z) / inside.element_sum();
            let point = SurfacePoint { shading_normal, ..SurfacePoint::new(scene, triangle, barycentric) };
            point.on_curve(scene, barycentric, tracer)
        }
        None => SurfacePoint {
            origin: scene.frame.point_to_local(point.position),
            geometric_normal: shading_normal,
            shading_normal,
            triangle: NO_TRIANGLE,
        },
    }
}
