//! Reading buffers back.

use crate::gpu::device::wait;

/// Reads a buffer that can be mapped. Waits for the card.
pub(in crate::gpu) fn read<T: bytemuck::Pod>(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<T>, String> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {}); // a failure shows in get_mapped_range
    wait(device)?;
    let values = {
        let mapped = buffer.slice(..).get_mapped_range().map_err(|error| {
            let error = error.to_string();
            format!("the graphics device was lost: {}", error.lines().next().unwrap_or_default())
        })?;
        bytemuck::pod_collect_to_vec(&mapped)
    };
    buffer.unmap();
    Ok(values)
}

/// Reads any buffer, by way of a copy.
pub(in crate::gpu) fn read_copy<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, String> {
    read_part(device, queue, buffer, buffer.size())
}

/// Reads the first bytes of any buffer, a multiple of 4, by way of a copy.
pub(in crate::gpu) fn read_part<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    bytes: u64,
) -> Result<Vec<T>, String> {
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read"),
        size: bytes,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, bytes);
    queue.submit([encoder.finish()]);
    read(device, &copy)
}

/// Reads the first layers of a texture of depths, row by row from the top, by way of a copy.
pub(in crate::gpu) fn read_depths(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    layers: u32,
) -> Result<Vec<f32>, String> {
    let (width, height) = (texture.width(), texture.height());
    let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read"),
        size: u64::from(row_bytes) * u64::from(height * layers),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: Some(height) };
    let source = wgpu::TexelCopyTextureInfo { aspect: wgpu::TextureAspect::DepthOnly, ..texture.as_image_copy() };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    encoder.copy_texture_to_buffer(source, wgpu::TexelCopyBufferInfo { buffer: &copy, layout }, size);
    queue.submit([encoder.finish()]);
    let rows: Vec<f32> = read(device, &copy)?;
    Ok(rows.chunks_exact(row_bytes as usize / 4).flat_map(|row| &row[..width as usize]).copied().collect())
}
