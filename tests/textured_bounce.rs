//! Light that leaves a textured floor is the light that leaves a floor of two materials.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::{problem, solve_unwatched};
use glam::Vec3;
use radiosity::{
    scene::{LoadOptions, Scene, Texture, area_light::AreaLightState, load::load_from_memory, texture::TextureFilter},
    solver::{SolveSettings, settings::Engine},
};

/// A floor 2 m wide that faces up, in two halves, and over the left one a board that faces down.
fn scene(left: &str, right: &str) -> Scene {
    let obj = format!(
        "v -1 0 -1\nv 0 0 -1\nv 1 0 -1\nv -1 0 1\nv 0 0 1\nv 1 0 1\n\
         v -0.8 0.4 -0.3\nv -0.2 0.4 -0.3\nv -0.2 0.4 0.3\nv -0.8 0.4 0.3\n\
         vt 0 0\nvt 0.5 0\nvt 1 0\nvt 0 1\nvt 0.5 1\nvt 1 1\n\
         usemtl {left}\nf 1/1 4/4 5/5 2/2\nusemtl {right}\nf 2/2 5/5 6/6 3/3\nusemtl board\nf 7 8 9 10\n"
    );
    let materials = "newmtl board\nKd 0 0 0\nnewmtl white\nKd 0.8 0.8 0.8\nnewmtl black\nKd 0 0 0\n";
    load_from_memory("floor", &obj, materials, &LoadOptions::default()).unwrap()
}

/// The floor white on both sides, with a texture of two texels.
fn textured(texels: [u8; 2]) -> Scene {
    let mut scene = scene("white", "white");
    let texels = texels.map(|grey| [grey, grey, grey, 255]).to_vec();
    scene.textures = vec![Texture::new(String::from("halves"), 2, 1, texels, TextureFilter::Nearest)];
    for material in &mut scene.materials {
        if material.reflectance.x > 0.0 {
            material.reflectance_texture = Some(0);
        }
    }
    scene
}

/// Mean irradiance of the first bounce on the board, which alone gets any.
fn bounced(scene: Scene, engine: Engine) -> f32 {
    let light = AreaLightState { centre: [0.0, 2.0, 0.0], u: [0.2, 0.0, 0.0], v: [0.0, 0.0, 0.2], radiance: [10.0; 3] };
    let settings = SolveSettings { engine, rays: 4096, bounces: Some(1), subdivide: 3, ..SolveSettings::even() };
    let (solution, _) = solve_unwatched(&problem(&Arc::new(scene), Some(light), settings));
    let lit: Vec<Vec3> = solution.bounces[1].iter().copied().filter(|value| value.x > 0.0).collect();
    lit.iter().sum::<Vec3>().x / lit.len() as f32
}

#[test]
fn a_bounce_looks_the_texture_up_where_each_ray_hit() {
    for engine in [Engine::Reference, Engine::Student] {
        for (texels, [left, right]) in [([255, 0], ["white", "black"]), ([0, 255], ["black", "white"])] {
            let (found, expected) = (bounced(textured(texels), engine), bounced(scene(left, right), engine));
            assert!((found / expected - 1.0).abs() < 0.01, "{engine:?}, {left} {right}: {found}, not {expected}");
        }
    }
}
