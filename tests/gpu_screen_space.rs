//! The screen-space view: its G-buffer and direct light against rays, its bounces against closed forms.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod screen_stage;

use std::sync::Arc;

use glam::{DVec3, Vec3};
use radiosity::{
    check::closed_form::polygon_irradiance,
    gpu::screen_space::{ScreenFields, ScreenSettings, SecondLayer, Weights},
    render::visible_points,
    scene::{AreaLight, camera::CameraState},
    solver::{SolveSettings, reconstruct::point_context},
    trace::{Hit, RayTracer as _, SurfacePoint, Tracer},
    transport::{
        Lights,
        direct::ShadowRays,
        sampling::{cosine_direction, frame},
        visible_light::Scratch,
    },
};
use screen_stage::{ScreenStage, plain, relative_l2};

#[test]
fn positions_rebuilt_from_depth_lie_where_rays_meet_the_scene() {
    let Some(mut stage) = ScreenStage::cornell([160, 120]) else { return };
    let fields = stage.drawn(&plain());
    let tracer = Tracer::new(Arc::clone(&stage.scene));
    let camera = stage.view.camera;
    let hits = visible_points(&tracer, &camera, [160, 120]);
    let mut elsewhere = 0;
    for (pixel, hit) in (0..).zip(&hits) {
        let rebuilt = fields.position(&camera, pixel);
        let Some(hit) = hit else {
            elsewhere += u32::from(rebuilt.is_some());
            continue;
        };
        let met = stage.scene.mesh.position(hit.triangle, hit.barycentric);
        let depth = (met - camera.position).dot(camera.forward);
        elsewhere += u32::from(rebuilt.is_none_or(|rebuilt| rebuilt.distance(met) > 1e-4 * depth));
    }
    println!("{elsewhere} of {} pixels", hits.len());
    // A pixel whose middle lies on an edge may show either side.
    assert!(elsewhere <= 6, "{elsewhere} of {} pixels show another point", hits.len());
}

/// Three unit squares that face the camera, at depths 2, 2 + `near` and 2 + `far`.
fn plates(near: f32, far: f32) -> Option<ScreenStage> {
    let corners = |depth: f32| format!("v -0.5 -0.5 {0}\nv 0.5 -0.5 {0}\nv 0.5 0.5 {0}\nv -0.5 0.5 {0}\n", 1.0 - depth);
    let plates: String = [2.0, 2.0 + near, 2.0 + far].map(corners).concat();
    let obj = format!("{plates}f 1 2 3 4\nf 5 6 7 8\nf 9 10 11 12\n");
    let camera =
        CameraState { position: [0.0, 0.0, 1.0], target: [0.0; 3], fov_degrees: 10.0, ..CameraState::default() };
    ScreenStage::of_text(&obj, "", &camera, [32, 32])
}

#[test]
fn the_second_layer_is_the_first_plate_that_lies_far_enough_behind() {
    for second_layer in [SecondLayer::Peel, SecondLayer::LastFrame] {
        // The scene is 1 m wide; what lies nearer than its tenth is left out.
        let settings = ScreenSettings { separation: 0.1, second_layer, ..plain() };
        for (near, far, expected) in [(0.05, 0.2, 2.2), (0.12, 0.2, 2.12), (0.05, 0.09, 0.0)] {
            let Some(mut stage) = plates(near, far) else { return };
            let metre = stage.scene.frame.vector_to_local(DVec3::X).x;
            // The last frame is one of the same view.
            for fields in [stage.drawn(&settings), stage.drawn(&settings)] {
                for (first, second) in fields.depth.iter().zip(&fields.second_depth) {
                    assert!((first - 2.0 * metre).abs() < 1e-4 * metre, "{first}");
                    assert!((second - expected * metre).abs() < 1e-4 * metre, "{second} and not {expected} m");
                }
            }
        }
    }
}

