//! The cases: one table.

use std::fmt;

use glam::DVec3;

use super::draft::Draft;
use crate::solver::SolveSettings;

/// A case.
#[derive(Clone)]
pub(super) struct Case {
    pub(super) group: &'static str,
    pub(super) name: String,
    pub(super) draft: Draft,
    pub(super) settings: SolveSettings,
    pub(super) asked: Asked,
}

impl Case {
    /// The same on elements that follow the light. Where they are cut hangs on ties between edges, which fall as numbers
    /// are rounded: so fields are the same to within the error that is asked of the elements.
    fn following_the_light(&self) -> Self {
        const ERROR: f32 = 0.05;
        let settings = SolveSettings { adaptive: ERROR, ..self.settings.clone() };
        let mut asked = self.asked.clone();
        if let Asked::SameAs { tolerance, .. } = &mut asked {
            *tolerance = f64::from(ERROR);
        }
        Self { group: "follow", settings, asked, ..self.clone() }
    }
}

/// What must be true of a case's answer, besides its bounds.
#[derive(Clone)]
pub(super) enum Asked {
    /// No more.
    Bounds,
    /// `factor` times another scene's field at the same points, but for a relative root mean square of `tolerance`.
    SameAs { other: Box<Draft>, factor: f64, tolerance: f64 },
    /// No light anywhere.
    Dark,
    /// Light, and no bounce of it.
    DirectOnly,
    /// Eq. 5 after as many bounces as there were, everywhere but for a relative `tolerance`.
    Furnace { reflectance: f64, tolerance: f64 },
}

impl fmt::Display for Asked {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bounds => write!(out, "bounds"),
            Self::SameAs { factor, tolerance, .. } if *factor == 1.0 => write!(out, "same field, to {tolerance:.0e}"),
            Self::SameAs { factor, tolerance, .. } => write!(out, "{factor:.0e} times the field, to {tolerance:.0e}"),
            Self::Dark => write!(out, "dark"),
            Self::DirectOnly => write!(out, "direct light alone"),
            Self::Furnace { tolerance, .. } => write!(out, "equation 5, to {tolerance:.0e}"),
        }
    }
}

/// A few elements and rays: what is stressed here is not their number.
fn settings() -> SolveSettings {
    SolveSettings { subdivide: 3, rays: 64, ..SolveSettings::even() }
}

fn case(group: &'static str, name: impl Into<String>, draft: Draft, asked: Asked) -> Case {
    Case { group, name: name.into(), draft, settings: settings(), asked }
}

fn same(tolerance: f64) -> Asked {
    times(1.0, tolerance)
}

fn times(factor: f64, tolerance: f64) -> Asked {
    Asked::SameAs { other: Box::new(Draft::cornell()), factor, tolerance }
}

fn same_as(other: Draft, tolerance: f64) -> Asked {
    Asked::SameAs { other: Box::new(other), factor: 1.0, tolerance }
}

/// All cases, or without those that take long.
pub(super) fn cases(full: bool) -> Vec<Case> {
    let mut cases = [places(), meshes(), lights(), values(), counts(full)].into_iter().flatten().collect::<Vec<_>>();
    let (seeds, triangles) = if full { (32, 500) } else { (6, 120) };
    for seed in 0..seeds {
        let name = |on_grid| format!("{triangles} triangles{}, seed {seed}", if on_grid { " on a grid" } else { "" });
        let soup = |on_grid| case("soups", name(on_grid), Draft::soup(seed, triangles, on_grid), Asked::Bounds);
        cases.extend(
            [false, true]
                .map(soup)
                .map(|case| Case { settings: SolveSettings { subdivide: 1, ..case.settings }, ..case }),
        );
    }
    let step = if full { 1 } else { 3 };
    let following: Vec<_> = cases.iter().step_by(step).map(Case::following_the_light).collect();
    cases.extend(following);
    cases
}

/// Places are rounded to 24 bits of the scene's size: so a ray in a few thousand meets another element's side of an edge.
const ROUNDED: f64 = 2e-3;
/// Where rays meet another surface of the same field, that has sampling errors of its own.
const ALMOST: f64 = 2e-2;

