//! `radiosity devices`: which graphics cards and drivers there are.

use anyhow::bail;
use clap::Args;

use super::Outcome;
use crate::gpu::device::{self, FoundDevice};

/// Arguments of `radiosity devices`.
#[derive(Clone, Copy, Debug, Args)]
pub struct DevicesArgs {}

/// Runs the command.
pub fn run(_: &DevicesArgs) -> anyhow::Result<Outcome> {
    let found = device::devices();
    if found.is_empty() {
        bail!("{}", device::NO_DRIVER);
    }
    for (index, device) in found.iter().enumerate() {
        println!("{}{}", line(device), if index == 0 && device.problem.is_none() { " (default)" } else { "" });
    }
    Ok(Outcome::Done)
}

fn line(device: &FoundDevice) -> String {
    let FoundDevice { info, limits, problem, .. } = device;
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "graphics card",
        wgpu::DeviceType::IntegratedGpu => "graphics in the processor",
        wgpu::DeviceType::VirtualGpu => "virtual graphics card",
        wgpu::DeviceType::Cpu => "software driver",
        wgpu::DeviceType::Other => "unknown kind",
    };
    let memory = limits.max_storage_buffer_binding_size >> 20;
    let usable = problem.as_ref().map_or_else(
        || format!("buffers of {memory} MiB, pages of {} texels", limits.max_texture_dimension_2d),
        |problem| format!("cannot solve: it {problem}"),
    );
    format!("{} [{}]: {kind}, {} {}; {usable}", info.name, info.backend, info.driver, info.driver_info)
}
