//! Points rebuilt from depth by the shaders' own function, against rays.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/compute.rs"]
mod compute;
mod screen_stage;

use std::sync::Arc;

use compute::computed;
use glam::{Vec2, Vec3, Vec4};
use radiosity::{
    gpu::{
        device,
        screen_space::{
            ScreenSettings,
            uniforms::{SCREEN_WGSL, ScreenUniforms},
        },
    },
    render::visible_points,
    scene::{LoadOptions, builtin, camera::CameraState},
    trace::Tracer,
};
use screen_stage::{ScreenStage, plain};
use wgpu::util::DeviceExt as _;

const REBUILD: &str = "
@group(0) @binding(1) var<storage, read_write> rebuilt: array<vec4f>;
@compute @workgroup_size(64)
fn rebuild(@builtin(global_invocation_id) id: vec3u) {
    if id.x < screen.end {
        let place = vec2f(place_in_rows(id.x, screen.size.x));
        rebuilt[id.x] = vec4f(screen.eye + in_space(position_at(place, rebuilt[id.x].x)), 0.0);
    }
}";

/// The points of a picture whose depth texture stores these values.
fn rebuilt(uniforms: &ScreenUniforms, stored: &[f32]) -> Vec<Vec3> {
    let (device, queue) = device::headless().unwrap();
    let values: Vec<Vec4> = stored.iter().map(|value| Vec4::splat(*value)).collect();
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let [uniforms, points] = [
        buffer(bytemuck::bytes_of(uniforms), wgpu::BufferUsages::UNIFORM),
        buffer(bytemuck::cast_slice(&values), usage),
    ];
    let source = (format!("{SCREEN_WGSL}{REBUILD}"), "rebuild");
    let workgroups = (stored.len() as u32).div_ceil(64);
    let found = computed::<Vec4>((&device, &queue), source, &[(0, &uniforms), (1, &points)], &points, workgroups);
    found.into_iter().map(Vec4::truncate).collect()
}

#[test]
fn shaders_rebuild_the_points_that_rays_meet_to_a_ten_thousandth_of_their_depth() {
    let size = [160, 120];
    let Some(mut stage) = ScreenStage::cornell(size) else { return };
    let depths = stage.drawn(&plain()).depth;
    let camera = stage.view.camera;
    let uniforms = ScreenUniforms { end: depths.len() as u32, ..ScreenUniforms::new(&camera, size, &plain(), 0, 1.0) };
    let stored: Vec<f32> = depths.iter().map(|depth| uniforms.near / depth).collect();
    let tracer = Tracer::new(Arc::clone(&stage.scene));
    let hits = visible_points(&tracer, &camera, size);
    let mut elsewhere = 0;
    for (point, hit) in rebuilt(&uniforms, &stored).iter().zip(&hits) {
        let Some(hit) = hit else { continue };
        let met = stage.scene.mesh.position(hit.triangle, hit.barycentric);
        let depth = (met - camera.position).dot(camera.forward);
        // Of nothing, the depth is 0, and the point no number: not there either.
        let is_there = point.distance(met) <= 1e-4 * depth;
        elsewhere += u32::from(!is_there);
    }
    // A pixel whose middle lies on an edge may show either side.
    assert!(elsewhere <= 6, "{elsewhere} of {} pixels show another point", hits.len());
}

/// The borders of the two pictures at depth 1, which lie half a pixel beyond the middle of the first one and of the last.
#[test]
fn the_picture_around_is_as_many_times_as_wide_and_high_as_it_is_asked_to_be() {
    let size = [160, 120];
    let scene = builtin::cornell(&LoadOptions::default()).unwrap();
    let camera = CameraState { fov_degrees: 50.0, ..CameraState::default() }.to_local(&scene.frame);
    for surround in [1.5, 3.0, 5.0] {
        let uniforms = ScreenUniforms::new(&camera, size, &ScreenSettings { surround, ..plain() }, 0, 1.0);
        let borders = |origin: Vec2, step: Vec2, size: [u32; 2]| {
            [origin - 0.5 * step, origin + (Vec2::new(size[0] as f32, size[1] as f32) - 0.5) * step]
        };
        let picture = borders(uniforms.ray_origin, uniforms.ray_step, uniforms.size);
        let around = borders(uniforms.surround_origin, uniforms.surround_step, uniforms.surround_size);
        for (inner, outer) in picture.into_iter().zip(around) {
            assert!(outer.abs_diff_eq(surround * inner, 1e-4), "{outer} is not {surround} times {inner}");
        }
        // A field of view of 50 degrees.
        assert!((picture[0].y - 25_f32.to_radians().tan()).abs() < 1e-5, "{}", picture[0]);
    }
}
