//! Views of a lightmap that read its pages on the card, against the same pages on the CPU.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;
mod gpu_stage;

use std::{f32::consts::PI, sync::Arc};

use common::lightmap::*;
use glam::{Vec2, Vec3, Vec4};
use gpu_stage::{PLAIN, Stage, Subjects};
use radiosity::{
    gpu::{
        MapFrame, Shading, ViewFrame, ViewGeometry,
        lightmap::{GpuSolver, Stage as Pages},
    },
    lightmap::{Ambient, Atlas, GpuSettings, pages_of},
    scene::{Scene, Tessellation, camera::CameraState, tessellate::TessellationOptions},
    trace::{Ray, RayTracer as _, Tracer},
};

const SIZE: [u32; 2] = [160, 120];

/// A lightmap of the Cornell box that has got some light, with the view's device, and its elements with their places.
struct Mapped {
    stage: Stage,
    subjects: Subjects,
    atlas: Atlas,
    solver: GpuSolver,
}

impl Mapped {
    fn new(settings: &GpuSettings) -> Self {
        let stage = Stage::new().unwrap();
        let mut subjects = Subjects::cornell(1);
        let scene = Arc::clone(&subjects.scene);
        let atlas = atlas_of(&scene, &texels(1500));
        subjects.geometry = Arc::new(ViewGeometry::with_map(&scene, &subjects.tessellation, &atlas.charts).unwrap());
        let light = common::cornell_light().to_local(&scene.frame);
        let mut solver = GpuSolver::new((&stage.device, &stage.queue), &scene, &atlas, Some(&light), settings).unwrap();
        (0..4).for_each(|_| solver.step().unwrap());
        Self { stage, subjects, atlas, solver }
    }

    fn frame(&self, shading: Shading) -> ViewFrame {
        let map = MapFrame {
            pages: self.solver.pages().clone(),
            version: self.solver.ledger().shooters,
            difference: false,
            nearest: false,
            on_screen: None,
        };
        ViewFrame { map: Some(map), light: None, ..self.subjects.frame(SIZE, shading) }
    }

    /// The map's irradiance on pages, on the CPU.
    fn pages(&self) -> Vec<Vec3> {
        pages_of(&self.atlas.charts, &self.atlas.texels, &self.solver.fields().unwrap().total)
    }

    /// The part of the pixels whose colour is not near what the point seen there should have.
    fn wrong_part(&mut self, frame: &ViewFrame, expected: impl Fn(u32, Vec2) -> Vec3) -> f64 {
        let picture = self.stage.picture(frame);
        let tracer = Tracer::new(Arc::clone(&self.subjects.scene));
        let (mut seen, mut wrong) = (0, 0);
        for (column, row, pixel) in picture.enumerate_pixels() {
            let Some((triangle, place)) = seen_at(&tracer, frame, column, row) else { continue };
            let expected = 255.0 * expected(triangle, place);
            seen += 1;
            wrong += usize::from((0..3).any(|band| (f32::from(pixel.0[band]) - expected[band]).abs() > 2.0));
        }
        assert!(seen > 10_000, "{seen}");
        wrong as f64 / f64::from(seen)
    }
}

fn seen_at(tracer: &Tracer, frame: &ViewFrame, column: u32, row: u32) -> Option<(u32, Vec2)> {
    let [width, height] = SIZE.map(|side| side as f32);
    let camera = &frame.camera;
    let x = (2.0 * (column as f32 + 0.5) / width - 1.0) * width / height;
    let y = 1.0 - 2.0 * (row as f32 + 0.5) / height;
    let direction = camera.forward + camera.tan_half_fov * (x * camera.right + y * camera.up);
    let ray = Ray {
        origin: camera.position,
        direction: direction.normalize(),
        max_distance: f32::INFINITY,
        origin_triangle: u32::MAX,
    };
    let hit = tracer.closest_hit(&ray)?;
    hit.front.then_some((hit.triangle, hit.barycentric))
}

