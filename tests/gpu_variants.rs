//! The switches of a lightmap: each does what its name says.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{f32::consts::PI, sync::Arc};

use common::lightmap::*;
use glam::Vec3;
use radiosity::{
    lightmap::{Attenuation, GpuSettings, LightmapSettings, Texel, Visibility},
    scene::{AreaLight, LoadOptions, area_light::AreaLightState, builtin},
};

const FLOOR: &str = "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nf 1 2 3 4\n";

#[test]
fn light_fades_by_the_law_that_was_asked_for() {
    let scene = from_obj(FLOOR, "newmtl unused\n");
    let atlas = atlas_of(&scene, &texels(2000));
    let light =
        AreaLightState { centre: [0.2, 0.6, 0.1], u: [0.15, 0.0, 0.0], v: [0.0, 0.0, 0.1], radiance: [5.0, 4.0, 3.0] };
    let light: AreaLight = light.to_local(&scene.frame);
    let areas: f32 = atlas.texels.iter().map(|texel| texel.open_area()).sum();
    for attenuation in [Attenuation::Linear, Attenuation::Quadratic, Attenuation::Patch] {
        let settings =
            GpuSettings { attenuation, light_side: 1, unabsorbed: 0.9, far_group: 4, ..GpuSettings::default() };
        let solver = solved(solver(&scene, &atlas, Some(light), &settings));
        let patch_area = areas / solver.size().groups as f32;
        for (texel, value) in atlas.texels.iter().zip(&solver.fields().unwrap().direct) {
            let way = light.centre - texel.position;
            let distance = way.length();
            let cosines = (way.y / distance).powi(2); // floor and light are parallel
            // M cos cos A / (π r²) with M = π L; A and the power of r as asked for.
            let expected = match attenuation {
                Attenuation::Linear => patch_area / distance,
                Attenuation::Quadratic => patch_area / distance.powi(2),
                _ => light.area() / distance.powi(2),
            };
            let expected = light.radiance * cosines * expected;
            assert!(value.abs_diff_eq(expected, 1e-3 * expected.x), "{attenuation:?}: {value}, not {expected}");
        }
    }
}

#[test]
fn only_the_physical_law_holds_close_by_and_one_that_makes_light_is_stopped() {
    // Just below a light nothing gets more than its emission π L.
    let scene = from_obj(FLOOR, "newmtl unused\n");
    let atlas = atlas_of(&scene, &texels(2000));
    let light = AreaLightState { centre: [0.0, 0.05, 0.0], u: [0.3, 0.0, 0.0], v: [0.0, 0.0, 0.3], radiance: [5.0; 3] };
    let light = light.to_local(&scene.frame);
    let brightest = |attenuation| {
        let settings = GpuSettings { attenuation, light_side: 1, unabsorbed: 0.999, ..GpuSettings::default() };
        let mut solver = solver(&scene, &atlas, Some(light), &settings);
        let _ = solver.step(); // light out of nothing may be refused
        solver.fields().unwrap().total.iter().fold(0.0_f32, |most, value| most.max(value.x)) / (PI * 5.0)
    };
    let (physical, patch) = (brightest(Attenuation::Physical), brightest(Attenuation::Patch));
    assert!(physical > 0.8 && physical < 1.0 && patch > 10.0, "{physical} and {patch} of the emission");
    // White walls, and light that hardly fades.
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 5 1 4 8\nf 2 6 7 3\n";
    let white = from_obj(&format!("{corners}usemtl wall\n{faces}"), "newmtl wall\nKd 0.9 0.9 0.9\nKe 1 1 1\n");
    let atlas = atlas_of(&white, &texels(600));
    let settings = GpuSettings { attenuation: Attenuation::Linear, ..GpuSettings::default() };
    let mut solver = solver(&white, &atlas, None, &settings);
    let mut failed = None;
    while !solver.is_done() && failed.is_none() {
        failed = solver.step().err();
    }
    assert!(failed.unwrap().contains("out of nothing"));
}

#[test]
fn groups_are_large_where_nothing_is_near_and_small_where_something_is() {
    // A floor with nothing around: all of it in the largest groups.
    let floor = from_obj(FLOOR, "newmtl unused\n");
    let count = |scene, far_group| {
        let atlas = atlas_of(scene, &texels(4000));
        let settings = GpuSettings { group: 2, far_group, ..GpuSettings::default() };
        solver(scene, &atlas, None, &settings).size().groups
    };
    let [small, large] = [2, 16].map(|far| count(&floor, far));
    assert!(large * 30 < small, "{large} and {small}");
    // Walls around, half a metre apart: some stay small.
    let box_scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let [small, large] = [2, 16].map(|far| count(&box_scene, far));
    assert!(large * 5 < small * 4 && large * 16 > small, "{large} and {small}");
}

#[test]
fn without_coverage_texels_are_whole_or_nothing_and_the_area_is_no_longer_the_scenes() {
    let scene = from_obj("v -2 0 -2\nv -1.3 0 2\nv 2 0 1.1\nf 1 2 3\n", "newmtl unused\n");
    let area = scene.mesh.area(0);
    let table = |no_coverage| atlas_of(&scene, &LightmapSettings { no_coverage, ..texels(200) }).texels;
    let [with, without] = [false, true].map(table);
    let sum = |table: &[radiosity::lightmap::Texel]| table.iter().map(|texel| texel.area).sum::<f32>();
    assert!((sum(&with) / area - 1.0).abs() < 1e-4, "{}", sum(&with) / area);
    assert!(without.len() < with.len(), "{} and {}", without.len(), with.len());
    let one = without[0].area;
    assert!(without.iter().all(|texel| (texel.area / one - 1.0).abs() < 1e-3));
}

