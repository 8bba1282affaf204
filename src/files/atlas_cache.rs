//! Lightmaps without their light, kept on the disk from run to run: unwrapping a large scene takes longer than reading.
//!
//! A file is a head of 32-bit words (format, columns, rows, pages, triangles, texels), the arrays, and a hash of it all. Its
//! name is a hash of the scene and of what its map was made with. A file that is not whole is made again.

use std::{
    path::{Path, PathBuf},
    time::SystemTime,
};

use glam::Vec2;

use super::write_atomically;
use crate::{
    lightmap::{Atlas, Charts, LightmapSettings, Texel, unwrap::UnwrapProgress},
    scene::Scene,
    trace::RayTracer,
};

/// Raised whenever the same scene would be mapped otherwise, or the file's layout changes.
const FORMAT: u32 = 2;
const HEAD: usize = 24;
const HASH: usize = 32;

/// A folder of maps.
#[derive(Clone, Debug)]
pub struct AtlasCache {
    folder: PathBuf,
    most_bytes: u64,
}

impl AtlasCache {
    /// The user's own, where programs keep what can be made again; none if the system has no such place.
    pub fn of_user() -> Option<Self> {
        let folders = directories::ProjectDirs::from("", "", "radiosity")?;
        Some(Self::in_folder(&folders.cache_dir().join("lightmaps"), 1 << 30))
    }

    /// In a folder, which is made when something is kept. Past `most_bytes` the files that were not used for the longest
    /// time are removed.
    pub fn in_folder(folder: &Path, most_bytes: u64) -> Self {
        Self { folder: folder.to_path_buf(), most_bytes }
    }

    /// The map from the cache, and true; else it is made, and kept for the next time. That it cannot be kept is no error.
    ///
    /// # Errors
    /// As [`Atlas::new`]; `Ok(None)` if `progress` stopped it.
    pub fn atlas(
        &self,
        scene: &Scene,
        tracer: &dyn RayTracer,
        settings: &LightmapSettings,
        progress: &UnwrapProgress<'_>,
    ) -> Result<Option<(Atlas, bool)>, String> {
        let path = self.path(scene, settings);
        if let Some(atlas) = std::fs::read(&path).ok().and_then(|bytes| decode(&bytes)) {
            // For the order of removal.
            let _ = std::fs::File::open(&path).and_then(|file| file.set_modified(SystemTime::now()));
            return Ok(Some((atlas, true)));
        }
        let Some(atlas) = Atlas::new(scene, tracer, settings, progress)? else { return Ok(None) };
        let bytes = encode(&atlas);
        if std::fs::create_dir_all(&self.folder).is_ok()
            && write_atomically(&path, |writer| Ok(writer.write_all(&bytes)?)).is_ok()
        {
            self.shrink(&path);
        }
        Ok(Some((atlas, false)))
    }

    fn path(&self, scene: &Scene, settings: &LightmapSettings) -> PathBuf {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&FORMAT.to_le_bytes());
        hasher.update(scene.hash().as_bytes());
        hasher.update(&[u8::from(scene.two_sided)]);
        hasher.update(format!("{settings:?}").as_bytes());
        self.folder.join(format!("{}.atlas", hasher.finalize().to_hex()))
    }

    /// Removes the oldest files but `newest`.
    fn shrink(&self, newest: &Path) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        let mut files: Vec<(SystemTime, u64, PathBuf)> = entries
            .flatten()
            .filter(|entry| entry.path().extension().is_some_and(|extension| extension == "atlas"))
            .filter_map(|entry| entry.metadata().ok().map(|found| (found, entry.path())))
            .filter_map(|(found, path)| Some((found.modified().ok()?, found.len(), path)))
            .collect();
        files.sort();
        let mut bytes: u64 = files.iter().map(|(_, size, _)| size).sum();
        for (_, size, path) in files.iter().filter(|(.., path)| path != newest) {
            if bytes <= self.most_bytes {
                break;
            }
            if std::fs::remove_file(path).is_ok() {
                bytes -= size;
            }
        }
    }
}

