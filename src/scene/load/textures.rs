//! Decoding the textures that materials ask for.

use std::path::{Path, PathBuf};

use image::{ImageReader, Limits};
use rayon::prelude::*;

use super::mtl::WantedTextures;
use super::source;
use crate::scene::texture::TextureFilter;
use crate::scene::{LoadOptions, Material, Texture};

/// In texels: larger textures are refused.
const LARGEST_SIDE: u32 = 16384;

/// What a picture is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Reflectance,
    Opacity,
}

/// A picture to decode.
#[derive(Debug, PartialEq, Eq)]
struct Picture {
    path: PathBuf,
    name: String,
    role: Role,
}

/// A decoded picture, and whether its alpha cuts holes.
type Decoded = Result<(Texture, bool), String>;

/// Finds and decodes the textures, each once, and hands them to the materials. A picture that is missing or broken
/// counts as grey 0.6, or as opaque.
pub(super) fn attach(
    materials: &mut [Material],
    wanted: &[WantedTextures],
    options: &LoadOptions,
    warnings: &mut Vec<String>,
) -> Vec<Texture> {
    let mut pictures = Vec::new();
    let places: Vec<[Option<usize>; 2]> = wanted
        .iter()
        .map(|wanted| {
            let mut place = |name: &Option<String>, role| {
                place_of(name.as_deref()?, &wanted.folders, role, &mut pictures, warnings)
            };
            [place(&wanted.reflectance, Role::Reflectance), place(&wanted.opacity, Role::Opacity)]
        })
        .collect();
    let decoded: Vec<Decoded> = pictures.par_iter().map(|picture| decode(picture, options.texture_filter)).collect();
    let mut textures = Vec::new();
    let mut numbers: Vec<Option<(u32, bool)>> = Vec::new();
    for (picture, decoded) in pictures.iter().zip(decoded) {
        numbers.push(match decoded {
            Ok((texture, has_cut_outs)) => {
                textures.push(texture);
                Some((textures.len() as u32 - 1, has_cut_outs))
            }
            Err(problem) => {
                tell_once(format!("the texture {:?} is of no use: {problem}", picture.name), warnings);
                None
            }
        });
    }
    for ((material, wanted), places) in materials.iter_mut().zip(wanted).zip(places) {
        let [reflectance, opacity] = places.map(|place| numbers[place?]);
        material.reflectance_texture = reflectance.map(|(number, _)| number);
        let cut_out_alpha = reflectance.filter(|(_, has_cut_outs)| *has_cut_outs);
        material.opacity_texture = opacity.or(cut_out_alpha).map(|(number, _)| number);
        if wanted.reflectance.is_some() && reflectance.is_none() {
            material.reflectance *= Material::default().reflectance;
        }
    }
    textures
}

/// The place of a picture in the list, which it joins when it is met first; none if there is no such file.
fn place_of(
    name: &str,
    folders: &[PathBuf],
    role: Role,
    pictures: &mut Vec<Picture>,
    warnings: &mut Vec<String>,
) -> Option<usize> {
    let Some(path) = folders.iter().find_map(|folder| source::find(folder, name)) else {
        tell_once(format!("the texture {name:?} is missing"), warnings);
        return None;
    };
    let known = pictures.iter().position(|picture| picture.path == path && picture.role == role);
    Some(known.unwrap_or_else(|| {
        pictures.push(Picture { path, name: name.to_owned(), role });
        pictures.len() - 1
    }))
}

fn tell_once(warning: String, warnings: &mut Vec<String>) {
    if !warnings.contains(&warning) {
        warnings.push(warning);
    }
}

fn decode(picture: &Picture, filter: TextureFilter) -> Decoded {
    let one_line = |error: &dyn std::fmt::Display| error.to_string().replace(['\n', '\r'], " ");
    let image = open(&picture.path).map_err(|error| one_line(&error))?;
    let has_alpha = image.color().has_alpha();
    let pixels = image.into_rgba8();
    let (width, height) = pixels.dimensions();
    if width == 0 || height == 0 {
        return Err(String::from("it has no pixels"));
    }
    let texels = pixels.pixels().map(|pixel| pixel.0).collect();
    let mut texture = Texture::new(picture.name.clone(), width, height, texels, filter);
    let mut has_cut_outs = has_alpha && texture.has_cut_outs();
    if picture.role == Role::Opacity && !has_cut_outs {
        texture = texture.with_opacity_from_grey();
        has_cut_outs = true;
    }
    Ok((texture, has_cut_outs))
}

fn open(path: &Path) -> Result<image::DynamicImage, image::ImageError> {
    let mut reader = ImageReader::open(path)?.with_guessed_format()?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    reader.limits(limits);
    reader.decode()
}
