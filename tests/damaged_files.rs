//! Damaged scene files: one clear line, or a scene without the damage; never a panic, never NaN.

#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use radiosity::scene::{LoadOptions, Scene, SceneError, load};
use tempfile::TempDir;

/// A square with a material and texture coordinates.
const OBJ: &str = "# square\nmtllib square.mtl\no square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
    vn 0 0 1\nusemtl red\ns 1\nf 1/1/1 2/2/1 3/3/1 4/1/1\ng rest\nf -4//1 -3//1 -2//1\nl 1 2\n";
const MTL: &str = "newmtl red\nKd 0.8 0.2 0.1\nKe 1 0 0\nd 1\nmap_Kd -s 1 1 red.png\nKs 0 0 0\n";

/// A folder with `scene.obj` and other files.
fn folder(obj: &[u8], others: &[(&str, &[u8])]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in others {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("scene.obj");
    std::fs::write(&path, obj).unwrap();
    (folder, path)
}

fn load_bytes(obj: &[u8], others: &[(&str, &[u8])]) -> Result<Scene, SceneError> {
    let (_folder, path) = folder(obj, others);
    load::load(&path, &LoadOptions::default())
}

fn assert_sound(scene: &Scene) {
    let mesh = &scene.mesh;
    let count = mesh.positions.len();
    assert!(!mesh.triangles.is_empty() && mesh.normals.len() == count);
    assert!(mesh.positions.iter().all(|position| position.abs().max_element() <= 1.0));
    assert!(mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
    assert!(mesh.triangles.iter().flatten().all(|&vertex| (vertex as usize) < count));
    assert!((0..mesh.triangles.len() as u32).all(|triangle| mesh.area(triangle) > 0.0));
    assert!(mesh.texcoords.is_empty() || mesh.texcoords.len() == mesh.triangles.len());
    assert!(mesh.texcoords.iter().flatten().all(|texcoord| texcoord.is_finite()));
    assert_eq!(mesh.material_indices.len(), mesh.triangles.len());
    for material in &scene.materials {
        assert!(material.reflectance.min_element() >= 0.0 && material.reflectance.max_element() <= 0.95);
        assert!(material.emitted_radiance.is_finite() && material.emitted_radiance.min_element() >= 0.0);
        assert!((0.0..=1.0).contains(&material.opacity));
    }
    assert!(scene.warnings.iter().all(|warning| warning.lines().count() == 1), "{:?}", scene.warnings);
}

#[test]
fn files_that_are_no_scene_are_refused_in_one_line_that_says_why() {
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain(OBJ.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let noise: Vec<u8> = (0..5000_u32).map(|index| (index.wrapping_mul(2_654_435_761) >> 24) as u8 | 1).collect();
    let zeros = [OBJ.as_bytes(), &[0; 100]].concat();
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let with_vertices = |rest: &str| format!("{vertices}{rest}").into_bytes();
    let cases: [(&str, Vec<u8>, &str); 13] = [
        ("empty", Vec::new(), "the file is empty"),
        ("UTF-16", utf16, "UTF-16"),
        ("binary", zeros, "binary, not text"),
        ("noise", noise, "no usable face"),
        ("text", b"Dear reader,\nthis is a letter.\n".to_vec(), "no usable face"),
        ("no faces", vertices.into(), "no usable face was found (ignored 3 vertices"),
        ("index too high", with_vertices("f 1 2 4\n"), "out of range, in line 4"),
        ("index 0", with_vertices("f 0 1 2\n"), "an index that is 0, unreadable or out of range, in line 4"),
        ("index huge", with_vertices("f 1 2 99999999999999999999\n"), "out of range, in line 4"),
        ("NaN", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), "not finite or beyond 1e18, in line 4"),
        ("huge", b"v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), "not finite or beyond 1e18, in line 4"),
        ("commas", b"v 0,0 0,0 0,0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), "the numbers of 1 line, in line 1"),
        ("a point", b"v 1 1 1\nf 1 1 1\n".to_vec(), "dropped 1 triangle without area"),
    ];
    for (name, bytes, expected) in cases {
        let message = load_bytes(&bytes, &[]).unwrap_err().to_string();
        assert!(message.contains(expected) && message.contains("scene.obj"), "{name}: {message}");
        assert_eq!(message.lines().count(), 1, "{name}: {message}");
    }
}

#[test]
fn a_missing_file_and_a_folder_are_refused() {
    let (folder, _) = folder(b"", &[]);
    for (path, expected) in
        [(folder.path().join("absent.obj"), "cannot be read"), (folder.path().into(), "is a folder")]
    {
        let message = load::load(&path, &LoadOptions::default()).unwrap_err().to_string();
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
}

#[test]
fn a_vanishing_scene_is_refused() {
    let message = load_bytes(b"v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n", &[]).unwrap_err().to_string();
    assert!(message.contains("only 1e-30 m wide"), "{message}");
}

#[test]
fn options_out_of_range_are_refused() {
    for (options, expected) in [
        (LoadOptions { weld: Some(f32::NAN), ..Default::default() }, "weld distance NaN"),
        (LoadOptions { crease_angle: Some(-1.0), ..Default::default() }, "crease angle -1"),
        (LoadOptions { reflectance_limit: f32::NAN, ..Default::default() }, "reflectance limit NaN"),
    ] {
        let message = load::load_from_memory("square", OBJ, MTL, &options).unwrap_err().to_string();
        assert!(message.starts_with("square: ") && message.contains(expected), "{message}");
    }
}

#[test]
fn a_file_cut_in_the_middle_of_a_line_keeps_its_whole_faces() {
    let end = OBJ.find("f -4").unwrap() + "f -4//1 -3".len();
    let scene = load_bytes(&OBJ.as_bytes()[..end], &[("square.mtl", MTL.as_bytes())]).unwrap();
    assert_sound(&scene);
    assert_eq!(scene.mesh.triangles.len(), 2);
    assert_eq!(scene.warnings[0], "dropped 1 face with fewer than 3 corners, in line 16");
}

#[test]
fn bytes_that_are_not_utf8_do_no_harm() {
    let obj = b"# caf\xe9\nmtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gr\xfcn\nf 1 2 3\n";
    let scene = load_bytes(obj, &[("m.mtl", b"# \xff\nnewmtl gr\xfcn\nKd 0 1 0\n")]).unwrap();
    assert_sound(&scene);
    assert_eq!(scene.materials[0].reflectance, glam::Vec3::Y * 0.95);
}

#[test]
fn material_files_of_no_use_leave_a_grey_scene_and_a_warning() {
    for (bytes, expected) in [
        (&b"\0\x01\x02newmtl red"[..], "the material file \"square.mtl\" is of no use: the file is binary"),
        (b"", "the material file \"square.mtl\" is of no use: the file is empty"),
        (b"newmtl blue\nKd 1 1 1\n", "1 material without an entry in a material file, grey 0.6 instead: red"),
        (b"newmtl red\nKd nan -1 0.25\n", "negative or unusable Kd or Ke values of 1 material as 0"),
        (b"newmtl red\nKd a b c\nKd 0.6 0.6\n", "ignored 2 lines of \"square.mtl\" that cannot be read, first line 2"),
    ] {
        let scene = load_bytes(OBJ.as_bytes(), &[("square.mtl", bytes)]).unwrap();
        assert_sound(&scene);
        let told = scene.warnings.iter().filter(|warning| warning.contains(expected)).count();
        assert_eq!(told, 1, "{expected}: {:?}", scene.warnings);
        let expected_red = if bytes.starts_with(b"newmtl red\nKd nan") { 0.0 } else { 0.6 };
        assert_eq!(scene.materials[0].reflectance.x, expected_red);
    }
}

/// A PNG header that promises 100,000 x 100,000 pixels (chunk checksum included).
const HUGE_PNG: &[u8] = &[
    0x89, b'P', b'N', b'G', 13, 10, 26, 10, 0, 0, 0, 13, b'I', b'H', b'D', b'R', 0, 1, 0x86, 0xa0, 0, 1, 0x86, 0xa0, 8,
    2, 0, 0, 0, 0x9d, 0x8f, 0x4d, 0x5e,
];

#[test]
fn textures_of_no_use_count_as_grey_and_are_told_once() {
    let others = |bytes: &'static [u8]| [("square.mtl", MTL.as_bytes()), ("red.png", bytes)];
    for bytes in [&b"this is no picture"[..], b"", b"\x89PNG\r\n\x1a\n", HUGE_PNG] {
        let scene = load_bytes(OBJ.as_bytes(), &others(bytes)).unwrap();
        assert_sound(&scene);
        let told = scene.warnings.iter().filter(|line| line.contains("the texture \"red.png\" is of no use")).count();
        assert_eq!(told, 1, "{:?}", scene.warnings);
        assert!((scene.materials[0].reflectance.x - 0.8 * 0.6).abs() < 1e-6);
    }
    let scene = load_bytes(OBJ.as_bytes(), &others(b"")[..1]).unwrap();
    assert!(scene.warnings.iter().any(|line| line == "the texture \"red.png\" is missing"), "{:?}", scene.warnings);
}

fn saved(folder: &Path, name: &str, pixel: [u8; 4]) {
    let path = folder.join(name);
    let image = image::RgbaImage::from_pixel(2, 2, image::Rgba(pixel));
    if name.ends_with("jpg") {
        image::DynamicImage::from(image).into_rgb8().save(path).unwrap();
    } else {
        image.save(path).unwrap();
    }
}

#[test]
fn textures_of_every_format_are_read_and_their_holes_found() {
    for (name, pixel, is_hole) in [
        ("a.png", [255, 0, 0, 255], false),
        ("a.png", [255, 0, 0, 10], true),
        ("a.tga", [255, 0, 0, 10], true),
        ("a.bmp", [255, 0, 0, 255], false),
        ("a.jpg", [255, 0, 0, 255], false),
    ] {
        let mtl = format!("newmtl red\nKd 0.5 0.5 0.5\nmap_Kd {}\n", name.to_uppercase());
        let (folder, path) = folder(OBJ.as_bytes(), &[("square.mtl", mtl.as_bytes())]);
        saved(folder.path(), name, pixel);
        let scene = load::load(&path, &LoadOptions::default()).unwrap();
        let reflectance = scene.reflectance(0, glam::Vec2::splat(0.25));
        assert!(reflectance.abs_diff_eq(glam::Vec3::X * 0.5, 5e-3), "{name}: {reflectance}");
        assert_eq!(scene.is_cut_out(0, glam::Vec2::splat(0.25)), is_hole, "{name}");
        assert_eq!(scene.may_be_cut_out(0), is_hole, "{name}");
    }
}

#[test]
fn an_opacity_map_cuts_holes_by_its_grey() {
    let mtl = b"newmtl red\nKd 0.5 0.5 0.5\nmap_d -imfchan l mask.png\n";
    let (folder, path) = folder(OBJ.as_bytes(), &[("square.mtl", mtl)]);
    for (grey, is_hole) in [(20, true), (230, false)] {
        saved(folder.path(), "mask.png", [grey, grey, grey, 255]);
        let scene = load::load(&path, &LoadOptions::default()).unwrap();
        assert_eq!(scene.is_cut_out(0, glam::Vec2::splat(0.25)), is_hole);
    }
}

/// One random change of a text: a byte replaced, a piece removed, or a piece put in.
fn damage(bytes: &mut Vec<u8>, place: usize, length: usize, kind: u8, piece: &[u8]) {
    let start = place % (bytes.len() + 1);
    let end = (start + length).min(bytes.len());
    match kind {
        0 => bytes.truncate(start),
        1 => drop(bytes.drain(start..end)),
        _ => drop(bytes.splice(start..end, piece.iter().copied())),
    }
}

fn piece() -> impl Strategy<Value = Vec<u8>> {
    let words =
        ["nan", "-1e308", "1e17", "0", "-7", "99999999999", "/", "//", "\n", "\\\n", "f ", "v ", "usemtl ", "map_d "];
    prop_oneof![
        prop::sample::select(words.to_vec()).prop_map(|word| word.as_bytes().to_vec()),
        prop::collection::vec(any::<u8>(), 0..4)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, rng_seed: prop::test_runner::RngSeed::Fixed(7), ..Default::default() })]

    #[test]
    fn any_damage_gives_a_sound_scene_or_one_line(
        changes in prop::collection::vec((any::<bool>(), any::<u16>(), 0..20_usize, 0..8_u8, piece()), 1..8),
        two_sided: bool,
        weld in prop::option::of(0.0..0.4_f32),
        crease_angle in prop::option::of(0.0..180.0_f32),
    ) {
        let (mut obj, mut mtl) = (OBJ.as_bytes().to_vec(), MTL.as_bytes().to_vec());
        for (in_obj, place, length, kind, piece) in changes {
            damage(if in_obj { &mut obj } else { &mut mtl }, usize::from(place), length, kind, &piece);
        }
        let options = LoadOptions { two_sided, weld, crease_angle, ..Default::default() };
        let (_folder, path) = folder(&obj, &[("square.mtl", &mtl)]);
        match load::load(&path, &options) {
            Ok(scene) => assert_sound(&scene),
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
        }
    }
}
