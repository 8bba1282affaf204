//! The archive of a student's work, written and read.

use std::{
    fs::File,
    io::{Read as _, Seek, Write},
    path::{Component, Path, PathBuf},
};

use anyhow::{Context as _, bail, ensure};
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use super::{
    handin::Notes,
    tree::{StudentFile, files_below},
};

/// What is read of a hand-in: nothing else of it is used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HandIn {
    /// The Rust files of src/student.
    pub files: Vec<StudentFile>,
    /// What the student says, if there is a handin.toml.
    pub notes: Notes,
}

/// A file of a hand-in is at most so large, in bytes.
const LARGEST_FILE: u64 = 1 << 20;
/// All that is read of a hand-in is at most so large.
const LARGEST_HAND_IN: u64 = 8 << 20;
/// An archive has at most so many entries.
const MOST_ENTRIES: usize = 10_000;

/// Writes an archive: each file by its name in it.
///
/// # Errors
/// The writer's.
pub fn write<'a, Output: Write + Seek>(
    output: Output,
    files: impl IntoIterator<Item = (String, &'a [u8])>,
) -> anyhow::Result<()> {
    let mut archive = ZipWriter::new(output);
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, bytes) in files {
        archive.start_file(name, options)?;
        archive.write_all(bytes)?;
    }
    archive.finish()?;
    Ok(())
}

/// Reads a hand-in: an archive, or a folder with the same files. It may be a whole source tree, and may lie in a folder
/// of its own.
///
/// # Errors
/// One line: it holds no src/student or more than one, it is damaged or too large, or a name in it leads out of it.
pub fn read(path: &Path) -> anyhow::Result<HandIn> {
    let named = || path.display().to_string();
    let texts = if path.is_dir() { texts_of_folder(path) } else { texts_of_archive(path) }.with_context(named)?;
    hand_in(texts).with_context(named)
}

/// A path inside the hand-in that matters, split around src/student: what stands before, and the path from there. For
/// handin.toml the latter is its name.
fn place(path: &Path) -> Option<(PathBuf, String)> {
    let names: Vec<&str> = path.iter().map(|name| name.to_str()).collect::<Option<_>>()?;
    if names.contains(&"__MACOSX") || names.contains(&"target") {
        return None;
    }
    if let Some((&"handin.toml", before)) = names.split_last() {
        return Some((before.iter().collect(), String::from("handin.toml")));
    }
    let student = names.windows(2).position(|pair| pair == ["src", "student"])?;
    let is_rust = path.extension().is_some_and(|extension| extension == "rs");
    is_rust.then(|| (names[..student].iter().collect(), names[student + 2..].join("/")))
}

type Texts = Vec<((PathBuf, String), String)>;

fn texts_of_folder(folder: &Path) -> anyhow::Result<Texts> {
    let mut left = LARGEST_HAND_IN;
    let places = files_below(folder)?.into_iter().filter_map(|path| Some((place(&path)?, path)));
    places.map(|(place, path)| Ok((place, read_text(File::open(folder.join(&path))?, &path, &mut left)?))).collect()
}

fn texts_of_archive(path: &Path) -> anyhow::Result<Texts> {
    let file = File::open(path).context("cannot be read; check the path")?;
    let mut archive = ZipArchive::new(file).context("is no readable ZIP archive")?;
    ensure!(archive.len() <= MOST_ENTRIES, "holds more than {MOST_ENTRIES} entries");
    let (mut texts, mut left) = (Texts::new(), LARGEST_HAND_IN);
    for index in 0..archive.len() {
        let entry = archive.by_index(index).context("is damaged")?;
        let name = entry.name().context("is damaged")?.into_owned();
        let inside =
            entry.enclosed_name().filter(|path| path.components().all(|part| matches!(part, Component::Normal(_))));
        let Some(inside) = inside else { bail!("the name {name:?} in it leads out of it") };
        if let Some(place) = place(&inside).filter(|_| entry.is_file()) {
            texts.push((place, read_text(entry, &inside, &mut left)?));
        }
    }
    Ok(texts)
}

fn read_text(reader: impl std::io::Read, path: &Path, left: &mut u64) -> anyhow::Result<String> {
    let mut bytes = Vec::new();
    reader.take(LARGEST_FILE + 1).read_to_end(&mut bytes).with_context(|| format!("{}: is damaged", path.display()))?;
    let length = bytes.len() as u64;
    ensure!(length <= LARGEST_FILE.min(*left), "{}: is too large", path.display());
    *left -= length;
    String::from_utf8(bytes).with_context(|| format!("{}: is no text", path.display()))
}

fn hand_in(texts: Texts) -> anyhow::Result<HandIn> {
    let is_notes = |path: &str| path == "handin.toml";
    let mut roots: Vec<&PathBuf> =
        texts.iter().filter(|((_, path), _)| !is_notes(path)).map(|((root, _), _)| root).collect();
    roots.dedup();
    let root = match roots[..] {
        [] => bail!("holds no Rust file in src/student"),
        [root] => root.clone(),
        _ => bail!("holds more than one folder src/student"),
    };
    let mut found = HandIn::default();
    for ((_, path), text) in texts.into_iter().filter(|((before, _), _)| *before == root) {
        if is_notes(&path) {
            found.notes = Notes::from_toml(&text).context("handin.toml")?;
        } else {
            found.files.push(StudentFile { path, text });
        }
    }
    Ok(found)
}