#[test]
fn direct_light_agrees_with_rays_within_5_percent_on_the_cornell_box() {
    let Some(mut stage) = ScreenStage::cornell([160, 120]) else { return };
    let tracer = Tracer::new(Arc::clone(&stage.scene));
    let lights = Lights::new(&stage.scene, stage.view.light);
    let settings = SolveSettings::default();
    let scene = Arc::clone(&stage.scene);
    let context = point_context(&scene, &tracer, &lights, &settings);
    let hits = visible_points(&tracer, &stage.view.camera, [160, 120]);
    for (frames, limit) in [(1, 0.05), (16, 0.03)] {
        let fields = stage.drawn_still(&ScreenSettings { bounces: 0, ..plain() }, frames);
        let (mut estimate, mut truth) = (Vec::new(), Vec::new());
        for (hit, value) in hits.iter().zip(&fields.direct) {
            let Some(hit) = hit else { continue };
            let point = SurfacePoint::new(&scene, hit.triangle, hit.barycentric);
            truth.push(context.at_point(&point, &mut Scratch::default(), &mut ShadowRays::default()).irradiance());
            estimate.push(*value);
        }
        let error = relative_l2(&estimate, &truth);
        println!("{frames} frames: {:.2} %", 100.0 * error);
        assert!(error < limit, "{frames} frames err by {:.2} %", 100.0 * error);
        assert!(truth.iter().map(|value| value.max_element()).sum::<f32>() > 0.0);
    }
}

/// The inside of a cube from -1 to 1, and, if asked for, the outside of a smaller one in it.
fn cubes(with_inner: bool) -> String {
    let corners = |half: f32| -> String {
        let sign = |corner: i32, bit: i32| if corner >> bit & 1 == 1 { half } else { -half };
        (0..8).map(|corner| format!("v {} {} {}\n", sign(corner, 0), sign(corner, 1), sign(corner, 2))).collect()
    };
    // Seen from inside, counter-clockwise.
    let inside = [[1, 2, 4, 3], [5, 7, 8, 6], [1, 5, 6, 2], [3, 4, 8, 7], [1, 3, 7, 5], [2, 6, 8, 4]];
    let outer: String = inside.map(|[a, b, c, d]| format!("f {a} {b} {c} {d}\n")).concat();
    let inner = inside.map(|face| face.map(|corner| corner + 8)).map(|[a, b, c, d]| format!("f {d} {c} {b} {a}\n"));
    if with_inner {
        format!("{}{}{outer}{}", corners(1.0), corners(0.5), inner.concat())
    } else {
        corners(1.0) + &outer
    }
}

#[test]
fn a_shadow_map_is_looked_up_in_all_directions_and_over_all_seams() {
    for with_inner in [false, true] {
        let mut lit = 0;
        for target in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            let up = if target.y == 0.0 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
            let camera = CameraState { position: [0.0; 3], target: target.to_array(), up, fov_degrees: 100.0 };
            let Some(mut stage) = ScreenStage::of_text(&cubes(with_inner), "", &camera, [96, 96]) else { return };
            // Turned so that no wall lies along a face of its shadow map.
            let (u, v) = (0.05 * Vec3::new(0.8, 0.1, 0.3), 0.05 * Vec3::new(-0.3, 0.2, 0.75));
            let light =
                AreaLight { centre: Vec3::ZERO, half_extent_u: v, half_extent_v: u, radiance: Vec3::splat(1e4) };
            stage.view.light = Some(light);
            let fields = stage.drawn(&ScreenSettings { bounces: 0, light_samples: 1, ..plain() });
            let tracer = Tracer::new(Arc::clone(&stage.scene));
            let hits = visible_points(&tracer, &stage.view.camera, [96, 96]);
            for (hit, value) in hits.iter().zip(&fields.direct) {
                let hit = hit.unwrap();
                let normal = stage.scene.mesh.geometric_normal(hit.triangle);
                let position = stage.scene.mesh.position(hit.triangle, hit.barycentric);
                let is_in_front = position.dot(light.normal()) > 0.02;
                let open = polygon_irradiance(position, normal, &light.corners(), light.radiance);
                let expected = if is_in_front && !with_inner { open } else { Vec3::ZERO };
                let error = (*value - expected).abs().max_element();
                let mut sides = position.abs().to_array();
                sides.sort_by(f32::total_cmp);
                // On an edge of the cube, pixels may show either wall.
                let edge = position.dot(light.normal()).abs() <= 0.02 || sides[1] > 0.999;
                // A light five times its size away is taken as a point; a seam that were missed would leave a quarter dark.
                assert!(edge || error <= 1e-2 * expected.x.max(0.01), "{value} instead of {expected} at {position}");
                lit += u32::from(expected.x > 0.0);
            }
        }
        // Half of all directions, where nothing hides them.
        assert!(with_inner == (lit == 0), "{lit}");
    }
}

