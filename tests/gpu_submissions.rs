//! A lightmap's work in submissions: short ones, the same light however it is cut, memory that is said and limited.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{path::Path, sync::Arc, time::Duration};

use common::lightmap::*;
use radiosity::{
    gpu::{
        device,
        lightmap::{GpuSolver, shaders::Shaders},
    },
    lightmap::{GpuSettings, LightmapSettings},
    scene::{LoadOptions, builtin},
};

#[test]
fn a_solve_cut_into_the_smallest_submissions_has_the_bits_of_one_in_the_largest() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(700));
    let light = common::cornell_light().to_local(&scene.frame);
    let settings = GpuSettings { unabsorbed: 0.3, light_side: 2, hemicube: 32, ..GpuSettings::default() };
    let in_submissions_of = |time| {
        let mut solver = solver(&scene, &atlas, Some(light), &settings);
        solver.set_submission_time(time);
        let solver = solved(solver);
        (solver.submissions().0, solver.ledger().shooters, solver.fields().unwrap())
    };
    let (many, shooters, finely) = in_submissions_of(Duration::ZERO);
    let (few, same_shooters, coarsely) = in_submissions_of(Duration::from_secs(10));
    assert!(many > 20 * few, "{many} and {few} submissions");
    assert_eq!(shooters, same_shooters);
    assert_eq!(finely, coarsely);
}

#[test]
fn power_is_balanced_after_every_submission_and_not_only_after_a_batch() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(1500));
    let light = common::cornell_light().to_local(&scene.frame);
    let settings = GpuSettings { unabsorbed: 0.05, light_side: 4, batch: 64, ..GpuSettings::default() };
    let mut solver = solver(&scene, &atlas, Some(light), &settings);
    solver.set_submission_time(Duration::from_millis(2));
    let mut within = 0;
    while !solver.is_done() {
        let batches = solver.ledger().batches;
        solver.submit().unwrap();
        within += usize::from(solver.ledger().batches == batches);
        assert!(solver.ledger().balance().abs() < 0.01, "{:?}", solver.ledger());
    }
    assert!(within > 5, "{within} submissions inside of batches");
}

#[test]
fn a_map_that_needs_more_memory_than_is_allowed_is_refused_with_what_it_needs() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(5000));
    let (device, queue) = card();
    let make = |device_memory| {
        let settings = GpuSettings { device_memory, ..GpuSettings::default() };
        GpuSolver::new((&device, &queue), &scene, &atlas, None, &settings)
    };
    let needed = make(4096).unwrap().size().bytes;
    // At least: 64 bytes a texel and three fields of 16; the light's atlas of 4096 × 1536 pixels of 4 bytes.
    let texels = atlas.texels.iter().filter(|texel| texel.open > 0.0).count() as u64;
    assert!(needed > texels * (64 + 48) + 4 * 4096 * 1536, "{needed}");
    let mebibytes = needed.div_ceil(1 << 20);
    assert!(make(mebibytes as u32).is_ok());
    let refused = make(mebibytes as u32 - 1).err().unwrap();
    assert!(refused.contains(&format!("{mebibytes} MiB")) && !refused.contains('\n'), "{refused}");
}

#[test]
fn passes_are_timed_by_the_device_and_take_no_longer_than_all_of_it() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(3000));
    let light = common::cornell_light().to_local(&scene.frame);
    let started = std::time::Instant::now();
    let solver = solved(solver(&scene, &atlas, Some(light), &GpuSettings::default()));
    let Some(times) = solver.pass_times() else {
        println!("skipped: this device has no timestamps");
        return;
    };
    let seconds: f64 = times.iter().map(|time| time.seconds).sum();
    assert!(seconds > 0.0 && seconds < started.elapsed().as_secs_f64(), "{times:?}");
    let runs = |name: &str| times.iter().find(|time| time.pass == name).unwrap().runs;
    assert_eq!(runs("choose shooters"), solver.ledger().batches);
    // A submission may hold some faces of a hemicube and no more.
    let (batches, submissions) = (solver.ledger().batches, solver.submissions().0);
    assert!((batches..=submissions).contains(&runs("receive")), "{times:?} in {submissions} submissions");
}

/// The sources of the shaders, in a folder of their own.
fn copy_of_shaders() -> tempfile::TempDir {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join(radiosity::gpu::lightmap::shaders::SHADER_FOLDER);
    let folder = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(&sources).unwrap().map(|file| file.unwrap().path()) {
        if file.extension().is_some_and(|extension| extension == "wgsl") {
            std::fs::copy(&file, folder.path().join(file.file_name().unwrap())).unwrap();
        }
    }
    folder
}

#[test]
fn shaders_are_taken_from_a_folder_and_the_old_ones_stay_where_the_new_do_not_compile() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join(radiosity::gpu::lightmap::shaders::SHADER_FOLDER);
    assert!(Shaders::from_folder(&sources) == Ok(Shaders::default()));
    let folder = copy_of_shaders();
    let receive = folder.path().join("receive.wgsl");
    let source = std::fs::read_to_string(&receive).unwrap();
    let scene = from_obj("v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nf 1 2 3 4\n", "newmtl unused\n");
    let atlas = atlas_of(&scene, &texels(200));
    let light = common::cornell_light().to_local(&scene.frame);
    let reloaded = |edit: &str| {
        std::fs::write(&receive, edit).unwrap();
        let mut solver = solver(&scene, &atlas, Some(light), &GpuSettings::default());
        let outcome = Shaders::from_folder(folder.path()).and_then(|shaders| solver.reload(&shaders));
        (outcome, mean(&atlas, &solved(solver).fields().unwrap().total).x)
    };
    let (outcome, before) = reloaded(&source);
    assert_eq!(outcome, Ok(()));
    // Twice the light.
    let (outcome, doubled) = reloaded(&source.replace("total += added;", "total += 2.0 * added;"));
    assert_eq!(outcome, Ok(()));
    assert!((doubled / before - 2.0).abs() < 1e-3, "{before} and {doubled}");
    // One that is no WGSL, and one that is but does not fit its buffers.
    let without_buffers = "@compute @workgroup_size(64)\nfn receive() {}";
    for (edit, expected) in [("fn receive(", "receive.wgsl"), (without_buffers, "old shaders stay")] {
        let (outcome, kept) = reloaded(edit);
        assert!(outcome.as_ref().is_err_and(|problem| problem.contains(expected)), "{outcome:?}");
        assert_eq!(kept, before);
    }
}

