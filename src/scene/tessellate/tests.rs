//! Expected values are closed forms: areas, counts, and points that interpolation must give back.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::collections::BTreeMap;

use super::*;
use crate::math::sequence::{Sampler, Sequence, Stream};
use crate::scene::{LocalFrame, Material};

const NOTHING: TessellationOptions = TessellationOptions { subdivide: 0, max_edge: None };

fn scene_of(positions: Vec<Vec3>, normals: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Scene {
    let material_indices = vec![0; triangles.len()];
    Scene {
        name: String::from("test"),
        mesh: Mesh { positions, normals, triangles, texcoords: Vec::new(), material_indices },
        materials: vec![Material::default()],
        textures: Vec::new(),
        frame: LocalFrame::default(),
        enclosed: Vec::new(),
        two_sided: false,
        faceted: false,
        warnings: Vec::new(),
    }
}

/// A closed box with a normal for each side: 24 vertices, 12 triangles.
fn hard_box(half_size: Vec3) -> Scene {
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let normal = sign * Vec3::AXES[axis];
            let u = Vec3::AXES[(axis + 1) % 3];
            let v = normal.cross(u);
            let first = positions.len() as u32;
            for corner in [-u - v, u - v, u + v, v - u] {
                positions.push((normal + corner) * half_size);
                normals.push(normal);
            }
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    scene_of(positions, normals, triangles)
}

fn single(a: Vec3, b: Vec3, c: Vec3) -> Scene {
    scene_of(vec![a, b, c], vec![Vec3::Z; 3], vec![[0, 1, 2]])
}

/// How many elements lie at each edge, edges being known by position alone.
fn elements_per_edge(mesh: &Mesh) -> BTreeMap<[[u32; 3]; 2], u32> {
    let key = |vertex: u32| (mesh.positions[vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut counts = BTreeMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (key(*from), key(*to));
            *counts.entry([from.min(to), from.max(to)]).or_insert(0) += 1;
        }
    }
    counts
}

fn total_area(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len() as u32).map(|triangle| f64::from(mesh.area(triangle))).sum()
}

fn longest_edge(mesh: &Mesh) -> f32 {
    let longest_of = |triangle| {
        let [a, b, c] = mesh.corners(triangle);
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    };
    (0..mesh.triangles.len() as u32).map(longest_of).fold(0.0, f32::max)
}

/// Locates random points of every scene triangle, and the element's corners, and compares positions.
fn assert_points_are_found(scene: &Scene, tessellation: &Tessellation) {
    let fields = &tessellation.mesh.positions;
    for triangle in 0..scene.mesh.triangles.len() as u32 {
        let sequence = Sequence::new(Sampler::Random, 1, triangle, Stream::Surface, 200);
        for index in 0..200 {
            let square = sequence.sample_2d(index);
            let point = if square.x + square.y > 1.0 { Vec2::ONE - square } else { square };
            let (element, local) = tessellation.locate(triangle, point);
            assert_eq!(tessellation.scene_triangle[element as usize], triangle);
            assert!(local.min_element() >= -1e-5 && local.x + local.y <= 1.0 + 1e-5, "{local} lies inside");
            let expected = scene.mesh.position(triangle, point);
            assert!(tessellation.mesh.position(element, local).abs_diff_eq(expected, 1e-6));
            // Positions are a linear field.
            assert!(tessellation.interpolate(fields, triangle, point).abs_diff_eq(expected, 1e-6));
        }
    }
    for (element, barycentrics) in tessellation.corner_barycentrics.iter().enumerate() {
        let triangle = tessellation.scene_triangle[element];
        let corners = tessellation.mesh.corners(element as u32);
        for (corner, barycentric) in corners.iter().zip(barycentrics) {
            assert!(scene.mesh.position(triangle, *barycentric).abs_diff_eq(*corner, 1e-6));
        }
        let centre = (barycentrics[0] + barycentrics[1] + barycentrics[2]) / 3.0;
        assert_eq!(tessellation.locate(triangle, centre).0, element as u32);
    }
}

#[test]
fn a_tessellation_without_cuts_is_the_scene() {
    let scene = hard_box(Vec3::new(1.0, 0.75, 0.5));
    let tessellation = Tessellation::new(&scene, &NOTHING).unwrap();
    assert_eq!(tessellation.mesh.triangles, scene.mesh.triangles);
    assert_eq!(tessellation.locate(7, Vec2::new(0.25, 0.5)), (7, Vec2::new(0.25, 0.5)));
    assert_points_are_found(&scene, &tessellation);
}

#[test]
fn every_cut_keeps_area_orientation_points_and_edges() {
    let scene = hard_box(Vec3::new(1.0, 0.6, 0.3));
    for (subdivide, max_edge) in [(1, None), (3, None), (0, Some(0.11)), (0, Some(0.5)), (2, Some(0.07))] {
        let options = TessellationOptions { subdivide, max_edge };
        let tessellation = Tessellation::new(&scene, &options).unwrap();
        let mesh = &tessellation.mesh;
        assert!((total_area(mesh) / total_area(&scene.mesh) - 1.0).abs() < 1e-6, "{options:?}");
        let vertex_area: f64 = tessellation.vertex_areas().into_iter().map(f64::from).sum();
        assert!((vertex_area / total_area(&scene.mesh) - 1.0).abs() < 1e-6, "{options:?}");
        for (element, triangle) in tessellation.scene_triangle.iter().enumerate() {
            let normal = scene.mesh.geometric_normal(*triangle);
            assert!(mesh.geometric_normal(element as u32).abs_diff_eq(normal, 1e-4), "{options:?}");
        }
        let edges = elements_per_edge(mesh);
        assert!(edges.values().all(|&count| count == 2), "{options:?}: a closed box has two elements at every edge");
        if let Some(longest) = max_edge {
            assert!(longest_edge(mesh) <= longest as f32 * 1.000_001, "{options:?}");
        }
        assert_points_are_found(&scene, &tessellation);
    }
}

