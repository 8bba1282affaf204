//! Solution files: what goes in comes out, and nothing that is damaged does harm.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::collections::HashMap;

use glam::Vec3;
use proptest::{prelude::*, sample::Index, test_runner::RngSeed};
use radiosity::{
    scene::{LoadOptions, LocalFrame, Material, Mesh, Scene, area_light::AreaLightState},
    solver::{
        Solution, SolutionInfo, SolveSettings,
        solution_file::{SolutionFileError, check_scene, check_tessellation, decode, encode},
    },
};
use safetensors::{Dtype, tensor::TensorView};

fn info() -> SolutionInfo {
    SolutionInfo {
        scene_name: String::from("box"),
        scene_hash: "a".repeat(64),
        tessellation_hash: "b".repeat(64),
        load: LoadOptions { weld: Some(1e-7), two_sided: true, ..LoadOptions::default() },
        settings: SolveSettings { max_edge: Some(0.1 + 0.2), seed: u64::MAX, ..SolveSettings::even() },
        light: Some(AreaLightState { centre: [1.0 / 3.0, 1e-300, 5e17], ..AreaLightState::default() }),
        program_version: String::from("0.1.0"),
        complete: false,
    }
}

/// Two bounces at five vertices, with the awkward floats.
fn solution() -> Solution {
    let value = |bounce: usize, vertex: usize| Vec3::new(0.1 * vertex as f32, bounce as f32 / 3.0, f32::MIN_POSITIVE);
    let bounces = (0..2).map(|bounce| (0..5).map(|vertex| value(bounce, vertex)).collect()).collect();
    Solution { info: info(), bounces, buried: vec![false, true, false, false, true], cuts: Vec::new() }
}

/// A file with chosen arrays and the metadata of a good one but for its version.
fn file_of(version: u32, arrays: &[(&str, Dtype, Vec<usize>, Vec<u8>)]) -> Vec<u8> {
    let header = format!("{{\"version\":{version},\"info\":{}}}", serde_json::to_string(&info()).unwrap());
    let metadata = HashMap::from([(String::from("radiosity-solution"), header)]);
    let views =
        arrays.iter().map(|(name, dtype, shape, data)| (*name, TensorView::new(*dtype, shape.clone(), data).unwrap()));
    safetensors::serialize(views, Some(metadata)).unwrap()
}

/// The one line an error prints.
fn line_of(bytes: &[u8]) -> String {
    let line = decode(bytes).unwrap_err().to_string();
    assert_eq!(line.lines().count(), 1, "{line}");
    line
}

#[test]
fn a_solution_comes_back_with_the_same_bits() {
    let before = solution();
    let bytes = encode(&before).unwrap();
    let after = decode(&bytes).unwrap();
    assert_eq!(after, before); // includes the metadata, down to f64 light positions
    let bits = |solution: &Solution| -> Vec<[u32; 3]> {
        solution.bounces.iter().flatten().map(|value| value.to_array().map(f32::to_bits)).collect()
    };
    assert_eq!(bits(&after), bits(&before));
    assert_eq!(encode(&after).unwrap(), bytes, "the same solution gives the same file");
}

#[test]
fn a_file_cut_short_or_lengthened_anywhere_is_refused_in_one_line() {
    let mut bytes = encode(&solution()).unwrap();
    for length in 0..bytes.len() {
        line_of(&bytes[..length]);
    }
    bytes.push(0);
    line_of(&bytes);
}

#[test]
fn values_that_cannot_be_irradiance_are_refused_on_both_ways() {
    for bad in [f32::NAN, f32::INFINITY, -1e-3] {
        let mut solution = solution();
        let good_bytes = encode(&solution).unwrap();
        solution.bounces[1][3].y = bad;
        assert!(encode(&solution).unwrap_err().to_string().contains("bounce 1, vertex 3"));
        // Irradiance comes first in the data: bounce 1, vertex 3, green is number (1·5 + 3)·3 + 1.
        let mut bytes = good_bytes.clone();
        let data_start = 8 + u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        let place = data_start + 4 * ((5 + 3) * 3 + 1);
        bytes[place..place + 4].copy_from_slice(&bad.to_le_bytes());
        assert!(line_of(&bytes).contains("bounce 1, vertex 3"));
    }
}

