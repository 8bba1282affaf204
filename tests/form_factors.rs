//! Form factors by item buffers, against closed forms and against rays.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use glam::Vec3;
use radiosity::{
    check::closed_form::{parallel_squares_form_factor, perpendicular_squares_form_factor},
    gpu::{
        device,
        lightmap::{
            hemicube::delta_form_factors,
            item_buffer::{ItemBuffers, Row, Viewpoint},
        },
    },
    scene::{LoadOptions, Scene, Tessellation, builtin, load, tessellate::TessellationOptions},
    solver::patches::Patches,
    student::basis::form_basis,
    trace::{Ray, RayTracer as _, Tracer, surface::lift},
};

/// Two triangles of the square with these corners.
fn square([a, b, c, d]: [Vec3; 4]) -> [[Vec3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

fn rows(triangles: &[[Vec3; 3]], viewpoints: &[Viewpoint], resolution: u32) -> Vec<Row> {
    let (device, queue) = device::headless().unwrap();
    let weights = delta_form_factors(resolution);
    let buffers = ItemBuffers::new((&device, &queue), triangles, resolution, &weights).unwrap();
    viewpoints.chunks(buffers.batch()).flat_map(|batch| buffers.rows(batch).unwrap()).collect()
}

/// Mean over a grid of points of the unit square z = 0 of the form factor to `target`.
fn mean_factor_from_unit_square(target: &[[Vec3; 3]], resolution: u32) -> f64 {
    const SIDE: u32 = 16;
    let place = |index: u32| (index as f32 + 0.5) / SIDE as f32;
    let viewpoints: Vec<Viewpoint> = (0..SIDE * SIDE)
        .map(|index| Viewpoint { origin: Vec3::new(place(index % SIDE), place(index / SIDE), 0.0), normal: Vec3::Z })
        .collect();
    let sums = rows(target, &viewpoints, resolution).into_iter();
    sums.map(|row| row.iter().map(|(_, factor)| f64::from(*factor)).sum::<f64>()).sum::<f64>() / f64::from(SIDE * SIDE)
}

#[test]
fn parallel_and_perpendicular_squares_have_their_form_factors_within_1_percent_at_128_pixels() {
    // Fronts towards the square z = 0.
    let above = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| Vec3::new(x, y, 1.0));
    let found = mean_factor_from_unit_square(&square(above), 128);
    let expected = parallel_squares_form_factor(1.0);
    assert!((found / expected - 1.0).abs() < 0.01, "parallel: {found}, not {expected}");
    let beside = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(y, z)| Vec3::new(0.0, y, z));
    let found = mean_factor_from_unit_square(&square(beside), 128);
    let expected = perpendicular_squares_form_factor();
    assert!((found / expected - 1.0).abs() < 0.01, "perpendicular: {found}, not {expected}");
}

#[test]
fn back_faces_count_for_nothing_but_hide() {
    let at = |height: f32, size: f32| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| Vec3::new(size * x, size * y, height))
    };
    let front = square(at(1.0, 2.0));
    let mut turned = at(0.5, 1.0);
    turned.reverse();
    let below = Viewpoint { origin: Vec3::ZERO, normal: Vec3::Z };
    let open = rows(&front, &[below], 64).remove(0).iter().map(|(_, factor)| factor).sum::<f32>();
    let hidden = rows(&[front, square(turned)].concat(), &[below], 64).remove(0);
    assert!(hidden.is_empty() && open > 0.7, "{open}, {hidden:?}"); // the turned square covers the other exactly
}

