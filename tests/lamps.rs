//! Direct light of lamps of many triangles: of each as a whole, and of one triangle after the other.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{fmt::Write as _, sync::Arc};

use glam::{DVec3, Vec3};
use radiosity::{
    check::closed_form::polygon_irradiance,
    math::sequence::Sampler,
    scene::{LoadOptions, Scene, load::load_from_memory},
    trace::{NO_TRIANGLE, SurfacePoint, Tracer},
    transport::{
        Lights,
        direct::{DirectContext, ShadowRays},
        lights::{DirectMethod, FinderCounts},
        visible_light::Scratch,
    },
};

/// Corners and faces.
struct Shape(Vec<DVec3>, Vec<Vec<usize>>);

/// The faces of an icosahedron, each cut in four `cuts` times, on a sphere.
fn ball(cuts: u32, centre: DVec3, radius: f64) -> Shape {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners: Vec<DVec3> = (0..12)
        .map(|index| {
            let (a, b) = (if index % 2 == 0 { 1.0 } else { -1.0 }, if index / 2 % 2 == 0 { golden } else { -golden });
            [DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)][index / 4].normalize()
        })
        .collect();
    let is_edge = |a: usize, b: usize, corners: &[DVec3]| (corners[a].distance(corners[b]) - 1.0515).abs() < 1e-3;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if is_edge(a, b, &corners) && is_edge(b, c, &corners) && is_edge(a, c, &corners) {
                    let outward = (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(corners[a]) > 0.0;
                    faces.push(if outward { vec![a, b, c] } else { vec![a, c, b] });
                }
            }
        }
    }
    for _ in 0..cuts {
        let mut cut = Vec::new();
        for face in &faces {
            let middles: Vec<usize> = (0..3)
                .map(|side| {
                    let middle = (corners[face[side]] + corners[face[(side + 1) % 3]]).normalize();
                    corners.iter().position(|corner| corner.distance(middle) < 1e-9).unwrap_or_else(|| {
                        corners.push(middle);
                        corners.len() - 1
                    })
                })
                .collect();
            cut.extend((0..3).map(|side| vec![face[side], middles[side], middles[(side + 2) % 3]]));
            cut.push(middles);
        }
        faces = cut;
    }
    Shape(corners.into_iter().map(|corner| centre + radius * corner).collect(), faces)
}

/// A tube without ends along x, of 24 sides.
fn tube(centre: DVec3, length: f64, radius: f64) -> Shape {
    let corner = |end: f64, side: usize| {
        let (sine, cosine) = (std::f64::consts::TAU * side as f64 / 24.0).sin_cos();
        centre + DVec3::new(end * length, radius * cosine, radius * sine)
    };
    let corners = [-0.5, 0.5].into_iter().flat_map(|end| (0..24).map(move |side| corner(end, side)));
    let faces = (0..24).map(|side| (side, (side + 1) % 24)).map(|(this, next)| vec![this, next, 24 + next, 24 + this]);
    Shape(corners.collect(), faces.collect())
}

/// What stands over an outline in the plane y = 0, counter-clockwise as it is seen from above; its ends are these faces.
fn prism(outline: &[[f64; 2]], bottom: f64, height: f64, ends: &[&[usize]]) -> Shape {
    let count = outline.len();
    let corners =
        [bottom, bottom + height].into_iter().flat_map(|y| outline.iter().map(move |[x, z]| DVec3::new(*x, y, -*z)));
    let sides = (0..count).map(|this| vec![this, (this + 1) % count, count + (this + 1) % count, count + this]);
    let top = ends.iter().map(|end| end.iter().map(|corner| count + corner).collect());
    let base = ends.iter().map(|end| end.iter().rev().copied().collect());
    Shape(corners.collect(), sides.chain(top).chain(base).collect())
}

const SQUARE: [[f64; 2]; 4] = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]];

/// An L of 0.4 m.
fn angle() -> Shape {
    let outline = [[-0.1, -0.1], [0.3, -0.1], [0.3, 0.1], [0.1, 0.1], [0.1, 0.3], [-0.1, 0.3]];
    prism(&outline, -0.05, 0.1, &[&[0, 1, 2, 3], &[0, 3, 4, 5]])
}