#[test]
fn the_pages_on_the_card_are_those_of_the_cpu_holes_and_gutters_included() {
    let mut mapped = Mapped::new(&GpuSettings { light_side: 4, ..GpuSettings::default() });
    mapped.solver.fill_pages(Pages::Irradiance).unwrap();
    let buffer = mapped.solver.pages();
    let copy = mapped.stage.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = mapped.stage.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    mapped.stage.queue.submit([encoder.finish()]);
    copy.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    mapped.stage.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = copy.slice(..).get_mapped_range().unwrap();
    let head: &[u32] = bytemuck::cast_slice(&bytes[..16]);
    let charts = &mapped.atlas.charts;
    assert_eq!(head, [charts.page_size[0], charts.page_size[1], charts.page_count, 0]);
    let on_card: &[Vec4] = bytemuck::cast_slice(&bytes[16..]);
    let on_cpu = mapped.pages();
    assert_eq!(on_card.len(), on_cpu.len());
    for (card, cpu) in on_card.iter().zip(&on_cpu) {
        assert!(card.truncate().abs_diff_eq(*cpu, 1e-5 * cpu.max_element()), "{card} and {cpu}");
    }
    // Open texels, and no others, name their chart.
    let named = on_card.iter().filter(|texel| texel.w > 0.0).count();
    assert_eq!(named, mapped.atlas.texels.iter().filter(|texel| texel.open > 0.0).count());
}

#[test]
fn a_view_shows_at_every_pixel_what_the_map_has_there() {
    let mut mapped = Mapped::new(&GpuSettings { light_side: 4, ..GpuSettings::default() });
    mapped.solver.fill_pages(Pages::Irradiance).unwrap();
    let (pages, charts) = (mapped.pages(), mapped.atlas.charts.clone());
    let frame = mapped.frame(Shading::Irradiance);
    let wrong =
        mapped.wrong_part(&frame, |triangle, place| PLAIN.apply(charts.interpolate(&pages, triangle, place) / PI));
    assert!(wrong < 0.005, "{:.2} % of the pixels", 100.0 * wrong); // edges
    // The nearest texel alone is another picture, and also right.
    let mut nearest = frame.clone();
    nearest.map.as_mut().unwrap().nearest = true;
    let texel = |triangle: u32, place: Vec2| {
        let at = charts.map_point(triangle, place);
        PLAIN.apply(pages[charts.pixel(charts.pages[triangle as usize], at.x as u32, at.y as u32)] / PI)
    };
    assert!(mapped.wrong_part(&frame, texel) > 0.2);
    let wrong = mapped.wrong_part(&nearest, texel);
    assert!(wrong < 0.02, "{:.2} % of the pixels", 100.0 * wrong); // edges, of texels too
}

/// Expected: the same walls in few elements. Pixels along elements' edges are interpolated at their centroids, up to half
/// a pixel aside, which is some levels; texels of another place are many.
#[test]
fn at_a_slant_no_line_is_drawn_along_the_elements_edges() {
    let mut mapped = Mapped::new(&GpuSettings::default());
    mapped.solver.fill_pages(Pages::Irradiance).unwrap();
    let low = CameraState { position: [0.278, 0.03, -0.4], target: [0.278, 0.02, 0.5], ..CameraState::default() };
    let camera = low.to_local(&mapped.subjects.scene.frame);
    let mut pictures = [1, 6].map(|subdivide| {
        let options = TessellationOptions { subdivide, max_edge: None };
        let elements = Tessellation::new(&mapped.subjects.scene, &options).unwrap();
        let charts = &mapped.atlas.charts;
        let geometry = Arc::new(ViewGeometry::with_map(&mapped.subjects.scene, &elements, charts).unwrap());
        let field = Arc::new(vec![Vec3::ZERO; elements.mesh.positions.len()]);
        let frame = mapped.frame(Shading::Irradiance);
        mapped.stage.picture(&ViewFrame { geometry, field, camera, antialias: true, ..frame })
    });
    let [few, many] = &mut pictures;
    let apart = |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| (0..3).any(|band| a.0[band].abs_diff(b.0[band]) > 32);
    let wrong = few.pixels().zip(many.pixels()).filter(|pair| apart(*pair)).count();
    let lit = few.pixels().filter(|pixel| pixel.0[0] > 20).count();
    assert!(lit > 10_000 && wrong == 0, "{wrong} pixels differ, {lit} are lit");
}

