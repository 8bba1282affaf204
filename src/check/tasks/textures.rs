//! Task `textures`: reading a texture, and reflectance that comes from one.

use glam::{Vec2, Vec3};

use super::{
    bounce,
    probe::{Check, Failure, Problem, Trial, call, quiet, written},
    stage::{Estimate, Quad, Stage, differs, estimate, matt},
};
use crate::{
    check::closed_form::polygon_irradiance,
    math::color::srgb_to_linear,
    scene::{Material, Texture, mesh::interpolate, texture::TextureFilter},
    student::{Receiver, SurfaceHit},
};

const SAMPLE: &str = "sample_texture";
const REFLECTANCE: &str = "surface_reflectance";

const SIZE: (u32, u32) = (3, 2);

/// Six colours, the top row first.
const TEXELS: [[u8; 4]; 6] =
    [[255, 0, 0, 255], [0, 200, 60, 255], [30, 90, 255, 0], [188, 188, 10, 255], [70, 20, 130, 255], [220, 140, 40, 9]];

/// The colour of the texel in this column, and row counted from below.
fn colour(column: usize, row_from_below: usize) -> Vec3 {
    let [red, green, blue, _] = TEXELS[3 * (1 - row_from_below) + column];
    Vec3::from([red, green, blue].map(|byte| srgb_to_linear(f32::from(byte) / 255.0)))
}

/// Texture coordinates, column, and row from below.
type Place = (Vec2, usize, usize);

/// The middles of the texels.
fn middles() -> Vec<Place> {
    let middle = |column: u8, row: u8| {
        let place = Vec2::new((f32::from(column) + 0.5) / 3.0, (f32::from(row) + 0.5) / 2.0);
        (place, usize::from(column), usize::from(row))
    };
    (0..2).flat_map(|row| (0..3).map(move |column| middle(column, row))).collect()
}

/// Places that show the step, and what to say if no other mistake is seen.
fn steps() -> [(&'static str, Vec<Place>, &'static str); 5] {
    let moved = |by: Vec2| middles().into_iter().map(move |(place, column, row)| (place + by, column, row));
    [
        ("texels inside the square", middles(), "column and row are those of the texel that holds the point"),
        (
            "the bottom left corner",
            vec![(Vec2::ZERO, 0, 0), (Vec2::new(0.01, 0.01), 0, 0), (Vec2::new(0.99, 0.99), 2, 1)],
            "the point is rounded to another texel: column ⌊u · width⌋, and rows likewise",
        ),
        (
            "texture coordinates above 1",
            moved(Vec2::new(1.0, 2.0)).chain(moved(Vec2::new(40.0, 0.0))).collect(),
            "the texture does not repeat: take the fraction of the coordinates first",
        ),
        (
            "negative texture coordinates",
            moved(Vec2::new(-1.0, -1.0)).chain(moved(Vec2::new(-7.0, 3.0))).collect(),
            "the texture is mirrored or shifted below 0: the fraction is t - floor(t), in [0, 1) for negative t as well",
        ),
        (
            "a coordinate a hair below 0",
            vec![(Vec2::new(-1e-9, 0.25), 2, 0), (Vec2::new(0.5, -1e-9), 1, 1)],
            "rounding takes the fraction to 1 there: the last texel counts, not one beyond",
        ),
    ]
}

fn read(trial: &Trial, texcoord: Vec2) -> Result<Vec3, Problem> {
    let input = format_args!("texture coordinates {texcoord} of {} × {} texels", SIZE.0, SIZE.1);
    call(SAMPLE, input, || (trial.functions.sample_texture)(SIZE, &TEXELS, texcoord))
}

pub(super) fn tests(trial: &Trial) -> Check {
    let inputs = [Vec2::new(0.5, 0.75), Vec2::new(0.1, 0.2)];
    written(trial, SAMPLE, &inputs, |functions, texcoord| (functions.sample_texture)(SIZE, &TEXELS, texcoord))?;
    for (test, places, fallback) in steps() {
        for (texcoord, column, row) in places {
            let found = read(trial, texcoord).map_err(|problem| step_of(problem, test, fallback))?;
            let expected = colour(column, row);
            if !found.abs_diff_eq(expected, 1e-3) {
                let measured = format!("{found:.3} at texture coordinates {texcoord}");
                let expected = format!("{expected:.3}: column {column}, row {row} from below, linear");
                return Err(Failure::new(SAMPLE, test, measured, &expected).fallback(fallback).into());
            }
        }
    }
    reflectances(trial)?;
    textured_plate(trial)
}

/// A panic tells the step as well.
fn step_of(problem: Problem, test: &'static str, fallback: &'static str) -> Problem {
    match problem {
        Problem::Wrong(failure) if test != "texels inside the square" => {
            Failure { test, ..failure }.hint(fallback).into()
        }
        other => other,
    }
}