fn encode(atlas: &Atlas) -> Vec<u8> {
    let charts = &atlas.charts;
    let [width, height] = charts.page_size;
    let head = [FORMAT, width, height, charts.page_count, charts.pages.len() as u32, atlas.texels.len() as u32];
    let mut bytes: Vec<u8> = bytemuck::cast_slice(&head).to_vec();
    bytes.extend_from_slice(bytemuck::cast_slice(&charts.pages));
    bytes.extend_from_slice(bytemuck::cast_slice(&charts.chart_of_triangle));
    bytes.extend_from_slice(bytemuck::cast_slice(&charts.coordinates));
    bytes.extend_from_slice(bytemuck::cast_slice(&atlas.texels));
    let hash = blake3::hash(&bytes);
    bytes.extend_from_slice(hash.as_bytes());
    bytes
}

/// None for anything but what [`encode`] writes.
fn decode(bytes: &[u8]) -> Option<Atlas> {
    let (contents, hash) = bytes.split_at_checked(bytes.len().checked_sub(HASH)?)?;
    if blake3::hash(contents).as_bytes() != hash {
        return None;
    }
    let (head, rest) = contents.split_at_checked(HEAD)?;
    let head: Vec<u32> = bytemuck::pod_collect_to_vec(head);
    let [FORMAT, width, height, page_count, triangles, texels] = head[..] else { return None };
    let (triangles, texels) = (triangles as usize, texels as usize);
    let (pages, rest) = rest.split_at_checked(4 * triangles)?;
    let (chart_of_triangle, rest) = rest.split_at_checked(4 * triangles)?;
    let (coordinates, rest) = rest.split_at_checked(size_of::<[Vec2; 3]>() * triangles)?;
    if rest.len() != size_of::<Texel>() * texels {
        return None;
    }
    let charts = Charts {
        page_size: [width, height],
        page_count,
        pages: bytemuck::pod_collect_to_vec(pages),
        chart_of_triangle: bytemuck::pod_collect_to_vec(chart_of_triangle),
        coordinates: bytemuck::pod_collect_to_vec(coordinates),
    };
    Some(Atlas { charts, texels: bytemuck::pod_collect_to_vec(rest) })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{
        scene::{LoadOptions, builtin},
        trace::Tracer,
    };

    fn texels(count: u32) -> LightmapSettings {
        LightmapSettings { texels: count, ..LightmapSettings::default() }
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let mut found: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        found.sort();
        found
    }

    #[test]
    fn a_map_comes_from_the_cache_the_second_time_and_is_made_again_if_its_file_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let cache = AtlasCache::in_folder(&folder.path().join("maps"), 1 << 30);
        let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
        let tracer = Tracer::new(Arc::clone(&scene));
        let get = |settings: &LightmapSettings| cache.atlas(&scene, &tracer, settings, &|_, _| true).unwrap().unwrap();
        let (made, from_cache) = get(&texels(500));
        assert!(!from_cache);
        let (found, from_cache) = get(&texels(500));
        assert!(from_cache && found.charts == made.charts && found.texels == made.texels);
        // Another map is another file.
        assert!(!get(&texels(600)).1 && get(&texels(600)).1);
        for file in files(&folder.path().join("maps")) {
            let mut bytes = std::fs::read(&file).unwrap();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            std::fs::write(&file, bytes).unwrap();
        }
        let (again, from_cache) = get(&texels(500));
        assert!(!from_cache && again.charts == made.charts && again.texels == made.texels);
        assert!(get(&texels(500)).1, "the damaged file was not replaced");
        for file in files(&folder.path().join("maps")) {
            std::fs::write(&file, [1, 2, 3]).unwrap();
        }
        assert!(!get(&texels(600)).1);
    }

    #[test]
    fn past_its_size_the_cache_forgets_what_was_not_used_for_the_longest_time() {
        let folder = tempfile::tempdir().unwrap();
        let scene = Arc::new(builtin::cornell(&LoadOptions::default()).unwrap());
        let tracer = Tracer::new(Arc::clone(&scene));
        let one = {
            let all = AtlasCache::in_folder(folder.path(), 1 << 30);
            all.atlas(&scene, &tracer, &texels(500), &|_, _| true).unwrap();
            std::fs::metadata(&files(folder.path())[0]).unwrap().len()
        };
        let cache = AtlasCache::in_folder(folder.path(), one * 5 / 2);
        let get = |count: u32| {
            std::thread::sleep(std::time::Duration::from_millis(20));
            cache.atlas(&scene, &tracer, &texels(count), &|_, _| true).unwrap().unwrap().1
        };
        assert!(!get(501) && get(500));
        // 501 is the oldest now.
        assert!(!get(502) && files(folder.path()).len() == 2);
        assert!(get(500) && get(502) && !get(501));
    }
}
