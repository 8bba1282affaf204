//! Faces that lie on one another, turn their backs to each other, or stand on one another: each kind small, with values
//! that follow from closed forms, and each turned, scaled, moved, in other order, cut otherwise and a hair apart.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{f64::consts::PI, fmt::Write, sync::Arc};

use common::{problem, solve_with_elements};
use glam::{DMat3, DVec3};
use radiosity::{
    check::{
        path_tracer::{PathSettings, PathTracer},
        surface_points::{locate, ray_origin},
        truth_file::TruthPoint,
    },
    scene::{LoadOptions, Scene, area_light::AreaLightState, load::load_from_memory},
    solver::{Reconstruction, Reconstructor, SolveSettings},
    trace::Tracer,
    transport::origins::VertexValues,
};

const MATERIALS: &str = "newmtl w\nKd .5 .5 .5\nKe 1 1 1\nnewmtl w2\nKd .5 .5 .5\nKe 1 1 1\nnewmtl grey\nKd .5 .5 .5\n\
    newmtl lamp\nKd 0 0 0\nKe 10 10 10\nnewmtl carpet\nKd .05 .05 .6\n";

/// A rectangle: a corner, its two sides (the front is where u × v points), and its material.
#[derive(Clone, Copy)]
struct Quad(DVec3, DVec3, DVec3, &'static str);

/// How a scene is written down; the light in it stays what it is.
#[derive(Clone, Copy)]
struct Variant {
    name: &'static str,
    turn: f64,
    scale: f64,
    offset: f64,
    reversed: bool,
    cells: usize,
}

const PLAIN: Variant = Variant { name: "plain", turn: 0.0, scale: 1.0, offset: 0.0, reversed: false, cells: 1 };
const VARIANTS: [Variant; 7] = [
    PLAIN,
    Variant { name: "turned", turn: 0.7, ..PLAIN },
    Variant { name: "small", scale: 1e-4, ..PLAIN },
    Variant { name: "large and turned", scale: 1e4, turn: -1.9, ..PLAIN },
    Variant { name: "far", offset: 1e4, ..PLAIN },
    Variant { name: "reversed", reversed: true, ..PLAIN },
    Variant { name: "cut", cells: 3, ..PLAIN },
];

impl Variant {
    fn turned(&self) -> DMat3 {
        DMat3::from_axis_angle(DVec3::new(0.3, 0.8, -0.5).normalize(), self.turn)
    }

    fn place(&self, point: DVec3) -> DVec3 {
        self.scale * (self.turned() * point) + DVec3::splat(self.offset)
    }

    fn scene(&self, quads: &[Quad]) -> Arc<Scene> {
        let mut obj = String::new();
        let mut count = 0;
        let mut quads = quads.to_vec();
        if self.reversed {
            quads.reverse();
        }
        for Quad(corner, u, v, material) in quads {
            writeln!(obj, "usemtl {material}").unwrap();
            let cells = self.cells as f64;
            for (i, j) in (0..self.cells).flat_map(|i| (0..self.cells).map(move |j| (i as f64, j as f64))) {
                for (s, t) in [(i, j), (i + 1.0, j), (i + 1.0, j + 1.0), (i, j + 1.0)] {
                    let point = self.place(corner + s / cells * u + t / cells * v);
                    writeln!(obj, "v {} {} {}", point.x, point.y, point.z).unwrap();
                }
                // The other diagonal where cells are cut.
                let order = if self.cells > 1 { [2, 3, 4, 1] } else { [1, 2, 3, 4] }.map(|corner| count + corner);
                writeln!(obj, "f {} {} {}\nf {} {} {}", order[0], order[1], order[2], order[0], order[2], order[3])
                    .unwrap();
                count += 4;
            }
        }
        Arc::new(load_from_memory(self.name, &obj, MATERIALS, &LoadOptions::default()).unwrap())
    }

    fn light(&self, light: &AreaLightState) -> AreaLightState {
        let vector = |vector: [f64; 3]| (self.scale * (self.turned() * DVec3::from_array(vector))).to_array();
        let centre = self.place(DVec3::from_array(light.centre)).to_array();
        AreaLightState { centre, u: vector(light.u), v: vector(light.v), ..*light }
    }
}

/// The inside of a box from `low` to `high`: floor, ceiling, and four walls.
fn room(low: DVec3, high: DVec3, material: &'static str) -> Vec<Quad> {
    let size = high - low;
    let [x, y, z] = [size.x * DVec3::X, size.y * DVec3::Y, size.z * DVec3::Z];
    vec![
        Quad(low, z, x, material),
        Quad(low + y, x, z, material),
        Quad(low, x, y, material),
        Quad(low + z, y, x, material),
        Quad(low, y, z, material),
        Quad(low + x, z, y, material),
    ]
}

/// The outside of a box.
fn solid(low: DVec3, high: DVec3, material: &'static str) -> Vec<Quad> {
    room(low, high, material).into_iter().map(|Quad(corner, u, v, material)| Quad(corner, v, u, material)).collect()
}

fn unit_room(material: &'static str) -> Vec<Quad> {
    room(DVec3::ZERO, DVec3::ONE, material)
}

fn even(subdivide: u32, vertex_values: VertexValues) -> SolveSettings {
    SolveSettings { adaptive: 0.0, subdivide, rays: 128, light_rays: 256, vertex_values, ..SolveSettings::default() }
}

/// Direct and total irradiance (red) at points, by the solver: direct light at the point itself.
fn solved(
    scene: &Arc<Scene>,
    light: Option<AreaLightState>,
    settings: SolveSettings,
    points: &[TruthPoint],
) -> Vec<[f64; 2]> {
    let problem = problem(scene, light, settings);
    let solved = solve_with_elements(&problem);
    let tracer = Tracer::new(scene.clone());
    let field = Reconstructor::new(scene, &tracer, &solved.tessellation, &solved.solution, Reconstruction::PointDirect);
    let at = |point: &TruthPoint| match locate(scene, &tracer, point).unwrap().on() {
        Some((triangle, place)) => {
            let (direct, total) = field.direct_and_total(triangle, place);
            [f64::from(direct.x), f64::from(total.x)]
        }
        None => [0.0; 2],
    };
    points.iter().map(at).collect()
}

/// The same by the reference path tracer, with the total's standard error.
fn traced(scene: &Arc<Scene>, light: Option<AreaLightState>, points: &[TruthPoint]) -> Vec<[f64; 3]> {
    let tracer = Tracer::new(scene.clone());
    let light = light.map(|light| light.to_local(&scene.frame));
    let settings = PathSettings { samples: 1000, bounces: 40, seed: 5 };
    let origins: Vec<_> = points
        .iter()
        .map(|point| ray_origin(scene, &tracer, point, locate(scene, &tracer, point).unwrap().on()))
        .collect();
    let found = PathTracer::new(scene, &tracer, light.as_ref(), settings).estimate_all(&origins, |_| ());
    found.iter().map(|found| [found.direct.mean.x, found.total.mean.x, found.total.standard_error.x]).collect()
}

fn points(variant: &Variant, places: &[([f64; 3], DVec3)]) -> Vec<TruthPoint> {
    let point = |(position, normal): &([f64; 3], DVec3)| TruthPoint {
        position: variant.place(DVec3::from_array(*position)),
        normal: variant.turned() * *normal,
    };
    places.iter().map(point).collect()
}

/// Solver and path tracer against expected direct and total irradiance.
fn assert_light(variant: &Variant, quads: &[Quad], places: &[([f64; 3], DVec3)], expected: &[[f64; 2]], what: &str) {
    let scene = variant.scene(quads);
    let points = points(variant, places);
    let solved = solved(&scene, None, even(2, VertexValues::Point), &points);
    let traced = traced(&scene, None, &points);
    for (((place, solved), traced), expected) in places.iter().zip(solved).zip(traced).zip(expected) {
        let name = format!("{what}, {}, at {:?}: {solved:?} {traced:?}", variant.name, place.0);
        // Closed forms are exact but for rounding; many small emitters are sampled.
        let noise = if variant.cells > 1 { 0.03 } else { 2e-3 };
        assert!((solved[0] - expected[0]).abs() <= noise * expected[0] + 1e-9, "direct, {name}, not {expected:?}");
        assert!((solved[1] - expected[1]).abs() <= 0.02 * expected[1] + 1e-9, "total, {name}, not {expected:?}");
        let error = 4.0 * traced[2] + 2e-3 * expected[1];
        assert!((traced[1] - expected[1]).abs() <= error, "path tracer, {name}, not {expected:?}");
    }
}

const UP: DVec3 = DVec3::Y;
const DOWN: DVec3 = DVec3::NEG_Y;
const FURNACE: [([f64; 3], DVec3); 4] = [
    ([0.3, 0.0, 0.62], UP),
    ([0.53, 1.0, 0.41], DOWN),
    ([0.0, 0.37, 0.45], DVec3::X),
    ([0.71, 0.22, 1.0], DVec3::NEG_Z),
];

/// A card in the furnace: a face at height 0.5, and its reverse `gap` below it.
fn card(gap: f64) -> Vec<Quad> {
    let mut quads = unit_room("w");
    let (u, v) = (0.6 * DVec3::X, 0.6 * DVec3::Z);
    quads.push(Quad(DVec3::new(0.2, 0.5, 0.2), v, u, "w"));
    quads.push(Quad(DVec3::new(0.2, 0.5 - gap, 0.2), u, v, "w"));
    quads
}

/// Expected: a closed furnace of reflectance 1/2 and emission π has direct π and total 2 π everywhere (eq. 5).
#[test]
fn a_card_with_two_sides_in_a_furnace_changes_nothing() {
    let card_places = [([0.41, 0.5, 0.37], UP), ([0.61, 0.5, 0.57], DOWN)];
    let places = [&FURNACE[..], &card_places].concat();
    for variant in &VARIANTS {
        assert_light(variant, &card(0.0), &places, &[[PI, 2.0 * PI]; 6], "card");
    }
    for gap in [1e-7, 1e-6, -1e-7, -1e-6, 1e-5, 1e-3] {
        for variant in &[PLAIN, VARIANTS[1]] {
            assert_light(variant, &card(gap), &FURNACE, &[[PI, 2.0 * PI]; 4], &format!("card {gap}"));
        }
    }
}

/// Expected: the furnace again, the floor being there once, whichever of the two it is.
#[test]
fn a_floor_that_is_there_twice_shines_once() {
    for (variant, gap) in VARIANTS
        .iter()
        .map(|variant| (variant, 0.0))
        .chain([1e-7, 1e-6, -1e-7, -1e-6, 1e-5, 1e-3].map(|gap| (&PLAIN, gap)))
    {
        let mut quads = unit_room("w");
        quads.push(Quad(gap * DVec3::Y, DVec3::Z, DVec3::X, "w2"));
        assert_light(variant, &quads, &FURNACE[1..], &[[PI, 2.0 * PI]; 3], &format!("floors {gap}"));
        assert!(
            variant.scene(&quads).warnings.iter().any(|line| line.contains("in the place of another"))
                == (gap.abs() < 1e-5)
        );
    }
}

/// Expected: Lambert's formula for the lamp alone (1.855, as a square of 0.4 by 0.4 at 0.9 gives below its middle).
#[test]
fn a_lamp_whose_faces_overlap_shines_once() {
    let lamp = |corner: DVec3, size: f64| Quad(corner, size * DVec3::X, size * DVec3::Z, "lamp");
    for variant in &VARIANTS {
        let mut quads = unit_room("grey");
        quads.push(lamp(DVec3::new(0.3, 0.9, 0.3), 0.4));
        quads.push(lamp(DVec3::new(0.35, 0.9, 0.4), 0.25));
        let points = points(variant, &[([0.5, 0.0, 0.5], UP), ([0.2, 0.0, 0.7], UP)]);
        let found = solved(&variant.scene(&quads), None, even(1, VertexValues::Point), &points);
        assert!((found[0][0] - 1.855).abs() < 2e-3 && (found[1][0] - 1.42).abs() < 5e-3, "{}: {found:?}", variant.name);
    }
}

/// Expected: Lambert's formula where the lamp lies in the ceiling or below it, nothing where it is hidden above it.
#[test]
fn a_lamp_laid_on_the_ceiling_shines_and_one_behind_it_does_not() {
    let variants = VARIANTS.iter().map(|variant| (variant, 0.0));
    for (variant, below) in
        variants.chain([1e-7, 1e-6, -1e-7, -1e-6, 1e-5, 1e-3, -1e-5, -1e-3].map(|gap| (&PLAIN, gap)))
    {
        for lamp_first in [false, true] {
            let mut quads = unit_room("grey");
            let lamp = Quad(DVec3::new(0.3, 1.0 - below, 0.3), 0.4 * DVec3::X, 0.4 * DVec3::Z, "lamp");
            quads.insert(if lamp_first { 0 } else { quads.len() }, lamp);
            let expected = if below < -5e-6 { 0.0 } else { 1.52 };
            let place = points(variant, &[([0.5, 0.0, 0.5], UP)]);
            let scene = variant.scene(&quads);
            let found = solved(&scene, None, even(1, VertexValues::Point), &place)[0][0];
            assert!((found - expected).abs() < 0.005, "{} {below}: {found}, not {expected}", variant.name);
            let traced = traced(&scene, None, &place)[0][0];
            assert!((traced - expected).abs() < 0.15, "{} {below}: {traced}, not {expected}", variant.name);
        }
    }
}

/// Expected: a carpet a millimetre above the floor, whose red is a twelfth of the floor's; without it there is more than
/// twice the light.
#[test]
fn a_carpet_in_the_plane_of_the_floor_is_seen_like_one_above_it() {
    let with_carpet = |height: f64| {
        let mut quads = room(DVec3::new(-1.0, 0.0, -1.0), DVec3::ONE, "grey");
        quads.push(Quad(DVec3::new(-0.3, 0.9, -0.3), 0.6 * DVec3::X, 0.6 * DVec3::Z, "lamp"));
        quads.push(Quad(DVec3::new(-0.8, height, -0.8), 1.6 * DVec3::Z, 1.6 * DVec3::X, "carpet"));
        quads
    };
    let places = [([-0.61, 1.0, 0.42], DOWN), ([0.53, 1.0, -0.67], DOWN), ([0.02, 1.0, 0.91], DOWN)];
    let light = |variant: &Variant, height: f64| {
        let scene = variant.scene(&with_carpet(height));
        let points = points(variant, &places);
        let solved = solved(&scene, None, SolveSettings::default(), &points);
        (
            solved.iter().map(|found| found[1]).sum::<f64>(),
            traced(&scene, None, &points).iter().map(|found| found[1]).sum::<f64>(),
        )
    };
    let (expected, _) = light(&PLAIN, 1e-3);
    let reversed_first = VARIANTS.iter().filter(|variant| !variant.reversed).map(|variant| (variant, 0.0));
    for (variant, height) in reversed_first.chain([1e-7, -1e-7, 1e-6, -1e-6].map(|height| (&PLAIN, height))) {
        let (solved, traced) = light(variant, height);
        assert!((solved / expected - 1.0).abs() < 0.03, "{} {height}: {solved}, not {expected}", variant.name);
        assert!((traced / expected - 1.0).abs() < 0.06, "{} {height}: {traced}, not {expected}", variant.name);
    }
    // In the reversed file the floor comes later, and wins.
    let (bare, _) = light(&VARIANTS[5], 0.0);
    assert!(bare > 1.5 * expected, "{bare} {expected}");
}

/// Two rooms over one floor, and what divides them at x = 2.
fn two_rooms(divider: &[Quad]) -> Vec<Quad> {
    let mut quads = room(DVec3::ZERO, DVec3::new(4.0, 2.0, 2.0), "grey");
    quads.extend(divider);
    quads
}

fn wall(thickness: f64) -> Vec<Quad> {
    solid(DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0 + thickness, 2.0, 2.0), "grey")
}

