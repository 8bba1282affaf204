//! What the lightmap's ledger says of light on back faces, and light on a ball by its shading normals.
#![cfg(all(feature = "gpu", feature = "reference"))]

mod common;

use std::{fmt::Write as _, sync::Arc};

use common::lightmap::{atlas_of, from_obj, solved, solver, texels};
use glam::Vec3;
use radiosity::{
    check::closed_form::polygon_irradiance,
    lightmap::{GpuSettings, Visibility},
    math::sequence::{Sampler, Sequence, Stream},
    scene::{AreaLight, Scene},
    trace::{RayTracer as _, Tracer, surface::free_ray},
};
use rand::{RngExt, SeedableRng, rngs::SmallRng};

/// A closed box of half-size 1 around 60 triangles that cross each other at random, all of one reflectance.
fn soup(reflectance: f32, seed: u64) -> Arc<Scene> {
    let mut obj = String::from(
        "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nusemtl grey\n\
         f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 1 4 8 5\nf 6 7 3 2\n",
    );
    let mut generator = SmallRng::seed_from_u64(seed);
    for triangle in 0..60 {
        for _ in 0..3 {
            let [x, y, z] = [0.8, 0.7, 0.8].map(|half| half * (2.0 * generator.random::<f64>() - 1.0));
            let _ = writeln!(obj, "v {x} {y} {z}");
        }
        let first = 9 + 3 * triangle;
        let _ = writeln!(obj, "f {} {} {}", first, first + 1, first + 2);
    }
    from_obj(&obj, &format!("newmtl grey\nKd {reflectance} {reflectance} {reflectance}\n"))
}

/// Under the box's top, shining down.
const LIGHT: AreaLight = AreaLight {
    centre: Vec3::new(0.0, 0.9, 0.0),
    half_extent_u: Vec3::new(0.2, 0.0, 0.0),
    half_extent_v: Vec3::new(0.0, 0.0, 0.2),
    radiance: Vec3::splat(10.0),
};

/// Of the light's rays, spread by the cosine, the part that first meets a back face.
fn part_on_backs_by_rays(scene: &Arc<Scene>) -> f64 {
    const RAYS: u32 = 1 << 16;
    let tracer = Tracer::new(Arc::clone(scene));
    let sequence = Sequence::new(Sampler::Sobol, 1, 0, Stream::AreaLight, RAYS);
    let met = (0..RAYS).filter(|index| {
        let (direction, place) = sequence.sample_4d(*index);
        let across = direction.x.sqrt() * glam::Vec2::from_angle(std::f32::consts::TAU * direction.y);
        let down = Vec3::new(across.x, -(1.0 - direction.x).sqrt(), across.y);
        let on_light = (2.0 * place - 1.0) * 0.2;
        let hit = tracer.closest_hit(&free_ray(LIGHT.centre + Vec3::new(on_light.x, 0.0, on_light.y), down));
        hit.is_some_and(|hit| !hit.front)
    });
    met.count() as f64 / f64::from(RAYS)
}

/// Expected: what is emitted is absorbed, waits, or met backs (a third and more of it here); and of light that is not
/// reflected, the part on backs is that of the CPU's rays. Hemispheres bend no edges, and see large triangles amiss.
#[test]
fn light_on_back_faces_has_its_line_in_the_ledger_of_a_soup() {
    for (reflectance, visibility) in
        [(0.0, Visibility::Hemicube), (0.5, Visibility::Hemicube), (0.0, Visibility::Hemisphere)]
    {
        let scene = soup(reflectance, 3);
        let atlas = atlas_of(&scene, &texels(8000));
        let settings = GpuSettings { light_side: 4, unabsorbed: 0.05, visibility, ..GpuSettings::default() };
        let ledger = *solved(solver(&scene, &atlas, Some(LIGHT), &settings)).ledger();
        println!(
            "{reflectance} {visibility:?}: {:.3} on backs, balance {:+.4}",
            ledger.part_on_backs(),
            ledger.balance()
        );
        if reflectance == 0.0 && visibility == Visibility::Hemicube {
            let expected = part_on_backs_by_rays(&scene);
            assert!((ledger.part_on_backs() - expected).abs() < 0.01, "{ledger:?}, expected {expected}");
        }
        assert!(ledger.part_on_backs() > 0.2, "{ledger:?}");
        assert!(visibility == Visibility::Hemisphere || ledger.balance().abs() < 0.015, "{ledger:?}");
    }
}

/// A ball of 12 rings of 16. Expected: Lambert's formula about the shading normals (eq. 6), where flat
/// triangles would be dark beyond their own edge to the light.
#[test]
fn texels_on_a_ball_are_lit_as_far_round_as_their_shading_normals_say() {
    let mut obj = String::new();
    let (rings, sides) = (12, 16);
    for ring in 0..=rings {
        for side in 0..sides {
            let (height, around) = (ring as f64 / rings as f64 * std::f64::consts::PI, side as f64 / sides as f64);
            let (sine, cosine) = (std::f64::consts::TAU * around).sin_cos();
            let point = [height.sin() * cosine, height.cos(), height.sin() * sine];
            let [x, y, z] = point;
            let _ = writeln!(obj, "v {x} {y} {z}\nvn {x} {y} {z}");
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let number = |ring: usize, side: usize| ring * sides + side % sides + 1;
            let face = [number(ring, side), number(ring, side + 1), number(ring + 1, side + 1), number(ring + 1, side)];
            let words = face.map(|corner| format!("{corner}//{corner}"));
            let _ = writeln!(obj, "f {}", words.join(" "));
        }
    }
    let scene = from_obj(&obj, "newmtl grey\nKd 0.5 0.5 0.5\n");
    let atlas = atlas_of(&scene, &texels(4000));
    let light = AreaLight {
        centre: Vec3::new(6.0, 1.0, 0.5),
        half_extent_u: Vec3::new(0.0, 0.0, 0.2),
        half_extent_v: Vec3::new(0.0, 0.2, 0.0),
        radiance: Vec3::splat(100.0),
    };
    let settings = GpuSettings { light_side: 2, unabsorbed: 0.5, ..GpuSettings::default() };
    let fields = solved(solver(&scene, &atlas, Some(light), &settings)).fields();
    let direct = fields.map(|fields| fields.direct).unwrap_or_default();
    let expected: Vec<f32> = atlas
        .texels
        .iter()
        .map(|texel| polygon_irradiance(texel.position, texel.shading_normal, &light.corners(), light.radiance).x)
        .collect();
    let brightest = expected.iter().copied().fold(0.0, f32::max);
    let open = || atlas.texels.iter().zip(&direct).zip(&expected).filter(|((texel, _), _)| texel.open > 0.0);
    let black =
        open().filter(|((_, found), expected)| **expected > 0.1 * brightest && found.x < 0.01 * brightest).count();
    let worst = open().map(|((_, found), expected)| (found.x - expected).abs() / brightest).fold(0.0, f32::max);
    println!("{} texels, {black} black, off by {worst}", open().count());
    assert!(black == 0 && worst < 0.03, "{black} black, off by {worst}");
}
