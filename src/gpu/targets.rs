//! The textures that a view is drawn into.

use super::{part::Part, visibility::SeenTargets};

/// Colour and depth of one view.
pub(super) struct Targets {
    pub(super) size: [u32; 2],
    pub(super) samples: u32,
    /// The finished picture, sRGB-coded.
    pub(super) picture: wgpu::Texture,
    pub(super) picture_view: wgpu::TextureView,
    /// The samples, if there are several a pixel.
    multisampled: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

impl Targets {
    /// Values are coded before they are stored, as the tone map gives them; so the mean of a pixel's samples is that of
    /// coded values, like in `render`.
    pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
    const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
    /// sRGB-coded colour where there is no surface, as `render` has it.
    const BACKGROUND: wgpu::Color = wgpu::Color { r: 0.11, g: 0.11, b: 0.11, a: 1.0 };

    pub(super) fn new(device: &wgpu::Device, [width, height]: [u32; 2], samples: u32) -> Self {
        let texture = |label, format, sample_count, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let read = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let none = wgpu::TextureUsages::empty();
        let picture = texture("view", Self::COLOR_FORMAT, 1, read);
        Self {
            size: [width, height],
            samples,
            picture_view: view(&picture),
            picture,
            multisampled: (samples > 1).then(|| view(&texture("view samples", Self::COLOR_FORMAT, samples, none))),
            depth: view(&texture("view depth", Self::DEPTH_FORMAT, samples, none)),
        }
    }

    /// Begins a pass for a part of a picture: the first clears it, the last finishes it.
    pub(super) fn begin<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        part: &Part,
    ) -> wgpu::RenderPass<'encoder> {
        let between = if part.is_last { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
        let (view, resolve_target, store) = match &self.multisampled {
            Some(samples) => (samples, part.is_last.then_some(&self.picture_view), between),
            None => (&self.picture_view, None, wgpu::StoreOp::Store),
        };
        let color_load = if part.is_first { wgpu::LoadOp::Clear(Self::BACKGROUND) } else { wgpu::LoadOp::Load };
        // Reversed depth: 0 is infinitely far.
        let depth_load = if part.is_first { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("view"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: color_load, store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: depth_load, store: between }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    /// Begins the pass that finds what pixels see. Its depth stays for [`Targets::begin_resolve`].
    pub(super) fn begin_visibility<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        seen: &SeenTargets,
    ) -> wgpu::RenderPass<'encoder> {
        let clear =
            wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
        let attachments = seen.views.each_ref().map(|view| {
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops: clear })
        });
        self.begin_with(encoder, &attachments, wgpu::LoadOp::Clear(0.0))
    }

    /// Begins the pass that colours pixels by what they see, and draws more over it.
    pub(super) fn begin_resolve<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
    ) -> wgpu::RenderPass<'encoder> {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(Self::BACKGROUND), store: wgpu::StoreOp::Store };
        let view = &self.picture_view;
        let color = wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
        self.begin_with(encoder, &[Some(color)], wgpu::LoadOp::Load)
    }

    fn begin_with<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        color_attachments: &[Option<wgpu::RenderPassColorAttachment<'_>>],
        depth: wgpu::LoadOp<f32>,
    ) -> wgpu::RenderPass<'encoder> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("view"),
            color_attachments,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: depth, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    /// Writes depth where `compare` to the reversed depth holds: `Greater` is nearer.
    pub(super) fn depth_state(compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
        wgpu::DepthStencilState {
            format: Self::DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }
    }

    /// So many samples a pixel.
    pub(super) fn multisample(samples: u32) -> wgpu::MultisampleState {
        wgpu::MultisampleState { count: samples, ..wgpu::MultisampleState::default() }
    }
}

/// A texture of one sample a pixel that is drawn into and read.
pub(in crate::gpu) fn drawn_texture(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
