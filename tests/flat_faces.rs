//! Flat neighbours taken as one surface: what is left, and that it is the same surface.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{collections::HashMap, fmt::Write};

use common::own_scene;
use glam::{Vec2, Vec3};
use radiosity::scene::{
    LoadOptions, Mesh, Scene, Tessellation, load::load_from_memory, tessellate::TessellationOptions,
};
#[cfg(feature = "reference")]
use {
    radiosity::{
        check::{metrics::lit_points, surface_points::locate},
        solver::{Reconstruction, Reconstructor, SolveSettings, Solved},
        trace::Tracer,
    },
    std::sync::Arc,
};

fn merged(obj: &str) -> Scene {
    load_from_memory("test", obj, "", &LoadOptions::default().merging_flat(true)).unwrap()
}

/// Cells of one square metre in the plane y = 0, facing up, where `is_there` says so.
fn grid(size: usize, is_there: impl Fn(usize, usize) -> bool) -> String {
    let mut obj = String::new();
    for (x, z) in (0..=size).flat_map(|x| (0..=size).map(move |z| (x, z))) {
        writeln!(obj, "v {x} 0 {z}").unwrap();
    }
    let vertex = |x: usize, z: usize| x * (size + 1) + z + 1;
    for (x, z) in (0..size).flat_map(|x| (0..size).map(move |z| (x, z))).filter(|&(x, z)| is_there(x, z)) {
        let [a, b, c, d] = [vertex(x, z), vertex(x, z + 1), vertex(x + 1, z + 1), vertex(x + 1, z)];
        writeln!(obj, "f {a} {b} {c} {d}").unwrap();
    }
    obj
}

fn area(scene: &Scene) -> f64 {
    let triangles = 0..scene.mesh.triangles.len() as u32;
    let area: f64 = triangles.map(|triangle| f64::from(scene.mesh.area(triangle))).sum();
    area * scene.frame.square_metres_per_unit()
}

/// A mesh as OBJ text with the scene's materials, and textures that go straight on over each plane.
fn as_obj(scene: &Scene, mesh: &Mesh) -> String {
    let mut obj = String::new();
    for position in &mesh.positions {
        let [x, y, z] = scene.frame.point_to_metres(*position).to_array();
        writeln!(obj, "v {x} {y} {z}\nvt {} {}", x + 0.5 * y, z - 0.25 * y).unwrap();
    }
    for (corners, &material) in mesh.triangles.iter().zip(&mesh.material_indices) {
        let [a, b, c] = corners.map(|vertex| vertex + 1);
        writeln!(obj, "usemtl m{material}\nf {a}/{a} {b}/{b} {c}/{c}").unwrap();
    }
    obj
}

/// Each material with the area and the normals of its triangles, which must be what their vertices say.
fn by_material(scene: &Scene) -> Vec<(f32, Vec<Vec3>)> {
    let mut found: Vec<(f32, Vec<Vec3>)> = vec![Default::default(); scene.materials.len()];
    for (triangle, corners) in scene.mesh.triangles.iter().enumerate() {
        let (area, normals) = &mut found[scene.mesh.material_indices[triangle] as usize];
        let normal = scene.mesh.geometric_normal(triangle as u32);
        assert!(corners.iter().all(|&vertex| scene.mesh.normals[vertex as usize].abs_diff_eq(normal, 1e-4)));
        *area += scene.mesh.area(triangle as u32);
        if !normals.iter().any(|other| other.abs_diff_eq(normal, 1e-4)) {
            normals.push(normal);
        }
    }
    found
}

