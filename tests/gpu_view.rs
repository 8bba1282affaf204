//! The window's view on a graphics card (or a software driver) against the pictures of the CPU.
//!
//! Without any driver these tests say so and pass: there is nothing to look at. The pictures compared are left in
//! Cargo's folder for temporary files of tests.
#![cfg(feature = "gpu")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod gpu_stage;

use std::{f32::consts::PI, path::Path, sync::Arc};

use glam::{Vec3, Vec3Swizzles};
use gpu_stage::{PLAIN, Stage, Subjects, varied};
use image::RgbaImage;
use radiosity::{
    gpu::{FalseColorRange, Shading, ViewFrame, false_color},
    math::color::{ToneCurve, ToneMap},
    render::View,
    scene::{AreaLight, Camera, LoadOptions, Material, Scene, Texture, load::load_from_memory, texture::TextureFilter},
};

/// A square from -1 to 1 in the plane z = 0, facing +z, with texture coordinates from 0 to `repeats`.
fn square(materials: &str, repeats: f32) -> Scene {
    let obj = format!(
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt {repeats} 0\nvt {repeats} {repeats}\nvt 0 {repeats}\n\
         usemtl wall\nf 1/1 2/2 3/3 4/4\n"
    );
    load_from_memory("square", &obj, materials, &LoadOptions::default()).unwrap()
}

/// Looks down the z axis from height 2: the square fills the picture.
const CAMERA: Camera =
    Camera { position: Vec3::new(0.0, 0.0, 2.0), forward: Vec3::NEG_Z, right: Vec3::X, up: Vec3::Y, tan_half_fov: 0.5 };

const GREY: &str = "newmtl wall\nKd 0.6 0.6 0.6\n";

/// Mean absolute difference of a channel, and the share of pixels with a channel off by more than `tolerance`.
fn difference(a: &RgbaImage, b: &RgbaImage, tolerance: u8) -> (f64, f64) {
    assert_eq!(a.dimensions(), b.dimensions());
    let channels = a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| a.abs_diff(*b));
    let mean = channels.clone().map(f64::from).sum::<f64>() / (0.75 * a.as_raw().len() as f64);
    let channels: Vec<u8> = channels.collect();
    let off = channels.chunks_exact(4).filter(|pixel| pixel.iter().any(|channel| *channel > tolerance)).count();
    (mean, off as f64 / f64::from(a.width() * a.height()))
}

/// Holds a picture of the card to one of the CPU, and leaves both for a look.
fn assert_alike(name: &str, card: &RgbaImage, cpu: &RgbaImage, largest_mean: f64, largest_share: f64) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    card.save(folder.join(format!("{name}-card.png"))).unwrap();
    cpu.save(folder.join(format!("{name}-cpu.png"))).unwrap();
    let (mean, share) = difference(card, cpu, 2);
    println!("{name}: mean difference {mean:.4} of 255, {:.3} % of pixels off by more than 2", 100.0 * share);
    assert!(mean <= largest_mean, "{name}: mean difference {mean} of 255");
    assert!(share <= largest_share, "{name}: {share} of the pixels differ");
}

#[test]
fn a_wall_of_any_radiance_gets_the_tone_maps_bytes() {
    let Some(mut stage) = Stage::new() else { return };
    let curves = [ToneCurve::Plain, ToneCurve::Filmic];
    let maps =
        curves.into_iter().flat_map(|curve| {
            [(0.0, 1.0, 1.0), (1.5, 4.0, 1.0), (-2.0, 0.25, 1.8), (0.0, 2.0, 0.6)]
                .map(|(exposure, white, gamma)| ToneMap { exposure, white, gamma, curve })
        });
    for tone_map in maps {
        for irradiance in [Vec3::ZERO, Vec3::new(0.001, 0.02, 0.3), Vec3::new(0.9, 2.0, 7.0), Vec3::splat(1e9)] {
            let subjects = Subjects::new(square(GREY, 1.0), 0, CAMERA, |_, _| irradiance);
            let frame = ViewFrame { tone_map, ..subjects.frame([8, 8], Shading::Radiosity) };
            let expected = tone_map.apply_to_bytes(0.6 * irradiance / PI);
            for pixel in stage.picture(&frame).pixels() {
                let close = pixel.0.iter().zip(expected).all(|(byte, wanted)| byte.abs_diff(wanted) <= 1);
                assert!(close, "{:?}, not {expected:?}, of {irradiance} by {tone_map:?}", pixel.0);
            }
        }
    }
}

