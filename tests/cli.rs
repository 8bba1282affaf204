//! The program as people type it.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{
    path::Path,
    process::{Command, Output, Stdio},
    time::Duration,
};

fn radiosity(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radiosity")).current_dir(folder).args(words).output().unwrap()
}

/// Runs a command that must succeed, and returns what it printed to standard output.
fn run(folder: &Path, words: &[&str]) -> String {
    let output = radiosity(folder, words);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must be refused with exit status 2, and returns its one line.
fn refused(folder: &Path, words: &[&str]) -> String {
    let output = radiosity(folder, words);
    assert_eq!(output.status.code(), Some(2), "{words:?}");
    let error = String::from_utf8(output.stderr).unwrap();
    let lines: Vec<&str> = error.lines().filter(|line| line.starts_with("error:")).collect();
    assert_eq!(lines.len(), 1, "{words:?}: {error}");
    String::from(lines[0])
}

const SOLVE: [&str; 10] =
    ["solve", "cornell", "--rays", "64", "--subdivide", "3", "--bounces", "6", "-o", "box.safetensors"];

#[test]
fn a_folder_of_the_built_in_scenes_name_does_not_hide_it() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("cornell")).unwrap();
    assert!(run(folder.path(), &["inspect", "cornell"]).contains("30"));
}

#[test]
fn a_box_is_solved_rendered_probed_compared_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let summary = run(folder, &SOLVE);
    assert!(summary.contains("bounces    7"), "{summary}");

    for view in ["radiosity", "irradiance", "direct", "indirect", "bounce=2", "normals", "albedo", "wireframe"] {
        let picture = format!("{}.png", view.replace('=', "-"));
        run(folder, &["render", "cornell", "box.safetensors", "--size", "80x60", "--view", view, "-o", &picture]);
        let picture = image::open(folder.join(picture)).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (80, 60));
        let first = picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|pixel| pixel != first), "{view}: the picture is of one colour");
    }

    run(folder, &["truth", "cornell", "--sample", "300", "--samples", "256", "-o", "truth.csv"]);
    run(folder, &["probe", "box.safetensors", "cornell", "--points", "truth.csv", "-o", "probed.csv"]);
    let probed = std::fs::read_to_string(folder.join("probed.csv")).unwrap();
    assert_eq!(probed.lines().next().unwrap(), "px,py,pz,nx,ny,nz,direct_r,direct_g,direct_b,total_r,total_g,total_b");
    assert_eq!(probed.lines().count(), 301);

    let words = ["compare", "box.safetensors", "truth.csv", "--scene", "cornell", "--json"];
    let errors: serde_json::Value = serde_json::from_str(&run(folder, &words)).unwrap();
    let lit = errors["errors"]["lit"]["total"]["relative_l2"].as_f64().unwrap();
    // 8 segments a wall err by some 6 % (ARCHITECTURE.md tells why), the truth's own noise by some 5 % at 256 paths.
    assert!(lit > 0.02 && lit < 0.15, "{lit}");

    run(folder, &["export", "box.safetensors", "cornell", "-o", "box.ply"]);
    assert!(std::fs::read(folder.join("box.ply")).unwrap().starts_with(b"ply\n"));
    run(folder, &["export", "box.safetensors", "cornell", "-o", "box.csv"]);
    assert!(std::fs::read_to_string(folder.join("box.csv")).unwrap().lines().count() > 1000);
}

#[test]
fn methods_are_timed_against_their_error_in_a_table_and_plots() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["truth", "cornell", "--sample", "200", "--samples", "256", "-o", "truth.csv"]);
    let methods = ["--method", "student", "--method", "patches"];
    let words = [["bench", "cornell", "--truth", "truth.csv"], methods].concat();
    let told = run(folder, &[&words[..], &["--repeat", "1", "-o", "bench"]].concat());
    assert!(told.contains("the assignment's method") && told.contains("patches, one ray a pair"), "{told}");
    let mut table = csv::Reader::from_path(folder.join("bench/bench.csv")).unwrap();
    let column = |name: &str| table.headers().unwrap().iter().position(|header| header == name).unwrap();
    let [seconds, error, vertices] = ["seconds", "error_vertex", "vertices"].map(column);
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let value = |row: &csv::StringRecord, column: usize| row[column].parse::<f64>().unwrap();
    assert_eq!(rows.len(), 4 + 7);
    // Cut twice, each wall's two triangles have 25 vertices; cut four times, 289: and the error falls.
    assert!(value(&rows[0], vertices) < value(&rows[3], vertices));
    assert!(rows.iter().all(|row| value(row, seconds) > 0.0 && (0.005..0.5).contains(&value(row, error))), "{rows:?}");
    assert!(value(&rows[3], error) < 0.6 * value(&rows[0], error), "{rows:?}");
    assert!(value(&rows[10], error) < 0.5 * value(&rows[4], error), "{rows:?}"); // 6,400 patches after 196
    assert!(folder.join("bench/bench.svg").exists() && folder.join("bench/bench.png").exists());
    refused(folder, &["bench", "cornell", "--truth", "none.csv", "-o", "bench"]);
}