/// The shape as a lamp of radiance 10 within other surfaces (OBJ) that do not shine. With `one_by_one` each triangle has
/// a radiance of its own, larger by up to 1e-4, so that each is a lamp.
fn lamp(Shape(corners, faces): &Shape, others: &str, one_by_one: bool) -> Arc<Scene> {
    let (mut obj, mut mtl) = (String::new(), String::from("newmtl grey\nKd 0.5 0.5 0.5\n"));
    for corner in corners {
        writeln!(obj, "v {} {} {}", corner.x, corner.y, corner.z).unwrap();
    }
    let triangles = faces.iter().flat_map(|face| (2..face.len()).map(|last| [face[0], face[last - 1], face[last]]));
    for (index, [a, b, c]) in triangles.enumerate() {
        let number = if one_by_one { index } else { 0 };
        if index == 0 || one_by_one {
            writeln!(mtl, "newmtl lamp{number}\nKd 0 0 0\nKe {0} {0} {0}", 10.0 + 2e-6 * number as f64).unwrap();
        }
        writeln!(obj, "usemtl lamp{number}\nf {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    // The frame shall not depend on the lamp.
    obj += "usemtl grey\nv -1 -1 -1\nv -1 -1 -0.999\nv -0.999 -1 -1\nf -3 -2 -1\nv 1 1 1\nv 1 1 0.999\nv 0.999 1 1\nf -3 -2 -1\n";
    Arc::new(load_from_memory("lamp", &(obj + others), &mtl, &LoadOptions::default()).unwrap())
}

/// Points all around the origin, each with a normal that turns more or less towards it, and so do their horizons; every
/// third has a shading normal of its own.
fn points(count: usize, distance: f32) -> Vec<SurfacePoint> {
    let direction = |index: usize| {
        let (sine, cosine) = (2.399_963 * index as f32).sin_cos();
        let z = 1.0 - 2.0 * (index as f32 + 0.5) / count as f32;
        (1.0 - z * z).sqrt() * Vec3::X * cosine + (1.0 - z * z).sqrt() * Vec3::Y * sine + z * Vec3::Z
    };
    let point = |index: usize| {
        let origin = distance * (0.7 + 0.6 * (index % 7) as f32 / 7.0) * direction(index);
        let geometric_normal = (1.2 * direction(index * 5 % count) - direction(index)).normalize();
        let aside = (geometric_normal + 0.4 * direction(index * 3 % count)).normalize();
        let shading_normal = if index.is_multiple_of(3) { aside } else { geometric_normal };
        SurfacePoint { origin, geometric_normal, shading_normal, triangle: NO_TRIANGLE }
    };
    (0..count).map(point).collect()
}

/// Direct light without samples, and the shadow rays that were traced for it all the same.
fn direct_at(scene: &Arc<Scene>, points: &[SurfacePoint]) -> (Vec<f32>, ShadowRays) {
    let context = DirectContext {
        scene,
        tracer: &Tracer::new(Arc::clone(scene)),
        lights: &Lights::new(scene, None),
        method: DirectMethod::Analytic,
        sampler: Sampler::Sobol,
        seed: 3,
        light_rays: 256,
        finders: FinderCounts { gather: 0, light: 256 },
        is_cancelled: &|| false,
    };
    let (mut scratch, mut rays) = (Scratch::default(), ShadowRays::default());
    let found = points.iter().map(|point| context.at_point(point, &mut scratch, &mut rays).irradiance().x);
    (found.collect(), rays)
}

/// The largest difference, and the largest of what is expected.
fn largest_difference(found: &[f32], expected: &[f32]) -> (f32, f32) {
    let pairs = || found.iter().zip(expected);
    (pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f32::max), expected.iter().copied().fold(0.0, f32::max))
}

/// Expected: the sum of Lambert's formula, in other words, over all triangles; from behind each is 0.
#[test]
fn a_convex_lamp_shines_as_the_sum_of_the_triangles_that_face_a_point() {
    let shapes = [
        ball(0, DVec3::ZERO, 0.1),
        ball(1, DVec3::new(0.02, 0.0, 0.03), 0.2),
        ball(2, DVec3::ZERO, 0.1),
        ball(3, DVec3::ZERO, 0.25),
        tube(DVec3::ZERO, 0.5, 0.03),
        prism(&SQUARE, -0.05, 0.1, &[&[0, 1, 2, 3]]),
    ];
    for (index, shape) in shapes.iter().enumerate() {
        let scene = lamp(shape, "", false);
        for distance in [0.31, 0.6] {
            let points: Vec<_> = points(200, distance)
                .into_iter()
                .map(|point| SurfacePoint { shading_normal: point.geometric_normal, ..point })
                .collect();
            let lambert = |point: &SurfacePoint| {
                let emissive = scene.emissive_triangles().map(|triangle| scene.mesh.corners(triangle));
                emissive
                    .map(|corners| {
                        polygon_irradiance(point.origin, point.shading_normal, &corners, Vec3::splat(10.0)).x
                    })
                    .sum()
            };
            let expected: Vec<f32> = points.iter().map(lambert).collect();
            let (found, rays) = direct_at(&scene, &points);
            let (worst, largest) = largest_difference(&found, &expected);
            assert!(worst < 1e-5 * largest, "{index} at {distance}: {worst} of {largest}");
            assert_eq!(rays.traced, 0, "{index}");
            assert!(expected.contains(&0.0) && largest > 0.5, "{largest}");
        }
    }
}

/// A wall of a corner at the first place and two edges, as OBJ.
fn wall(corner: [f64; 3], one: [f64; 3], other: [f64; 3]) -> String {
    let [corner, one, other] = [corner, one, other].map(DVec3::from_array);
    let corners = [corner, corner + one, corner + one + other, corner + other];
    let lines = corners.map(|corner| format!("v {} {} {}\n", corner.x, corner.y, corner.z)).concat();
    lines + "f -4 -3 -2 -1\n"
}

/// Expected: the same light where every triangle is a lamp of its own, hidden by the others and by what else there is: a
/// post beside it, a table under it, a ceiling that it is sunk into, and a plate that runs through it.
#[test]
fn what_hides_a_part_of_a_lamp_hides_the_same_of_its_triangles() {
    let shapes = [
        ball(1, DVec3::ZERO, 0.1),
        tube(DVec3::ZERO, 0.5, 0.03),
        prism(&SQUARE, -0.05, 0.1, &[&[0, 1, 2, 3]]),
        angle(),
    ];
    let others = [
        wall([0.4, -0.5, -0.1], [0.0, 1.0, 0.0], [0.0, 0.0, 0.07]),
        wall([-0.5, -0.1, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        wall([-0.5, 0.04, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        wall([-0.3, -0.2, 0.0], [0.4, 0.1, 0.1], [0.1, 0.3, 0.1]),
    ];
    for (index, shape) in shapes.iter().enumerate() {
        for (number, others) in others.iter().enumerate() {
            let points = points(150, 0.6);
            let (found, rays) = direct_at(&lamp(shape, others, false), &points);
            let (expected, rays_of_triangles) = direct_at(&lamp(shape, others, true), &points);
            let (worst, largest) = largest_difference(&found, &expected);
            assert!(worst < 1e-4 * largest, "{index} with {number}: {worst} of {largest}");
            // Of 38,400; what a table leaves of a ball on it may have too many corners.
            assert!(rays.traced < 64 && rays_of_triangles.traced == 0, "{index} with {number}: {rays:?}");
            assert!(rays.partly_seen + rays.hidden > 0, "{index} with {number}: {rays:?}");
        }
    }
}

/// Expected: no light. All that a point inside of a lamp sees are backs.
#[test]
fn inside_a_lamp_it_is_dark() {
    let scene = lamp(&ball(2, DVec3::ZERO, 0.4), "", false);
    let (found, rays) = direct_at(&scene, &points(50, 0.2));
    assert!(found.iter().all(|&value| value == 0.0));
    assert_eq!(rays.below_horizon, 50 * 256);
}
