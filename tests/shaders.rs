//! Every shader is valid, and every struct shared with a shader has the same fields at the same places on both sides.
#![cfg(feature = "gpu")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::{mem::offset_of, path::Path};

use radiosity::gpu::{
    frame::{FRAME_WGSL, FrameUniforms},
    lightmap::{
        cutouts::Mask,
        pages::PageSettings,
        patches::{BatchSettings, ChartGroups, Face, Group, LedgerSums, PowerSums, Receiver, Shooter},
        shaders::{ON_FACE_WGSL, PATCHES_WGSL, VISIBILITY_WGSL},
    },
    map_picture::PictureUniforms,
    mesh_view::MaterialUniforms,
    screen_space::{
        g_buffer::LayerUniforms,
        gather::{BounceUniforms, GATHER_WGSL},
        lamps::{Lamp, light_source},
        show::ShowUniforms,
        uniforms::{SCREEN_WGSL, ScreenUniforms},
    },
    variant::SHADING_WGSL,
};
use radiosity::lightmap::dilate::Fill;
use wgpu::naga::{Module, TypeInner, front::wgsl, valid};

/// A shader as its pass loads it: most begin with what they share with others.
fn source(file: &str) -> String {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu").join(file)).unwrap();
    let beside = |name: &str| std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu").join(name));
    match file {
        "mesh_view.wgsl" => format!("{FRAME_WGSL}{SHADING_WGSL}{text}{}", beside("vertex_field.wgsl").unwrap()),
        "vertex_field.wgsl" | "map_field.wgsl" => {
            format!("{FRAME_WGSL}{SHADING_WGSL}{}{text}", beside("mesh_view.wgsl").unwrap())
        }
        "visibility.wgsl" => format!("{}{text}", source("vertex_field.wgsl")),
        "resolve.wgsl" => format!("{FRAME_WGSL}{SHADING_WGSL}{text}"),
        "map_picture.wgsl" | "blit.wgsl" | "frame.wgsl" | "lightmap/patches.wgsl" | "lightmap/on_face.wgsl" => text,
        "lightmap/hemicube.wgsl"
        | "lightmap/hemisphere.wgsl"
        | "lightmap/cutouts.wgsl"
        | "lightmap/item_buffer.wgsl" => {
            format!("{ON_FACE_WGSL}{text}")
        }
        "screen_space/g_buffer.wgsl" => {
            format!("{}{text}", source("vertex_field.wgsl"))
        }
        "screen_space/screen.wgsl" => text,
        "screen_space/light.wgsl" => light_source(),
        "screen_space/gather.wgsl"
        | "screen_space/line.wgsl"
        | "screen_space/slices.wgsl"
        | "screen_space/kept.wgsl"
        | "screen_space/spiral.wgsl" => {
            format!("{SCREEN_WGSL}{GATHER_WGSL}")
        }
        _ if file.starts_with("screen_space/") => format!("{SCREEN_WGSL}{text}"),
        "lightmap/see_by_item.wgsl" => format!("{PATCHES_WGSL}{VISIBILITY_WGSL}{text}"),
        "lightmap/receive.wgsl" | "lightmap/visibility.wgsl" | "lightmap/see_by_depth.wgsl" => {
            let [seen, receive] =
                ["see_by_depth", "receive"].map(|name| beside(&format!("lightmap/{name}.wgsl")).unwrap());
            format!("{PATCHES_WGSL}{VISIBILITY_WGSL}{seen}{receive}")
        }
        _ if file.starts_with("lightmap/") => format!("{PATCHES_WGSL}{text}"),
        _ => format!("{FRAME_WGSL}{text}"),
    }
}

fn shaders_in(folder: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu").join(folder);
    let names = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(".wgsl")).map(|name| format!("{folder}{name}")).collect()
}

fn parsed(file: &str) -> Module {
    let source = source(file);
    wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{file}: {}", error.emit_to_string(&source)))
}

