//! What is handed out, handed in and marked. (.ci/handout builds the hand-out; here its text is looked at.)
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{
    io::Write as _,
    path::{Path, PathBuf},
    process::Command,
};

use radiosity::course::{
    archive::{self, HandIn},
    handin::Notes,
    handout,
    judge::{Limits, Program, run_limited},
    tree::{STUDENT_FOLDER, files_below, student_files},
};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn radiosity(words: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_radiosity")).current_dir(root()).args(words).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// The answers: the lines of code that stand between the markers of src/student.
fn answers() -> Vec<Vec<String>> {
    let mut answers = Vec::new();
    for file in student_files(root()).unwrap() {
        let mut answer = None;
        for line in file.text.lines().map(str::trim) {
            match (&mut answer, line) {
                (None, "// <answer>") => answer = Some(Vec::new()),
                (Some(_), line) if line.starts_with("// </answer>") => answers.extend(answer.take()),
                (Some(answer), line) => answer.push(String::from(line)),
                _ => {}
            }
        }
    }
    answers
}

/// Whether two lines of the answer that follow each other, and say something, do so in the text as well. (One line may
/// be alike anywhere.)
fn gives_away(text: &[&str], answer: &[String]) -> bool {
    let says_something = |pair: &&[String]| pair.iter().all(|line| line.len() > 16);
    answer.windows(2).filter(says_something).any(|pair| text.windows(2).any(|lines| lines == pair))
}

#[test]
fn the_hand_out_holds_no_answer_and_no_marker_and_nothing_that_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("out");
    handout::write(Some(root()), &target).unwrap();
    let answers = answers();
    assert!(answers.len() > 20, "only {} answers: is the reader of markers broken?", answers.len());
    let files = files_below(&target).unwrap();
    let name = |path: &PathBuf| path.iter().map(|name| name.to_str().unwrap()).collect::<Vec<_>>().join("/");
    let names: Vec<String> = files.iter().map(name).collect();
    for name in &names {
        let Ok(text) = std::fs::read_to_string(target.join(name)) else { continue };
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        let found = answers.iter().find(|answer| gives_away(&lines, answer));
        assert_eq!(found, None, "{name}");
        let is_students = name.starts_with(STUDENT_FOLDER);
        let line =
            answers.iter().flatten().find(|line| is_students && line.len() > 24 && lines.contains(&line.as_str()));
        assert_eq!(line, None, "{name}");
        assert!(!text.contains("answer>"), "{name}: a marker");
    }
    let whole = std::fs::read_to_string(root().join("src/student/irradiance.rs")).unwrap();
    let whole: Vec<&str> = whole.lines().map(str::trim).collect();
    assert!(answers.iter().any(|answer| gives_away(&whole, answer)), "the source itself gives its answers away");
    for gone in [
        "src/solver/gather.rs",
        "src/transport/rows.rs",
        "src/transport/direct.rs",
        "src/check/path_tracer.rs",
        "src/check/emitters.rs",
        "src/cli/truth.rs",
        "src/course/grade.rs",
        "tests/mutants/light.rs",
        "tests/samplers.rs",
    ] {
        assert!(root().join(gone).exists() && !names.iter().any(|name| name == gone), "{gone}");
    }
    for hidden in ["target/", ".git/", ".ci/"] {
        assert!(names.iter().all(|name| !name.starts_with(hidden)), "{hidden}");
    }
    for there in
        ["ASSIGNMENT.txt", "handin.toml", "src/student/basis.rs", "tests/assignment.rs", "states/atrium-vaults.toml"]
    {
        assert!(names.iter().any(|name| name == there), "{there}");
    }
    let manifest: toml::Table = std::fs::read_to_string(target.join("Cargo.toml")).unwrap().parse().unwrap();
    assert_eq!(manifest["features"]["default"].as_array().unwrap().len(), 1);
    assert!(!manifest["features"].as_table().unwrap().contains_key("reference"));
}

