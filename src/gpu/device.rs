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