#[test]
fn settings_that_no_solve_accepts_are_refused() {
    let mut solution = solution();
    solution.info.settings.subdivide = 4_000_000_000; // would cut the scene into more elements than memory holds
    assert!(encode(&solution).is_err());
    solution.info.settings.subdivide = 12;
    let mut bytes = encode(&solution).unwrap();
    let key = br#"subdivide\":12"#; // JSON inside a JSON string
    let place = bytes.windows(key.len()).position(|window| window == key).unwrap() + key.len() - 2;
    bytes[place..place + 2].copy_from_slice(b"99");
    assert!(line_of(&bytes).contains("damaged"));
}

#[test]
fn wrong_shapes_types_and_flags_are_refused() {
    let zeros = |count: usize| vec![0_u8; count];
    let buried = ("buried", Dtype::U8, vec![2], zeros(2));
    let good = ("irradiance", Dtype::F32, vec![1, 2, 3], zeros(24));
    assert!(decode(&file_of(1, &[good.clone(), buried.clone()])).is_ok());
    let bad_pairs = [
        vec![good.clone()],
        vec![buried.clone()],
        vec![("irradiance", Dtype::F32, vec![1, 2, 4], zeros(32)), buried.clone()],
        vec![("irradiance", Dtype::F32, vec![2, 3], zeros(24)), buried.clone()],
        vec![("irradiance", Dtype::F64, vec![1, 2, 3], zeros(48)), buried.clone()],
        vec![("irradiance", Dtype::F32, vec![0, 2, 3], zeros(0)), buried.clone()],
        // Takes no bytes and claims 2^60 bounces.
        vec![("irradiance", Dtype::F32, vec![1 << 60, 0, 3], zeros(0)), ("buried", Dtype::U8, vec![0], zeros(0))],
        vec![good.clone(), ("buried", Dtype::U8, vec![3], zeros(3))],
        vec![good.clone(), ("buried", Dtype::U8, vec![2], vec![0, 2])],
    ];
    for arrays in &bad_pairs {
        line_of(&file_of(1, arrays));
    }
}

#[test]
fn a_newer_format_is_refused_by_its_version() {
    let arrays = [("irradiance", Dtype::F32, vec![1, 1, 3], vec![0; 12]), ("buried", Dtype::U8, vec![1], vec![0])];
    assert!(matches!(decode(&file_of(7, &arrays)), Err(SolutionFileError::NewerVersion { found: 7 })));
}

#[test]
fn a_solution_of_another_scene_or_tessellation_is_refused_by_a_line_that_names_both() {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        triangles: vec![[0, 1, 2]],
        texcoords: Vec::new(),
        material_indices: vec![0],
    };
    let scene = Scene {
        name: String::from("triangle"),
        mesh,
        materials: vec![Material::default()],
        textures: Vec::new(),
        frame: LocalFrame::default(),
        enclosed: Vec::new(),
        two_sided: false,
        faceted: false,
        warnings: Vec::new(),
    };
    let info = info();
    let line = check_scene(&info, &scene).unwrap_err().to_string();
    assert!(line.contains("box (aaaaaaaaaaaa)") && line.contains("triangle") && line.contains(&scene.hash()[..12]));
    assert!(check_scene(&SolutionInfo { scene_hash: scene.hash(), ..info.clone() }, &scene).is_ok());
    let line = check_tessellation(&info, "cccccccccccccccc").unwrap_err().to_string();
    assert!(line.contains("bbbbbbbbbbbb,") && line.contains("cccccccccccc;"), "{line}");
    assert!(check_tessellation(&info, &info.tessellation_hash).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn flipped_bits_give_an_error_or_a_solution_that_can_be_written(
        flips in prop::collection::vec(any::<Index>(), 1..6),
    ) {
        let mut bytes = encode(&solution()).unwrap();
        for flip in flips {
            let bit = flip.index(8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        if let Ok(decoded) = decode(&bytes) {
            prop_assert!(encode(&decoded).is_ok());
        }
    }

    #[test]
    fn arbitrary_bytes_are_refused(header in prop::collection::vec(any::<u8>(), 0..200), claimed in any::<u64>()) {
        let mut bytes = claimed.to_le_bytes().to_vec();
        bytes.extend(header);
        prop_assert!(decode(&bytes).is_err());
    }
}
