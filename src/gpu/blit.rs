//! The pass that copies a finished picture into the window.

/// The shader.
pub const WGSL: &str = include_str!("blit.wgsl");

/// The pipeline.
pub(super) struct Blit {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

/// One picture and its place in the window.
pub(super) struct BlitInputs {
    place: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Blit {
    /// For windows of this format; to one that codes sRGB itself, linear values are written.
    pub(super) fn new(device: &wgpu::Device, target_format: wgpu::TextureFormat) -> Self {
        let layout = bindings(device);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("blit"),
            source: wgpu::ShaderSource::Wgsl(WGSL.into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("blit"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let entry = if target_format.is_srgb() { "linear" } else { "coded" };
        let pipeline = window_pipeline(device, "blit", (Some(&pipeline_layout), &module), entry, target_format);
        Self { pipeline, layout }
    }

    /// Bindings of a picture, at the window's top left corner.
    pub(super) fn inputs(&self, device: &wgpu::Device, picture: &wgpu::TextureView) -> BlitInputs {
        let place = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("blit place"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let entries = [
            wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(picture) },
            wgpu::BindGroupEntry { binding: 1, resource: place.as_entire_binding() },
        ];
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blit"),
            layout: &self.layout,
            entries: &entries,
        });
        BlitInputs { place, group }
    }

    /// Copies a picture into a pass over the window.
    pub(super) fn record(&self, pass: &mut wgpu::RenderPass<'_>, inputs: &BlitInputs) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &inputs.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl BlitInputs {
    /// Moves the picture's top left corner to this pixel of the window, and gives it this size there.
    pub(super) fn place(&self, queue: &wgpu::Queue, [x, y]: [i32; 2], size: [u32; 2]) {
        let [across, down] = size.map(|pixels| 1.0 / pixels.max(1) as f32);
        queue.write_buffer(&self.place, 0, bytemuck::bytes_of(&[x as f32, y as f32, across, down]));
    }
}

/// A pass over all pixels of a viewport of the window, from one triangle. Without a layout, the shader's own is taken.
pub(super) fn window_pipeline(
    device: &wgpu::Device,
    label: &str,
    (layout, module): (Option<&wgpu::PipelineLayout>, &wgpu::ShaderModule),
    entry: &str,
    target_format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(target_format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn bindings(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::FRAGMENT, ty, count: None };
    let picture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let place = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("blit"),
        entries: &[entry(0, picture), entry(1, place)],
    })
}