fn materials() -> [Material; 2] {
    let textured = Material { reflectance_texture: Some(0), ..matt(Vec3::new(0.9, 0.5, 0.7)) };
    [matt(Vec3::new(0.2, 0.4, 0.6)), textured]
}

fn textures() -> Vec<Texture> {
    let filter = TextureFilter::Nearest;
    vec![Texture::new(String::from("six colours"), SIZE.0, SIZE.1, TEXELS.to_vec(), filter)]
}

/// A textured plate above a floor.
fn stage() -> (Stage, Receiver) {
    let floor = Quad { corner: Vec3::new(-0.5, 0.0, -0.5), along: Vec3::Z, up: Vec3::X, material: 0 };
    let plate = Quad { corner: Vec3::new(-0.4, 0.4, -0.3), along: 0.9 * Vec3::X, up: 0.7 * Vec3::Z, material: 1 };
    let stage = Stage::new(&[floor, plate], materials().to_vec(), textures(), 1);
    let receiver = stage.receiver(Vec3::ZERO, Vec3::Y);
    (stage, receiver)
}

fn reflectances(trial: &Trial) -> Check {
    let (stage, _) = stage();
    let world = stage.world(trial, None);
    let [plain, textured] = materials();
    let hit = |material, texcoord| SurfaceHit {
        front: true,
        distance: 1.0,
        vertices: [0, 1, 2],
        barycentric: Vec2::splat(0.25),
        material,
        texcoord,
    };
    written(trial, REFLECTANCE, &[Vec2::new(0.5, 0.75), Vec2::new(0.1, 0.2)], |functions, texcoord| {
        (functions.surface_reflectance)(&world, &hit(&textured, texcoord))
    })?;
    for (texcoord, column, row) in middles() {
        let right = textured.reflectance * colour(column, row);
        for (material, expected) in [(&textured, right), (&plain, plain.reflectance)] {
            let input = format_args!("a hit at texture coordinates {texcoord}");
            let found =
                call(REFLECTANCE, input, || (trial.functions.surface_reflectance)(&world, &hit(material, texcoord)))?;
            if found.abs_diff_eq(expected, 1e-3) {
                continue;
            }
            let hint = if material.reflectance_texture.is_none() {
                "a material without a texture keeps its own reflectance"
            } else if found.abs_diff_eq(colour(column, row), 1e-3) {
                "the material's own reflectance is left out: the texture multiplies it"
            } else if found.abs_diff_eq(right * colour(column, row), 1e-3) {
                "the texture is multiplied in twice"
            } else if found.abs_diff_eq(right * material.reflectance, 1e-3) {
                "the material's reflectance is multiplied in twice"
            } else {
                "the reflectance is the material's times the texture's colour at the hit's texture coordinates"
            };
            let measured = format!("{found:.3} at texture coordinates {texcoord}");
            let expected = format!("{expected:.3}: the material's reflectance, times its texture where it has one");
            return Err(Failure::new(REFLECTANCE, "reflectance at a hit", measured, &expected).hint(hint).into());
        }
    }
    Ok(())
}

/// The textured plate, gathered: against its texels as six polygon lights.
fn textured_plate(trial: &Trial) -> Check {
    let (stage, receiver) = stage();
    let field = vec![Vec3::ONE; stage.tessellation.mesh.positions.len()];
    let world = stage.world(trial, None);
    let found: Estimate = estimate(bounce::FUNCTION, "a receiver below a textured plate", &world, |world| {
        (trial.functions.indirect_irradiance)(world, &receiver, &[&field])
    })?;
    let [_, textured] = materials();
    let [corner, along, _] = stage.scene.mesh.corners(2);
    let [_, _, up] = stage.scene.mesh.corners(3);
    let at = |u: f32, v: f32| interpolate([corner, along, up], Vec2::new(u, v));
    let expected: Vec3 = (0..6_u8)
        .map(|texel| {
            let (column, row) = (f32::from(texel % 3), f32::from(texel / 3));
            let (left, right, low, high) = (column / 3.0, (column + 1.0) / 3.0, row / 2.0, (row + 1.0) / 2.0);
            let corners = [at(left, low), at(right, low), at(right, high), at(left, high)];
            let colour = colour(usize::from(texel % 3), usize::from(texel / 3));
            let radiance = textured.reflectance * colour / std::f32::consts::PI;
            polygon_irradiance(receiver.point.origin, receiver.normal(), &corners, radiance)
        })
        .sum();
    if found.is(expected) {
        return Ok(());
    }
    let place = "below a plate with a texture";
    let failure = differs(bounce::FUNCTION, "a textured plate", place, &found, (expected, "eq. 6, texel by texel"));
    Err(failure.fallback("the gather does not use the texture: each hit counts with surface_reflectance").into())
}

