//! Writes the scenes of this repository: `cargo run --release --example make_scenes [FOLDER]`.
//!
//! The files are the same at every run; without a folder they go to this package's own `scenes`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

#[path = "make_scenes/mod.rs"]
mod make_scenes;

fn main() -> anyhow::Result<()> {
    let default = || Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folder = std::env::args_os().nth(1).map_or_else(default, PathBuf::from);
    for file in make_scenes::all()? {
        let path = folder.join(&file.path);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).with_context(|| format!("{} cannot be made", parent.display()))?;
        }
        fs::write(&path, &file.bytes).with_context(|| format!("{} cannot be written", path.display()))?;
        println!("{} ({} bytes)", path.display(), file.bytes.len());
    }
    Ok(())
}
