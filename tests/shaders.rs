//! Every shader is valid, and every struct shared with a shader has the same fields at the same places on both sides.
#![cfg(feature = "gpu")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{mem::offset_of, path::Path};

use radiosity::gpu::{
    frame::{FRAME_WGSL, FrameUniforms},
    mesh_view::MaterialUniforms,
};
use wgpu::naga::{Module, TypeInner, front::wgsl, valid};

/// A shader as its pass loads it: all but the blit begin with `frame.wgsl`.
fn source(file: &str) -> String {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu").join(file)).unwrap();
    if ["blit.wgsl", "frame.wgsl"].contains(&file) { text } else { format!("{FRAME_WGSL}{text}") }
}

fn parsed(file: &str) -> Module {
    let source = source(file);
    wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{file}: {}", error.emit_to_string(&source)))
}

#[test]
fn every_shader_is_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu");
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let shaders: Vec<String> = names.filter(|name| name.ends_with(".wgsl")).collect();
    assert!(shaders.len() >= 5, "only {shaders:?}");
    for file in shaders {
        let module = parsed(&file);
        // No more than WebGPU's core: what every browser and card has.
        let mut validator = valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|error| panic!("{file}: {error:?}"));
    }
}

/// Names and offsets of a struct's fields, and its size, in WGSL.
fn wgsl_layout(file: &str, name: &str) -> (Vec<(String, usize)>, usize) {
    let module = parsed(file);
    let (_, found) = module.types.iter().find(|(_, kind)| kind.name.as_deref() == Some(name)).unwrap();
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
    let fields = members.iter().map(|member| (member.name.clone().unwrap(), member.offset as usize));
    (fields.collect(), *span as usize)
}

macro_rules! rust_layout {
    ($name:ident: $($field:ident),*) => {
        (vec![$((String::from(stringify!($field)), offset_of!($name, $field))),*], size_of::<$name>())
    };
}

#[test]
fn uniforms_have_the_same_layout_in_rust_and_in_the_shader() {
    let frame = rust_layout!(FrameUniforms: view_projection, eye, outline_width, typical_edge, pixel_size,
        exposure_scale, inverse_gamma, ambient, range, light_centre, light_u, light_v, light_color, outline_color,
        false_colors);
    assert_eq!(wgsl_layout("frame.wgsl", "FrameUniforms"), frame);
    let material = rust_layout!(MaterialUniforms: reflectance, opacity, emitted_radiance, largest_texel);
    assert_eq!(wgsl_layout("mesh_view.wgsl", "MaterialUniforms"), material);
}