#[test]
fn every_function_of_a_hand_out_is_its_placeholder() {
    let files = handout::files(root()).unwrap();
    let text = |name: &str| String::from_utf8(files[&Path::new(STUDENT_FOLDER).join(name)].clone()).unwrap();
    assert!(
        text("basis.rs").ends_with("-> Mat3 {\n    (super::PLACEHOLDERS.form_basis)(normal)\n}\n"),
        "{}",
        text("basis.rs")
    );
    let in_students = files.iter().filter(|(path, _)| path.starts_with(STUDENT_FOLDER));
    let placeholders =
        in_students.map(|(_, text)| String::from_utf8_lossy(text).matches("(super::PLACEHOLDERS.").count());
    let table = text("placeholder.rs");
    let table = table.split("const PLACEHOLDERS").nth(1).unwrap().split("};").next().unwrap();
    // A ray tracer of one's own is nobody's task: it has a placeholder, but no answer.
    let functions = table.lines().filter(|line| line.contains(": |") && !line.contains("ray_tracer")).count();
    // world.rs, which is given, compares with one of them.
    assert_eq!(placeholders.sum::<usize>(), functions + 1);
    assert!(functions >= 18);
}

#[test]
fn a_folder_that_is_not_empty_and_a_broken_source_leave_everything_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    let (status, line) = radiosity(&["handout", folder.path().to_str().unwrap()]);
    assert!(status == Some(2) && line.contains("is not empty") && line.lines().count() == 1, "{line}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    let broken = tempfile::tempdir().unwrap();
    let source = broken.path().join("source");
    for (path, bytes) in handout::files(root()).unwrap() {
        std::fs::create_dir_all(source.join(&path).parent().unwrap()).unwrap();
        std::fs::write(source.join(&path), bytes).unwrap();
    }
    std::fs::create_dir_all(source.join("benches")).unwrap(); // all of it was left out
    std::fs::write(source.join("src/student/basis.rs"), "fn f() {\n    // <answer>\n}\n").unwrap();
    let problem = format!("{:#}", handout::write(Some(&source), &broken.path().join("out")).unwrap_err());
    assert!(problem.contains("basis.rs: line 2") && !problem.contains('\n'), "{problem}");
    assert_eq!(std::fs::read_dir(broken.path()).unwrap().count(), 1, "only the source");
}

fn zip(files: &[(&str, &str)]) -> tempfile::NamedTempFile {
    let mut file = tempfile::Builder::new().suffix(".zip").tempfile().unwrap();
    archive::write(&mut file, files.iter().map(|(name, text)| (String::from(*name), text.as_bytes()))).unwrap();
    file
}

fn refusal(files: &[(&str, &str)]) -> String {
    let line = format!("{:#}", archive::read(zip(files).path()).unwrap_err());
    assert!(!line.contains('\n'), "{line}");
    line
}