#[test]
fn the_difference_to_a_field_at_the_vertices_is_taken_at_every_pixel() {
    let mut mapped = Mapped::new(&GpuSettings { light_side: 4, ..GpuSettings::default() });
    mapped.solver.fill_pages(Pages::Irradiance).unwrap();
    let level = Vec3::new(0.3, 0.2, 0.1);
    mapped.subjects.field = Arc::new(vec![level; mapped.subjects.field.len()]);
    let (pages, charts) = (mapped.pages(), mapped.atlas.charts.clone());
    let mut frame = mapped.frame(Shading::Irradiance);
    frame.map.as_mut().unwrap().difference = true;
    let wrong = mapped.wrong_part(&frame, |triangle, place| {
        PLAIN.apply((charts.interpolate(&pages, triangle, place) - level).abs() / PI)
    });
    assert!(wrong < 0.005, "{:.2} % of the pixels", 100.0 * wrong);
}

#[test]
fn a_view_is_drawn_again_when_the_pages_are_new_and_only_then() {
    let mut mapped = Mapped::new(&GpuSettings { light_side: 2, ..GpuSettings::default() });
    mapped.solver.fill_pages(Pages::Irradiance).unwrap();
    let mut frame = mapped.frame(Shading::Irradiance);
    assert!(mapped.stage.draw(&frame));
    assert!(!mapped.stage.draw(&frame));
    frame.map.as_mut().unwrap().version += 1;
    assert!(mapped.stage.draw(&frame));
}

#[test]
fn the_order_of_the_shooters_is_shown_by_colours_and_their_number_by_grey() {
    let mut mapped = Mapped::new(&GpuSettings { light_side: 2, batch: 8, ..GpuSettings::default() });
    let never = Vec3::splat(0.15);
    let mut parts = Vec::new();
    for _ in 0..2 {
        mapped.solver.fill_pages(Pages::Order).unwrap();
        let frame = ViewFrame { field_version: parts.len() as u64 + 2, ..mapped.frame(Shading::Plain) };
        // How much of the picture has not shot.
        parts.push(1.0 - mapped.wrong_part(&frame, |_, _| never));
        (0..4).for_each(|_| mapped.solver.step().unwrap());
    }
    assert!(parts[0] < 0.9 && parts[1] < parts[0] - 0.05, "{parts:?}");
    mapped.solver.fill_pages(Pages::Normals).unwrap();
    let scene = Arc::clone(&mapped.subjects.scene);
    let frame = ViewFrame { field_version: 9, ..mapped.frame(Shading::Plain) };
    let wrong = mapped.wrong_part(&frame, |triangle, _| 0.5 * scene.mesh.geometric_normal(triangle) + 0.5);
    assert!(wrong < 0.05, "{wrong}"); // all is flat; edges, and slivers beside them
}

