//! What the load options do to a scene's geometry.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::fmt::Write;

use glam::{DVec3, Vec3};
use radiosity::scene::{LoadOptions, Scene, load};

/// A closed cube of quads from `low` to `high`, corners in this order: bit 0 is x, bit 1 is y, bit 2 is z.
fn cube(low: [f64; 3], high: [f64; 3]) -> String {
    let mut text = String::new();
    for corner in 0..8_usize {
        let [x, y, z] = [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] });
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for quad in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
        writeln!(text, "f {quad}").unwrap();
    }
    text
}

fn scene(obj: &str, options: &LoadOptions) -> Scene {
    load::load_from_memory("test", obj, "", options).unwrap()
}

/// A volume by the divergence theorem [local units³]: positive if fronts face outwards.
fn volume(scene: &Scene) -> f32 {
    let triangles = 0..scene.mesh.triangles.len() as u32;
    triangles.map(|triangle| scene.mesh.corners(triangle)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

#[test]
fn a_cube_has_flat_normals_and_four_vertices_a_side() {
    let scene = scene(&cube([-1.0; 3], [1.0; 3]), &LoadOptions::default());
    assert_eq!((scene.mesh.triangles.len(), scene.mesh.positions.len()), (12, 24));
    assert!((volume(&scene) - 8.0).abs() < 1e-5);
    for (triangle, corners) in scene.mesh.triangles.iter().enumerate() {
        let face = scene.mesh.geometric_normal(triangle as u32);
        assert!(corners.iter().all(|&vertex| scene.mesh.normals[vertex as usize] == face));
    }
}

#[test]
fn a_crease_angle_above_the_cubes_bends_gives_eight_radial_vertices() {
    let options = LoadOptions { crease_angle: Some(91.0), ..Default::default() };
    let scene = scene(&cube([-1.0; 3], [1.0; 3]), &options);
    assert_eq!(scene.mesh.positions.len(), 8);
    for (position, normal) in scene.mesh.positions.iter().zip(&scene.mesh.normals) {
        assert!(normal.abs_diff_eq(position.normalize(), 1e-6));
    }
}

#[test]
fn flip_turns_faces_and_normals_inwards() {
    let options = LoadOptions { flip: true, ..Default::default() };
    let scene = scene(&cube([-1.0; 3], [1.0; 3]), &options);
    assert!((volume(&scene) + 8.0).abs() < 1e-5);
    let inwards =
        scene.mesh.positions.iter().zip(&scene.mesh.normals).all(|(position, normal)| position.dot(*normal) < 0.0);
    assert!(inwards);
}

#[test]
fn two_sided_appends_each_triangle_turned_round() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 3 2 1\n";
    let scene = scene(obj, &LoadOptions { two_sided: true, ..Default::default() });
    let mesh = &scene.mesh;
    assert!(scene.two_sided);
    assert_eq!(mesh.triangles.len(), 2, "the file's own back side is not doubled");
    let [[a, b, c], back] = [mesh.corners(0), mesh.corners(1)];
    assert_eq!(back, [a, c, b]);
    assert_eq!(mesh.texcoords[1], [mesh.texcoords[0][0], mesh.texcoords[0][2], mesh.texcoords[0][1]]);
    assert!(mesh.triangles[0].iter().all(|&vertex| mesh.normals[vertex as usize] == Vec3::Z));
    assert!(mesh.triangles[1].iter().all(|&vertex| mesh.normals[vertex as usize] == Vec3::NEG_Z));
    assert_eq!(mesh.positions.len(), 6);
}

#[test]
fn unit_size_makes_the_largest_side_one_metre() {
    let options = LoadOptions { unit_size: true, ..Default::default() };
    let scene = scene(&cube([10.0, 0.0, 0.0], [50.0, 20.0, 10.0]), &options);
    let metres = scene.mesh.positions.iter().map(|position| scene.frame.point_to_metres(*position));
    let (low, high) = metres.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    assert!((high - low).abs_diff_eq(DVec3::new(1.0, 0.5, 0.25), 1e-6), "{}", high - low);
}

#[test]
fn weld_joins_near_positions_and_drops_what_collapses() {
    // Two triangles share an edge whose ends differ by 1e-6; a third one is as small as that.
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.000001 0 0\nv 1 1 0\nv 0 1.000001 0\nv 0.999999 0 0\n\
        f 1 2 3\nf 4 5 6\nf 2 4 5\nf 7 5 3\n";
    let as_read = LoadOptions { faces_as_read: true, ..Default::default() };
    let loose = scene(obj, &as_read);
    let welded = scene(obj, &LoadOptions { weld: Some(1e-5), ..as_read });
    assert_eq!((loose.mesh.triangles.len(), loose.mesh.positions.len()), (4, 7));
    assert_eq!((welded.mesh.triangles.len(), welded.mesh.positions.len()), (2, 4));
    let told = |text: &str| welded.warnings.iter().any(|warning| warning.contains(text));
    assert!(told("welded 3 vertices") && told("dropped 1 triangle that had two corners in one place"));
    assert!(told("dropped 1 triangle that repeat"), "{:?}", welded.warnings);
}

#[test]
fn a_scene_a_hundred_thousand_sizes_away_has_the_same_local_positions() {
    // Corners that are exact in binary, so that the shifted text has all their digits.
    let near = scene(&cube([0.125, 0.25, 0.5], [1.0, 0.75, 0.625]), &LoadOptions::default());
    let shift = 131_072.0;
    let far =
        scene(&cube([0.125 + shift, 0.25, 0.5 - shift], [1.0 + shift, 0.75, 0.625 - shift]), &LoadOptions::default());
    assert_eq!(near.mesh.positions, far.mesh.positions);
    assert_eq!(near.mesh.normals, far.mesh.normals);
    assert_eq!(near.hash(), far.hash());
}

#[test]
fn corners_of_one_position_share_a_vertex_only_if_they_share_the_normal() {
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 -0.0\nvn 0 0 2\nvn 0 1 1\n\
        f 1//1 2//1 3//1\nf 5//1 3//2 4//1\n";
    let scene = scene(obj, &LoadOptions::default());
    assert_eq!(scene.mesh.triangles, [[0, 1, 2], [0, 3, 4]]);
}

#[test]
fn normals_against_the_winding_are_kept_and_counted() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n";
    let scene = scene(obj, &LoadOptions::default());
    assert_eq!(scene.mesh.geometric_normal(0), Vec3::Z);
    assert_eq!(scene.mesh.normals[0], Vec3::NEG_Z);
    assert!(scene.warnings.iter().any(|warning| warning.contains("normals of 1 triangle point to the back")));
}

#[test]
fn numbers_are_read_in_every_notation_that_has_one_meaning() {
    let obj = "v +1e2 2. -.5E+01\nv .8e-001 -.7e+02 1e+2\nv 0 0 0 1.0\nf 1 2 3 # last\n";
    let scene = scene(obj, &LoadOptions::default());
    let first = scene.frame.point_to_metres(scene.mesh.corners(0)[0]);
    assert!(first.abs_diff_eq(DVec3::new(100.0, 2.0, -5.0), 1e-5), "{first}");
    let second = scene.frame.point_to_metres(scene.mesh.corners(0)[1]);
    assert!(second.abs_diff_eq(DVec3::new(0.08, -70.0, 100.0), 1e-5), "{second}");
}