/// Expected: the box as it was before it was cut.
#[test]
fn the_cornell_box_cut_into_11776_triangles_is_read_as_the_few_that_it_was_cut_from() {
    let whole = own_scene("cornell/cornell", &LoadOptions::default());
    let cut = Tessellation::new(&whole, &TessellationOptions { subdivide: 4, max_edge: None }).unwrap();
    let obj = as_obj(&whole, &cut.mesh);
    let kept = load_from_memory("cut", &obj, "", &LoadOptions::default()).unwrap();
    // With what is cut off around the blocks, the box has 46 triangles.
    assert_eq!(whole.mesh.triangles.len(), 46);
    assert_eq!(kept.mesh.triangles.len(), 46 * 256, "without being asked to, nothing is merged");
    let scene = merged(&obj);
    // One quad is not flat: its halves stay two surfaces, as they are when it comes whole.
    // The floor around the blocks is cut anew, without the four points where the blocks' feet crossed a diagonal.
    assert_eq!((scene.mesh.triangles.len(), scene.mesh.positions.len()), (42, whole.mesh.positions.len() - 4));
    let mut corners: Vec<_> = whole.mesh.positions.iter().map(|&p| whole.frame.point_to_metres(p)).collect();
    for position in &scene.mesh.positions {
        let wanted = scene.frame.point_to_metres(*position);
        let found = corners.iter().position(|corner| corner.abs_diff_eq(wanted, 1e-6)).unwrap();
        corners.swap_remove(found);
    }
    for ((area, normals), (whole_area, whole_normals)) in by_material(&scene).iter().zip(by_material(&whole)) {
        assert!((area / whole_area - 1.0).abs() < 1e-5, "{area}, not {whole_area}");
        assert!(normals.len() == whole_normals.len());
        assert!(normals.iter().all(|normal| whole_normals.iter().any(|other| other.abs_diff_eq(*normal, 1e-4))));
    }
    // Texture coordinates are what they were at each place.
    for (triangle, texcoords) in scene.mesh.texcoords.iter().enumerate() {
        for (position, texcoord) in scene.mesh.corners(triangle as u32).into_iter().zip(texcoords) {
            let place = scene.frame.point_to_metres(position).as_vec3();
            let expected = Vec2::new(place.x + 0.5 * place.y, place.z - 0.25 * place.y);
            assert!(texcoord.abs_diff_eq(expected, 1e-5), "{texcoord}, not {expected}");
        }
    }
}

/// Expected: a polygon of n corners with a hole of m corners takes n + m triangles.
#[test]
fn a_hole_and_a_concave_outline_stay() {
    let ring = merged(&grid(8, |x, z| !((2..5).contains(&x) && (3..6).contains(&z))));
    assert_eq!((ring.mesh.triangles.len(), ring.mesh.positions.len()), (8, 8));
    assert!((area(&ring) - 55.0).abs() < 1e-4);
    // An L of six corners.
    let corner = merged(&grid(8, |x, z| x < 3 || z < 2));
    assert_eq!((corner.mesh.triangles.len(), corner.mesh.positions.len()), (4, 6));
    assert!((area(&corner) - 34.0).abs() < 1e-4);
    // Two squares that touch in a corner are two surfaces.
    let squares = merged(&grid(8, |x, z| (x < 4) == (z < 4)));
    assert_eq!((squares.mesh.triangles.len(), area(&squares).round()), (4, 32.0));
}

#[test]
fn a_vertex_that_a_neighbour_needs_stays_so_that_no_crack_opens() {
    // A wall of three triangles stands on the floor's edge x = 0 and uses its vertex at z = 2.
    let wall = "v 0 3 2\nf 1 26 3\nf 3 26 5\n";
    let scene = merged(&(grid(4, |_, _| true) + wall));
    let at_edge = |vertex: &u32| {
        let point = scene.frame.point_to_metres(scene.mesh.positions[*vertex as usize]);
        (point.x.abs() < 1e-6 && point.y.abs() < 1e-6).then_some(point.z.round() as i32)
    };
    let mut edges: HashMap<[i32; 2], usize> = HashMap::new();
    for corners in &scene.mesh.triangles {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if let [Some(from), Some(to)] = [a, b].map(|place: usize| at_edge(&corners[place])) {
                *edges.entry([from.min(to), from.max(to)]).or_default() += 1;
            }
        }
    }
    assert_eq!(edges, HashMap::from([([0, 2], 2), ([2, 4], 2)]), "floor and wall share both halves of the edge");
    assert_eq!(scene.mesh.triangles.len(), 5);
}

#[test]
fn a_large_quad_beside_small_ones_keeps_its_place_and_area() {
    // The small quads' vertices hang on the large one's edge x = 0, which has none of them.
    let large = "v -4 0 0\nv -4 0 4\nf 26 27 5 1\n";
    let scene = merged(&(grid(4, |_, _| true) + large));
    assert_eq!((scene.mesh.triangles.len(), area(&scene).round()), (4, 32.0));
    assert!(scene.mesh.positions.len() <= 8);
}

/// Four cells in a row with texture coordinates from `start` to `end` of each.
fn row_of_cells(texcoord: impl Fn(usize, usize) -> f32) -> String {
    let mut obj = String::new();
    for cell in 0..4_usize {
        for (x, z) in [(0, 0), (0, 1), (1, 1), (1, 0)] {
            writeln!(obj, "v {} 0 {z}\nvt {} {z}", cell + x, texcoord(cell, x)).unwrap();
        }
        writeln!(obj, "f -4/-4 -3/-3 -2/-2 -1/-1").unwrap();
    }
    obj
}