const CEILING_LIGHT: AreaLightState =
    AreaLightState { centre: [1.0, 1.98, 1.0], u: [0.2, 0.0, 0.0], v: [0.0, 0.0, 0.2], radiance: [20.0; 3] };

fn dark_points(from: f64) -> Vec<([f64; 3], DVec3)> {
    let places = (1..36).map(|step| from + 1e-4 + f64::from(step * step) * 1.2e-3);
    places.flat_map(|x| [([x, 0.0, 0.613], UP), ([x, 2.0, 1.377], DOWN), ([x, 0.71, 0.0], DVec3::Z)]).collect()
}

/// Expected: nothing, exactly: no path leads there.
#[test]
fn behind_a_wall_that_stands_on_the_floor_it_is_dark_with_every_method() {
    let (u, v) = (2.0 * DVec3::Y, 2.0 * DVec3::Z);
    let sheet = vec![Quad(2.0 * DVec3::X, u, v, "grey"), Quad(2.0 * DVec3::X, v, u, "grey")];
    // Without its bottom and top, the wall's sides alone stand on the floor.
    let open: Vec<Quad> = wall(0.001).into_iter().skip(2).collect();
    let settings = [
        SolveSettings { rays: 128, ..SolveSettings::default() },
        even(3, VertexValues::Point),
        even(2, VertexValues::Average),
        even(2, VertexValues::LeastSquares),
    ];
    for (divider, until, name) in [
        (sheet, 2.0, "sheet"),
        (wall(0.001), 2.001, "wall"),
        (open, 2.001, "open wall"),
        (wall(0.3), 2.3, "thick wall"),
    ] {
        for (index, variant) in VARIANTS.iter().enumerate() {
            let settings = if index == 0 { &settings[..] } else { &settings[..1] };
            let scene = variant.scene(&two_rooms(&divider));
            let light = variant.light(&CEILING_LIGHT);
            for settings in settings {
                let places = points(variant, &dark_points(until));
                let found = solved(&scene, Some(light), settings.clone(), &places);
                let brightest = found.iter().map(|found| found[1]).fold(0.0, f64::max);
                assert_eq!(brightest, 0.0, "{name}, {}, {settings:?}: {found:?}", variant.name);
            }
        }
    }
}