fn places() -> Vec<Case> {
    let scaled = [1e-6, 1e-3, 1e3, 1e6].map(|factor| {
        case("places", format!("{factor:e} times as large"), Draft::cornell().scaled(factor), same(ROUNDED))
    });
    let far = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::ONE].map(|direction| {
        let draft = Draft::cornell().moved(1e5 * 0.5592 * direction);
        case("places", format!("moved by 100000 sizes along {direction}"), draft, same(ROUNDED))
    });
    let both = Draft::cornell().scaled(1e-6).moved(DVec3::splat(0.05));
    let both = case("places", "1e-6 times as large, moved by 100000 sizes", both, same(ROUNDED));
    scaled.into_iter().chain(far).chain([both]).collect()
}

fn meshes() -> Vec<Case> {
    let quad = |corners: [[f64; 3]; 4], material: &str| {
        let vertices: Vec<String> = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        format!("{}usemtl {material}\nf -4 -3 -2 -1\n", vertices.concat())
    };
    let floor = |height: f64, material: &str| {
        quad([[0.5528, height, 0.0], [0.0, height, 0.0], [0.0, height, 0.5592], [0.5496, height, 0.5592]], material)
    };
    let size = 0.5592;
    let block = |x: f64, z: f64| {
        let top = [[x, 0.2, z], [x, 0.2, z + 0.1], [x + 0.1, 0.2, z + 0.1], [x + 0.1, 0.2, z]];
        let side = |[a, b]: [usize; 2]| {
            let ground = |corner: usize| [top[corner][0], 0.0, top[corner][2]];
            quad([top[b], top[a], ground(a), ground(b)], "white")
        };
        quad(top, "white") + &[[0, 1], [1, 2], [2, 3], [3, 0]].map(side).concat()
    };
    let needle = |length: f64| {
        let width = length / 1e5;
        quad(
            [[0.05, 0.3, 0.2], [0.05, 0.3, 0.2 + width], [0.05 + length, 0.3, 0.2 + width], [0.05 + length, 0.3, 0.2]],
            "white",
        )
    };
    let cornell = Draft::cornell;
    let red = || Draft::cornell().with_red_floor();
    let fin = "v 0.1 0 0.5\nv 0.2 0 0.5\nv 0.15 0.1 0.5\nv 0.15 0.1 0.4\nv 0.15 0.02 0.45\nusemtl white\n\
               f -5 -4 -3\nf -5 -4 -2\nf -4 -5 -1\n";
    vec![
        case("meshes", "needles 1 to 100000", cornell().with(&[0.1, 0.4].map(needle).concat()), same(ALMOST)),
        case("meshes", "the floor once more", cornell().with(&floor(0.0, "white")), same(ROUNDED)),
        // Of faces in one place the later one stays, and what lies so near is in one place.
        case("meshes", "the floor once more, red", cornell().with(&floor(0.0, "red")), same_as(red(), ALMOST)),
        case(
            "meshes",
            "a red floor 1e-7 sizes above",
            cornell().with(&floor(1e-7 * size, "red")),
            same_as(red(), ALMOST),
        ),
        case("meshes", "a floor 1e-7 sizes above", cornell().with(&floor(1e-7 * size, "white")), same(ALMOST)),
        case("meshes", "a floor 1e-7 sizes below", cornell().with(&floor(-1e-7 * size, "white")), same(ALMOST)),
        case(
            "meshes",
            "blocks through each other",
            cornell().with(&block(0.2, 0.2)).with(&block(0.25, 0.23)),
            Asked::Bounds,
        ),
        case("meshes", "three faces at an edge", cornell().with(fin), Asked::Bounds),
        case("meshes", "vertices of no face", cornell().with("v 9 9 9\nv -9 0.5 0.5\n"), Asked::Bounds),
        case("meshes", "vertices twice", cornell().with("v 0 0 0\nv 0 0 0\nv 0.1 0.1 0.1\n"), same(0.0)),
        case("meshes", "faces without area", cornell().with("usemtl white\nf 1 1 2\nf 3 3 3\n"), same(0.0)),
    ]
}

