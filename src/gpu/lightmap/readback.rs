//! Reading buffers back.

/// Reads a buffer that can be mapped. Waits for the card.
pub(in crate::gpu) fn read<T: bytemuck::Pod>(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<T>, String> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {}); // a failure shows in get_mapped_range
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| format!("the graphics driver failed: {error}"))?;
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