/// One bounce at each pixel by rays (eq. 4), of which those count that meet what the picture shows: with the direct light
/// that was drawn there.
fn traced_bounce(stage: &ScreenStage, fields: &ScreenFields) -> Vec<Vec3> {
    const RAYS: u32 = 256;
    let (camera, scene) = (&stage.view.camera, &stage.scene);
    let tracer = Tracer::new(Arc::clone(scene));
    let hits = visible_points(&tracer, camera, fields.size);
    let size = glam::Vec2::new(fields.size[0] as f32, fields.size[1] as f32);
    let shown = |position: Vec3| -> Option<usize> {
        let offset = position - camera.position;
        let depth = offset.dot(camera.forward);
        let half = camera.tan_half_fov * glam::Vec2::new(size.x / size.y, 1.0);
        let place = glam::Vec2::new(offset.dot(camera.right), -offset.dot(camera.up)) / (depth * half);
        let pixel = ((place + 1.0) * 0.5 * size).floor();
        let inside = depth > 0.0 && pixel.cmpge(glam::Vec2::ZERO).all() && pixel.cmplt(size).all();
        let index = (pixel.y * size.x + pixel.x) as usize;
        (inside && (fields.depth[index] - depth).abs() < 0.03 * depth).then_some(index)
    };
    let bounce = |hit: &Option<Hit>| {
        let Some(hit) = hit else { return Vec3::ZERO };
        let point = SurfacePoint::new(scene, hit.triangle, hit.barycentric);
        let frame = frame(scene.mesh.shading_normal(hit.triangle, hit.barycentric));
        let arriving = |ray: u32| {
            let square = (glam::Vec2::new(0.754_877_7, 0.569_840_3) * ray as f32).fract();
            let met = point.ray(frame * cosine_direction(square)).and_then(|ray| tracer.closest_hit(&ray));
            let Some(met) = met.filter(|met| met.front) else { return Vec3::ZERO };
            let pixel = shown(scene.mesh.position(met.triangle, met.barycentric));
            pixel.map_or(Vec3::ZERO, |pixel| scene.reflectance(met.triangle, met.barycentric) * fields.direct[pixel])
        };
        (1..=RAYS).map(arriving).sum::<Vec3>() / RAYS as f32
    };
    hits.iter().map(bounce).collect()
}

#[test]
fn a_bounce_converges_to_what_rays_find_of_what_the_picture_shows_and_the_sources_weights_do_not() {
    let Some(mut stage) = ScreenStage::cornell([64, 48]) else { return };
    let settings = ScreenSettings {
        second_layer: SecondLayer::Off,
        bounces: 1,
        taps: 128,
        radius: 1.0,
        thickness: 0.005,
        ..plain()
    };
    let indirect = |fields: &ScreenFields| -> Vec<Vec3> {
        fields.total.iter().zip(&fields.direct).map(|(total, direct)| *total - *direct).collect()
    };
    let mut compared_with_taps = |taps, weights, size, frames| {
        stage.view.size = size;
        stage.renderer.forget();
        let fields = stage.drawn_still(&ScreenSettings { weights, taps, ..settings.clone() }, frames);
        let (found, traced) = (indirect(&fields), traced_bounce(&stage, &fields));
        let mean = |values: &[Vec3]| values.iter().map(|value| value.element_sum()).sum::<f32>();
        let compared = (relative_l2(&found, &traced), mean(&found) / mean(&traced) - 1.0);
        println!("{weights:?} {size:?} {taps} {frames}: {compared:?}");
        compared
    };
    let (few, _) = compared_with_taps(12, Weights::Integral, [160, 120], 64);
    let mut compared = |weights, size, frames| compared_with_taps(128, weights, size, frames);
    let (coarse, _) = compared(Weights::Integral, [64, 48], 64);
    let (fine, bias) = compared(Weights::Integral, [160, 120], 64);
    // What is left lies beside edges, where a pixel's piece of surface reaches over them: less of it with smaller pixels.
    assert!(fine < 0.16 && fine < 0.6 * coarse && bias.abs() < 0.03, "{coarse}, then {fine}, {bias}");
    // The ends of what few taps stand for leave no bands.
    assert!(few < 0.45, "{few} by twelve taps");
    let (noisy, _) = compared(Weights::Integral, [160, 120], 1);
    let (of_source, _) = compared(Weights::Source, [64, 48], 64);
    assert!(noisy > 2.0 * fine && of_source > 0.5, "{noisy}, {of_source}");
}