#[test]
fn only_where_the_texture_goes_straight_on_are_neighbours_merged() {
    let triangles = |obj: &str| merged(obj).mesh.triangles.len();
    assert_eq!(triangles(&row_of_cells(|cell, x| 0.3 * (cell + x) as f32)), 2);
    assert_eq!(triangles(&row_of_cells(|_, x| x as f32)), 8, "each cell has the whole texture");
    assert_eq!(triangles(&row_of_cells(|cell, x| ((cell + x) % 2) as f32)), 8, "the texture is mirrored");
}

#[test]
fn what_is_curved_or_shaded_as_if_it_were_stays() {
    let mut bent = String::new();
    let mut shaded = String::new();
    for step in 0..=32_i32 {
        let (x, height) = (f64::from(step), 0.0005 * f64::from(step * step));
        for z in [0, 8] {
            writeln!(bent, "v {x} {height} {z}").unwrap();
            writeln!(shaded, "v {x} 0 {z}\nvn {} 1 0", 0.01 * (x - 16.0)).unwrap();
        }
    }
    for step in 0..32 {
        let [a, b, c, d] = [2 * step + 1, 2 * step + 2, 2 * step + 4, 2 * step + 3];
        writeln!(bent, "f {a} {b} {c} {d}").unwrap();
        writeln!(shaded, "f {a}//{a} {b}//{b} {c}//{c} {d}//{d}").unwrap();
    }
    for obj in [bent, shaded] {
        assert_eq!(merged(&obj).mesh.triangles.len(), 64);
    }
}

#[test]
fn second_sides_stay_the_flipped_copies_of_the_first() {
    let options = LoadOptions { two_sided: true, ..LoadOptions::default() }.merging_flat(true);
    let scene = load_from_memory("test", &grid(6, |x, _| x != 2), "", &options).unwrap();
    assert_eq!(scene.mesh.triangles.len(), 8);
    for triangle in 0..4 {
        let ([a, b, c], back) = (scene.mesh.corners(triangle), scene.mesh.corners(triangle + 4));
        assert_eq!(back, [a, c, b]);
    }
}

/// Expected: the path-traced truth of another program. The box that comes whole errs by 0.8 to 1.0 %, by which diagonals its
/// quads are cut; with all 7,680 triangles kept the same solve traces more than twice the rays.
#[cfg(feature = "reference")]
#[test]
fn the_cornell_box_that_comes_cut_costs_and_errs_as_the_whole_one_does() {
    let Some(case) = common::truths::case("cornell", "cornell/cornell.obj", 1) else { return };
    let cut = Tessellation::new(&case.scene, &TessellationOptions { subdivide: 4, max_edge: None }).unwrap();
    let obj = as_obj(&case.scene, &cut.mesh);
    let mut mtl = String::new();
    for (index, material) in case.scene.materials.iter().enumerate() {
        let [r, g, b] = material.reflectance.to_array();
        writeln!(mtl, "newmtl m{index}\nKd {r} {g} {b}").unwrap();
    }
    let scene = load_from_memory(
        "cut",
        &(String::from("mtllib a.mtl\n") + &obj),
        &mtl,
        &LoadOptions::default().merging_flat(true),
    );
    let problem = common::problem(&Arc::new(scene.unwrap()), case.light, SolveSettings::default());
    let Solved { solution, report, tessellation, .. } = common::solve_with_elements(&problem);
    assert!(solution.buried.len() < 12_000 && report.gather_rays < 2_000_000, "{} vertices", solution.buried.len());
    let tracer = Tracer::new(Arc::clone(&problem.scene));
    let field = Reconstructor::new(&problem.scene, &tracer, &tessellation, &solution, Reconstruction::PointDirect);
    let at = |point| {
        let (triangle, place) = locate(&problem.scene, &tracer, point).unwrap().on().unwrap();
        field.direct_and_total(triangle, place).1.as_dvec3()
    };
    let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
    let lit = lit_points(&case.values.iter().map(|value| value.total).collect::<Vec<_>>());
    for index in lit {
        squares += (at(&case.points[index]) - case.values[index].total).length_squared();
        sum += case.values[index].total.element_sum() / 3.0;
        count += 1.0;
    }
    let error = f64::sqrt(squares / 3.0 / count) / (sum / count);
    assert!(error < 0.012, "{error}");
}
