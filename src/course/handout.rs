//! The hand-out: the source tree that a teacher gives to students.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use anyhow::{Context as _, bail};

use super::{
    markers,
    tree::{files_below, find_root},
};

/// What of the root goes along: everything else there (built files, the history, a teacher's own things) stays.
const HANDED_OUT: [&str; 14] = [
    ".gitignore",
    ".rustfmt.toml",
    "ASSIGNMENT.txt",
    "CHANGELOG.txt",
    "Cargo.lock",
    "Cargo.toml",
    "README.txt",
    "benches",
    "examples",
    "handin.toml",
    "scenes",
    "src",
    "states",
    "tests",
];

/// A note on top of texts that speak of what is left out, each after its title.
const NOTES: [(&str, &str); 2] = [
    (
        "README.txt",
        "This tree is the hand-out of the assignment: begin with ASSIGNMENT.txt. Left out of it are the answers, the program's\n\
         own engine, the reference path tracer (`radiosity truth`), what is for teachers, and the tests of all these, of which\n\
         this text and src/ARCHITECTURE.md speak as well. Its engine is that of src/student.\n",
    ),
    (
        "src/ARCHITECTURE.md",
        "*In this tree, the hand-out of the assignment, the modules `transport::direct`, `transport::rows`, `solver::gather`,\n\
         `check::path_tracer` and what is for teachers in `course` are left out.*\n",
    ),
];

/// What a hand-out holds: the bytes of every file, by its path from the root.
pub type Files = BTreeMap<PathBuf, Vec<u8>>;

/// The files of the hand-out of a source tree: answers replaced by their placeholders, and without what only the program
/// with its own engine has.
///
/// # Errors
/// One line: what cannot be read, or a marker without its partner.
pub fn files(root: &Path) -> anyhow::Result<Files> {
    let mut files = Files::new();
    for name in HANDED_OUT {
        let path = root.join(name);
        let below = if path.is_dir() { files_below(&path)? } else { vec![PathBuf::new()] };
        for file in below {
            let (full, relative) = if file.as_os_str().is_empty() {
                (path.clone(), PathBuf::from(name))
            } else {
                (path.join(&file), Path::new(name).join(&file))
            };
            let bytes = std::fs::read(&full).with_context(|| format!("{}: cannot be read", full.display()))?;
            files.insert(relative, bytes);
        }
    }
    let left_out = left_out(&files);
    files.retain(|path, _| !left_out.iter().any(|left_out| path.starts_with(left_out)));
    for (path, bytes) in &mut files {
        *bytes = handed_out(path, std::mem::take(bytes)).with_context(|| path.display().to_string())?;
    }
    Ok(files)
}

/// Files and folders that are left out: modules behind the feature `reference`, and files that are behind it whole.
fn left_out(files: &Files) -> BTreeSet<PathBuf> {
    let mut left_out = BTreeSet::new();
    for (path, text) in files.iter().filter_map(|(path, bytes)| Some((path, rust_text(path, bytes)?))) {
        let folder = path.parent().unwrap_or(Path::new(""));
        let is_folders_own = path.file_stem().is_some_and(|stem| stem == "mod" || stem == "lib" || stem == "main");
        if markers::is_left_out(text) {
            left_out.insert(if path.ends_with("mod.rs") { folder.to_path_buf() } else { path.clone() });
        }
        let modules = if is_folders_own { folder.to_path_buf() } else { path.with_extension("") };
        for module in markers::left_out_modules(text) {
            left_out.insert(modules.join(&module));
            left_out.insert(modules.join(module + ".rs"));
        }
    }
    left_out
}

fn rust_text<'a>(path: &Path, bytes: &'a [u8]) -> Option<&'a str> {
    path.extension().filter(|extension| *extension == "rs")?;
    std::str::from_utf8(bytes).ok()
}

fn handed_out(path: &Path, bytes: Vec<u8>) -> anyhow::Result<Vec<u8>> {
    if let Some(text) = rust_text(path, &bytes) {
        return Ok(markers::without_reference(&markers::without_answers(text)?)?.into_bytes());
    }
    if path == Path::new("Cargo.toml") {
        return Ok(markers::without_answers(&String::from_utf8(bytes)?)?.into_bytes());
    }
    let Some((_, note)) = NOTES.iter().find(|(name, _)| path == Path::new(name)) else { return Ok(bytes) };
    let text = String::from_utf8(bytes)?.replace(" --features reference", "");
    let (title, rest) = text.split_once('\n').context("holds no title")?;
    Ok(format!("{title}\n\n{note}{rest}").into_bytes())
}

/// Writes the hand-out of the source tree at `root` (or else around the current folder) to `target`, a folder that is
/// empty or not there yet. It appears whole or not at all. Returns the number of files.
///
/// # Errors
/// One line: what is in the way, or what cannot be read or written.
pub fn write(root: Option<&Path>, target: &Path) -> anyhow::Result<usize> {
    if target.exists() {
        let mut entries = target.read_dir().with_context(|| format!("{}: is no folder", target.display()))?;
        if entries.next().is_some() {
            bail!("{}: is not empty; name a new folder", target.display());
        }
    }
    let files = files(&find_root(root)?)?;
    let parent = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let unwritable = || format!("{}: cannot be written", target.display());
    let temporary = tempfile::Builder::new().prefix(".handout-").tempdir_in(parent).with_context(unwritable)?;
    // A folder inside the temporary one has ordinary permissions; that of the temporary one is the owner's alone.
    let whole = temporary.path().join("handout");
    write_files(&files, &whole).with_context(unwritable)?;
    if target.exists() {
        std::fs::remove_dir(target).with_context(unwritable)?;
    }
    std::fs::rename(&whole, target).with_context(unwritable)?;
    Ok(files.len())
}

/// Writes the files below a folder, which is made.
pub(super) fn write_files(files: &Files, folder: &Path) -> std::io::Result<()> {
    for (path, bytes) in files {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
        std::fs::write(path, bytes)?;
    }
    Ok(())
}