#[test]
fn light_from_around_the_picture_is_what_a_wider_picture_shows() {
    let settings = ScreenSettings { bounces: 1, taps: 64, radius: 1.0, ..plain() };
    let Some(mut wide) = ScreenStage::cornell([192, 144]) else { return };
    let wide_fields = wide.drawn_still(&ScreenSettings { surround: 1.0, ..settings }, 8);
    let Some(mut narrow) = ScreenStage::cornell([64, 48]) else { return };
    narrow.view.camera.tan_half_fov /= 3.0;
    let mean = |fields: &ScreenFields, pixels: &mut dyn Iterator<Item = usize>| -> f32 {
        pixels.map(|pixel| (fields.total[pixel] - fields.direct[pixel]).element_sum()).sum::<f32>()
    };
    // The middle of the wide picture has the very pixels of the narrow one.
    let middle = (0..48).flat_map(|row| (0..64).map(move |column| (row + 48) * 192 + column + 64));
    let expected = mean(&wide_fields, &mut middle.into_iter());
    let mut with = |surround| {
        let fields = narrow.drawn_still(&ScreenSettings { surround, ..settings }, 8);
        mean(&fields, &mut (0..64 * 48)) / expected
    };
    let (around, alone) = (with(3.0), with(1.0));
    println!("{around} with, {alone} without the picture around");
    // The pixels around are twelve times as large.
    assert!((around - 1.0).abs() < 0.1 && alone < 0.5, "{around} with, {alone} without the picture around");
}

#[test]
fn later_bounces_are_the_same_by_what_the_first_kept_of_its_taps_and_by_taps_anew() {
    let settings = ScreenSettings { taps: 128, filter: 0, every: 1, surround: 1.0, ..ScreenSettings::default() };
    let Some(mut stage) = ScreenStage::cornell([8, 8]) else { return };
    // Two layers of 128 taps fill what is kept, at most, with 256 x 254 pixels.
    let mut means = [254, 256].map(|height| {
        stage.view.size = [256, height];
        let fields = stage.drawn(&settings);
        let sum = fields.total.iter().zip(&fields.direct).map(|(total, direct)| (*total - *direct).element_sum());
        // A row is as wide in both, so that a pixel of the lower picture is a little larger.
        f64::from(sum.sum::<f32>()) / f64::from(height).powi(2)
    });
    println!("{means:?}");
    means.sort_by(f64::total_cmp);
    assert!(means[1] < 1.002 * means[0], "{means:?}");
}

#[test]
fn still_frames_add_the_light_of_later_bounces() {
    let Some(mut stage) = ScreenStage::cornell([64, 48]) else { return };
    let mean = |fields: &ScreenFields| fields.total.iter().sum::<Vec3>().element_sum();
    let mut of =
        |bounces, no_tail| mean(&stage.drawn_still(&ScreenSettings { bounces, no_tail, radius: 1.0, ..plain() }, 32));
    let (cut, with_tail, many) = (of(2, true), of(2, false), of(8, true));
    println!("{cut} {with_tail} {many}");
    assert!(
        (with_tail - many).abs() < 0.25 * (many - cut),
        "{cut} without, {with_tail} with it, {many} with 8 bounces"
    );
    assert!(of(1, true) == of(1, false), "one bounce is one bounce");
}