#[test]
fn every_shader_is_valid() {
    let shaders = [shaders_in(""), shaders_in("lightmap/"), shaders_in("screen_space/")];
    assert!(shaders[0].len() >= 5 && shaders[1].len() >= 6 && shaders[2].len() >= 7, "only {shaders:?}");
    for file in shaders.concat() {
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
    let picture = rust_layout!(PictureUniforms: place, exposure_scale, inverse_gamma, page, mode, outlines,
        codes_itself, part);
    assert_eq!(wgsl_layout("map_picture.wgsl", "PictureUniforms"), picture);
    let material = rust_layout!(MaterialUniforms: reflectance, opacity, emitted_radiance, largest_texel);
    assert_eq!(wgsl_layout("mesh_view.wgsl", "MaterialUniforms"), material);
}

#[test]
fn what_the_lightmap_passes_share_has_the_same_layout_in_rust_and_in_the_shaders() {
    let patches = |name| wgsl_layout("lightmap/patches.wgsl", name);
    assert_eq!(
        patches("Settings"),
        rust_layout!(BatchSettings: receiver_count, group_count, slot_count, resolution, tiles_per_row, near, bias,
            filtered, first_slot, end_slot, first_receiver, end_receiver, shooter_count, attenuation,
            patch_area, spare)
    );
    assert_eq!(
        patches("Receiver"),
        rust_layout!(Receiver: position, area, geometric_normal, triangle, shading_normal, room, reflectance,
            spare_again)
    );
    assert_eq!(
        patches("Group"),
        rust_layout!(Group: centre, area, origin, first, normal, count, half_u, chart, half_v, most_power,
            tangent, parent)
    );
    assert_eq!(
        patches("Shooter"),
        rust_layout!(Shooter: centre, area, origin, first, normal, count, half_u, spare_three, half_v, spare_four,
            tangent, spare_five, radiosity, spare_six)
    );
    assert_eq!(patches("Face"), rust_layout!(Face: x, y, w));
    let pages = rust_layout!(PageSettings: even, stage, trend, spare, receiver_count, shooter_count,
        largest_area, spare_too);
    assert_eq!(wgsl_layout("lightmap/pages.wgsl", "PageSettings"), pages);
    let fill = rust_layout!(Fill: pixel, neighbours);
    assert_eq!(wgsl_layout("lightmap/pages.wgsl", "Fill"), fill);
    let charts = rust_layout!(ChartGroups: first, count, area, spare);
    assert_eq!(wgsl_layout("lightmap/choose.wgsl", "ChartGroups"), charts);
    let mask = rust_layout!(Mask: first, width, height, filtered, opacity);
    assert_eq!(wgsl_layout("lightmap/cutouts.wgsl", "Mask"), mask);
    let sums = rust_layout!(PowerSums: arrived, spare, reflected, spare_too, unshot, spare_three);
    assert_eq!(patches("PowerSums"), sums);
    assert_eq!(
        wgsl_layout("lightmap/ledger.wgsl", "Ledger"),
        rust_layout!(LedgerSums: arrived, shooters, reflected, spare, escaped, spare_too, on_backs, spare_three, unshot,
            spare_four)
    );
}

#[test]
fn what_the_screen_space_passes_share_has_the_same_layout_in_rust_and_in_the_shaders() {
    let screen = rust_layout!(ScreenUniforms: size, layers, still, ray_origin, ray_step, right, near, up, pixel_area, forward,
        taps, eye, radius, filter_radius, filter_depth, obscurance_radius, obscurance_taps, obscurance_strength,
        obscurance_slope, unseen, keeps, first, end, every, thickness, surround_origin, surround_step,
        surround_size, surround, spare, grid, spare_too);
    assert_eq!(wgsl_layout("screen_space/screen.wgsl", "Screen"), screen);
    let layer =
        rust_layout!(LayerUniforms: reference, right, near, up, separation, forward, spare, ray_origin, ray_step);
    assert_eq!(wgsl_layout("screen_space/g_buffer.wgsl", "Layer"), layer);
    let lamp = rust_layout!(Lamp: corners, origin, least_height, normal, pieces, tangent, area, radiosity, spare);
    assert_eq!(wgsl_layout("screen_space/light.wgsl", "Lamp"), lamp);
    let bounce = rust_layout!(BounceUniforms: is_first, is_last, feeds_last, is_fed);
    assert_eq!(wgsl_layout("screen_space/gather.wgsl", "Bounce"), bounce);
    let show = rust_layout!(ShowUniforms: buffer, layer, nearest, farthest);
    assert_eq!(wgsl_layout("screen_space/show.wgsl", "Show"), show);
}