#[test]
fn the_even_rest_of_a_closed_box_is_all_that_has_still_to_be_shot() {
    // A closed box of one reflectance that glows: after the first shooting what is missing is the same everywhere (eq. 5).
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1.2 0\nv 0 1.2 0\nv 0 0 1.4\nv 1 0 1.4\nv 1 1.2 1.4\nv 0 1.2 1.4\n";
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 4 3 7 8\nf 5 1 4 8\nf 2 6 7 3\n";
    let scene = from_obj(&format!("{corners}usemtl wall\n{faces}"), "newmtl wall\nKd 0.6 0.6 0.6\nKe 1 1 1\n");
    let atlas = atlas_of(&scene, &texels(600));
    for (ambient, expected) in [(Ambient::Off, PI), (Ambient::Even, PI / (1.0 - 0.6))] {
        let settings = GpuSettings { ambient, ..GpuSettings::default() };
        let mut solver = solver(&scene, &atlas, None, &settings);
        while solver.ledger().shooters < solver.size().lamps as u64 {
            solver.step().unwrap();
        }
        let total = mean(&atlas, &solver.fields().unwrap().total).x;
        assert!((total / expected - 1.0).abs() < 0.01, "{ambient:?}: {total}, not {expected}");
    }
}

/// A glowing bowl, half a sphere of flat pieces whose fronts look inwards; and the part of its light that stays inside.
fn bowl() -> (Arc<Scene>, f32) {
    const ROUND: u32 = 24;
    const RINGS: u32 = 8;
    let angle = |index: u32, count: u32, whole: f32| whole * index as f32 / count as f32;
    let mut obj = String::from("v 0 -1 0\n");
    for (ring, place) in (1..=RINGS).flat_map(|ring| (0..ROUND).map(move |place| (ring, place))) {
        let (polar, around) = (angle(ring, RINGS, 0.5 * PI), angle(place, ROUND, 2.0 * PI));
        let (x, z) = (polar.sin() * around.cos(), polar.sin() * around.sin());
        obj.push_str(&format!("v {x} {} {z}\n", -polar.cos()));
    }
    obj.push_str("usemtl wall\n");
    let vertex = |ring: u32, place: u32| if ring == 0 { 1 } else { 2 + (ring - 1) * ROUND + place % ROUND };
    for (ring, place) in (0..RINGS).flat_map(|ring| (0..ROUND).map(move |place| (ring, place))) {
        let corners = [(ring, place), (ring + 1, place), (ring + 1, place + 1), (ring, place + 1)];
        let [a, b, c, d] = corners.map(|(ring, place)| vertex(ring, place));
        obj.push_str(&if ring == 0 { format!("f {a} {c} {b}\n") } else { format!("f {a} {d} {c} {b}\n") });
    }
    let scene = from_obj(&obj, "newmtl wall\nKd 0.6 0.6 0.6\nKe 1 1 1\n");
    let surface: f32 = (0..scene.mesh.triangles.len() as u32).map(|triangle| scene.mesh.area(triangle)).sum();
    let opening = 0.5 * ROUND as f32 * (2.0 * PI / ROUND as f32).sin();
    // All that enters by the opening meets the bowl: so what leaves by it is its area over the bowl's (reciprocity).
    (Arc::clone(&scene), 1.0 - opening / (surface * scene.frame.square_metres_per_unit() as f32))
}

#[test]
fn an_open_bowl_that_is_left_early_is_too_dark_unless_the_trend_is_added() {
    let (scene, inside) = bowl();
    let atlas = atlas_of(&scene, &texels(3000));
    // E = f (M + ρ E), f the part that stays inside; of a sphere it is the same everywhere. While a part u of the emitted
    // power has still to be shot, E is too small by the very same part.
    let expected = PI * inside / (1.0 - 0.6 * inside);
    for ambient in [Ambient::Off, Ambient::Trend] {
        let settings = GpuSettings { ambient, group: 2, far_group: 2, unabsorbed: 0.15, ..GpuSettings::default() };
        let solver = solved(solver(&scene, &atlas, None, &settings));
        let missing = if ambient == Ambient::Off { solver.ledger().unabsorbed() as f32 } else { 0.0 };
        let total = mean(&atlas, &solver.fields().unwrap().total).x / expected;
        assert!((total + missing - 1.0).abs() < 0.01, "{ambient:?}: {total} of the closed form, {missing} missing");
    }
}