/// Expected: the path tracer's values; the error of anywhere else.
#[test]
fn in_front_of_the_wall_light_is_right_up_to_the_wall() {
    let quads = two_rooms(&wall(0.001));
    let places: Vec<_> =
        [0.002, 0.01, 0.03, 0.1].map(|gap| [([2.0 - gap, 0.0, 0.613], UP), ([2.0 - gap, 2.0, 1.377], DOWN)]).concat();
    for variant in &[PLAIN, VARIANTS[1]] {
        let (scene, light) = (variant.scene(&quads), variant.light(&CEILING_LIGHT));
        let places = points(variant, &places);
        let found = solved(&scene, Some(light), SolveSettings { rays: 256, ..SolveSettings::default() }, &places);
        for (found, [_, expected, error]) in found.iter().zip(traced(&scene, Some(light), &places)) {
            assert!((found[1] - expected).abs() < 4.0 * error + 0.06 * expected, "{found:?} {expected} ± {error}");
        }
    }
}

/// Expected: the same room with one box for a wall.
#[test]
fn a_wall_of_ten_boxes_that_touch_is_like_one_of_one_box() {
    let shell = |divider: Vec<Quad>| {
        // The room's own shell is made of boxes, too.
        let mut quads = vec![];
        for (from, to) in [
            (DVec3::new(-0.2, -0.2, -0.2), DVec3::new(4.2, 0.0, 2.2)),
            (DVec3::new(-0.2, 2.0, -0.2), DVec3::new(4.2, 2.2, 2.2)),
            (DVec3::new(-0.2, 0.0, -0.2), DVec3::new(4.2, 2.0, 0.0)),
            (DVec3::new(-0.2, 0.0, 2.0), DVec3::new(4.2, 2.0, 2.2)),
            (DVec3::new(-0.2, 0.0, 0.0), DVec3::new(0.0, 2.0, 2.0)),
            (DVec3::new(4.0, 0.0, 0.0), DVec3::new(4.2, 2.0, 2.0)),
        ] {
            quads.extend(solid(from, to, "grey"));
        }
        quads.extend(divider);
        quads
    };
    let ten = (0..10).flat_map(|part| {
        let z = |part: i32| 0.2 * f64::from(part);
        solid(DVec3::new(2.0, 0.0, z(part)), DVec3::new(2.1, 2.0, z(part + 1)), "grey")
    });
    let places: Vec<_> = (0..20).map(|step| ([2.0, 0.031 + 0.1 * f64::from(step), 0.002], DVec3::NEG_X)).collect();
    let seams = (1..10).map(|step| ([2.0, 0.83, 0.2 * f64::from(step) + 0.002], DVec3::NEG_X));
    let floor = (1..10).map(|step| ([1.998, 0.0, 0.2 * f64::from(step) - 0.002], UP));
    let places: Vec<_> = places.into_iter().chain(seams).chain(floor).collect();
    let settings = SolveSettings { rays: 256, ..SolveSettings::default() };
    let ten: Vec<Quad> = ten.collect();
    for variant in &[PLAIN, VARIANTS[1], VARIANTS[5]] {
        let light = variant.light(&CEILING_LIGHT);
        let of = |divider: Vec<Quad>| {
            let scene = variant.scene(&shell(divider));
            solved(&scene, Some(light), settings.clone(), &points(variant, &places))
        };
        let (one, ten) = (of(wall(0.1)), of(ten.clone()));
        let mean = one.iter().map(|found| found[1]).sum::<f64>() / one.len() as f64;
        for ((place, one), ten) in places.iter().zip(&one).zip(&ten) {
            assert!((one[1] - ten[1]).abs() < 0.06 * mean, "{}, {:?}: {one:?} {ten:?}", variant.name, place.0);
        }
    }
    let scene = PLAIN.scene(&shell(ten));
    assert!(scene.warnings.iter().any(|line| line.contains("enclosed")), "{:?}", scene.warnings);
    assert!(!scene.enclosed.is_empty());
}

