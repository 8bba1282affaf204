//! The source tree of the program: where it is, and which of its files are a student's.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};

/// Where a student's files are, from the tree's root.
pub const STUDENT_FOLDER: &str = "src/student";

/// Files of [`STUDENT_FOLDER`] that are given: a hand-in does not change them.
pub const GIVEN_FILES: [&str; 2] = ["placeholder.rs", "world.rs"];

/// The root of the program's source tree: the given folder, or else the nearest one from the current folder upwards
/// whose Cargo.toml is that of the package radiosity.
///
/// # Errors
/// There is no such folder.
pub fn find_root(named: Option<&Path>) -> anyhow::Result<PathBuf> {
    if let Some(folder) = named {
        if !is_root(folder) {
            bail!("{}: holds no Cargo.toml of radiosity; name the folder of its source", folder.display());
        }
        return folder.canonicalize().with_context(|| format!("{}: cannot be read", folder.display()));
    }
    let current = std::env::current_dir().context("the current folder cannot be read")?;
    let root = current.ancestors().find(|folder| is_root(folder));
    root.map(Path::to_path_buf).context("the current folder lies in no source tree of radiosity; go to one, or name it")
}

fn is_root(folder: &Path) -> bool {
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
    let parsed = manifest.parse::<toml::Table>().unwrap_or_default();
    parsed.get("package").and_then(|package| package.get("name")?.as_str()) == Some(env!("CARGO_PKG_NAME"))
}

/// All files below a folder, as paths from it, in the order of their names. Links are not followed.
pub fn files_below(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(relative) = folders.pop() {
        let here = folder.join(&relative);
        for entry in std::fs::read_dir(&here).with_context(|| format!("{}: cannot be read", here.display()))? {
            let entry = entry?;
            let (kind, path) = (entry.file_type()?, relative.join(entry.file_name()));
            if kind.is_dir() {
                folders.push(path);
            } else if kind.is_file() {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// A file of a student: its path from [`STUDENT_FOLDER`], with `/`, and its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudentFile {
    /// Its path, such as `basis.rs`.
    pub path: String,
    /// What it holds.
    pub text: String,
}

/// The student's files of a tree: the Rust files of [`STUDENT_FOLDER`].
pub fn student_files(root: &Path) -> anyhow::Result<Vec<StudentFile>> {
    let folder = root.join(STUDENT_FOLDER);
    let is_rust = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "rs");
    files_below(&folder)?.into_iter().filter(is_rust).map(|path| read_student_file(&folder, &path)).collect()
}

fn read_student_file(folder: &Path, path: &Path) -> anyhow::Result<StudentFile> {
    let full = folder.join(path);
    let text = std::fs::read_to_string(&full).with_context(|| format!("{}: cannot be read as text", full.display()))?;
    let names: Vec<_> = path.iter().map(|name| name.to_string_lossy()).collect();
    Ok(StudentFile { path: names.join("/"), text })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_found_from_a_folder_in_it_and_no_other_package_is_taken_for_it() -> anyhow::Result<()> {
        let own = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert_eq!(find_root(Some(own))?, own.canonicalize()?);
        let folder = tempfile::tempdir()?;
        assert!(find_root(Some(folder.path())).is_err());
        std::fs::write(folder.path().join("Cargo.toml"), "[package]\nname = \"other\"\n")?;
        let line = find_root(Some(folder.path())).err().context("another package")?.to_string();
        assert!(line.contains("holds no Cargo.toml of radiosity") && line.lines().count() == 1, "{line}");
        let files = student_files(own)?;
        assert!(files.iter().any(|file| file.path == "basis.rs" && file.text.contains("pub fn form_basis")));
        for given in GIVEN_FILES {
            assert!(files.iter().any(|file| file.path == given), "{given}");
        }
        Ok(())
    }
}