#[test]
fn only_the_rust_files_of_src_student_and_the_notes_are_read_from_an_archive() {
    let files = [
        ("work/src/student/basis.rs", "fn basis() {}"),
        ("work/src/student/mine/helper.rs", "fn helper() {}"),
        ("work/src/student/notes.md", "text"),
        ("work/src/main.rs", "fn main() {}"),
        ("work/build.rs", "fn main() {}"),
        ("work/handin.toml", "name = \"Ada\""),
        ("work/target/debug/src/student/basis.rs", "old"),
        ("__MACOSX/work/src/student/basis.rs", "junk"),
    ];
    let read = archive::read(zip(&files).path()).unwrap();
    let names: Vec<&str> = read.files.iter().map(|file| file.path.as_str()).collect();
    assert_eq!(names, ["basis.rs", "mine/helper.rs"]);
    assert_eq!(read.notes.name.as_deref(), Some("Ada"));

    let folder = tempfile::tempdir().unwrap();
    for (name, text) in &files[..6] {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let HandIn { files, notes } = archive::read(folder.path()).unwrap();
    assert_eq!((files, notes), (read.files, read.notes), "a folder is read as the archive of it");
}

#[test]
fn archives_that_lead_out_or_are_ambiguous_or_damaged_or_too_large_are_refused() {
    let good = ("src/student/basis.rs", "fn f() {}");
    assert!(refusal(&[good, ("../../src/student/basis.rs", "x")]).contains("leads out of it"));
    assert!(refusal(&[good, ("copy/src/student/basis.rs", "x")]).contains("more than one"));
    assert!(refusal(&[("src/main.rs", "x")]).contains("no Rust file in src/student"));
    assert!(refusal(&[good, ("src/student/large.rs", &"x".repeat(2 << 20))]).contains("too large"));
    assert!(refusal(&[good, ("handin.toml", "name = \"A\"\nnick = \"B\"\n")]).contains("handin.toml: line 2"));
    let mut cut = tempfile::NamedTempFile::new().unwrap();
    cut.write_all(&std::fs::read(zip(&[good]).path()).unwrap()[..60]).unwrap();
    assert!(format!("{:#}", archive::read(cut.path()).unwrap_err()).contains("no readable ZIP archive"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_program_without_end_and_one_without_measure_are_stopped_and_it_is_told_why() {
    let started = std::time::Instant::now();
    let run = run_limited(Command::new("sleep").arg("60"), 1, None).unwrap();
    assert_eq!(run.stopped.as_deref(), Some("it did not end within 1 s"));
    assert!(started.elapsed().as_secs() < 20);

    let mut fine_mesh = Command::new(env!("CARGO_BIN_EXE_radiosity"));
    fine_mesh.args(["solve", "cornell", "--subdivide", "9", "--rays", "1", "--json"]).env("MALLOC_ARENA_MAX", "2");
    let run = run_limited(&mut fine_mesh, 60, Some(256)).unwrap();
    assert!(run.stopped.as_deref().unwrap().contains("more than the 256 MiB of memory"), "{run:?}");

    let run = run_limited(Command::new("sh").args(["-c", "echo out; echo err >&2; exit 3"]), 60, Some(1024)).unwrap();
    assert_eq!((run.exit_status, run.stopped), (Some(3), None));
    assert_eq!((run.output.as_slice(), run.errors.as_str()), (&b"out\n"[..], "err\n"));
}

#[test]
fn a_program_that_says_nothing_usable_costs_the_task_and_not_the_marking() {
    let limits = Limits { time_limit: 20, memory_limit: 1024 };
    let (executable, root) = (PathBuf::from("echo"), root().to_path_buf());
    let mute = Program { executable, root, limits };
    let task = radiosity::check::tasks::task("basis").unwrap();
    let report = mute.check(task).unwrap();
    assert_eq!(report.earned, 0.0);
    let solve = &radiosity::course::judge::PICTURE_SOLVES[0];
    assert!(mute.solve(solve).is_err());
    let own = Program { executable: PathBuf::from(env!("CARGO_BIN_EXE_radiosity")), ..mute };
    assert_eq!(own.check(task).unwrap().earned, task.points);
}

#[test]
fn a_hand_in_wants_a_name_and_a_program_as_new_as_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("work.zip").display().to_string();
    let (status, line) = radiosity(&["handin", "-o", &output]);
    assert!(status == Some(2) && line.contains("--name") && line.lines().count() == 1, "{line}");
    let (status, line) = radiosity(&["handin", "--name", "Ada", "-o", "work.tar"]);
    assert!(status == Some(2) && line.contains(".zip"), "{line}");
    let notes = Notes::from_toml("name = \"Ada\"\ncomments = \" \"\n").unwrap();
    let flags = Notes { name: Some(String::from("Bea")), ..Notes::default() };
    let both = flags.over(notes);
    assert_eq!((both.name.as_deref(), both.comments), (Some("Bea"), None));
}
