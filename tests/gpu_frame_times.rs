//! How long the views take to draw.
#![cfg(feature = "gpu")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod gpu_stage;

use std::{path::Path, time::Instant};

use gpu_stage::{Stage, Subjects, varied};
use radiosity::{
    gpu::{FalseColorRange, Shading, ViewFrame, ViewGeometry},
    scene::{Camera, LoadOptions, load::load},
    solver::State,
};

/// Frame times at 1280×720; run with `cargo test --release --test gpu_frame_times -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement, not a check"]
fn time_of_a_frame() {
    let Some(mut stage) = Stage::new() else { return };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/atrium/atrium.obj");
    let atrium = || {
        let scene = load(&path, &LoadOptions::default()).unwrap();
        let state = std::fs::read_to_string(path.with_extension("toml")).unwrap();
        let camera = State::from_toml(&state).unwrap().0.camera.unwrap().to_local(&scene.frame);
        Subjects::new(scene, 0, camera, varied)
    };
    let subjects = [("cornell 5", Subjects::cornell(5)), ("atrium", atrium()), ("cornell 8", Subjects::cornell(8))];
    for (name, subjects) in &subjects {
        let geometry = &subjects.geometry;
        let start = Instant::now();
        let again = ViewGeometry::new(&subjects.scene, &subjects.tessellation).unwrap();
        println!("{name}: prepared in {:.1} ms, {} bytes", 1000.0 * start.elapsed().as_secs_f64(), again.bytes());
        println!("{name}: {} vertices, {} triangles", geometry.vertex_count(), geometry.triangle_count());
        let plain = subjects.frame([1280, 720], Shading::Radiosity);
        let frames = [
            ("1 sample", plain.clone()),
            ("beside a solve, drawn", ViewFrame { saves_time: true, ..plain.clone() }),
            ("beside a solve", ViewFrame { saves_time: true, gradual: true, ..plain.clone() }),
            ("4 samples", ViewFrame { antialias: true, ..plain.clone() }),
            ("4 samples, wireframe", ViewFrame { antialias: true, wireframe: true, ..plain.clone() }),
            (
                "4 samples, false colours",
                ViewFrame {
                    antialias: true,
                    shading: Shading::FalseColor(FalseColorRange { minimum: 0.0, maximum: 3.0, logarithmic: false }),
                    ..plain
                },
            ),
        ];
        for (what, frame) in frames {
            let [moved, both, new_field] =
                [(1e-4, false), (1e-4, true), (0.0, true)].map(|change| frame_times(&mut stage, &frame, change));
            let median = |times: &[[f64; 2]]| {
                [0, 1].map(|column| {
                    let mut sorted: Vec<f64> = times.iter().map(|time| time[column]).collect();
                    sorted.sort_by(f64::total_cmp);
                    sorted[sorted.len() / 2]
                })
            };
            let (first, moved, both, new_field) =
                (moved[0], median(&moved[1..]), median(&both[1..]), median(&new_field[2..]));
            println!(
                "  {what}, ms recorded and drawn: first {first:.1?}, camera moves {moved:.1?}, field changes {new_field:.1?}, \
                 both {both:.1?}"
            );
        }
        let picture = stage.picture(&ViewFrame { antialias: true, ..subjects.frame([1280, 720], Shading::Radiosity) });
        picture.save(Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"))).unwrap();
    }
}

/// Milliseconds for each of some frames, before which the camera moves by `step_length` and the field may change: until
/// recorded, and until the picture is finished.
fn frame_times(stage: &mut Stage, frame: &ViewFrame, (step_length, new_field): (f32, bool)) -> Vec<[f64; 2]> {
    let times = (0..8).map(|step| {
        let position = frame.camera.position + step_length * step as f32 * frame.camera.right;
        let field_version = if new_field { 100 + step } else { 1 };
        let moved = ViewFrame { camera: Camera { position, ..frame.camera }, field_version, ..frame.clone() };
        let start = Instant::now();
        stage.draw(&moved);
        let recorded = start.elapsed();
        stage.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        [recorded, start.elapsed()].map(|time| 1000.0 * time.as_secs_f64())
    });
    times.collect()
}
