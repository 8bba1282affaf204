//! The weights of the screen-space filter, against their closed form.
#![cfg(feature = "gpu")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/compute.rs"]
mod compute;

use compute::computed;
use glam::{Vec2, Vec3};
use radiosity::gpu::{
    device,
    screen_space::{
        filter::FILTER_WGSL,
        uniforms::{SCREEN_WGSL, ScreenUniforms},
    },
};
use wgpu::util::DeviceExt as _;

const COLUMNS: usize = 41;
const RADIUS: i32 = 9;

/// A surface as `pack_surface` in screen.wgsl: depth 1 or 2, and a normal that faces the camera or the right.
fn surface(depth: u32, faces_right: bool) -> u32 {
    let depth_word = if depth == 1 { 0x6000 } else { 0x6800 };
    // On the octahedron, (0, 0, -1) is (1, 1), and (1, 0, 0) is (1, 0).
    let normal = if faces_right { 0x007f } else { 0x7f7f };
    depth_word << 16 | normal
}

/// The exponent of 1 and its mantissa, 128 / 255 of 2.
const ONE: u32 = 128 << 24 | 0x0080_8080;
const NONE: u32 = 1 << 24;

/// A row of pixels filtered along itself.
fn filtered(row: &[[u32; 2]; COLUMNS], every: u32) -> Option<Vec<f64>> {
    let (device, queue) = device::headless().map_err(|reason| println!("skipped: {reason}")).ok()?;
    let uniforms = ScreenUniforms {
        size: [COLUMNS as u32, 1],
        layers: 1,
        // Depth 1 in a picture 0.04 wide: all of a plane that faces the camera.
        ray_origin: Vec2::new(-0.02, 0.0),
        ray_step: Vec2::new(0.001, 0.001),
        filter_radius: RADIUS as f32,
        filter_depth: 0.05,
        every,
        end: COLUMNS as u32,
        eye: Vec3::ZERO,
        ..ScreenUniforms::default()
    };
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let uniforms = buffer(bytemuck::bytes_of(&uniforms), wgpu::BufferUsages::UNIFORM);
    // What lies off the grid is not to be read.
    let mut on_grid = *row;
    on_grid.iter_mut().enumerate().filter(|(column, _)| !(*column as u32).is_multiple_of(every)).for_each(
        |(_, words)| {
            words[1] = 0xffff_ffff;
        },
    );
    let [surfaces, light] = [row.map(|words| words[0]), on_grid.map(|words| words[1])]
        .map(|words| buffer(bytemuck::cast_slice(&words), wgpu::BufferUsages::STORAGE));
    let target = buffer(&[0; 16 * COLUMNS], wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    // The pass down, turned to run along the row: it is the one that leaves numbers.
    let down = "vec2u(0u, 1u), screen.size.x)";
    assert!(FILTER_WGSL.contains(down));
    let along = FILTER_WGSL.replace(down, "vec2u(1u, 0u), 1u)");
    let source = (format!("{SCREEN_WGSL}{along}"), "down");
    let buffers = [(0, &uniforms), (1, &surfaces), (2, &light), (4, &target)];
    let values: Vec<[f32; 4]> = computed((&device, &queue), source, &buffers, &target, 1);
    Some(values.iter().map(|value| f64::from(value[0])).collect())
}

#[test]
fn one_bright_pixel_of_a_plane_becomes_a_gaussian_whose_radius_is_three_deviations() {
    let middle = COLUMNS / 2;
    let mut row = [[surface(1, false), NONE]; COLUMNS];
    row[middle][1] = ONE;
    let Some(found) = filtered(&row, 1) else { return };
    let gaussian = |offset: i32| (-0.5 * (3.0 * f64::from(offset) / f64::from(RADIUS)).powi(2)).exp();
    let sum: f64 = (-RADIUS..=RADIUS).map(gaussian).sum();
    for (column, value) in (0..).zip(&found) {
        let offset = column - middle as i32;
        let expected = if offset.abs() <= RADIUS { 2.0 * 128.0 / 255.0 * gaussian(offset) / sum } else { 0.0 };
        assert!((value - expected).abs() < 1e-5, "{value} instead of {expected} at {offset}");
    }
}

#[test]
fn nothing_crosses_an_edge_of_depth_or_of_direction_on_a_grid_of_any_step() {
    for (there, name) in [(surface(2, false), "depth"), (surface(1, true), "direction"), (0, "nothing behind")] {
        let bright = |column: usize| if column < 20 { [surface(1, false), ONE] } else { [there, NONE] };
        for every in 1..=4 {
            let Some(found) = filtered(&std::array::from_fn(bright), every) else { return };
            for (column, value) in found.iter().enumerate() {
                let expected = if column < 20 { 2.0 * 128.0 / 255.0 } else { 0.0 };
                let place = format!("column {column} of a grid of every {every}");
                assert!((value - expected).abs() < 1e-5, "{name}: {value} instead of {expected} in {place}");
            }
        }
    }
}