#[test]
fn subdividing_thirty_triangles_four_times_gives_256_parts_each() {
    let mut scene = hard_box(Vec3::ONE);
    let more: Vec<_> = scene.mesh.triangles.iter().cycle().take(30).copied().collect();
    scene.mesh.material_indices = vec![0; more.len()];
    scene.mesh.triangles = more;
    let tessellation = Tessellation::new(&scene, &TessellationOptions { subdivide: 4, max_edge: None }).unwrap();
    assert_eq!(tessellation.mesh.triangles.len(), 7680);
    // A side of the box, 2 triangles, has (16 + 1)^2 vertices: midpoints are shared, also by equal triangles.
    assert_eq!(tessellation.mesh.positions.len(), 6 * 289);
}

#[test]
fn a_smooth_edge_shares_its_new_vertices_and_a_crease_does_not() {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let smooth = scene_of(corners.clone(), vec![Vec3::Z; 4], vec![[0, 1, 2], [0, 2, 3]]);
    let creased = scene_of(
        [corners[..3].to_vec(), vec![corners[0], corners[2], corners[3]]].concat(),
        [vec![Vec3::Z; 3], vec![Vec3::Y; 3]].concat(),
        vec![[0, 1, 2], [3, 4, 5]],
    );
    let options = TessellationOptions { subdivide: 0, max_edge: Some(1.2) }; // only the diagonal, sqrt(2), is longer
    let vertex_count = |scene| Tessellation::new(scene, &options).unwrap().mesh.positions.len();
    assert_eq!((vertex_count(&smooth), vertex_count(&creased)), (5, 8));
}

#[test]
fn midpoint_normals_are_unit_means_and_survive_opposite_ends() {
    let mut scene = single(Vec3::ZERO, Vec3::X, Vec3::Y);
    scene.mesh.normals = vec![Vec3::X, Vec3::Y, Vec3::NEG_X];
    let tessellation = Tessellation::new(&scene, &TessellationOptions { subdivide: 1, max_edge: None }).unwrap();
    assert!(tessellation.mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-6));
    let half = 0.5_f32.sqrt();
    assert!(tessellation.mesh.normals.iter().any(|normal| normal.abs_diff_eq(Vec3::new(half, half, 0.0), 1e-6)));
}

#[test]
fn a_needle_and_triangles_without_area_come_to_an_end() {
    let needle = single(Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1e-7, 0.0));
    let line = single(Vec3::ZERO, Vec3::X, Vec3::X);
    let point = single(Vec3::X, Vec3::X, Vec3::X);
    let options = TessellationOptions { subdivide: 0, max_edge: Some(1e-3) };
    for (scene, fewest) in [(needle, 1000), (line, 1000), (point, 1)] {
        let tessellation = Tessellation::new(&scene, &options).unwrap();
        assert!(tessellation.mesh.triangles.len() >= fewest);
        assert!(longest_edge(&tessellation.mesh) <= 1.000_001e-3);
    }
}

#[test]
fn points_on_and_slightly_outside_of_a_triangle_find_an_element_and_nan_does_not_panic() {
    let scene = hard_box(Vec3::ONE);
    let tessellation = Tessellation::new(&scene, &TessellationOptions { subdivide: 3, max_edge: Some(0.1) }).unwrap();
    for point in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::splat(0.5), Vec2::new(-1e-6, 0.3), Vec2::new(0.7, 0.300_001)] {
        let (element, local) = tessellation.locate(5, point);
        let expected = scene.mesh.position(5, point);
        assert!(tessellation.mesh.position(element, local).abs_diff_eq(expected, 1e-5), "{point}");
    }
    assert!((tessellation.locate(5, Vec2::NAN).0 as usize) < tessellation.mesh.triangles.len());
}

#[test]
fn too_fine_cuts_are_refused_with_one_line() {
    let scene = hard_box(Vec3::ONE);
    for (subdivide, max_edge) in [(12, None), (40, None), (0, Some(5e-4)), (0, Some(1e-9)), (0, Some(f64::NAN))] {
        let problem = Tessellation::new(&scene, &TessellationOptions { subdivide, max_edge }).unwrap_err();
        assert!(!problem.contains('\n') && (problem.contains("million") || problem.contains("usable")), "{problem}");
    }
}

#[test]
fn the_hash_knows_how_finely_a_scene_was_cut() {
    let scene = hard_box(Vec3::ONE);
    let hash =
        |subdivide| Tessellation::new(&scene, &TessellationOptions { subdivide, max_edge: None }).unwrap().hash();
    assert_eq!(hash(1), hash(1));
    assert_ne!(hash(1), hash(2));
}