#[test]
fn a_lost_device_is_an_error_in_one_line_and_not_the_end_of_the_program() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(500));
    let light = common::cornell_light().to_local(&scene.frame);
    let (device, queue) = card();
    let mut lost = GpuSolver::new((&device, &queue), &scene, &atlas, Some(&light), &GpuSettings::default()).unwrap();
    lost.submit().unwrap();
    device.destroy();
    let problem = lost.submit().unwrap_err();
    assert!(problem.contains("lost") && !problem.contains('\n'), "{problem}");
    assert!(lost.fields().is_err());
    // On another device it starts anew.
    assert!(solved(solver(&scene, &atlas, Some(light), &GpuSettings::default())).is_done());
}

#[test]
fn opengl_gives_the_field_of_vulkan() {
    let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
    let atlas = atlas_of(&scene, &texels(500));
    let light = common::cornell_light().to_local(&scene.frame);
    let settings =
        GpuSettings { light_side: 2, unabsorbed: 0.1, hemicube: 32, light_hemicube: 64, ..GpuSettings::default() };
    let found = device::devices();
    let backends = [wgpu::Backend::Vulkan, wgpu::Backend::Gl];
    let usable = |backend| found.iter().find(|device| device.info.backend == backend && device.problem.is_none());
    let [Some(vulkan), Some(gl)] = backends.map(usable) else {
        println!("skipped: not both Vulkan and OpenGL are there");
        return;
    };
    let [by_vulkan, by_gl] = [vulkan, gl].map(|found| {
        let (device, queue) = found.open().unwrap();
        let solver = GpuSolver::new((&device, &queue), &scene, &atlas, Some(&light), &settings).unwrap();
        solved(solver).fields().unwrap().total
    });
    let means = [&by_vulkan, &by_gl].map(|field| mean(&atlas, field));
    assert!(means[0].abs_diff_eq(means[1], 0.01 * means[0].x), "{means:?}");
    // Texel by texel: both draw the same triangles, but not to the same bit of depth.
    let area_of_square = |values: &dyn Fn(usize) -> glam::Vec3| -> f32 {
        let texels = atlas.texels.iter().enumerate();
        texels.map(|(index, texel)| texel.open_area() * values(index).length_squared()).sum()
    };
    let apart = area_of_square(&|texel| by_vulkan[texel] - by_gl[texel]) / area_of_square(&|texel| by_vulkan[texel]);
    println!("fields are {:.3} % apart", 100.0 * apart.sqrt());
    assert!(apart.sqrt() < 0.01, "{:.2} %", 100.0 * apart.sqrt());
}

#[test]
#[ignore = "a table, not a test: cargo test --release --test gpu_submissions -- --ignored --nocapture"]
fn table_of_the_longest_submissions() {
    let texels = |count| LightmapSettings { texels: count, ..LightmapSettings::default() };
    let cases = [
        ("cornell", "cornell/cornell.obj", texels(20_000), 0.01),
        ("sponza", "sponza/sponza.obj", texels(40_000), 0.2),
        ("sponza", "sponza/sponza.obj", texels(250_000), 0.5),
        ("staircase", "staircase/staircase.obj", texels(40_000), 0.5),
    ];
    for (truth, path, map, unabsorbed) in cases {
        let Some(case) = common::truths::case(truth, path, 1000) else { return };
        let atlas = atlas_of(&case.scene, &map);
        let light = case.light.map(|light| light.to_local(&case.scene.frame));
        let settings = GpuSettings { unabsorbed, ..GpuSettings::default() };
        let mut solver = solver(&case.scene, &atlas, light, &settings);
        // Of the process, all its threads together: a submission alone takes no longer, whatever else runs.
        let mut times: Vec<(f64, f64)> = Vec::new();
        while !solver.is_done() {
            let (wall, processor) = (std::time::Instant::now(), cpu_time::ProcessTime::now());
            solver.submit().unwrap();
            times.push((processor.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64()));
        }
        let milliseconds = |part: f64, value: &dyn Fn(&(f64, f64)) -> f64| {
            let mut sorted: Vec<f64> = times.iter().map(value).collect();
            sorted.sort_by(f64::total_cmp);
            1e3 * sorted[((sorted.len() - 1) as f64 * part) as usize]
        };
        let (processor, wall) = (&|time: &(f64, f64)| time.0, &|time: &(f64, f64)| time.1);
        println!(
            "{truth}, {} texels, {} triangles, {} shooters in {} submissions: processor {:.1} ms in the mean, 99 % within \
             {:.1}, longest {:.1}; wall {:.1}, {:.1}, {:.1}",
            atlas.texels.len(),
            case.scene.mesh.triangles.len(),
            solver.ledger().shooters,
            times.len(),
            1e3 * times.iter().map(processor).sum::<f64>() / times.len() as f64,
            milliseconds(0.99, processor),
            milliseconds(1.0, processor),
            1e3 * times.iter().map(wall).sum::<f64>() / times.len() as f64,
            milliseconds(0.99, wall),
            milliseconds(1.0, wall),
        );
    }
}
