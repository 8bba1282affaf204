//! The scenes as files in memory: shared by the example that writes them and the test that compares them.

mod atrium;
mod bleeding;
mod cornell;
mod known_answers;
mod model;
mod obj;
mod picture;
mod shapes;

/// A file to write.
pub(crate) struct File {
    /// Its place below the folder of scenes, with `/`.
    pub(crate) path: String,
    pub(crate) bytes: Vec<u8>,
}

impl File {
    fn text(path: impl Into<String>, text: impl Into<String>) -> Self {
        Self { path: path.into(), bytes: text.into().into_bytes() }
    }
}

/// All files of all scenes.
pub(crate) fn all() -> anyhow::Result<Vec<File>> {
    let mut files = cornell::files();
    files.extend(bleeding::files()?);
    files.extend(atrium::files()?);
    files.extend(known_answers::files());
    Ok(files)
}
