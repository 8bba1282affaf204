//! Files in and out, for the command line and the window: whole or not at all, with errors that name the file.

pub mod atlas_cache;
#[cfg(feature = "reference")]
pub mod error_plot;
mod first_camera;
pub mod lightmap_export;
pub mod loaded_scene;
pub mod mesh_export;
pub mod solved_field;
pub mod truth_comparison;

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use anyhow::{Context as _, anyhow};
use image::{ExtendedColorType, ImageEncoder as _, RgbaImage, codecs::png::PngEncoder};
use tempfile::NamedTempFile;

use crate::{
    scene::{Scene, Tessellation},
    solver::{Solution, solution_file},
};

/// Bytes kept back before they are written.
const BUFFER_SIZE: usize = 1 << 20;

/// Writes a file under a temporary name in the same folder, then renames it: a file of this name is always whole, and
/// an older one stays if anything fails. What is not a regular file (`/dev/stdout`, a pipe) is written to directly.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    write_or_leave(path, write).with_context(|| format!("{}: not written", path.display()))
}

/// Fails now if a file could not be written later: for work that takes long.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    let whole = || if is_special(path)? { Ok(()) } else { temporary_for(path).map(|_| ()) };
    whole().with_context(|| format!("{}: cannot be written", path.display()))
}

fn write_or_leave(path: &Path, write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>) -> anyhow::Result<()> {
    if is_special(path)? {
        let mut writer = BufWriter::with_capacity(BUFFER_SIZE, File::options().write(true).open(path)?);
        write(&mut writer)?;
        return Ok(writer.flush()?);
    }
    let (temporary, target) = temporary_for(path)?;
    let mut writer = BufWriter::with_capacity(BUFFER_SIZE, temporary);
    write(&mut writer)?;
    writer.into_inner().map_err(std::io::IntoInnerError::into_error)?.persist(&target)?;
    Ok(())
}

/// True for what exists and is neither file nor folder; an error for a folder.
fn is_special(path: &Path) -> anyhow::Result<bool> {
    match std::fs::metadata(path) {
        Ok(existing) if existing.is_dir() => Err(anyhow!("it is a folder; give the name of a file")),
        Ok(existing) => Ok(!existing.is_file()),
        Err(_) => Ok(false),
    }
}

/// A temporary file that can be renamed to `path`, and the path to rename it to.
fn temporary_for(path: &Path) -> anyhow::Result<(NamedTempFile, PathBuf)> {
    // A link stays a link, and what it points to is replaced.
    let target = if path.exists() { path.canonicalize()? } else { path.to_path_buf() };
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".radiosity-");
    #[cfg(unix)]
    {
        // Readable to those whom the umask lets read, as any other file; temporary files are private by default.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(folder).context("check that the folder exists and may be written to")?;
    Ok((temporary, target))
}

/// Reads a file into memory. Folders and devices, which have no end, are refused.
pub fn read_bytes(path: &Path) -> anyhow::Result<Vec<u8>> {
    let unreadable = || format!("{}: cannot be read; check the path", path.display());
    let mut file = File::open(path).with_context(unreadable)?;
    if !file.metadata().with_context(unreadable)?.is_file() {
        return Err(anyhow!("{}: is not a file; check the path", path.display()));
    }
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut file, &mut bytes).with_context(unreadable)?;
    Ok(bytes)
}

/// Reads a solution. Whether it belongs to a scene is asked by [`elements_of`].
pub fn read_solution(path: &Path) -> anyhow::Result<Solution> {
    let bytes = read_bytes(path)?;
    solution_file::decode(&bytes).map_err(|problem| anyhow!("{}: {problem}", path.display()))
}

/// Writes a solution.
pub fn write_solution(path: &Path, solution: &Solution) -> anyhow::Result<()> {
    let bytes = solution_file::encode(solution).map_err(|problem| anyhow!("{}: {problem}", path.display()))?;
    write_atomically(path, |writer| Ok(writer.write_all(&bytes)?))
}

/// Writes a picture as PNG.
pub fn write_picture(path: &Path, picture: &RgbaImage) -> anyhow::Result<()> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(picture, picture.width(), picture.height(), ExtendedColorType::Rgba8)?;
    write_atomically(path, |writer| Ok(writer.write_all(&bytes)?))
}

/// Cuts a scene into the elements that a solution was computed on; `path` is the solution's, for errors.
///
/// # Errors
/// The solution belongs to another scene, or to other elements.
pub fn elements_of(path: &Path, solution: &Solution, scene: &Scene) -> anyhow::Result<Tessellation> {
    let named = |problem: String| anyhow!("{}: {problem}", path.display());
    solution_file::check_scene(&solution.info, scene).map_err(|problem| named(problem.to_string()))?;
    let tessellation =
        Tessellation::with_cuts(scene, &solution.info.settings.tessellation(), &solution.cuts).map_err(named)?;
    let checked = solution_file::check_tessellation(&solution.info, &tessellation.hash());
    checked.map_err(|problem| named(problem.to_string()))?;
    if tessellation.mesh.positions.len() != solution.buried.len() {
        let (vertices, values) = (tessellation.mesh.positions.len(), solution.buried.len());
        return Err(named(format!("{values} values for {vertices} vertices; the file is damaged, solve again")));
    }
    Ok(tessellation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_that_fails_leaves_the_older_file_and_no_other() -> anyhow::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("out.txt");
        write_atomically(&path, |writer| Ok(writer.write_all(b"first")?))?;
        let failed = write_atomically(&path, |writer| {
            writer.write_all(b"second, cut sh")?;
            Err(anyhow!("the disk is full"))
        });
        let line = format!("{:#}", failed.err().context("must fail")?);
        assert!(line.contains("out.txt") && line.contains("the disk is full"), "{line}");
        assert_eq!(std::fs::read(&path)?, b"first");
        assert_eq!(std::fs::read_dir(folder.path())?.count(), 1);
        write_atomically(&path, |writer| Ok(writer.write_all(b"third")?))?;
        assert_eq!(std::fs::read(&path)?, b"third");
        check_writable(&path)?;
        assert_eq!(std::fs::read(&path)?, b"third", "a check changes nothing");
        let missing = check_writable(&folder.path().join("missing").join("out.txt")).err().context("must fail")?;
        assert!(format!("{missing:#}").contains("missing"), "{missing:#}");
        Ok(())
    }

    #[test]
    fn a_missing_folder_and_a_folder_as_file_are_named() -> anyhow::Result<()> {
        let folder = tempfile::tempdir()?;
        let nowhere = folder.path().join("missing").join("out.txt");
        for path in [nowhere.as_path(), folder.path()] {
            let failed = write_atomically(path, |writer| Ok(writer.write_all(b"text")?));
            let line = format!("{:#}", failed.err().context("must fail")?);
            assert!(line.contains(&path.display().to_string()) && line.lines().count() == 1, "{line}");
            assert!(read_bytes(path).is_err());
        }
        Ok(())
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_to_the_new_file() -> anyhow::Result<()> {
        let folder = tempfile::tempdir()?;
        let (target, link) = (folder.path().join("target"), folder.path().join("link"));
        std::fs::write(&target, "old")?;
        std::os::unix::fs::symlink(&target, &link)?;
        write_atomically(&link, |writer| Ok(writer.write_all(b"new")?))?;
        assert!(link.is_symlink());
        assert_eq!(std::fs::read(&target)?, b"new");
        Ok(())
    }
}