#[test]
fn the_cornell_box_looks_as_the_cpu_draws_it() {
    let Some(mut stage) = Stage::new() else { return };
    let subjects = Subjects::cornell(3);
    let shadings = [
        (Shading::Radiosity, View::Radiosity, "cornell-radiosity"),
        (Shading::Irradiance, View::Irradiance, "cornell-irradiance"),
        (Shading::Normals, View::Normals, "cornell-normals"),
        (Shading::Albedo, View::Albedo, "cornell-albedo"),
    ];
    for (shading, view, name) in shadings {
        let frame = subjects.frame([320, 240], shading);
        let frame = if view == View::Radiosity { frame } else { ViewFrame { light: None, ..frame } };
        // Both look through the middle of each pixel, so only pixels cut by an edge at that very point may differ.
        assert_alike(name, &stage.picture(&frame), &subjects.rendered(&frame, view), 0.2, 0.003);
    }
    // Four samples a pixel against sixteen: along edges the share of each side differs by up to 1/8 or so.
    let frame = ViewFrame { antialias: true, ..subjects.frame([320, 240], Shading::Radiosity) };
    assert_alike("cornell-smooth", &stage.picture(&frame), &subjects.rendered(&frame, View::Radiosity), 0.5, 0.04);
}

#[test]
fn the_wireframe_hides_behind_surfaces_and_is_as_bright_as_the_cpus() {
    let Some(mut stage) = Stage::new() else { return };
    let subjects = Subjects::cornell(2);
    let size = [640, 480];
    let frame = ViewFrame { wireframe: true, antialias: true, ..subjects.frame(size, Shading::Radiosity) };
    let lines = stage.picture(&frame);
    let cpu = subjects.rendered(&frame, View::Wireframe);
    // Lines are 1 pixel wide here and 1.2 there, and seen end-on they fade differently: only the mean is compared.
    assert_alike("cornell-wireframe", &lines, &cpu, 12.0, 1.0);
    let none = stage.picture(&ViewFrame { wireframe: false, ..frame.clone() });
    let covered = |image: &RgbaImage| difference(image, &none, 24).1;
    println!("covered {} and {}", covered(&lines), covered(&cpu));
    assert!((covered(&lines) / covered(&cpu) - 1.0).abs() < 0.3);
    // From behind the back wall, all faces near the camera are seen from behind: their edges are no more drawn than they
    // are, and what is seen through them differs from the picture without lines by as much as lines cover.
    let behind = Camera {
        position: 2.0 * subjects.camera.forward,
        forward: -subjects.camera.forward,
        right: -subjects.camera.right,
        ..subjects.camera
    };
    let frame = ViewFrame { camera: behind, light: None, ..frame };
    let (lines, cpu) = (stage.picture(&frame), subjects.rendered(&frame, View::Wireframe));
    assert_alike("cornell-behind", &lines, &cpu, 12.0, 1.0);
    let none = stage.picture(&ViewFrame { wireframe: false, ..frame });
    let covered = |image: &RgbaImage| difference(image, &none, 24).1;
    println!("covered {} and {} from behind", covered(&lines), covered(&cpu));
    assert!((covered(&lines) / covered(&cpu) - 1.0).abs() < 0.3);
}

