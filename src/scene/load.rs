//! Reading OBJ and MTL files.
//!
//! In order: bytes to text (`source`), text to lines that hold nothing unusable (`clean`), parsing and cutting
//! polygons (`obj`, `polygon`), materials and textures (`mtl`, `textures`), repair (`repair`, `weld`), shading
//! normals (`normals`), and last the mesh in local units (`build`), flat neighbours merged (`merge`) and faces that touch
//! settled (`contacts`). Up to there all geometry is in f64.

mod build;
mod clean;
mod contacts;
mod merge;
mod mtl;
mod normals;
mod obj;
mod polygon;
mod repair;
mod source;
mod textures;
mod weld;

use std::path::Path;

use super::{LoadOptions, Scene, SceneError};
use build::Built;
use mtl::MtlSource;

/// Reads a scene: `path` is an OBJ file; its MTL files and textures are looked for beside it.
///
/// What can be mended is mended and told in [`Scene::warnings`].
///
/// # Errors
/// If the file cannot be read, is not an OBJ file, has no usable face, or an option is out of its range.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let text = source::read_text(path).map_err(|(problem, advice)| SceneError::new(path, problem, advice))?;
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let folder = path.parent().unwrap_or(Path::new(""));
    load_text(path, name, text, &MtlSource::Folder(folder), options)
}

/// Reads a scene from the texts of an OBJ and an MTL file; textures that the MTL names count as missing.
///
/// # Errors
/// As [`load`]; the error's path is `name`.
pub fn load_from_memory(name: &str, obj: &str, mtl: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    load_text(Path::new(name), name.to_owned(), obj.to_owned(), &MtlSource::Memory(mtl), options)
}

fn load_text(
    path: &Path,
    name: String,
    text: String,
    source: &MtlSource,
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    if let Some(problem) = options.problem() {
        return Err(SceneError::new(path, problem, "choose a value in that range"));
    }
    let cleaned = clean::clean(&text);
    drop(text);
    let mut warnings = cleaned.warnings();
    let libraries = mtl::read_libraries(source, &cleaned.libraries, &mut warnings);
    let mut soup = obj::parse(cleaned)
        .map_err(|error| SceneError::new(path, format!("the OBJ parser gave up: {error}"), "export the file again"))?;
    let (mut materials, wanted) = mtl::materials(&soup.materials, &libraries, &mut warnings);
    let no_face = |warnings: &[String]| {
        let found = if warnings.is_empty() { String::new() } else { format!(" ({})", warnings.join(", ")) };
        SceneError::new(path, format!("no usable face was found{found}"), "give an OBJ file with faces (lines `f`)")
    };
    if soup.triangles.is_empty() {
        return Err(no_face(&warnings));
    }
    repair::mend(&mut soup, options, &mut warnings);
    if soup.triangles.is_empty() {
        return Err(no_face(&warnings));
    }
    let mut textures = textures::attach(&mut materials, &wanted, options, &mut warnings);
    mtl::settle_opacity(&mut materials, options.opaque, &mut warnings);
    mtl::limit_reflectances(&mut materials, &mut textures, options.reflectance_limit, &mut warnings);
    let Built { mesh, frame, enclosed } = build::build(soup, &materials, options, &mut warnings)
        .map_err(|problem| SceneError::new(path, problem, "export the scene again with its lengths in metres"))?;
    if mesh.triangles.is_empty() {
        return Err(no_face(&warnings));
    }
    Ok(Scene {
        name,
        mesh,
        materials,
        textures,
        frame,
        enclosed,
        two_sided: options.two_sided,
        faceted: options.faceted,
        warnings,
    })
}

/// "1 face", "2 faces": a count with its noun.
fn counted(count: usize, noun: &str) -> String {
    match (count, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "vertex") => format!("{count} vertices"),
        _ => format!("{count} {noun}s"),
    }
}
