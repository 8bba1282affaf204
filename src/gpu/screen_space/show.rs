//! The pass that writes one buffer where views read it.

use clap::ValueEnum;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use wgpu::util::{BufferInitDescriptor, DeviceExt as _};

/// The shader; comes after [`super::uniforms::SCREEN_WGSL`].
pub const SHOW_WGSL: &str = include_str!("show.wgsl");

/// A buffer that can be shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShownBuffer {
    /// Irradiance, direct and indirect.
    #[default]
    Total,
    /// Direct irradiance.
    Direct,
    /// Irradiance of all bounces.
    Indirect,
    /// Normals in view space, as colours.
    Normals,
    /// Reflectance.
    Reflectance,
    /// Depth: white is as near as the scene's box, and black as far.
    Depth,
    /// Ambient obscurance: white is open.
    Obscurance,
}

impl ShownBuffer {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Total, Self::Direct, Self::Indirect, Self::Normals, Self::Reflectance, Self::Depth, Self::Obscurance];

    /// Its name.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| String::from(value.get_name()))
    }

    /// True if it is irradiance, to be shown as light; others hold colours.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Total | Self::Direct | Self::Indirect)
    }
}

impl ShownBuffer {
    /// True if the second layer has it, too.
    pub fn has_layers(self) -> bool {
        self != Self::Obscurance
    }
}

/// A page of irradiance [W/m²] from elsewhere, row by row from the top, to be shown in the same way.
pub fn page_of(device: &wgpu::Device, [width, height]: [u32; 2], values: &[Vec3]) -> wgpu::Buffer {
    let mut bytes = bytemuck::bytes_of(&[width, height, 1, 0]).to_vec();
    for value in values {
        bytes.extend_from_slice(bytemuck::bytes_of(&value.extend(1.0)));
    }
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some("page"),
        contents: &bytes,
        usage: wgpu::BufferUsages::STORAGE,
    })
}

/// Laid out as `Show` in `show.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ShowUniforms {
    /// The buffer.
    pub buffer: u32,
    /// Its layer: 0 or 1.
    pub layer: u32,
    /// The depth that is shown as white.
    pub nearest: f32,
    /// The depth that is shown as black, or almost.
    pub farthest: f32,
}