#[test]
fn textures_are_read_as_the_cpu_reads_them() {
    let Some(mut stage) = Stage::new() else { return };
    for filter in [TextureFilter::Nearest, TextureFilter::Bilinear] {
        let mut scene = square(GREY, 2.5);
        let texels = (0..15_u8).map(|index| [17 * index, 255 - 11 * index, 40 * (index % 5), 80 * (index % 3)]);
        let texture = Texture::new(String::from("fifteen"), 5, 3, texels.collect(), filter);
        let mut limited = texture.clone();
        limited.limit_values(0.7);
        scene.textures = vec![texture, limited];
        for (reflectance_texture, opacity_texture) in [(Some(0), None), (Some(1), None), (Some(1), Some(0))] {
            scene.materials[0] = Material {
                reflectance: Vec3::new(0.9, 0.8, 0.7),
                reflectance_texture,
                opacity_texture,
                ..scene.materials[0].clone()
            };
            let subjects = Subjects::new(scene.clone(), 1, CAMERA, varied);
            let frame = subjects.frame([150, 150], Shading::Radiosity);
            let name = format!("texture-{filter:?}-{}", opacity_texture.is_some());
            // A pixel whose middle lies on the border between two texels may take either.
            let cpu = subjects.rendered(&frame, View::Radiosity);
            assert_alike(&name, &stage.picture(&frame), &cpu, 0.3, 0.01);
        }
    }
}

#[test]
fn corners_at_one_vertex_keep_their_own_texture_coordinates() {
    let Some(mut stage) = Stage::new() else { return };
    // Both triangles of the square show the whole texture, so the corners on the diagonal differ.
    let obj = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n\
               usemtl wall\nf 1/1/1 2/2/1 3/3/1\nf 3/1/1 4/2/1 1/3/1\n";
    let mut scene = load_from_memory("seam", obj, GREY, &LoadOptions::default()).unwrap();
    let texels = (0..12_u8).map(|index| [20 * index, 255 - 20 * index, 60 * (index % 4), 255]).collect();
    scene.textures = vec![Texture::new(String::from("twelve"), 4, 3, texels, TextureFilter::Nearest)];
    scene.materials[0].reflectance_texture = Some(0);
    let subjects = Subjects::new(scene, 2, CAMERA, varied);
    // Cut in four twice, the diagonal has 5 vertices; each is there twice but the middle one, which is the texture's
    // middle from either side.
    assert_eq!(subjects.geometry.vertex_count(), subjects.tessellation.mesh.positions.len() + 4);
    let frame = subjects.frame([150, 150], Shading::Radiosity);
    assert_alike("seam", &stage.picture(&frame), &subjects.rendered(&frame, View::Radiosity), 0.3, 0.01);
}

#[test]
fn with_several_samples_a_pixel_textures_are_smoothed_too() {
    let Some(mut stage) = Stage::new() else { return };
    // A checkerboard of 1.3 squares a pixel: read once a pixel, each is black or white.
    let mut scene = square("newmtl wall\nKd 0.9 0.9 0.9\n", 65.0);
    let texels = vec![[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]];
    scene.textures = vec![Texture::new(String::from("checkers"), 2, 2, texels, TextureFilter::Nearest)];
    scene.materials[0].reflectance_texture = Some(0);
    let subjects = Subjects::new(scene, 1, CAMERA, |_, _| Vec3::splat(PI));
    let smooth = ViewFrame { antialias: true, ..subjects.frame([100, 100], Shading::Radiosity) };
    let cpu = subjects.rendered(&smooth, View::Radiosity);
    let smooth_error = difference(&stage.picture(&smooth), &cpu, 2).0;
    let rough_error = difference(&stage.picture(&ViewFrame { antialias: false, ..smooth }), &cpu, 2).0;
    println!("mean difference {smooth_error} smoothed, {rough_error} not");
    assert!(smooth_error < 0.6 * rough_error);
}

