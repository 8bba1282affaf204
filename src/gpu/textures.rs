//! The scene's textures on the card.

use std::collections::{BTreeMap, BTreeSet};

use crate::scene::{Scene, Texture};

/// One group of bindings for each pair of textures that some material has.
pub(super) struct TextureGroups {
    groups: BTreeMap<TexturePair, wgpu::BindGroup>,
    of_material: Vec<TexturePair>,
}

/// A material's textures: reflectance and opacity.
type TexturePair = [Option<u32>; 2];

impl TextureGroups {
    /// Uploads the textures that the scene's materials use.
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        scene: &Scene,
    ) -> Self {
        let of_material: Vec<TexturePair> =
            scene.materials.iter().map(|material| [material.reflectance_texture, material.opacity_texture]).collect();
        let white = upload(device, queue, "no texture", [1, 1], &[[255; 4]]);
        let used: BTreeSet<u32> = of_material.iter().flatten().flatten().copied().collect();
        let uploaded = |index| (index, upload_texture(device, queue, &scene.textures[index as usize]));
        let used: BTreeMap<u32, wgpu::TextureView> = used.into_iter().map(uploaded).collect();
        let view = |texture: Option<u32>| texture.and_then(|index| used.get(&index)).unwrap_or(&white);
        let mut groups = BTreeMap::new();
        for &[reflectance, opacity] in &of_material {
            let group = || {
                let entry = |binding, texture| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(view(texture)),
                };
                let entries = [entry(0, reflectance), entry(1, opacity)];
                device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("textures"),
                    layout,
                    entries: &entries,
                })
            };
            groups.entry([reflectance, opacity]).or_insert_with(group);
        }
        Self { groups, of_material }
    }

    /// The bindings of a material's textures.
    pub(super) fn of_material(&self, material: u32) -> &wgpu::BindGroup {
        &self.groups[&self.of_material[material as usize]]
    }
}

/// Uploads a texture; one that is larger than the card can take is reduced by leaving out rows and columns.
fn upload_texture(device: &wgpu::Device, queue: &wgpu::Queue, texture: &Texture) -> wgpu::TextureView {
    let (width, height) = texture.size();
    let step = width.max(height).div_ceil(device.limits().max_texture_dimension_2d);
    if step <= 1 {
        return upload(device, queue, &texture.name, [width, height], texture.texels());
    }
    let rows = texture.texels().chunks_exact(width as usize).step_by(step as usize);
    let reduced: Vec<[u8; 4]> = rows.flat_map(|row| row.iter().copied().step_by(step as usize)).collect();
    upload(device, queue, &texture.name, [width.div_ceil(step), height.div_ceil(step)], &reduced)
}

/// A texture of sRGB bytes with linear alpha.
fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    name: &str,
    [width, height]: [u32; 2],
    texels: &[[u8; 4]],
) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None };
    queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
