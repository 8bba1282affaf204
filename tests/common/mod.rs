//! What several test programs need.

use std::path::{Path, PathBuf};

/// A file or folder of the shared test scenes, which lie beside the repository or where `RADIOSITY_SHARED` says.
/// None, with the reason printed, if they are absent: then a test has nothing to look at.
pub fn shared(relative: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let path = std::env::var_os("RADIOSITY_SHARED").map_or_else(beside, PathBuf::from).join(relative);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no {} (set RADIOSITY_SHARED to the folder of shared test scenes)", path.display());
    None
}