/// Expected: one value on both sides of an edge. One half of the floor is a whole face, the other comes in three.
#[test]
fn across_an_edge_with_corners_of_others_on_it_light_does_not_jump() {
    let mut quads = room(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0), "grey");
    quads[0] = Quad(DVec3::ZERO, DVec3::Z, DVec3::X, "grey");
    for part in 0..3 {
        let z = DVec3::Z / 3.0;
        quads.push(Quad(DVec3::X + f64::from(part) * z, z, DVec3::X, "grey"));
    }
    quads.push(Quad(DVec3::new(0.9, 0.95, 0.1), 0.3 * DVec3::X, 0.3 * DVec3::Z, "lamp"));
    for variant in &VARIANTS {
        let scene = variant.scene(&quads);
        let problem = problem(&scene, None, even(2, VertexValues::Point));
        let solved = solve_with_elements(&problem);
        let tracer = Tracer::new(scene.clone());
        let field = Reconstructor::new(&scene, &tracer, &solved.tessellation, &solved.solution, Reconstruction::Vertex);
        let at = |x: f64, z: f64| {
            let place = &points(variant, &[([x, 0.0, z], UP)])[0];
            let (triangle, place) = locate(&scene, &tracer, place).unwrap().on().unwrap();
            field.direct_and_total(triangle, place).1.x
        };
        for step in 0..40 {
            let z = 0.012 + 0.0244 * f64::from(step);
            let (left, right) = (at(1.0 - 1e-4, z), at(1.0 + 1e-4, z));
            assert!((left / right - 1.0).abs() < 2e-3, "{}, {z}: {left} {right}", variant.name);
        }
    }
}

/// Expected: what is written in the file.
#[test]
fn scenes_without_contacts_are_read_as_they_are() {
    let scene = PLAIN.scene(&unit_room("w"));
    assert_eq!(scene.mesh.triangles.len(), 12);
    assert!(scene.warnings.is_empty() && scene.enclosed.is_empty(), "{:?}", scene.warnings);
    assert!(
        scene.mesh.normals.iter().all(|normal| normal.abs_diff_eq(normal.round(), 1e-6)),
        "{:?}",
        scene.mesh.normals
    );
}