/// A hemicube by rays through the middles of its pixels: the sum of the delta form factors by triangle.
fn row_by_rays(tracer: &Tracer, viewpoint: &Viewpoint, (from, count): (u32, usize), resolution: u32) -> Vec<f32> {
    // Any turn about the normal does.
    let basis = form_basis(viewpoint.normal);
    let mut sums = vec![0.0; count];
    let step = 2.0 / resolution as f32;
    let mut add = |direction: Vec3, weight: f32| {
        let direction = (basis * direction).normalize();
        let ray = Ray { origin: viewpoint.origin, direction, max_distance: f32::INFINITY, origin_triangle: from };
        if let Some(hit) = tracer.closest_hit(&ray).filter(|hit| hit.front) {
            sums[hit.triangle as usize] += weight;
        }
    };
    for row in 0..resolution {
        for column in 0..resolution {
            let (x, y) = ((column as f32 + 0.5) * step - 1.0, (row as f32 + 0.5) * step - 1.0);
            let squared = x * x + y * y + 1.0;
            let weight = step * step / (std::f32::consts::PI * squared * squared);
            add(Vec3::new(x, y, 1.0), weight);
            if y > 0.0 {
                for side in [Vec3::new(1.0, x, y), Vec3::new(-1.0, x, y), Vec3::new(x, 1.0, y), Vec3::new(x, -1.0, y)] {
                    add(side, y * weight);
                }
            }
        }
    }
    sums
}

/// A row against one by rays, over all triangles: Σ |F - F'|.
fn apart(row: &Row, by_rays: &[f32]) -> f32 {
    let drawn = |index: usize| row.iter().find(|(item, _)| *item as usize == index).map_or(0.0, |(_, factor)| *factor);
    by_rays.iter().enumerate().map(|(index, value)| (drawn(index) - value).abs()).sum()
}

#[test]
fn a_row_of_pixels_shows_what_rays_meet() {
    let scene: Arc<Scene> = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let tracer = Tracer::new(Arc::clone(&scene));
    let triangles: Vec<[Vec3; 3]> =
        (0..scene.mesh.triangles.len() as u32).map(|index| scene.mesh.corners(index)).collect();
    const RESOLUTION: u32 = 64;
    const ORIGINS: u32 = 10;
    let differences = (0..ORIGINS).map(|triangle| {
        let viewpoint = middle_of(&scene, triangle);
        let row = rows(&triangles, &[viewpoint], RESOLUTION).remove(0);
        apart(&row, &row_by_rays(&tracer, &viewpoint, (triangle, triangles.len()), RESOLUTION))
    });
    let mean = differences.sum::<f32>() / ORIGINS as f32;
    assert!(mean < 0.02, "rows differ by {mean} in the mean; 64 pixels cut edges differently when they are turned");
}

/// Where the hemicube of a scene's triangle stands.
fn middle_of(scene: &Scene, triangle: u32) -> Viewpoint {
    let (corners, normal) = (scene.mesh.corners(triangle), scene.mesh.geometric_normal(triangle));
    Viewpoint { origin: lift(corners.iter().sum::<Vec3>() / 3.0, normal, corners), normal }
}

#[test]
fn a_row_shows_what_lies_behind_the_holes_of_a_texture() {
    // A floor, a board with holes, a ceiling. Elements are the halves' halves, so that a hole's place in them counts.
    let obj = "mtllib holes.mtl\nv -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nusemtl whole\nf 1 2 3 4\n\
        v -1 1 -1\nv 1 1 -1\nv 1 1.1 1\nv -1 1.1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl holes\nf 5/1 6/2 7/3 8/4\n\
        v -2 2 -2\nv 2 2 -2\nv 2 2 2\nv -2 2 2\nusemtl whole\nf 9 10 11 12\n";
    const OPACITIES: [u8; 12] = [0, 255, 90, 255, 40, 255, 0, 0, 255, 0, 255, 255];
    const RESOLUTION: u32 = 128;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::GrayImage::from_vec(4, 3, OPACITIES.to_vec()).unwrap().save(at("holes.png")).unwrap();
    std::fs::write(at("holes.mtl"), "newmtl whole\nnewmtl holes\nmap_d holes.png\n").unwrap();
    std::fs::write(at("scene.obj"), obj).unwrap();
    let scene = Arc::new(load::load(&at("scene.obj"), &LoadOptions::default()).unwrap());
    let options = TessellationOptions { subdivide: 1, max_edge: None };
    let elements = Tessellation::new(&scene, &options).unwrap();
    let (device, queue) = device::headless().unwrap();
    let weights = delta_form_factors(RESOLUTION);
    let buffers = ItemBuffers::of_elements((&device, &queue), (&scene, &elements), RESOLUTION, &weights).unwrap();
    let viewpoint = middle_of(&scene, 0);
    let mut by_triangle: Row = (0..6).map(|triangle| (triangle, 0.0)).collect();
    for (element, factor) in &buffers.rows(&[viewpoint]).unwrap()[0] {
        by_triangle[elements.scene_triangle[*element as usize] as usize].1 += factor;
    }
    let by_rays = row_by_rays(&Tracer::new(Arc::clone(&scene)), &viewpoint, (0, 6), RESOLUTION);
    assert!(by_rays[2..].iter().all(|factor| *factor > 0.02), "{by_rays:?}"); // board and ceiling are seen
    assert!(apart(&by_triangle, &by_rays) < 0.015, "{by_triangle:?}, by rays {by_rays:?}");
}

