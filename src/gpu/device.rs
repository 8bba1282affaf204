//! A graphics card without a window, for tests and for baking.

/// A card or driver that was found.
#[derive(Clone, Debug)]
pub struct FoundDevice {
    /// Name, driver, backend.
    pub info: wgpu::AdapterInfo,
    /// What it can do at most.
    pub limits: wgpu::Limits,
    /// What is missing for solving on it, if anything.
    pub problem: Option<String>,
    adapter: wgpu::Adapter,
}

/// All cards and drivers, in the order in which they are preferred. A software driver (lavapipe, llvmpipe) is as good as
/// a card, but comes after it. The environment variable `WGPU_BACKEND` (`vulkan`, `gl`, ...) restricts the choice.
pub fn devices() -> Vec<FoundDevice> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::all());
    let adapters = pollster::block_on(instance.enumerate_adapters(backends));
    let mut found: Vec<FoundDevice> = adapters.into_iter().map(FoundDevice::new).collect();
    let rank = |device: &FoundDevice| {
        let kind = match device.info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
            wgpu::DeviceType::Cpu => 3,
        };
        (device.problem.is_some(), kind, device.info.backend == wgpu::Backend::Gl)
    };
    found.sort_by_key(rank);
    found
}

/// What is asked of an adapter, with a window or without: the limits of WebGPU's core as far as it has them, its own limits
/// of memory, and its clock, if it has one.
pub fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let limits = adapter.limits();
    wgpu::DeviceDescriptor {
        label: Some("radiosity"),
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        required_limits: wgpu::Limits {
            max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size,
            max_buffer_size: limits.max_buffer_size,
            ..wgpu::Limits::default().or_worse_values_from(&limits)
        },
        ..wgpu::DeviceDescriptor::default()
    }
}

/// What a device with these limits lacks for solving, if anything.
pub fn missing_limit(limits: &wgpu::Limits) -> Option<&'static str> {
    if limits.max_storage_buffers_per_shader_stage < 8 {
        Some("has fewer than 8 storage buffers a shader")
    } else if limits.max_compute_invocations_per_workgroup < 256 {
        Some("runs fewer than 256 invocations a workgroup")
    } else {
        None
    }
}

impl FoundDevice {
    fn new(adapter: wgpu::Adapter) -> Self {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        let flags = adapter.get_downlevel_capabilities().flags;
        let has_compute = flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS);
        let problem = if has_compute { missing_limit(&limits) } else { Some("has no compute shaders") };
        Self { info, limits, problem: problem.map(String::from), adapter }
    }

    /// Opens it.
    ///
    /// # Errors
    /// One line, if the driver refuses.
    pub fn open(&self) -> Result<(wgpu::Device, wgpu::Queue), String> {
        let opened = pollster::block_on(self.adapter.request_device(&descriptor(&self.adapter)));
        opened.map_err(|error| format!("{}: the graphics driver failed: {error}", self.info.name))
    }
}

/// The device whose name holds `name`, in any case of letters; without a name, the best that can solve.
///
/// # Errors
/// One line, if there is none: what to install, or which there are.
pub fn choose(name: Option<&str>) -> Result<FoundDevice, String> {
    let found = devices();
    if found.is_empty() {
        return Err(String::from(NO_DRIVER));
    }
    let names: Vec<&str> = found.iter().map(|device| device.info.name.as_str()).collect();
    let names = names.join(", ");
    let matches =
        |device: &&FoundDevice| name.is_none_or(|name| device.info.name.to_lowercase().contains(&name.to_lowercase()));
    let chosen = found.iter().find(matches);
    let chosen = chosen.ok_or_else(|| format!("no device is called {}; found: {names}", name.unwrap_or_default()))?;
    match &chosen.problem {
        Some(problem) => Err(format!("{} {problem}; found: {names}", chosen.info.name)),
        None => Ok(chosen.clone()),
    }
}

/// What to do where no driver is found.
pub const NO_DRIVER: &str = "no graphics driver was found; a software driver will do (Debian: mesa-vulkan-drivers)";

/// A device and its queue: the best there is.
///
/// # Errors
/// One line, if there is no driver at all.
pub fn headless() -> Result<(wgpu::Device, wgpu::Queue), String> {
    devices().first().ok_or_else(|| String::from(NO_DRIVER))?.open()
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
    wait(device)?;
    let mapped = buffer.slice(..).get_mapped_range().map_err(|error| format!("the picture is lost: {error}"))?;
    let mut image = image::RgbaImage::new(width, height);
    let rows = image.chunks_exact_mut(4 * width as usize).zip(mapped.chunks_exact(row_bytes as usize));
    for (row, bytes) in rows {
        row.copy_from_slice(&bytes[..row.len()]);
    }
    Ok(image)
}

/// Waits until all that was submitted is done, by whoever shares the device.
pub(in crate::gpu) fn wait(device: &wgpu::Device) -> Result<(), String> {
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| format!("the graphics driver failed: {error}"))?;
    Ok(())
}