#[test]
fn false_colours_are_those_of_the_legend() {
    let Some(mut stage) = Stage::new() else { return };
    let ranges = [
        FalseColorRange { minimum: 0.0, maximum: 4.0, logarithmic: false },
        FalseColorRange { minimum: 0.5, maximum: 3.0, logarithmic: false },
        FalseColorRange { minimum: 0.01, maximum: 4.0, logarithmic: true },
    ];
    // The field grows from 0 at the left edge to 4 at the right one.
    let subjects = Subjects::new(square(GREY, 1.0), 1, CAMERA, |position, _| Vec3::splat(2.0 * (position.x + 1.0)));
    for range in ranges {
        let image = stage.picture(&subjects.frame([64, 4], Shading::FalseColor(range)));
        assert!(range.place(range.minimum).abs() < 1e-6 && (range.place(range.maximum) - 1.0).abs() < 1e-6);
        for column in 0..64 {
            // 64 by 4 pixels: the middle of the square's height, and 16 times its width.
            let value = 2.0 * (1.0 + 16.0 * ((column as f32 + 0.5) / 32.0 - 1.0));
            if !(0.0..=4.0).contains(&value) {
                continue;
            }
            let expected = (255.0 * false_color::color(range.place(value))).round();
            let pixel = Vec3::from_array([0, 1, 2].map(|band| f32::from(image[(column, 2)].0[band])));
            assert!((pixel - expected).abs().max_element() <= 2.0, "{pixel}, not {expected}, for {value} in {range:?}");
        }
    }
}

#[test]
fn a_view_is_drawn_again_only_if_something_changed_and_views_keep_apart() {
    let Some(mut stage) = Stage::new() else { return };
    let subjects = Subjects::new(square(GREY, 1.0), 2, CAMERA, |_, _| Vec3::splat(1.0));
    let first = subjects.frame([32, 32], Shading::Radiosity);
    assert!(stage.draw(&first));
    assert!(!stage.draw(&first));
    let other_field = Arc::new(vec![Vec3::splat(3.0); first.field.len()]);
    let second = ViewFrame { view: 2, field: Arc::clone(&other_field), ..first.clone() };
    assert!(stage.draw(&second));
    assert!(!stage.draw(&first));
    assert_ne!(stage.picture(&first), stage.picture(&second));
    // The same number of version: taken as the same field. Another number: uploaded.
    let same_version = ViewFrame { field: Arc::clone(&other_field), ..first.clone() };
    assert!(!stage.draw(&same_version));
    assert_eq!(stage.picture(&ViewFrame { field_version: 2, ..same_version }), stage.picture(&second));
    let mut materials = subjects.scene.materials.clone();
    materials[0].reflectance = Vec3::new(0.1, 0.2, 0.3);
    let changes = [
        ViewFrame { materials: Arc::new(materials), ..second.clone() },
        ViewFrame { size: [16, 48], ..second.clone() },
        ViewFrame { antialias: true, ..second.clone() },
        ViewFrame { ambient: Vec3::splat(0.5), ..second.clone() },
        ViewFrame { wireframe: true, ..second.clone() },
        ViewFrame { buried: Some(Arc::new(vec![true; first.field.len()])), ..second.clone() },
        ViewFrame { shading: Shading::Normals, ..second.clone() },
    ];
    for change in changes {
        assert!(stage.draw(&change));
        assert!(stage.draw(&second));
    }
    stage.viewer.close(1);
    assert!(stage.viewer.picture(1).is_none() && stage.viewer.picture(2).is_some());
}