/// The Cornell box with its open front closed.
fn closed_box() -> Arc<Scene> {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 5 1 4 8\nf 2 6 7 3\n";
    Arc::new(load::load_from_memory("box", &format!("{corners}{faces}"), "", &LoadOptions::default()).unwrap())
}

#[test]
fn in_a_closed_box_every_row_sums_to_one() {
    let scene = closed_box();
    let count = scene.mesh.triangles.len() as u32;
    let triangles: Vec<[Vec3; 3]> = (0..count).map(|index| scene.mesh.corners(index)).collect();
    let viewpoints: Vec<Viewpoint> = (0..count).map(|index| middle_of(&scene, index)).collect();
    for row in rows(&triangles, &viewpoints, 128) {
        let sum: f32 = row.iter().map(|(_, factor)| factor).sum();
        assert!((sum - 1.0).abs() < 0.01, "{sum}");
    }
}

/// The Cornell box of the published coordinates with its blocks, and a fifth wall at its open front.
fn closed_cornell() -> Arc<Scene> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell");
    let [obj, mtl] = ["cornell.obj", "cornell.mtl"].map(|name| std::fs::read_to_string(folder.join(name)).unwrap());
    let closed = format!("{obj}\nusemtl white\nf 2 1 5 8\n");
    Arc::new(load::load_from_memory("closed", &closed, &mtl, &LoadOptions::default()).unwrap())
}

#[test]
fn in_a_closed_cornell_box_every_row_sums_to_one_within_1_percent_and_none_is_under_a_block() {
    let scene = closed_cornell();
    let elements = Tessellation::new(&scene, &TessellationOptions { subdivide: 2, max_edge: None }).unwrap();
    let patches = Patches::new(&scene, &elements);
    let viewpoint = |(origin, normal): &(Vec3, Vec3)| Viewpoint { origin: *origin, normal: *normal };
    let viewpoints: Vec<Viewpoint> = patches.places.iter().map(viewpoint).collect();
    let (device, queue) = device::headless().unwrap();
    let weights = delta_form_factors(128);
    let buffers = ItemBuffers::of_elements((&device, &queue), (&scene, &elements), 128, &weights).unwrap();
    let rows = buffers.all_rows(&viewpoints, &mut |_| true).unwrap().unwrap();
    // However many are drawn at once.
    assert_eq!(rows[..3], buffers.rows(&viewpoints[..3]).unwrap());
    for (row, area) in rows.iter().zip(&patches.areas) {
        let sum: f32 = row.iter().map(|(_, factor)| factor).sum();
        assert!(*area > 0.0 && (sum - 1.0).abs() < 0.01, "{sum}");
    }
    // The floor under the blocks, which stand on 0.168 by 0.166 m and on 0.165 by 0.167 m, is left out.
    let under_blocks = scene.enclosed.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum::<f32>();
    let square_metres = f64::from(under_blocks) * scene.frame.square_metres_per_unit();
    assert!((square_metres / 0.0554 - 1.0).abs() < 0.01, "{square_metres}");
    assert_eq!(buffers.all_rows(&viewpoints, &mut |done| done < 0.5).unwrap(), None); // stopped half-way
}
