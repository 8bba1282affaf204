//! Pictures of what a shooter sees, against colours that follow from what is put in.
#![cfg(all(feature = "gpu", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;
mod gpu_stage;

use gpu_stage::{PLAIN, Stage};
use radiosity::gpu::map_picture::{MapPicture, MapPictureFrame, Pictured};

/// A texture of one row that holds these words.
fn row_of(stage: &Stage, format: wgpu::TextureFormat, words: &[u32]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width: words.len() as u32, height: 1, depth_or_array_layers: 1 };
    let texture = stage.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size.width), rows_per_image: None };
    stage.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(words), layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The first row of the picture, 64 pixels wide, as red, green and blue.
fn drawn(stage: &Stage, pictured: Pictured) -> Vec<[u8; 3]> {
    const SIZE: wgpu::Extent3d = wgpu::Extent3d { width: 64, height: 2, depth_or_array_layers: 1 };
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let mut picture = MapPicture::new(&stage.device, format);
    let frame = MapPictureFrame { pictured, tone_map: PLAIN, origin: [0; 2], size: [SIZE.width, SIZE.height] };
    picture.prepare(&stage.device, &stage.queue, &frame);
    let target = stage.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: SIZE,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let copy = stage.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 512,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = stage.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let attachment = wgpu::RenderPassColorAttachment {
        view: &view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
    };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(attachment)],
        ..wgpu::RenderPassDescriptor::default()
    });
    picture.record(&mut pass);
    drop(pass);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(256), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &copy, layout };
    encoder.copy_texture_to_buffer(target.as_image_copy(), to, SIZE);
    stage.queue.submit([encoder.finish()]);
    copy.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    stage.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = copy.slice(..).get_mapped_range().unwrap();
    bytes.as_chunks::<4>().0[..64].iter().map(|[red, green, blue, _]| [*red, *green, *blue]).collect()
}

fn assert_near(found: [u8; 3], expected: [f32; 3]) {
    let apart = |(found, expected): (u8, f32)| (f32::from(found) - 255.0 * expected).abs();
    assert!(found.into_iter().zip(expected).map(apart).all(|apart| apart <= 1.0), "{found:?} for {expected:?}");
}

/// What nothing was drawn on.
const NOTHING: [f32; 3] = [0.1, 0.1, 0.25];

#[test]
fn items_have_a_colour_each_and_only_the_part_that_is_asked_for_is_shown() {
    let stage = Stage::new().unwrap();
    // Four items are there; the picture shows the first two, half of it each.
    let items = row_of(&stage, wgpu::TextureFormat::R32Uint, &[0, 7, 7, 9]);
    let pixels = drawn(&stage, Pictured::Items(items, [2, 1]));
    pixels[..32].iter().for_each(|&pixel| assert_near(pixel, NOTHING));
    assert!(pixels[32..].iter().all(|pixel| *pixel == pixels[32]) && pixels[32].iter().all(|&band| band >= 50));
    let items = row_of(&stage, wgpu::TextureFormat::R32Uint, &[7, 8, 7, 9]);
    let all = drawn(&stage, Pictured::Items(items, [4, 1]));
    assert_eq!(all[0], pixels[32], "an item keeps its colour");
    assert_eq!(all[0], all[40]);
    assert!(all[0] != all[20] && all[20] != all[60] && all[0] != all[60], "{all:?}");
}

#[test]
fn depth_is_grey_that_halves_where_it_is_sixteen_times_as_far() {
    let stage = Stage::new().unwrap();
    // White at 0.02 from the shooter, an eighth darker with each doubling; depth is stored as 1e-4 over the distance.
    let stored = [0.02_f32, 0.32, 5.12, f32::INFINITY].map(|distance| (1e-4 / distance).to_bits());
    let depth = row_of(&stage, wgpu::TextureFormat::R32Float, &stored);
    let pixels = drawn(&stage, Pictured::Hemicubes(depth, [4, 1]));
    for (quarter, expected) in [[1.0; 3], [0.5; 3], [0.05; 3], NOTHING].into_iter().enumerate() {
        pixels[16 * quarter..16 * (quarter + 1)].iter().for_each(|&pixel| assert_near(pixel, expected));
    }
}
