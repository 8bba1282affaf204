//! `radiosity lightmap`, `devices` and `form-factors` as a user runs them.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{
    path::Path,
    process::{Command, Output},
};

fn radiosity(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .current_dir(folder)
        .env("XDG_RUNTIME_DIR", folder)
        .env("XDG_CACHE_HOME", folder.join("cache"))
        .args(arguments)
        .output()
        .unwrap()
}

fn standard_output(output: &Output) -> String {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn refusal(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2));
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    let lines: Vec<&str> = errors.lines().filter(|line| line.starts_with("error:")).collect();
    assert_eq!(lines.len(), 1, "{errors}");
    String::from(lines[0])
}

#[test]
fn a_lightmap_is_written_for_other_programs_and_read_back_by_probe_and_compare() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| radiosity(folder.path(), arguments);
    let map = ["lightmap", "cornell", "--texels", "2000", "--light-side", "4", "-o", "map", "--json"];
    let report: serde_json::Value = serde_json::from_str(&standard_output(&run(&map))).unwrap();
    assert!(report["unabsorbed"].as_f64().unwrap() <= 0.01 && report["balance"].as_f64().unwrap().abs() < 0.01);
    let file = |name: &str| folder.path().join("map").join(name);
    // The picture in the EXR is the irradiance in the solution, to the bit.
    let image = image::open(file("lightmap-0.exr")).unwrap().to_rgb32f();
    let solution = radiosity::solver::lightmap_solution::decode(&std::fs::read(file("lightmap.safetensors")).unwrap());
    let solution = solution.unwrap();
    let [width, height] = solution.charts.page_size;
    assert_eq!((image.width(), image.height()), (width, height));
    let values: Vec<f32> = solution.total.iter().flat_map(|value| value.to_array()).collect();
    assert_eq!(image.into_raw(), values);
    assert_eq!(image::open(file("lightmap-0.png")).unwrap().width(), width);
    // The OBJ is the scene: the same area, and a coordinate for every corner.
    let inspected = standard_output(&run(&["inspect", "map/lightmap.obj"]));
    // The floor is cut around the blocks: the box's 30 triangles are 46.
    assert!(inspected.contains("triangles  46"), "{inspected}");
    let obj = std::fs::read_to_string(file("lightmap.obj")).unwrap();
    assert_eq!(obj.lines().filter(|line| line.starts_with("vt ")).count(), 3 * 46);
    // Points of it, and the difference to the ray tracer's solution.
    std::fs::write(folder.path().join("points.csv"), "px,py,pz,nx,ny,nz\n0.28,0,0.1,0,1,0\n").unwrap();
    standard_output(&run(&["probe", "map/lightmap.safetensors", "cornell", "--points", "points.csv", "-o", "out.csv"]));
    let line =
        std::fs::read_to_string(folder.path().join("out.csv")).unwrap().lines().nth(1).map(String::from).unwrap();
    let numbers: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
    let (direct, total) = (numbers[6], numbers[9]);
    assert!(direct > 0.1 && total > direct, "{line}");
    standard_output(&run(&["solve", "cornell", "--subdivide", "4", "-o", "rays.safetensors"]));
    let compared = run(&["compare", "map/lightmap.safetensors", "rays.safetensors", "--scene", "cornell", "--json"]);
    let compared: serde_json::Value = serde_json::from_str(&standard_output(&compared)).unwrap();
    let errors = &compared["errors"]["lit"]["total"];
    assert!(errors["bias"].as_f64().unwrap().abs() < 0.02, "{errors}");
    assert!(errors["relative_l2"].as_f64().unwrap() < 0.15, "{errors}"); // 18 texels a wall
    let without_scene = refusal(&run(&["compare", "map/lightmap.safetensors", "rays.safetensors"]));
    assert!(without_scene.contains("--scene"), "{without_scene}");
    pictures_of_both_show_the_same_light(folder.path());
}

/// Colours of the map's and the ray tracer's picture, in sRGB-coded levels.
fn pictures_of_both_show_the_same_light(folder: &Path) {
    let run = |arguments: &[&str]| radiosity(folder, arguments);
    for view in ["radiosity", "direct", "indirect"] {
        let [map, rays] = ["map/lightmap", "rays"].map(|name| {
            let solution = format!("{name}.safetensors");
            let size = ["--size", "160x120", "--samples", "1"];
            standard_output(&run(
                &[&["render", "cornell", &solution, "--view", view, "-o", "seen.png"], &size[..]].concat()
            ));
            image::open(folder.join("seen.png")).unwrap().to_rgb8().into_raw()
        });
        let apart: u64 = map.iter().zip(&rays).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        let bright: u64 = rays.iter().map(|level| u64::from(*level)).sum();
        // Shadows' edges are soft by a texel of 3 cm; without the field nothing but the light is bright.
        assert!(apart < bright / 25, "{view}: {apart} of {bright}");
    }
    let late = run(&["render", "cornell", "map/lightmap.safetensors", "--view", "bounce=2", "-o", "seen.png"]);
    assert!(refusal(&late).contains("bounce 2"));
}

#[test]
fn form_factors_give_a_solution_near_the_ray_tracers() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| radiosity(folder.path(), arguments);
    let factors = ["form-factors", "cornell", "--subdivide", "3", "--resolution", "64", "-o", "patches.safetensors"];
    let report = standard_output(&run(&[&factors[..], &["--json"]].concat()));
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let number = |name: &str| report["quality"][name].as_f64().unwrap();
    // The front is open: rows sum to less than 1, and no row to more.
    assert!(number("greatest_row_sum") < 1.01 && number("mean_row_sum") > 0.5, "{report}");
    assert!(number("reciprocity_error") < 0.2, "{report}");
    let changes: Vec<f64> = report["changes"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
    assert!(changes.len() > 5 && changes[5] < 0.1 * changes[0], "{changes:?}");
    standard_output(&run(&["solve", "cornell", "--subdivide", "3", "-o", "rays.safetensors"]));
    let compared = standard_output(&run(&["compare", "patches.safetensors", "rays.safetensors", "--json"]));
    let compared: serde_json::Value = serde_json::from_str(&compared).unwrap();
    let errors = &compared["errors"]["lit"]["total"];
    assert!(errors["bias"].as_f64().unwrap().abs() < 0.06, "{errors}"); // constant patches at 8 segments a wall
}

#[test]
fn devices_lists_names_and_what_is_wrong_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| radiosity(folder.path(), arguments);
    let listed = standard_output(&run(&["devices"]));
    assert!(listed.lines().next().unwrap().contains("(default)"), "{listed}");
    let unknown = run(&["lightmap", "cornell", "--device", "no such card", "-o", "map"]);
    assert!(refusal(&unknown).contains("no such card"));
    let odd = run(&["lightmap", "cornell", "--hemicube", "63", "-o", "map"]);
    assert!(refusal(&odd).contains("even"));
    let group = run(&["lightmap", "cornell", "--group", "3", "-o", "map"]);
    assert!(refusal(&group).contains("group"));
    std::fs::write(folder.path().join("file"), "").unwrap();
    assert!(refusal(&run(&["lightmap", "cornell", "-o", "file"])).contains("file"));
}