#[test]
fn a_large_mesh_is_shown_coarse_at_once_and_ends_up_as_if_it_were_drawn_whole() {
    let Some(mut stage) = Stage::new() else { return };
    let subjects = Subjects::cornell(7);
    for (antialias, wireframe) in [(false, true), (true, false)] {
        let frame = ViewFrame { antialias, wireframe, ..subjects.frame([96, 96], Shading::Radiosity) };
        let whole = stage.picture(&frame);
        // Another exposure in between, so that there is something to draw.
        let mut other = frame.clone();
        other.tone_map.exposure = 1.0;
        stage.draw(&other);
        let gradual = ViewFrame { gradual: true, ..frame };
        let coarse = stage.picture(&gradual);
        assert!(stage.viewer.is_refining() && coarse != whole);
        let difference: u64 = coarse.as_raw().iter().zip(whole.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        let mean = difference as f64 / coarse.as_raw().len() as f64;
        assert!(mean < if wireframe { 40.0 } else { 4.0 }, "the coarse picture is {mean} of 255 levels off");
        let mut frames = 0;
        while stage.viewer.is_refining() {
            assert!(stage.draw(&gradual));
            frames += 1;
        }
        assert!((5..30).contains(&frames), "{frames} frames");
        assert!(stage.picture(&gradual) == whole, "antialias {antialias}, wireframe {wireframe}");
        assert!(!stage.draw(&gradual), "nothing is left to draw");
    }
}

/// A field at so many moments of a solve.
fn moments(subjects: &Subjects) -> [Arc<Vec<Vec3>>; 3] {
    [0.3, 1.0, 40.0].map(|factor| Arc::new(subjects.field.iter().map(|value| factor * value.zxy()).collect()))
}

/// A square whose texture has holes, before a box.
fn textured_and_cut_out() -> Subjects {
    let mut scene = square(GREY, 2.5);
    let texels = (0..15_u8).map(|index| [17 * index, 255 - 11 * index, 40 * (index % 5), 80 * (index % 3)]);
    scene.textures = vec![Texture::new(String::from("fifteen"), 5, 3, texels.collect(), TextureFilter::Bilinear)];
    scene.materials[0] = Material {
        emitted_radiance: Vec3::new(0.1, 0.0, 0.4),
        reflectance_texture: Some(0),
        opacity_texture: Some(0),
        ..scene.materials[0].clone()
    };
    Subjects::new(scene, 3, CAMERA, varied)
}

#[test]
fn while_only_the_field_changes_pixels_get_the_colours_that_drawn_triangles_give_them() {
    let Some(mut stage) = Stage::new() else { return };
    let range = |logarithmic| FalseColorRange { minimum: 0.1, maximum: 6.0, logarithmic };
    let filmic = ToneMap { exposure: 0.7, white: 2.0, gamma: 1.3, curve: ToneCurve::Filmic };
    let shadings = [
        (Shading::Radiosity, PLAIN),
        (Shading::Radiosity, filmic),
        (Shading::Irradiance, PLAIN),
        (Shading::Plain, PLAIN),
        (Shading::FalseColor(range(true)), PLAIN),
        (Shading::FalseColor(range(false)), PLAIN),
    ];
    for subjects in [Subjects::cornell(3), textured_and_cut_out()] {
        for ((shading, tone_map), wireframe) in
            shadings.into_iter().flat_map(|shading| [(shading, false), (shading, true)])
        {
            let ambient = if wireframe { Vec3::ZERO } else { Vec3::new(0.5, 0.3, 0.8) };
            let frame = ViewFrame { tone_map, wireframe, ambient, ..subjects.frame([160, 121], shading) };
            // A driver that draws triangles is what the pixels are held to; both pictures are of a quarter of the pixels.
            let drawn = ViewFrame { view: 2, saves_time: true, ..frame.clone() };
            let by_pixel = ViewFrame { saves_time: true, gradual: true, ..frame };
            stage.draw(&by_pixel);
            assert!(!stage.viewer.is_by_pixel(1), "the first picture of a camera is drawn");
            for (field, field_version) in moments(&subjects).into_iter().zip(10..) {
                let expected = stage.picture(&ViewFrame { field: Arc::clone(&field), field_version, ..drawn.clone() });
                let picture = stage.picture(&ViewFrame { field, field_version, ..by_pixel.clone() });
                assert!(stage.viewer.is_by_pixel(1) && !stage.viewer.is_by_pixel(2));
                let (mean, share) = difference(&picture, &expected, 1);
                assert!(mean < 0.2 && share < 1e-3, "{shading:?}: {mean} of 255, {share} of the pixels are off");
            }
            let mut moved = by_pixel.clone();
            moved.camera.position.z += 0.3;
            let expected = stage.picture(&ViewFrame { view: 2, gradual: false, ..moved.clone() });
            assert!(stage.picture(&moved) == expected && !stage.viewer.is_by_pixel(1), "{shading:?}: a moved camera");
        }
    }
}

#[test]
fn fields_that_do_not_fit_and_sizes_of_nothing_are_no_reason_to_fail() {
    let Some(mut stage) = Stage::new() else { return };
    let subjects = Subjects::cornell(1);
    let frame = subjects.frame([0, 7], Shading::Radiosity);
    assert_eq!(stage.picture(&frame).dimensions(), (1, 7));
    for length in [0, 5, 100_000] {
        let frame = ViewFrame {
            field: Arc::new(vec![Vec3::ONE; length]),
            field_version: length as u64,
            buried: Some(Arc::new(vec![true; length])),
            size: [20, 10],
            ..frame.clone()
        };
        assert_eq!(stage.picture(&frame).dimensions(), (20, 10));
    }
    let frame = ViewFrame { materials: Arc::new(Vec::new()), ..frame };
    assert_eq!(stage.picture(&frame).dimensions(), (1, 7));
}

#[test]
fn buried_vertices_are_hatched_over_half_of_their_surface() {
    let Some(mut stage) = Stage::new() else { return };
    let subjects = Subjects::new(square(GREY, 1.0), 3, CAMERA, |_, _| Vec3::ONE);
    let frame = subjects.frame([64, 64], Shading::Radiosity);
    let buried = subjects.tessellation.mesh.positions.iter().map(|position| position.x > 0.0).collect();
    let hatched = stage.picture(&ViewFrame { buried: Some(Arc::new(buried)), ..frame.clone() });
    let plain = stage.picture(&frame);
    let share = |columns: std::ops::Range<u32>| {
        let pixels = columns.flat_map(|column| (0..64).map(move |row| (column, row)));
        pixels.filter(|place| hatched[*place] != plain[*place]).count()
    };
    assert_eq!(share(0..32), 0);
    assert_eq!(share(40..64), 24 * 64 / 2);
}

#[test]
fn the_light_shines_to_its_front_and_has_an_outline_two_pixels_wide() {
    let Some(mut stage) = Stage::new() else { return };
    // The middle half of the picture, facing the camera.
    let light = AreaLight {
        centre: Vec3::new(0.0, 0.0, 1.0),
        half_extent_u: Vec3::X * 0.25,
        half_extent_v: Vec3::Y * 0.25,
        radiance: Vec3::new(0.5, 0.0, 9.0),
    };
    let subjects = Subjects::new(square(GREY, 1.0), 0, CAMERA, |_, _| Vec3::ZERO);
    let frame = ViewFrame { light: Some(light), ..subjects.frame([64, 64], Shading::Radiosity) };
    let image = stage.picture(&frame);
    assert_eq!([15, 16, 47, 48].map(|column| image[(column, 30)].0[2]), [0, 255, 255, 0]);
    assert_eq!(image[(30, 30)].0, [188, 0, 255, 255]); // IEC 61966-2-1: 0.5 linear is 0.7354 coded
    let outlined = stage.picture(&ViewFrame { light_outline: Some(Vec3::Y), ..frame.clone() });
    assert_eq!([15, 16, 17, 18, 30].map(|column| outlined[(column, 30)].0[1]), [0, 255, 255, 0, 0]);
    let turned = AreaLight { half_extent_u: -light.half_extent_u, ..light };
    assert_eq!(stage.picture(&ViewFrame { light: Some(turned), ..frame })[(30, 30)].0, [13, 13, 13, 255]);
}

#[test]
fn ambient_light_adds_what_the_direction_of_a_surface_lets_in() {
    let Some(mut stage) = Stage::new() else { return };
    let subjects = Subjects::new(square(GREY, 1.0), 0, CAMERA, |_, _| Vec3::ONE);
    let ambient = Vec3::new(1.0, 2.0, 0.0);
    let image = stage.picture(&ViewFrame { ambient, ..subjects.frame([8, 8], Shading::Irradiance) });
    // The wall faces +z, where ambient light has 0.55 + 0.45 · 0.466 of its full strength.
    let expected = PLAIN.apply_to_bytes((Vec3::ONE + ambient * 0.7599) / PI);
    assert!(image[(4, 4)].0.iter().zip(expected).all(|(byte, wanted)| byte.abs_diff(wanted) <= 1));
}
