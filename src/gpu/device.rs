//! A graphics card without a window, for tests and for baking.

/// A device and its queue, with the limits of WebGPU's core as far as the card has them. A software driver (lavapipe,
/// llvmpipe) is as good as a card. The environment variable `WGPU_BACKEND` (`vulkan`, `gl`, ...) restricts the choice.
///
/// # Errors
/// One line, if there is no driver at all.
pub fn headless() -> Result<(wgpu::Device, wgpu::Queue), String> {
    pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = instance.request_adapter(&options).await.map_err(|error| {
            format!("no graphics driver: {error}; a software driver will do (package mesa-vulkan-drivers)")
        })?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("headless"),
            required_limits: wgpu::Limits::default().or_worse_values_from(&adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        };
        adapter.request_device(&descriptor).await.map_err(|error| format!("the graphics driver failed: {error}"))
    })
}

/// Reads a picture of `Rgba8Unorm` back, such as [`super::Viewer::picture`]. Waits for the card.
///
/// # Errors
/// One line, if the device was lost.
pub fn read_picture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    picture: &wgpu::Texture,
) -> Result<image::RgbaImage, String> {
    let (width, height) = (picture.width(), picture.height());
    let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row_bytes) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(picture.as_image_copy(), destination, picture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {}); // a failure shows in get_mapped_range
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| format!("the graphics driver failed: {error}"))?;
    let mapped = buffer.slice(..).get_mapped_range().map_err(|error| format!("the picture is lost: {error}"))?;
    let mut image = image::RgbaImage::new(width, height);
    let rows = image.chunks_exact_mut(4 * width as usize).zip(mapped.chunks_exact(row_bytes as usize));
    for (row, bytes) in rows {
        row.copy_from_slice(&bytes[..row.len()]);
    }
    Ok(image)
}