#[test]
fn still_frames_are_added_up_until_camera_or_light_moves() {
    let Some(mut stage) = ScreenStage::cornell([32, 24]) else { return };
    let settings = ScreenSettings::default();
    for expected in 1..=3 {
        stage.drawn(&settings);
        assert_eq!(stage.renderer.still_frames(), expected);
    }
    stage.view.camera.position.x += 0.01;
    stage.drawn(&settings);
    assert_eq!(stage.renderer.still_frames(), 1);
    stage.drawn(&settings);
    stage.view.light = stage.view.light.map(|light| AreaLight { centre: light.centre + 0.01, ..light });
    stage.drawn(&settings);
    assert_eq!(stage.renderer.still_frames(), 1);
    stage.drawn(&settings);
    assert_eq!(stage.renderer.still_frames(), 2);
}

#[test]
fn a_frame_is_the_same_to_the_bit_however_it_is_cut_into_submissions() {
    let Some(mut stage) = ScreenStage::cornell([96, 72]) else { return };
    let settings = ScreenSettings { obscurance: 9, ..ScreenSettings::default() };
    let whole = stage.drawn(&settings);
    let (before, _) = stage.renderer.submissions();
    stage.renderer.forget();
    stage.renderer.set_submission_time(std::time::Duration::from_micros(50));
    let cut = stage.drawn(&settings);
    assert!(stage.renderer.submissions().0 > 3 * before, "{:?} after {before}", stage.renderer.submissions());
    assert!(whole == cut);
}

#[test]
fn obscurance_leaves_a_plane_open_and_is_the_same_for_a_scene_of_any_size() {
    let settings = ScreenSettings { obscurance: 32, obscurance_radius: 0.2, ..plain() };
    let mean_of = |obj: &str, scale: f64| -> Option<f32> {
        let scaled: String = obj
            .lines()
            .map(|line| match line.strip_prefix("v ") {
                Some(numbers) => {
                    let numbers =
                        numbers.split(' ').map(|number| format!(" {}", scale * number.parse::<f64>().unwrap()));
                    format!("v{}\n", numbers.collect::<String>())
                }
                None => format!("{line}\n"),
            })
            .collect();
        let position = [1.5 * scale, 1.0 * scale, 1.5 * scale];
        let camera = CameraState { position, target: [0.5 * scale, 0.0, 0.5 * scale], ..CameraState::default() };
        let fields = ScreenStage::of_text(&scaled, "", &camera, [64, 64])?.drawn_still(&settings, 8);
        Some(fields.obscurance.iter().sum::<f32>() / fields.obscurance.len() as f32)
    };
    let plane = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf 1 2 3 4\n";
    let corner = format!("{plane}v 0 1 0\nv 0 1 1\nf 1 5 6 2\n");
    let Some(open) = mean_of(plane, 1.0) else { return };
    assert!(open > 0.999, "{open}");
    let near = mean_of(&corner, 1.0).unwrap();
    assert!(near < 0.99 && near > 0.5, "{near}");
    for scale in [1e-3, 1e3] {
        let scaled = mean_of(&corner, scale).unwrap();
        assert!((scaled - near).abs() < 1e-3, "{scaled} instead of {near} at scale {scale}");
    }
}

#[test]
fn the_filter_takes_noise_away() {
    let Some(mut stage) = ScreenStage::cornell([160, 120]) else { return };
    let settings = ScreenSettings { second_layer: SecondLayer::Off, bounces: 1, ..plain() };
    let converged = stage.drawn_still(&settings, 64).total;
    let [noisy, filtered] = [0, 4].map(|filter| {
        stage.renderer.forget();
        relative_l2(&stage.drawn(&ScreenSettings { filter, ..settings.clone() }).total, &converged)
    });
    println!("{noisy} {filtered}");
    assert!(filtered < 0.6 * noisy, "{filtered} of {noisy}");
}
