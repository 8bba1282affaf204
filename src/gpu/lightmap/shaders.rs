//! The sources of a solve's shaders: built in, or read again from a folder while one works on them.

use std::{borrow::Cow, path::Path};

/// Structs and functions that all shaders of this folder begin with, but those of the hemicubes' faces.
pub const PATCHES_WGSL: &str = include_str!("patches.wgsl");
/// The shader of the face matrices.
pub const FACES_WGSL: &str = include_str!("faces.wgsl");
/// The shader that chooses shooters.
pub const CHOOSE_WGSL: &str = include_str!("choose.wgsl");
/// What of a light arrives at a point; comes after [`PATCHES_WGSL`].
pub const VISIBILITY_WGSL: &str = include_str!("visibility.wgsl");
/// The shader of the receiving texels; comes after [`VISIBILITY_WGSL`].
pub const RECEIVE_WGSL: &str = include_str!("receive.wgsl");
/// The shader of the energy ledger.
pub const LEDGER_WGSL: &str = include_str!("ledger.wgsl");
/// The shader that fills the pages.
pub const PAGES_WGSL: &str = include_str!("pages.wgsl");
/// What shaders that draw on hemicubes' faces begin with.
pub const ON_FACE_WGSL: &str = include_str!("on_face.wgsl");

/// What it sees by depth, and by items.
pub const SEE_BY_DEPTH_WGSL: &str = include_str!("see_by_depth.wgsl");
/// The other.
pub const SEE_BY_ITEM_WGSL: &str = include_str!("see_by_item.wgsl");

/// The shader that draws hemispheres.
pub const HEMISPHERE_WGSL: &str = include_str!("hemisphere.wgsl");

/// The shader that draws hemicubes.
pub const HEMICUBE_WGSL: &str = include_str!("hemicube.wgsl");

/// The shader that draws triangles with holes on hemicubes.
pub const CUTOUTS_WGSL: &str = include_str!("cutouts.wgsl");

/// The shaders of a solve, each as its pass loads it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaders {
    pub(super) faces: Cow<'static, str>,
    pub(super) choose: Cow<'static, str>,
    pub(super) receive: Cow<'static, str>,
    pub(super) receive_by_item: Cow<'static, str>,
    pub(super) ledger: Cow<'static, str>,
    pub(super) pages: Cow<'static, str>,
    pub(super) hemicube: Cow<'static, str>,
    pub(super) hemisphere: Cow<'static, str>,
    pub(super) cutouts: Cow<'static, str>,
}

impl Default for Shaders {
    fn default() -> Self {
        let with_patches = |source: &str| Cow::Owned(format!("{PATCHES_WGSL}{source}"));
        let with_faces = |source: &str| Cow::Owned(format!("{ON_FACE_WGSL}{source}"));
        Self {
            faces: with_patches(FACES_WGSL),
            choose: with_patches(CHOOSE_WGSL),
            receive: with_patches(&format!("{VISIBILITY_WGSL}{SEE_BY_DEPTH_WGSL}{RECEIVE_WGSL}")),
            receive_by_item: with_patches(&format!("{VISIBILITY_WGSL}{SEE_BY_ITEM_WGSL}{RECEIVE_WGSL}")),
            ledger: with_patches(LEDGER_WGSL),
            pages: with_patches(PAGES_WGSL),
            hemicube: with_faces(HEMICUBE_WGSL),
            hemisphere: with_faces(HEMISPHERE_WGSL),
            cutouts: with_faces(CUTOUTS_WGSL),
        }
    }
}

/// Where the shaders lie in the program's source tree, seen from its top.
pub const SHADER_FOLDER: &str = "src/gpu/lightmap";

impl Shaders {
    /// The shaders in a folder, by the names that they have here.
    ///
    /// # Errors
    /// One line, if one cannot be read; several, if one does not compile: the compiler's message.
    pub fn from_folder(folder: &Path) -> Result<Self, String> {
        let read = |name: &str| {
            let path = folder.join(name);
            std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
        };
        let (patches, on_face) = (read("patches.wgsl")?, read("on_face.wgsl")?);
        let visibility = read("visibility.wgsl")?;
        let by_depth = format!("{patches}{visibility}{}", read("see_by_depth.wgsl")?);
        let by_item = format!("{patches}{visibility}{}", read("see_by_item.wgsl")?);
        let checked = |name: &str, before: &str| {
            let source = format!("{before}{}", read(name)?);
            match wgpu::naga::front::wgsl::parse_str(&source) {
                Ok(_) => Ok(Cow::Owned(source)),
                Err(error) => Err(format!("{name} does not compile: {}", error.emit_to_string(&source))),
            }
        };
        Ok(Self {
            faces: checked("faces.wgsl", &patches)?,
            choose: checked("choose.wgsl", &patches)?,
            receive: checked("receive.wgsl", &by_depth)?,
            receive_by_item: checked("receive.wgsl", &by_item)?,
            ledger: checked("ledger.wgsl", &patches)?,
            pages: checked("pages.wgsl", &patches)?,
            hemicube: checked("hemicube.wgsl", &on_face)?,
            hemisphere: checked("hemisphere.wgsl", &on_face)?,
            cutouts: checked("cutouts.wgsl", &on_face)?,
        })
    }
}
