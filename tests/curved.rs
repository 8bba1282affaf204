//! Rounded bodies: light reaches as far round as their shading normals say, whatever the triangles are.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{collections::HashMap, fmt::Write as _, sync::Arc};

use common::{problem, solve_unwatched, solve_with_elements};
use glam::{DQuat, DVec3, Vec2, Vec3};
use radiosity::{
    check::{
        closed_form::{furnace_irradiance, polygon_irradiance},
        path_tracer::{PathSettings, PathTracer},
        surface_points::area_uniform_points,
    },
    scene::{LoadOptions, Scene, area_light::AreaLightState, load::load_from_memory},
    solver::{Engine, Problem, Reconstruction, Reconstructor, SolveSettings, settings::Iteration},
    trace::{SurfacePoint, Tracer},
    transport::{lights::DirectMethod, origins::VertexValues, visible_light::Scratch},
};

/// The unit sphere as an icosahedron whose triangles were cut in four so many times, and its corners pushed outwards.
fn sphere(cuts: u32) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners: Vec<DVec3> = Vec::new();
    for [a, b] in [[-1.0, golden], [1.0, golden], [-1.0, -golden], [1.0, -golden]] {
        corners.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)].map(DVec3::normalize));
    }
    // The 20 triples of corners that are each other's neighbours, counter-clockwise from outside.
    let near = |a: usize, b: usize| corners[a].distance(corners[b]) < 1.1;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in (b + 1..12).filter(|&c| near(a, b) && near(b, c) && near(a, c)) {
                let outward = corners[a].dot((corners[b] - corners[a]).cross(corners[c] - corners[a])) > 0.0;
                faces.push(if outward { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..cuts {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                corners.push((corners[a] + corners[b]).normalize());
                corners.len() - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (corners, faces)
}

/// A sphere as OBJ text, with its own normals; `inside` turns it round. `first` is the number of vertices before it.
fn sphere_obj(cuts: u32, place: impl Fn(DVec3) -> DVec3, turn: DQuat, inside: bool, first: usize) -> String {
    let (corners, faces) = sphere(cuts);
    let mut text = String::new();
    for corner in &corners {
        let (point, normal) = (place(turn * *corner), turn * *corner * if inside { -1.0 } else { 1.0 });
        writeln!(text, "v {} {} {}\nvn {} {} {}", point.x, point.y, point.z, normal.x, normal.y, normal.z).unwrap();
    }
    for [a, b, c] in faces {
        let words =
            if inside { [a, c, b] } else { [a, b, c] }.map(|corner| format!("{}//{}", first + corner + 1, corner + 1));
        writeln!(text, "f {}", words.join(" ")).unwrap();
    }
    text
}

/// A ball of radius 1 in the units given, lit by a small square 40 radii away from aside.
struct LitBall {
    scene: Arc<Scene>,
    light: AreaLightState,
}

fn lit_ball(cuts: u32, scale: f64, shift: DVec3, turn: DQuat, options: &LoadOptions) -> LitBall {
    let place = |point: DVec3| scale * point + shift;
    let obj = format!("usemtl grey\n{}", sphere_obj(cuts, place, turn, false, 0));
    let scene = Arc::new(load_from_memory("ball", &obj, "newmtl grey\nKd 0.5 0.5 0.5\n", options).unwrap());
    let (u, v) = (DVec3::new(0.0, 0.0, 0.5 * scale), DVec3::new(0.15, -0.2, 0.0).normalize() * 0.5 * scale);
    let centre = shift - u.cross(v).normalize() * 40.0 * scale;
    let light =
        AreaLightState { centre: centre.to_array(), u: u.to_array(), v: v.to_array(), radiance: [100.0, 50.0, 10.0] };
    LitBall { scene, light }
}

impl LitBall {
    /// Irradiance on a sphere at a point with this normal (eq. 6): nothing is in the way of what is above the horizon.
    fn expected(&self, position: Vec3, normal: Vec3) -> f32 {
        let light = self.light.to_local(&self.scene.frame);
        polygon_irradiance(position, normal, &light.corners(), light.radiance).x
    }

    /// Irradiance where the light stands highest.
    fn brightest(&self) -> f32 {
        let mesh = &self.scene.mesh;
        let at = |(position, normal): (&Vec3, &Vec3)| self.expected(*position, *normal);
        mesh.positions.iter().zip(&mesh.normals).map(at).fold(0.0, f32::max)
    }

    /// Of a solve's vertices: the largest error of direct light by the brightest, and how many are black in the light.
    fn errors(&self, problem: &Problem) -> (f32, usize) {
        let brightest = self.brightest();
        let solved = solve_with_elements(problem);
        let mesh = &solved.tessellation.mesh;
        let (mut worst, mut black) = (0.0_f32, 0);
        for (vertex, direct) in solved.solution.direct().iter().enumerate() {
            let expected = self.expected(mesh.positions[vertex], mesh.normals[vertex]);
            worst = worst.max((direct.x - expected).abs() / brightest);
            black += usize::from(expected > 0.1 * brightest && direct.x < 0.01 * brightest);
        }
        (worst, black)
    }
}

fn turned() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(0.3, 0.8, -0.5).normalize(), 0.7)
}

fn direct_only() -> SolveSettings {
    SolveSettings { bounces: Some(0), rays: 64, subdivide: 2, ..SolveSettings::even() }
}

/// Expected values: Lambert's formula at the vertices, about their shading normals. Flat triangles are off by 4 % of
/// the brightest light and more.
#[test]
fn light_on_a_ball_follows_its_shading_normals_at_any_size_and_place() {
    for (cuts, scale, shift, turn) in [
        (1, 1.0, DVec3::ZERO, DQuat::IDENTITY),
        (1, 1e-4, DVec3::ZERO, turned()),
        (1, 1e4, DVec3::new(3e5, -2e6, 1e5), DQuat::IDENTITY),
        (2, 1.0, DVec3::new(500.0, 20.0, -300.0), turned()),
        (0, 1.0, DVec3::ZERO, turned()),
    ] {
        let ball = lit_ball(cuts, scale, shift, turn, &LoadOptions::default());
        let (worst, black) = ball.errors(&problem(&ball.scene, Some(ball.light), direct_only()));
        assert!(black == 0 && worst < 0.02, "{cuts} cuts, scale {scale}: {black} black, off by {worst}");
        let flat = lit_ball(cuts, scale, shift, turn, &LoadOptions { faceted: true, ..LoadOptions::default() });
        let (worst, _) = flat.errors(&problem(&flat.scene, Some(flat.light), direct_only()));
        assert!(worst > 0.03, "{cuts} cuts, scale {scale}: off by {worst} only with flat triangles");
    }
}

/// Elements that follow the light have vertices all over the triangles.
#[test]
fn no_vertex_in_the_light_is_black_where_elements_follow_it() {
    let settings = || SolveSettings { adaptive: 0.02, bounces: Some(0), ..SolveSettings::default() };
    let black = [false, true].map(|faceted| {
        let options = LoadOptions { faceted, ..LoadOptions::default() };
        let ball = lit_ball(1, 1.0, DVec3::ZERO, DQuat::IDENTITY, &options);
        ball.errors(&problem(&ball.scene, Some(ball.light), settings())).1
    });
    assert!(black[0] == 0 && black[1] > 100, "black vertices: {black:?}");
}

/// The same for whatever finds the light. Averages over elements of that size are off by a few percent by their nature, and
/// samples by their noise.
#[test]
fn every_way_to_direct_light_follows_the_shading_normals() {
    let ball = lit_ball(1, 1.0, DVec3::ZERO, turned(), &LoadOptions::default());
    let ways = [
        (SolveSettings { direct: DirectMethod::Ratio, ..direct_only() }, 0.02),
        (SolveSettings { direct: DirectMethod::Sampled, light_rays: 256, ..direct_only() }, 0.02),
        (SolveSettings { vertex_values: VertexValues::Average, ..direct_only() }, 0.06),
        (SolveSettings { vertex_values: VertexValues::LeastSquares, ..direct_only() }, 0.06),
        (SolveSettings { adaptive: 0.02, bounces: Some(0), ..SolveSettings::default() }, 0.02),
        (SolveSettings { engine: Engine::Student, light_rays: 256, ..direct_only() }, 0.02),
    ];
    for (settings, bound) in ways {
        let what = format!("{:?} {:?} {:?}", settings.engine, settings.direct, settings.vertex_values);
        let (worst, black) = ball.errors(&problem(&ball.scene, Some(ball.light), settings));
        assert!(black == 0 && worst < bound, "{what}: {black} black, off by {worst}");
    }
}

/// Expected values: Lambert's formula; and the path tracer, which has samplers of its own, within its standard error.
#[test]
fn points_inside_the_triangles_of_a_ball_are_lit_by_their_shading_normals() {
    let ball = lit_ball(1, 1.0, DVec3::ZERO, turned(), &LoadOptions::default());
    let problem = problem(&ball.scene, Some(ball.light), direct_only());
    let (solution, _) = solve_unwatched(&problem);
    let (scene, tracer) = (&*ball.scene, Tracer::new(Arc::clone(&ball.scene)));
    let field = Reconstructor::new(scene, &tracer, &problem.tessellation, &solution, Reconstruction::PointDirect);
    let settings = PathSettings { samples: 400, bounces: 2, seed: 5 };
    let light = ball.light.to_local(&scene.frame);
    let path_tracer = PathTracer::new(scene, &tracer, Some(&light), settings);
    let brightest = ball.brightest();
    for (index, (triangle, place)) in area_uniform_points(scene, 400, 3).into_iter().enumerate() {
        let position = scene.mesh.position(triangle, place);
        let expected = ball.expected(position, scene.mesh.shading_normal(triangle, place));
        let found = field.irradiance(triangle, place, &mut Scratch::default()).direct.x;
        assert!((found - expected).abs() < 0.02 * brightest, "{position}: {found}, expected {expected}");
        let point = SurfacePoint::new(scene, triangle, place).on_curve(scene, place, &tracer);
        // A ball sees nothing of itself, so all its light is direct.
        let traced = path_tracer.estimate(&point, index as u32).total;
        let allowed = 4.0 * traced.standard_error.x + 1e-3 * f64::from(brightest);
        assert!((traced.mean.x - f64::from(found)).abs() < allowed, "{position}: {traced:?}, expected {found}");
    }
}

/// The inside of a box of half-size 2 around the ball, wound inwards, as OBJ text.
const BOX: &str = "v -2 -2 -2\nv 2 -2 -2\nv 2 2 -2\nv -2 2 -2\nv -2 -2 2\nv 2 -2 2\nv 2 2 2\nv -2 2 2\n\
                   f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 1 4 8 5\nf 6 7 3 2\n";

/// Irradiance of a furnace after so many bounces, at every vertex (eq. 5); the largest error relative to it.
fn furnace_error(obj: &str, settings: SolveSettings) -> f64 {
    let mtl = "newmtl w\nKd 0.5 0.5 0.5\nKe 1 1 1\n";
    let scene =
        Arc::new(load_from_memory("furnace", &format!("usemtl w\n{obj}"), mtl, &LoadOptions::default()).unwrap());
    let bounces = settings.bounces.unwrap();
    let (solution, _) = solve_unwatched(&problem(&scene, None, settings));
    assert!(!solution.buried.contains(&true));
    let expected = furnace_irradiance(std::f64::consts::PI, 0.5, bounces);
    let total = solution.total();
    let tracer = Tracer::new(Arc::clone(&scene));
    let path_tracer = PathTracer::new(&scene, &tracer, None, PathSettings { samples: 400, bounces, seed: 2 });
    for (index, (triangle, place)) in area_uniform_points(&scene, 40, 3).into_iter().enumerate() {
        let point = SurfacePoint::new(&scene, triangle, place).on_curve(&scene, place, &tracer);
        let found = path_tracer.estimate(&point, index as u32).total;
        let allowed = 4.0 * found.standard_error.x + 0.03 * expected;
        assert!((found.mean.x - expected).abs() < allowed, "path tracer: {found:?}, expected {expected}");
    }
    total.iter().map(|value| (f64::from(value.x) / expected - 1.0).abs()).fold(0.0, f64::max)
}

/// All that a convex ball sees is furnace, down to the horizon of its shading normals: so its irradiance is exact.
#[test]
fn a_ball_in_a_furnace_has_the_closed_form_everywhere() {
    let ball = sphere_obj(1, |point| point, turned(), false, 8);
    let settings = SolveSettings { rays: 1024, bounces: Some(6), subdivide: 1, ..SolveSettings::even() };
    for vertex_values in [VertexValues::Point, VertexValues::Average] {
        let error = furnace_error(&format!("{BOX}{ball}"), SolveSettings { vertex_values, ..settings.clone() });
        assert!(error < 0.01, "{vertex_values:?}: off by {error}");
    }
    let krylov = SolveSettings { iteration: Iteration::Krylov, bounces: Some(20), ..settings };
    let error = furnace_error(&format!("{BOX}{ball}"), krylov);
    assert!(error < 0.01, "Krylov: off by {error}");
}

/// Seen from inside a sphere is hollow, and stays as its triangles are: they hide what lies below their planes, 2.5 % of
/// the light where normals lean by 18°, and more with each bounce.
#[test]
fn a_sphere_from_inside_stays_as_it_was() {
    let obj = sphere_obj(1, |point| point, turned(), true, 0);
    let scenes = [false, true].map(|faceted| {
        let options = LoadOptions { faceted, ..LoadOptions::default() };
        let mtl = "newmtl w\nKd 0.5 0.5 0.5\nKe 1 1 1\n";
        Arc::new(load_from_memory("sphere", &format!("usemtl w\n{obj}"), mtl, &options).unwrap())
    });
    let settings = SolveSettings { rays: 64, bounces: Some(3), subdivide: 1, ..SolveSettings::even() };
    let [curved, faceted] = scenes.map(|scene| solve_unwatched(&problem(&scene, None, settings.clone())).0.total());
    assert_eq!(curved, faceted);
    let expected = furnace_irradiance(std::f64::consts::PI, 0.5, 3) as f32;
    assert!(curved.iter().all(|value| (0.9..1.01).contains(&(value.x / expected))));
}

/// A wall just before a ball's side: the curved surface would lie behind it, and be lit from there.
#[test]
fn a_ball_does_not_reach_through_a_wall_beside_it() {
    let ball = sphere_obj(0, |point| point, DQuat::IDENTITY, false, 0);
    // The icosahedron's faces are 0.795 from its middle; the wall of two sides cuts off what is beyond 0.8.
    let scene_text =
        format!("usemtl grey\n{ball}v -9 0.8 -9\nv 9 0.8 -9\nv 9 0.8 9\nv -9 0.8 9\nf 13 14 15 16\nf 16 15 14 13\n");
    let load = |faceted| {
        let options = LoadOptions { faceted, ..LoadOptions::default() };
        Arc::new(load_from_memory("wall", &scene_text, "newmtl grey\nKd 0.5 0.5 0.5\n", &options).unwrap())
    };
    let (curved, faceted) = (load(false), load(true));
    let (tracer, mut moved) = (Tracer::new(Arc::clone(&curved)), 0);
    for (triangle, place) in area_uniform_points(&curved, 20_000, 3).into_iter().filter(|(triangle, _)| *triangle < 20)
    {
        let flat = SurfacePoint::new(&faceted, triangle, place);
        let point = SurfacePoint::new(&curved, triangle, place).on_curve(&curved, place, &tracer);
        let wall = 0.8 / curved.frame.metres_per_unit as f32 - curved.frame.origin.y as f32;
        assert_eq!(flat.origin.y < wall, point.origin.y < wall, "{flat:?} {point:?}");
        moved += u32::from(flat.origin != point.origin);
    }
    assert!(moved > 10);
}

/// A flat square and a box whose corners have one normal each, which no smooth surface has.
#[test]
fn flat_triangles_and_boxes_with_normals_across_their_edges_stay_where_they_are() {
    let lean = Vec3::new(-1.0, -1.0, 1.0).normalize();
    for (normal, moves) in [(Vec3::Z, false), (lean, false), (Vec3::new(-0.2, -0.2, 1.0).normalize(), true)] {
        let normals = [normal, normal * Vec3::new(-1.0, 1.0, 1.0), normal * Vec3::new(1.0, -1.0, 1.0)];
        let mut obj = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
        normals.iter().for_each(|normal| writeln!(obj, "vn {} {} {}", normal.x, normal.y, normal.z).unwrap());
        obj.push_str("f 1//1 2//2 3//3\n");
        let scene = Arc::new(load_from_memory("triangle", &obj, "", &LoadOptions::default()).unwrap());
        let (tracer, place) = (Tracer::new(Arc::clone(&scene)), Vec2::new(0.3, 0.3));
        let flat = SurfacePoint::new(&scene, 0, place);
        let point = flat.on_curve(&scene, place, &tracer);
        assert_eq!(point.origin != flat.origin, moves, "{normal}");
        assert_eq!(point.geometric_normal != flat.geometric_normal, moves, "{normal}");
    }
}