#[test]
fn bias_moves_the_shadow_and_the_filter_softens_its_edge() {
    // A blocker above the floor, and one shooter: what is neither lit nor dark lies at the shadow's edge.
    let blocker = "v -0.4 0.3 -0.3\nv 0.5 0.3 -0.3\nv 0.5 0.3 0.4\nv -0.4 0.3 0.4\nf 5 6 7 8\n";
    let scene = from_obj(&format!("{FLOOR}{blocker}"), "newmtl unused\n");
    let atlas = atlas_of(&scene, &texels(6000));
    let light =
        AreaLightState { centre: [0.0, 0.8, 0.0], u: [0.05, 0.0, 0.0], v: [0.0, 0.0, 0.05], radiance: [5.0; 3] };
    let light = light.to_local(&scene.frame);
    let whole = |position: Vec3| {
        let way = light.centre - position;
        light.radiance.x * light.area() * (way.y / way.length()).powi(2) / way.length_squared()
    };
    let parts = |settings: GpuSettings| -> Vec<f32> {
        let solver = solved(solver(&scene, &atlas, Some(light), &GpuSettings { light_side: 1, ..settings }));
        let fields = solver.fields().unwrap();
        let on_floor = atlas.texels.iter().zip(fields.direct).filter(|(texel, _)| texel.triangle < 2);
        on_floor.map(|(texel, value)| value.x / whole(texel.position)).collect()
    };
    let base = GpuSettings { light_hemicube: 32, attenuation: Attenuation::Patch, ..GpuSettings::default() };
    let between = |parts: &[f32]| parts.iter().filter(|part| (0.02..0.98).contains(*part)).count();
    let [soft, hard] = [false, true].map(|no_filter| parts(GpuSettings { no_filter, ..base.clone() }));
    assert!(between(&soft) > 50 && between(&hard) == 0, "{} and {}", between(&soft), between(&hard));
    // A bias larger than the gap between blocker and floor lets the light through.
    let lit = |bias: f32| {
        let parts = parts(GpuSettings { bias, light_hemicube: 16, ..base.clone() });
        parts.iter().sum::<f32>() / parts.len() as f32
    };
    let (little, much) = (lit(0.5), lit(8.0));
    assert!(much > little + 0.02 && much > 0.99, "{little} and {much}");
}

/// A floor of 4 m, cut into squares, and a board above it that is cut likewise.
fn floor_and_board(cuts: u32) -> String {
    let mut obj = String::new();
    let mut corner = 0;
    let mut square = |low: [f32; 2], side: f32, height: f32| {
        let [x, z] = low;
        for (x, z) in [(x, z), (x, z + side), (x + side, z + side), (x + side, z)] {
            obj.push_str(&format!("v {x} {height} {z}\n"));
        }
        obj.push_str(&format!("f {} {} {} {}\n", corner + 1, corner + 2, corner + 3, corner + 4));
        corner += 4;
    };
    let step = 1.0 / cuts as f32;
    for (column, row) in (0..cuts * cuts).map(|index| ((index % cuts) as f32, (index / cuts) as f32)) {
        square([4.0 * step * column - 2.0, 4.0 * step * row - 2.0], 4.0 * step, 0.0);
        square([0.8 * step * column - 0.5, 0.8 * step * row - 0.3], 0.8 * step, 0.3);
    }
    obj
}

#[test]
fn hemispheres_see_what_rays_do_where_triangles_are_small_and_something_else_where_they_are_large() {
    let light =
        AreaLightState { centre: [0.1, 0.8, 0.1], u: [0.05, 0.0, 0.0], v: [0.0, 0.0, 0.05], radiance: [5.0; 3] };
    let misplaced = |cuts, visibility| {
        let scene = from_obj(&floor_and_board(cuts), "newmtl unused\n");
        let atlas = atlas_of(&scene, &texels(6000));
        let light: AreaLight = light.to_local(&scene.frame);
        let settings = GpuSettings { visibility, light_side: 1, light_hemicube: 512, ..GpuSettings::default() };
        let solver = solved(solver(&scene, &atlas, Some(light), &settings));
        assert_eq!(solver.item_buffer().is_some(), visibility == Visibility::Hemisphere);
        // Texels at a triangle's edge are left out: they may be seen under the number of the next.
        let is_inside = |texel: &Texel| {
            let corners = scene.mesh.corners(texel.triangle);
            (0..3).all(|side| {
                let (from, along) = (corners[side], (corners[(side + 1) % 3] - corners[side]).normalize());
                (texel.position - from).cross(along).length() > 0.012
            })
        };
        let direct = solver.fields().unwrap().direct;
        let found = against_rays(&scene, &atlas, &light, &direct, |texel| texel.position.y < 0.0 && is_inside(texel));
        assert!(found.shaded > 20, "{} texels in shadow", found.shaded);
        found.misplaced
    };
    let [cubes, coarse] = [Visibility::Hemicube, Visibility::Hemisphere].map(|visibility| misplaced(1, visibility));
    let fine = misplaced(16, Visibility::Hemisphere);
    println!("{cubes}, {coarse}, {fine}");
    assert!(cubes < 0.02 && fine < 0.03 && coarse > 0.1, "{cubes}; hemispheres {fine}, of large triangles {coarse}");
}
