//! Materials from MTL files.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::clean::logical_lines;
use super::{counted, source};
use crate::scene::{Material, Texture};

/// Where the MTL text comes from.
pub(super) enum MtlSource<'a> {
    /// Files that the OBJ names, seen from its folder.
    Folder(&'a Path),
    /// This text, whatever the OBJ names; it has no textures.
    Memory(&'a str),
}

/// A material of an MTL file.
pub(super) struct Entry {
    material: tobj::Material,
    /// The folders in which its textures are looked for.
    folders: Vec<PathBuf>,
}

/// The pictures a material asks for.
#[derive(Debug, Default)]
pub(super) struct WantedTextures {
    /// `map_Kd`, as the file writes it, without options.
    pub(super) reflectance: Option<String>,
    /// `map_d`.
    pub(super) opacity: Option<String>,
    /// Where to look.
    pub(super) folders: Vec<PathBuf>,
}

/// The highest reflectance that any option allows.
const HIGHEST_REFLECTANCE: f32 = 0.999;

/// So many names are listed in a warning.
const NAMES_TOLD: usize = 5;

/// Reads every MTL file that the OBJ names; later materials replace earlier ones of the same name.
pub(super) fn read_libraries(
    source: &MtlSource,
    names: &[String],
    warnings: &mut Vec<String>,
) -> BTreeMap<String, Entry> {
    let mut entries = BTreeMap::new();
    let folder = match source {
        MtlSource::Memory(text) => {
            add_library(text, "the MTL text", &[], &mut entries, warnings);
            return entries;
        }
        MtlSource::Folder(folder) => *folder,
    };
    for name in names.iter().flat_map(|names| file_names(folder, names)) {
        let Some(path) = source::find(folder, &name) else {
            warnings.push(format!("the material file {name:?} is missing"));
            continue;
        };
        match source::read_text(&path) {
            Ok(text) => {
                let folders = [path.parent().unwrap_or(Path::new("")).to_path_buf(), folder.to_path_buf()];
                add_library(&text, &name, &folders, &mut entries, warnings);
            }
            Err((problem, _)) => warnings.push(format!("the material file {name:?} is of no use: {problem}")),
        }
    }
    entries
}

/// The files of one `mtllib` line: one name if such a file exists, otherwise cut behind each ".mtl", otherwise at
/// white space.
fn file_names(folder: &Path, line: &str) -> Vec<String> {
    let line = line.replace("\\ ", " ");
    if source::find(folder, &line).is_some() {
        return vec![line];
    }
    let mut names = Vec::new();
    let mut rest = line.as_str();
    while let Some(end) = rest.to_ascii_lowercase().find(".mtl").map(|place| place + 4) {
        names.push(rest[..end].trim().to_owned());
        rest = &rest[end..];
    }
    if names.is_empty() { line.split_whitespace().map(str::to_owned).collect() } else { names }
}

fn add_library(
    text: &str,
    name: &str,
    folders: &[PathBuf],
    entries: &mut BTreeMap<String, Entry>,
    warnings: &mut Vec<String>,
) {
    let (cleaned, bad_lines) = clean(text);
    if let Some(first) = bad_lines.first() {
        let lines = counted(bad_lines.len(), "line");
        warnings.push(format!("ignored {lines} of {name:?} that cannot be read, first line {first}"));
    }
    match tobj::load_mtl_buf(&mut cleaned.as_bytes()) {
        Ok((materials, _)) => entries.extend(
            materials
                .into_iter()
                .map(|material| (material.name.clone(), Entry { material, folders: folders.to_vec() })),
        ),
        Err(error) => warnings.push(format!("the material file {name:?} is of no use: {error}")),
    }
}

/// The lines of an MTL text that count, in the form a strict parser wants, and the numbers of those not understood.
fn clean(text: &str) -> (String, Vec<usize>) {
    let mut cleaned = String::new();
    let mut bad_lines = Vec::new();
    let mut has_dissolve = false;
    for (line_number, line) in logical_lines(text) {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let last_number = || rest.split_whitespace().last().and_then(|word| word.parse::<f64>().ok());
        let entry = match keyword.to_ascii_lowercase().as_str() {
            "newmtl" => {
                has_dissolve = false;
                Some(rest.to_owned()).filter(|name| !name.is_empty()).map(|name| format!("newmtl {name}"))
            }
            "kd" => colour(rest).map(|colour| format!("Kd {colour}")),
            "ke" => colour(rest).map(|colour| format!("Ke {colour}")),
            "ks" => colour(rest).map(|colour| format!("Ks {colour}")),
            "d" => {
                has_dissolve = true;
                last_number().map(|opacity| format!("d {opacity}"))
            }
            // Where both are given they should agree; where they do not, `d` is the one that exporters get right.
            "tr" if has_dissolve => continue,
            "tr" => last_number().map(|transparency| format!("d {}", 1.0 - transparency)),
            "map_kd" => map_file(rest).map(|file| format!("map_Kd {file}")),
            "map_d" => map_file(rest).map(|file| format!("map_d {file}")),
            _ => continue,
        };
        match entry {
            Some(entry) => {
                let _ = writeln!(cleaned, "{entry}");
            }
            None => bad_lines.push(line_number),
        }
    }
    (cleaned, bad_lines)
}

/// Three numbers; one alone counts for all three, as the format says.
fn colour(rest: &str) -> Option<String> {
    let words = rest.split_whitespace().take_while(|word| !word.starts_with('#')).take(3);
    let numbers = words.map(|word| word.parse::<f64>().ok()).collect::<Option<Vec<f64>>>()?;
    match numbers[..] {
        [grey] => Some(format!("{grey} {grey} {grey}")),
        [red, green, blue] => Some(format!("{red} {green} {blue}")),
        _ => None,
    }
}

/// Options of texture maps, and how many arguments each takes at most; those with several may leave out the last.
const MAP_OPTIONS: [(&str, usize); 14] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-boost", 1),
    ("-bm", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-colorspace", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
    ("-type", 1),
];

/// The file name of a map statement, without the options before or behind it.
fn map_file(rest: &str) -> Option<&str> {
    let argument_count = |word: &str| MAP_OPTIONS.iter().find(|(option, _)| *option == word).map(|(_, count)| *count);
    let mut rest = rest.trim();
    while let Some((arguments, after)) =
        rest.split_once(char::is_whitespace).and_then(|(word, after)| Some((argument_count(word)?, after.trim_start())))
    {
        rest = after;
        for number in 0..arguments {
            let Some((word, after)) = rest.split_once(char::is_whitespace) else { break };
            if number > 0 && word.parse::<f64>().is_err() {
                break;
            }
            rest = after.trim_start();
        }
    }
    let options_behind = MAP_OPTIONS.iter().filter_map(|(option, _)| rest.find(&format!(" {option} ")));
    let file = rest[..options_behind.min().unwrap_or(rest.len())].trim().trim_matches('"');
    if file.is_empty() { None } else { Some(file) }
}

/// The scene's materials: one for each name, found in the libraries or grey, and the textures they ask for.
pub(super) fn materials(
    names: &[Option<String>],
    libraries: &BTreeMap<String, Entry>,
    warnings: &mut Vec<String>,
) -> (Vec<Material>, Vec<WantedTextures>) {
    let mut unknown = Vec::new();
    let mut tallies = Tallies::default();
    let found = names.iter().map(|name| {
        let Some(name) = name else {
            tallies.nameless = true;
            return (Material::default(), WantedTextures::default());
        };
        let Some(entry) = libraries.get(name) else {
            unknown.push(name.as_str());
            return (Material { name: name.clone(), ..Default::default() }, WantedTextures::default());
        };
        let wanted = WantedTextures {
            reflectance: entry.material.diffuse_texture.clone(),
            opacity: entry.material.dissolve_texture.clone(),
            folders: entry.folders.clone(),
        };
        (convert(&entry.material, &mut tallies), wanted)
    });
    let found = found.unzip();
    if !unknown.is_empty() {
        let more = if unknown.len() > NAMES_TOLD { ", ..." } else { "" };
        let list = unknown[..unknown.len().min(NAMES_TOLD)].join(", ");
        let count = counted(unknown.len(), "material");
        warnings.push(format!("{count} without an entry in a material file, grey 0.6 instead: {list}{more}"));
    }
    tallies.tell(warnings);
    found
}

/// Counts of materials with something to be told.
#[derive(Default)]
struct Tallies {
    nameless: bool,
    broken: usize,
    specular: usize,
}

impl Tallies {
    fn tell(&self, warnings: &mut Vec<String>) {
        if self.nameless {
            warnings.push(String::from("some faces have no material: grey 0.6 instead"));
        }
        if self.broken > 0 {
            let count = counted(self.broken, "material");
            warnings.push(format!("took negative or unusable Kd or Ke values of {count} as 0"));
        }
        if self.specular > 0 {
            let count = counted(self.specular, "material");
            warnings.push(format!("ignored the specular terms (Ks) of {count}: all surfaces are diffuse"));
        }
    }
}

fn convert(source: &tobj::Material, tallies: &mut Tallies) -> Material {
    let mut broken = false;
    let mut radiometric = |colour: [f64; 3]| {
        Vec3::from_array(colour.map(|value| {
            let usable = (0.0..=1e18).contains(&value);
            broken |= !usable;
            if usable { value as f32 } else { 0.0 }
        }))
    };
    let absent = if source.diffuse_texture.is_some() { Vec3::ONE } else { Material::default().reflectance };
    let reflectance = source.diffuse.map_or(absent, &mut radiometric);
    let emitted_radiance = source.emissive.map_or(Vec3::ZERO, &mut radiometric);
    let opacity = source.dissolve.filter(|value| value.is_finite()).map_or(1.0, |value| value.clamp(0.0, 1.0) as f32);
    tallies.broken += usize::from(broken);
    tallies.specular += usize::from(source.specular.is_some_and(|specular| specular != [0.0; 3]));
    Material { name: source.name.clone(), reflectance, emitted_radiance, opacity, ..Default::default() }
}

/// Closes every surface if asked to; otherwise tells of materials that light passes everywhere.
pub(super) fn settle_opacity(materials: &mut [Material], opaque: bool, warnings: &mut Vec<String>) {
    if opaque {
        for material in materials.iter_mut() {
            (material.opacity, material.opacity_texture) = (1.0, None);
        }
    }
    let see_through = materials.iter().filter(|material| material.opacity < 0.5).count();
    if see_through > 0 {
        let count = counted(see_through, "material");
        warnings.push(format!("{count} less than half opaque: light passes (option --opaque closes them)"));
    }
}

/// Brings reflectances down to the limit. Of a textured material the texels that exceed it are brought down, so that
/// the rest of its texture keeps its values.
pub(super) fn limit_reflectances(
    materials: &mut [Material],
    textures: &mut [Texture],
    limit: f32,
    warnings: &mut Vec<String>,
) {
    let limit = limit.clamp(0.0, HIGHEST_REFLECTANCE);
    let mut factors = vec![limit; textures.len()];
    let mut clamped = vec![false; materials.len()];
    for (material, clamped) in materials.iter_mut().zip(&mut clamped) {
        let most = if material.reflectance_texture.is_some() { 1.0 } else { limit };
        *clamped = material.reflectance.max_element() > most;
        material.reflectance = material.reflectance.min(Vec3::splat(most));
        if let Some(texture) = material.reflectance_texture {
            factors[texture as usize] = factors[texture as usize].max(material.reflectance.max_element());
        }
    }
    let changed: Vec<bool> =
        textures.iter_mut().zip(factors).map(|(texture, factor)| texture.limit_values(limit / factor)).collect();
    for (material, clamped) in materials.iter().zip(&mut clamped) {
        *clamped |= material.reflectance_texture.is_some_and(|texture| changed[texture as usize]);
    }
    let count = clamped.iter().filter(|clamped| **clamped).count();
    if count > 0 {
        let count = counted(count, "material");
        warnings.push(format!("clamped the reflectance of {count} to {limit} (option --reflectance-limit)"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_options_with_all_their_arguments_leave_the_file_name() {
        for (line, file) in [
            ("wood.png", "wood.png"),
            ("  my old wood.png  ", "my old wood.png"),
            ("-s 1 1 1 -o 0.1 wood.png", "wood.png"),
            ("-o 0.1 my wood.png", "my wood.png"),
            ("-colorspace sRGB -o 0.1 wood.png", "wood.png"),
            ("-mm 0.1 0.3 -imfchan r -bm 3 \"my wood.png\"", "my wood.png"),
            ("-texres 512 wood.png", "wood.png"),
            ("-blendu on -clamp off wood-s 2.png -bm 1.5", "wood-s 2.png"),
            ("-unknown.png", "-unknown.png"),
        ] {
            assert_eq!(map_file(line), Some(file), "{line}");
        }
        assert_eq!(map_file(" "), None);
    }

    #[test]
    fn a_strict_parser_gets_only_what_it_can_read() {
        let text = "Kd 9 9 9\nnewmtl a b \nKd 0.5\nkd x\nKe 1 2 3 # lamp\nTr 0.25\nmap_kd -s 2 x.png\nmap_Kd\n\
            newmtl\nnewmtl c\nd -halo 0.5\nTr 1\nKd spectral file.rfl\nillum two\n";
        let (cleaned, bad_lines) = clean(text);
        assert_eq!(cleaned, "Kd 9 9 9\nnewmtl a b\nKd 0.5 0.5 0.5\nKe 1 2 3\nd 0.75\nmap_Kd x.png\nnewmtl c\nd 0.5\n");
        assert_eq!(bad_lines, [4, 8, 9, 13]);
    }

    #[test]
    fn limits_bring_down_colours_and_only_the_brightest_texels() {
        let texel = |grey: u8| [grey, grey, grey, 255];
        let mut texture = vec![Texture::new(String::new(), 2, 1, vec![texel(255), texel(188)], Default::default())];
        let material = |reflectance: f32, reflectance_texture| Material {
            reflectance: Vec3::splat(reflectance),
            reflectance_texture,
            ..Default::default()
        };
        let mut materials = [material(1.0, None), material(0.5, None), material(1.5, Some(0))];
        let mut warnings = Vec::new();
        limit_reflectances(&mut materials, &mut texture, 2.0, &mut warnings);
        assert_eq!(materials.each_ref().map(|material| material.reflectance.x), [0.999, 0.5, 1.0]);
        let sample = |u: f32| texture[0].sample(glam::Vec2::new(u, 0.5)).x;
        assert!((sample(0.25) - 0.999).abs() < 1e-6);
        assert!((sample(0.75) - 0.503).abs() < 1e-3); // IEC 61966-2-1: 188 is 0.503 linear
        assert_eq!(warnings, ["clamped the reflectance of 2 materials to 0.999 (option --reflectance-limit)"]);
    }
}
