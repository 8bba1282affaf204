//! Drawing without triangles: what the pixels of a view see is found once, and then, while only the field changes, the
//! pixels alone are coloured again.

use super::{
    ViewFrame,
    contents::Contents,
    mesh_view::{Layouts, MeshInputs},
    resolve::{FieldTexture, Resolve},
    targets::Targets,
    variant::{ToneVariant, Variant},
    visibility::{CornerStreams, SeenTargets, Visibility},
};

/// Both passes.
pub(super) struct ByPixel {
    visibility: Visibility,
    resolve: Resolve,
}

/// What the pixels of a view see, for as long as that stays the same.
pub(super) struct Seen {
    group: wgpu::BindGroup,
    pub(super) field: FieldTexture,
}

impl ByPixel {
    /// Compiles the shaders.
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        Self { visibility: Visibility::new(device, layouts), resolve: Resolve::new(device, layouts) }
    }

    /// Makes the pipelines for a frame that is drawn in this way or will be, once a solve begins: what colours are made
    /// by, or none if this way does not do for the frame.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, frame: &ViewFrame) -> Option<ToneVariant> {
        let variant = Variant::new(frame).with_samples(1);
        let fits = frame.geometry.coarse.is_none() && frame.geometry.vertex_count() <= FieldTexture::capacity(device);
        let tone = variant.resolved().filter(|_| fits)?;
        self.visibility.prepare(device, variant, &frame.geometry.scene, &frame.materials);
        self.resolve.prepare(device, tone);
        Some(tone)
    }

    /// Finds what the pixels of `targets` see.
    pub(super) fn see(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        (targets, contents, inputs): (&Targets, &Contents, &MeshInputs<'_>),
    ) -> Seen {
        let mesh = &contents.mesh;
        let field = FieldTexture::new(device, contents.geometry.vertex_count());
        let seen = SeenTargets::new(device, targets.size);
        let corners = mesh.corners.get_or_init(|| CornerStreams::new(device, &contents.geometry));
        let mut pass = targets.begin_visibility(encoder, &seen);
        self.visibility.record(&mut pass, mesh, (inputs, corners));
        let group = self.resolve.bind(device, &seen, &field);
        Seen { group, field }
    }

    /// Begins a picture with the colours of all pixels.
    pub(super) fn begin<'encoder>(
        &self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        (targets, frame): (&Targets, &wgpu::BindGroup),
        (seen, tone): (&Seen, ToneVariant),
    ) -> wgpu::RenderPass<'encoder> {
        let mut pass = targets.begin_resolve(encoder);
        self.resolve.record(&mut pass, tone, [frame, &seen.group]);
        pass
    }
}
