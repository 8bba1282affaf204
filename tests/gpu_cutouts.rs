//! Hemicubes see through the holes that textures cut, where the ray tracer does.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::sync::Arc;

use common::lightmap::*;
use radiosity::{
    lightmap::GpuSettings,
    scene::{LoadOptions, area_light::AreaLightState, load, texture::TextureFilter},
};

/// A floor, a whole board at its side, and over its middle a board whose material has holes by texture.
const OBJ: &str = "mtllib holes.mtl\nv -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nusemtl floor\nf 1 2 3 4\n\
    v 0.9 0.35 -0.3\nv 1.2 0.35 -0.3\nv 1.2 0.35 0.3\nv 0.9 0.35 0.3\nf 5 6 7 8\n\
    v -0.6 0.3 -0.7\nv 0.8 0.3 -0.7\nv 0.8 0.4 0.6\nv -0.6 0.4 0.6\n\
    vt -0.5 0\nvt 1.5 0\nvt 1.5 1\nvt -0.5 1\nusemtl holes\nf 9/1 10/2 11/3 12/4\n";

/// Grey opacities of a picture 7 by 5: no row or column is like another.
const OPACITIES: [u8; 35] = [
    0, 255, 90, 255, 40, 255, 0, 255, 0, 255, 0, 255, 160, 255, 30, 255, 200, 0, 255, 0, 140, 255, 110, 0, 255, 0, 255,
    0, 0, 255, 0, 255, 70, 255, 255,
];

/// Of the light that rays say arrives on the floor, the part that hemicubes place elsewhere.
fn misplaced(opacity: f32, texture_filter: TextureFilter) -> f32 {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::GrayImage::from_vec(7, 5, OPACITIES.to_vec()).unwrap().save(at("holes.png")).unwrap();
    std::fs::write(at("holes.mtl"), format!("newmtl floor\nnewmtl holes\nd {opacity}\nmap_d holes.png\n")).unwrap();
    std::fs::write(at("scene.obj"), OBJ).unwrap();
    let options = LoadOptions { texture_filter, ..LoadOptions::default() };
    let scene = Arc::new(load::load(&at("scene.obj"), &options).unwrap());
    let atlas = atlas_of(&scene, &texels(6000));
    let light =
        AreaLightState { centre: [0.1, 0.8, 0.1], u: [0.05, 0.0, 0.0], v: [0.0, 0.0, 0.05], radiance: [5.0; 3] };
    let light = light.to_local(&scene.frame);
    let settings = GpuSettings { light_side: 1, light_hemicube: 512, ..GpuSettings::default() };
    let direct = solved(solver(&scene, &atlas, Some(light), &settings)).fields().unwrap().direct;
    let AgainstRays { misplaced, shaded } = against_rays(&scene, &atlas, &light, &direct, |texel| texel.triangle < 2);
    assert!(shaded > 50, "{shaded} texels in shadow");
    misplaced
}

#[test]
fn light_passes_the_holes_of_a_texture_where_rays_do() {
    // Edges are soft by a pixel of the hemicube, which is a fifth of a texel; holes are some six texels wide.
    for filter in [TextureFilter::Nearest, TextureFilter::Bilinear] {
        let wrong = misplaced(1.0, filter);
        println!("{filter:?}: {:.2} %", 100.0 * wrong);
        assert!(wrong < 0.02, "{filter:?}: {:.1} % of the light", 100.0 * wrong);
    }
}

#[test]
fn the_opacity_of_the_material_counts_together_with_the_textures() {
    // 0.7 of 160, 200 is less than one half: more holes than with an opacity of one.
    let wrong = misplaced(0.7, TextureFilter::Nearest);
    assert!(wrong < 0.02, "{:.1} % of the light", 100.0 * wrong);
}