fn lights() -> Vec<Case> {
    let lit = |name: &str, asked, change: &dyn Fn(&mut crate::scene::area_light::AreaLightState)| {
        case("lights", name, Draft::cornell().lit_by(change), asked)
    };
    vec![
        lit("in the ceiling's plane", same(ALMOST), &|light| light.centre[1] = 0.5488),
        lit("touching the left wall", Asked::Bounds, &|light| light.centre[0] = 0.556 - 0.065),
        lit("half outside", Asked::Bounds, &|light| light.centre[0] = 0.556),
        lit("in the floor's plane, shining into the ground", Asked::Bounds, &|light| light.centre[1] = 0.0),
        lit("of no size", Asked::Dark, &|light| light.u = [0.0; 3]),
        lit("a line of no width", Asked::Dark, &|light| light.u = light.v),
        lit("1e-6 m wide", Asked::Bounds, &|light| (light.u, light.v) = ([5e-7, 0.0, 0.0], [0.0, 0.0, 5e-7])),
        lit("a kilometre wide", Asked::Bounds, &|light| (light.u, light.v) = ([500.0, 0.0, 0.0], [0.0, 0.0, 500.0])),
        lit("a kilometre away", Asked::Bounds, &|light| light.centre = [0.278, 0.273, -1000.0]),
        lit("edge-on to the side walls", Asked::Bounds, &|light| {
            (light.centre, light.u, light.v) = ([0.278, 0.3, 0.2795], [0.0, 0.065, 0.0], [0.0, 0.0, 0.0525]);
        }),
        lit("standing in the floor", Asked::Bounds, &|light| {
            (light.centre, light.u, light.v) = ([0.35, 0.0, 0.1], [0.0, 0.065, 0.0], [0.05, 0.0, 0.0]);
        }),
        lit("skew", Asked::Bounds, &|light| light.v = [0.06, 0.0, 1e-4]),
    ]
}

fn values() -> Vec<Case> {
    let shining = [1e-20_f32, 1e-6, 1e6, 1e20].map(|factor| {
        let draft = Draft::cornell().lit_by(|light| light.radiance = light.radiance.map(|value| value * factor));
        case("values", format!("{factor:e} times the light"), draft, times(f64::from(factor), 1e-5))
    });
    let no_light = Draft::cornell().lit_by(|light| light.radiance = [0.0; 3]);
    let furnaces = [(0.0, 1e-3), (0.5, 1e-3), (0.95, 1e-3), (0.999, 1e-3)].map(|(reflectance, tolerance)| Case {
        settings: SolveSettings { subdivide: 2, ..settings() },
        ..case(
            "values",
            format!("a closed box that reflects {reflectance}"),
            Draft::furnace(reflectance),
            Asked::Furnace { reflectance, tolerance },
        )
    });
    let black = case("values", "nothing reflects", Draft::cornell().reflecting(0.0), Asked::DirectOnly);
    let bright = case("values", "everything reflects 0.999", Draft::cornell().reflecting(0.999), Asked::Bounds);
    let dark = case("values", "a light of no radiance", no_light, Asked::Dark);
    shining.into_iter().chain(furnaces).chain([black, bright, dark]).collect()
}

fn counts(full: bool) -> Vec<Case> {
    let rays = |rays: u32, draft: Draft, name: &str, asked: Asked| Case {
        settings: SolveSettings { subdivide: 0, rays, ..settings() },
        ..case("counts", name, draft, asked)
    };
    let mut cases = vec![
        rays(64, Draft::triangle(), "one triangle", Asked::DirectOnly),
        rays(0, Draft::cornell(), "no rays", Asked::DirectOnly),
        rays(1, Draft::cornell(), "one ray a vertex", Asked::Bounds),
    ];
    if full {
        cases.push(rays(10_000_000, Draft::triangle(), "ten million rays a vertex", Asked::DirectOnly));
    }
    cases
}