#[test]
fn patches_are_solved_by_rays_without_a_graphics_card() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let by_rays = ["form-factors", "cornell", "--by", "rays", "--max-edge", "0.13"];
    let told = run(folder, &[&by_rays[..], &["--json", "-o", "patches.safetensors"]].concat());
    let report: serde_json::Value = serde_json::from_str(&told).unwrap();
    // 804 patches have 322,806 pairs; those that face each other, about two thirds, take a ray each.
    assert_eq!(report["patches"], 804);
    assert!((150_000..322_806).contains(&report["rays"].as_u64().unwrap()), "{told}");
    run(folder, &["render", "cornell", "patches.safetensors", "--size", "80x60", "-o", "patches.png"]);
    refused(folder, &["form-factors", "cornell", "--by", "rays", "--pair-rays", "0"]);
    let line = refused(folder, &["form-factors", "cornell", "--by", "rays", "--subdivide", "10"]);
    assert!(line.contains("patches may have") && line.contains("cut less finely"), "{line}");
}

#[test]
fn the_same_seed_writes_the_same_file_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for threads in ["1", "2", "7"] {
        run(folder.path(), &[&SOLVE[..], &["--threads", threads]].concat());
        files.push(std::fs::read(folder.path().join("box.safetensors")).unwrap());
    }
    assert!(files[0] == files[1] && files[0] == files[2]);
}

#[test]
fn flags_win_over_the_state_file_and_the_state_file_over_defaults() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), "[settings]\nrays = 4\nlight_rays = 8\nbounces = 1\nraz = 3\n")
        .unwrap();
    let words = ["solve", "cornell", "--state", "s.toml", "--rays", "16", "--light-centre", "0.2,0.5,0.2", "--json"];
    let output = radiosity(folder.path(), &words);
    assert!(String::from_utf8_lossy(&output.stderr).contains("settings.rays"), "the nearest name of `raz` is told");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let settings = &report["info"]["settings"];
    assert_eq!((settings["rays"].as_u64(), settings["light_rays"].as_u64()), (Some(16), Some(8)));
    assert_eq!(report["info"]["light"]["centre"][0].as_f64(), Some(0.2));
    assert_eq!(report["bounces"].as_u64(), Some(2));
}

#[test]
fn bad_input_is_refused_in_one_line_with_exit_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("empty.obj"), "").unwrap();
    std::fs::write(folder.join("bad.toml"), "[settings]\nrays = \"many\"\n").unwrap();
    std::fs::write(folder.join("short.safetensors"), [1, 2, 3]).unwrap();
    std::fs::write(folder.join("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert!(refused(folder, &["solve", "missing.obj"]).contains("missing.obj"));
    assert!(refused(folder, &["inspect", "empty.obj"]).contains("empty.obj"));
    assert!(refused(folder, &["solve", "cornell", "--state", "bad.toml"]).contains("bad.toml"));
    assert!(refused(folder, &["solve", "cornell", "-o", "no/such/folder/box.safetensors"]).contains("folder"));
    assert!(refused(folder, &["solve", "cornell", "--unabsorbed", "7"]).contains("unabsorbed"));
    assert!(refused(folder, &["solve", "cornell", "--light-radiance", "-1,0,0"]).contains("radiance"));
    assert!(refused(folder, &["render", "cornell", "short.safetensors", "-o", "a.png"]).contains("short.safetensors"));
    run(folder, &SOLVE);
    let other = refused(folder, &["render", "one.obj", "box.safetensors", "-o", "a.png"]);
    assert!(other.contains("cornell") && other.contains("one"), "{other}");
    assert!(!folder.join("a.png").exists());
}

#[test]
fn a_scene_is_inspected_as_text_and_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tests/furnace-50.obj");
    let report: serde_json::Value =
        serde_json::from_str(&run(folder.path(), &["inspect", "--json", scene.to_str().unwrap()])).unwrap();
    assert_eq!(report["triangles"].as_u64(), Some(768));
    assert!((report["area"].as_f64().unwrap() - 6.0).abs() < 1e-6); // a unit cube
    assert!(run(folder.path(), &["inspect", scene.to_str().unwrap()]).contains("768"));
}

#[cfg(unix)]
#[test]
fn an_interrupted_solve_ends_with_status_130_and_keeps_its_partial_result() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["solve", "cornell", "--rays", "100000", "--subdivide", "5", "-o", "part.safetensors"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .current_dir(folder.path())
        .args(words)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    run(folder.path(), &["render", "cornell", "part.safetensors", "--size", "40x30", "-o", "part.png"]);
}