/// What is made of the bytes, and what to say.
type WrongColour = (fn(Vec3) -> Vec3, &'static str);

/// Wrong texel for a place: its column and row from below.
type Wrong = (fn(usize, usize) -> (usize, usize), &'static str);

const UPSIDE_DOWN: &str = "v is upside down: it points up, and the first row of the texels is the top one";

const KNOWN: [Wrong; 4] = [
    (|column, row| (column, 1 - row), UPSIDE_DOWN),
    (|column, row| (2 - column, row), "u is mirrored: it runs from left to right"),
    (|column, row| (2 - column, 1 - row), "the texture is turned half round: u runs to the right, v up"),
    (|_, _| (0, 0), "every point reads the same texel: a whole-number division gives 0?"),
];

pub(super) fn diagnose(trial: &Trial, failure: &Failure) -> Option<String> {
    if failure.function != SAMPLE || failure.test != "texels inside the square" && failure.test != "no panic" {
        return None;
    }
    let found: Vec<(Place, Vec3)> = middles()
        .into_iter()
        .filter_map(|place| Some((place, quiet(|| (trial.functions.sample_texture)(SIZE, &TEXELS, place.0))?)))
        .collect();
    let raw = |column: usize, row: usize| {
        let [red, green, blue, _] = TEXELS[3 * (1 - row) + column];
        Vec3::from([red, green, blue].map(f32::from))
    };
    let all = |wrong: &dyn Fn(Place) -> Vec3| {
        !found.is_empty() && found.iter().all(|(place, found)| found.abs_diff_eq(wrong(*place), 1e-3))
    };
    let as_colour: [WrongColour; 6] = [
        (|raw| raw / 255.0, "sRGB is not decoded: light adds up in linear values only (srgb_to_linear)"),
        (|raw| raw, "the bytes are neither divided by 255 nor decoded from sRGB"),
        (|raw| (raw / 255.0).powf(2.2), "a power of 2.2 is near to sRGB but not it: take srgb_to_linear"),
        (|raw| decoded(decoded(raw / 255.0)), "sRGB is decoded twice"),
        (|raw| encoded(raw / 255.0), "sRGB is encoded where it must be decoded"),
        (|raw| decoded(Vec3::new(raw.z, raw.y, raw.x) / 255.0), "red and blue are swapped"),
    ];
    let places = KNOWN.iter().copied().chain([((|column, row| (column, row)) as fn(usize, usize) -> _, "")]);
    for (wrong, hint) in places {
        let read = |place: Place| wrong(place.1, place.2);
        if !hint.is_empty() && all(&|place| colour(read(place).0, read(place).1)) {
            return Some(String::from(hint));
        }
        for (change, colour_hint) in as_colour {
            if all(&|place| change(raw(read(place).0, read(place).1))) {
                let both = [colour_hint, hint].into_iter().filter(|hint| !hint.is_empty()).collect::<Vec<_>>();
                return Some(both.join("; and "));
            }
        }
    }
    let strided = |place: Place| {
        let index = (1 - place.2) * SIZE.1 as usize + place.1;
        decoded(raw(index % 3, 1 - index / 3) / 255.0)
    };
    if all(&strided) {
        return Some(String::from("the texel's number is row times width plus column, not row times height"));
    }
    is_swapped(trial).then(|| String::from("u and v are swapped: u chooses the column, v the row"))
}

fn decoded(value: Vec3) -> Vec3 {
    Vec3::from(value.to_array().map(srgb_to_linear))
}

fn encoded(value: Vec3) -> Vec3 {
    Vec3::from(value.to_array().map(crate::math::color::linear_to_srgb))
}

/// Whether a square texture is read with u and v swapped, whichever row is taken for the first.
fn is_swapped(trial: &Trial) -> bool {
    const FOUR: [[u8; 4]; 4] = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
    let read = |u, v| quiet(|| (trial.functions.sample_texture)((2, 2), &FOUR, Vec2::new(u, v)));
    let is = |u, v, expected: Vec3| read(u, v).is_some_and(|found| found.abs_diff_eq(expected, 1e-3));
    // Red and green over blue and white: mirrored at one diagonal or the other, or turned.
    let mirrored = is(0.25, 0.25, Vec3::Z) && is(0.75, 0.25, Vec3::X) && is(0.25, 0.75, Vec3::ONE);
    let turned = is(0.25, 0.25, Vec3::X) && is(0.75, 0.25, Vec3::Z) && is(0.25, 0.75, Vec3::Y);
    mirrored || turned
}
