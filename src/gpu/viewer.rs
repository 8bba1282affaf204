//! All views of the window: what each keeps on the card, when it is drawn again, and the order of its passes.

use std::{
    collections::BTreeMap,
    sync::{Arc, Weak},
    time::{Duration, Instant},
};

use super::{
    ViewFrame, ViewGeometry,
    blit::{Blit, BlitInputs},
    by_pixel::{ByPixel, Seen},
    contents::{Changes, Contents},
    frame::{FrameUniforms, MapFrame, SAMPLE_COUNTS},
    light_view::LightView,
    mesh_buffers::{MeshBuffers, Triangles},
    mesh_view::{Layouts, MeshView},
    part::Part,
    targets::Targets,
    variant::{ToneVariant, Variant},
    wireframe::Wireframe,
};

/// Draws views, each into a picture of its own. Several views of one geometry share its buffers.
pub struct Viewer {
    layouts: Layouts,
    blit: Blit,
    target_format: wgpu::TextureFormat,
    mesh_pass: MeshView,
    /// Made for a driver that draws on the processor.
    by_pixel: Option<ByPixel>,
    /// By number of samples; made for the first view.
    passes: BTreeMap<u32, Passes>,
    meshes: Vec<(Weak<ViewGeometry>, Arc<MeshBuffers>)>,
    views: BTreeMap<u64, ViewState>,
    busy: Duration,
}

struct Passes {
    wireframe: Wireframe,
    light: LightView,
}

/// A picture, and what it is shown by.
struct Picture {
    targets: Targets,
    blit: BlitInputs,
}

impl Picture {
    fn new(device: &wgpu::Device, blit: &Blit, size: [u32; 2], samples: u32) -> Self {
        let targets = Targets::new(device, size, samples);
        Self { blit: blit.inputs(device, &targets.picture_view), targets }
    }
}

/// What a view keeps between frames.
struct ViewState {
    frame_buffer: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    shown: Picture,
    /// The number of the next part that is drawn, if `shown` is coarse.
    next_part: Option<u32>,
    /// What the parts are drawn into, until it takes the place of `shown`.
    refined: Option<Picture>,
    /// What `shown` sees, from the second field on that this camera shows.
    seen: Option<Seen>,
    /// None before the first frame.
    contents: Option<Contents>,
    drawn: Option<Drawn>,
}

/// All that decides what a picture looks like, besides [`Contents`]: a view is drawn again if any of it differs.
#[derive(Clone, PartialEq)]
struct Drawn {
    uniforms: FrameUniforms,
    variant: Variant,
    size: [u32; 2],
    wireframe: bool,
    light: bool,
    map: Option<MapFrame>,
}

impl Drawn {
    fn new(frame: &ViewFrame) -> Self {
        Self {
            uniforms: FrameUniforms::new(frame),
            variant: Variant::new(frame),
            size: frame.size,
            wireframe: frame.wireframe,
            light: frame.light.is_some(),
            map: frame.map.clone(),
        }
    }
}

impl Viewer {
    /// For windows of this format. The shaders are compiled when the first view is drawn.
    pub fn new(device: &wgpu::Device, target_format: wgpu::TextureFormat) -> Self {
        let layouts = Layouts::new(device);
        Self {
            mesh_pass: MeshView::new(device, &layouts),
            by_pixel: None,
            layouts,
            blit: Blit::new(device, target_format),
            target_format,
            passes: BTreeMap::new(),
            meshes: Vec::new(),
            views: BTreeMap::new(),
            busy: Duration::ZERO,
        }
    }

    /// Records what is needed to bring a view's picture up to date, if it is not: true if it is drawn again.
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        frame: &ViewFrame,
    ) -> bool {
        let started = Instant::now();
        let drawn = self.draw_unmeasured(device, queue, encoder, frame);
        self.busy += started.elapsed();
        drawn
    }

    /// What [`Viewer::draw`] took since the last call, on the thread that called it.
    pub fn take_busy_time(&mut self) -> Duration {
        std::mem::take(&mut self.busy)
    }

    fn draw_unmeasured(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        frame: &ViewFrame,
    ) -> bool {
        let frame = &ViewFrame { size: drawable_size(device, frame.picture_size()), ..frame.clone() };
        let samples = frame.samples();
        let mesh = self.mesh(device, queue, &frame.geometry);
        for samples in SAMPLE_COUNTS {
            self.passes.entry(samples).or_insert_with(|| Passes {
                wireframe: Wireframe::new(device, &self.layouts, samples),
                light: LightView::new(device, &self.layouts, samples),
            });
        }
        let new_view = || ViewState::new(device, &self.layouts, &self.blit, frame.size, samples);
        let view = self.views.entry(frame.view).or_insert_with(new_view);
        if view.shown.targets.size != frame.size || view.shown.targets.samples != samples {
            view.shown = Picture::new(device, &self.blit, frame.size, samples);
        }
        let changes = view.upload_contents(device, queue, &self.layouts, mesh, frame);
        view.bind_pages(device, &self.layouts, &mut self.mesh_pass, frame);
        let drawn = Drawn::new(frame);
        let Some(passes) = self.passes.get(&samples) else { return false };
        let same = !changes.more && view.drawn.as_ref() == Some(&drawn);
        if same && !changes.field {
            let Some(number) = view.next_part else { return false };
            let picture = view.refined.take().filter(|_| number > 0);
            let picture = picture.unwrap_or_else(|| Picture::new(device, &self.blit, frame.size, samples));
            view.refine(encoder, &self.mesh_pass, passes, picture, number);
            return true;
        }
        queue.write_buffer(&view.frame_buffer, 0, bytemuck::bytes_of(&drawn.uniforms));
        self.mesh_pass.prepare(device, drawn.variant, &frame.geometry.scene, &frame.materials);
        let by_pixel = frame.gradual.then(|| self.by_pixel.get_or_insert_with(|| ByPixel::new(device, &self.layouts)));
        let by_pixel = by_pixel.and_then(|by_pixel| by_pixel.prepare(device, frame).map(|tone| (&*by_pixel, tone)));
        view.drawn = Some(drawn);
        view.next_part = (frame.gradual && frame.geometry.coarse.is_some()).then_some(0);
        view.seen = view.seen.take().filter(|_| same);
        if let Some((by_pixel, tone)) = by_pixel.filter(|_| same && frame.saves_time) {
            view.see(device, encoder, by_pixel);
            view.record_by_pixel(queue, encoder, (by_pixel, tone), (passes, frame));
            return true;
        }
        if let Some(contents) = &mut view.contents {
            contents.stream_field(queue, frame);
        }
        if view.next_part.is_some() {
            view.record_coarse(encoder, &self.mesh_pass, passes);
        } else {
            view.record_whole(encoder, &self.mesh_pass, passes);
        }
        true
    }

    /// True if a view is shown coarse and gets finer with each frame.
    pub fn is_refining(&self) -> bool {
        self.views.values().any(|view| view.next_part.is_some())
    }

    /// True if the view's last picture drew no triangle: its pixels were coloured by what they saw before.
    pub fn is_by_pixel(&self, view: u64) -> bool {
        self.views.get(&view).is_some_and(|view| view.seen.is_some())
    }

    /// The windows' format.
    pub fn target_format(&self) -> wgpu::TextureFormat {
        self.target_format
    }

    /// Moves a view's top left corner to this pixel of the window, and gives it this size there, in pixels.
    pub fn place(&self, queue: &wgpu::Queue, view: u64, origin: [i32; 2], size: [u32; 2]) {
        if let Some(view) = self.views.get(&view) {
            view.shown.blit.place(queue, origin, size);
        }
    }

    /// Copies a view's picture into a pass over the window; nothing if the view was not drawn.
    pub fn show(&self, pass: &mut wgpu::RenderPass<'_>, view: u64) {
        if let Some(view) = self.views.get(&view) {
            self.blit.record(pass, &view.shown.blit);
        }
    }

    /// A view's picture: sRGB-coded `Rgba8Unorm`, which can be copied from.
    pub fn picture(&self, view: u64) -> Option<&wgpu::Texture> {
        self.views.get(&view).map(|view| &view.shown.targets.picture)
    }

    /// Frees all that a view holds.
    pub fn close(&mut self, view: u64) {
        self.views.remove(&view);
    }

    /// The geometry's buffers, uploaded if they are not there yet; those of geometries that are gone are freed.
    pub fn mesh(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        geometry: &Arc<ViewGeometry>,
    ) -> Arc<MeshBuffers> {
        let is_it = |(known, _): &&(Weak<ViewGeometry>, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(geometry));
        if let Some((_, mesh)) = self.meshes.iter().find(is_it) {
            return Arc::clone(mesh);
        }
        self.meshes.retain(|(known, _)| known.strong_count() > 0);
        let mesh = Arc::new(MeshBuffers::new(device, queue, &self.layouts.textures, geometry));
        self.meshes.push((Arc::downgrade(geometry), Arc::clone(&mesh)));
        mesh
    }
}

impl ViewState {
    fn new(device: &wgpu::Device, layouts: &Layouts, blit: &Blit, size: [u32; 2], samples: u32) -> Self {
        let frame_buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &layouts.frame,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame_buffer.as_entire_binding() }],
        });
        let shown = Picture::new(device, blit, size, samples);
        Self {
            frame_buffer,
            frame_group,
            shown,
            next_part: None,
            refined: None,
            seen: None,
            contents: None,
            drawn: None,
        }
    }

    /// Uploads what differs from the last frame's buried vertices and materials, and tells of its geometry and field.
    fn upload_contents(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &Layouts,
        mesh: Arc<MeshBuffers>,
        frame: &ViewFrame,
    ) -> Changes {
        let same = |contents: &Contents| {
            Arc::ptr_eq(&contents.geometry, &frame.geometry) && contents.materials.is_for(&frame.materials)
        };
        let kept = self.contents.take().filter(same);
        let is_new = kept.is_none();
        let contents = self.contents.insert(kept.unwrap_or_else(|| Contents::new(device, layouts, mesh, frame)));
        let field = contents.take_field(frame);
        let more = [contents.upload_buried(queue, frame), contents.upload_materials(queue, frame)];
        Changes { field, more: is_new || more.contains(&true) }
    }

    /// Binds the pages of the frame's lightmap, if there is one.
    fn bind_pages(&mut self, device: &wgpu::Device, layouts: &Layouts, mesh_pass: &mut MeshView, frame: &ViewFrame) {
        let Some(contents) = &mut self.contents else { return };
        let Some(map) = &frame.map else {
            contents.pages = None;
            return;
        };
        if contents.pages.as_ref().is_none_or(|(bound, _)| *bound != map.pages) {
            let group = mesh_pass.bind_pages(device, layouts, &map.pages);
            contents.pages = Some((map.pages.clone(), group));
        }
    }

    fn record_whole(&self, encoder: &mut wgpu::CommandEncoder, mesh_pass: &MeshView, passes: &Passes) {
        let Some(Contents { mesh, .. }) = &self.contents else { return };
        let part = Part::whole(mesh.triangles.count(), mesh.edge_count);
        self.record(encoder, mesh_pass, passes, (&self.shown.targets, &mesh.triangles, &part));
    }

    fn record_coarse(&self, encoder: &mut wgpu::CommandEncoder, mesh_pass: &MeshView, passes: &Passes) {
        let Some(Contents { mesh, .. }) = &self.contents else { return };
        let Some(triangles) = &mesh.coarse else { return };
        let part = Part::whole(triangles.count(), 0);
        self.record(encoder, mesh_pass, passes, (&self.shown.targets, triangles, &part));
    }

    /// Finds what the pixels see, if it is not known.
    fn see(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, by_pixel: &ByPixel) {
        let (Some(contents), Some(drawn)) = (&self.contents, &self.drawn) else { return };
        let inputs = contents.inputs(&self.frame_group, (drawn.variant, false));
        self.seen.get_or_insert_with(|| by_pixel.see(device, encoder, (&self.shown.targets, contents, &inputs)));
    }

    /// Colours pixels by what they see.
    fn record_by_pixel(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        (by_pixel, tone): (&ByPixel, ToneVariant),
        (passes, frame): (&Passes, &ViewFrame),
    ) {
        let (Some(contents), Some(seen)) = (&self.contents, &self.seen) else { return };
        seen.field.write(queue, &contents.field(frame));
        let mut pass = by_pixel.begin(encoder, (&self.shown.targets, &self.frame_group), (seen, tone));
        self.record_over(&mut pass, passes, &Part::whole(0, contents.mesh.edge_count));
    }

    /// Draws a part of the fine picture.
    fn refine(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        mesh_pass: &MeshView,
        passes: &Passes,
        picture: Picture,
        number: u32,
    ) {
        let (Some(Contents { mesh, .. }), Some(drawn)) = (&self.contents, &self.drawn) else { return };
        let edges = if drawn.wireframe { mesh.edge_count } else { 0 };
        let part = Part::numbered(number, mesh.triangles.count(), edges);
        self.record(encoder, mesh_pass, passes, (&picture.targets, &mesh.triangles, &part));
        if part.is_last {
            (self.shown, self.refined, self.next_part) = (picture, None, None);
        } else {
            (self.refined, self.next_part) = (Some(picture), Some(number + 1));
        }
    }

    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        mesh_pass: &MeshView,
        passes: &Passes,
        (targets, triangles, part): (&Targets, &Triangles, &Part),
    ) {
        let (Some(contents), Some(drawn)) = (&self.contents, &self.drawn) else { return };
        let mut pass = targets.begin(encoder, part);
        let inputs = contents.inputs(&self.frame_group, (drawn.variant, drawn.map.is_some()));
        mesh_pass.record(&mut pass, &contents.mesh, &inputs, (triangles, part.triangles.clone()));
        self.record_over(&mut pass, passes, part);
    }

    /// What is drawn over the surfaces.
    fn record_over(&self, pass: &mut wgpu::RenderPass<'_>, passes: &Passes, part: &Part) {
        let (Some(contents), Some(drawn)) = (&self.contents, &self.drawn) else { return };
        if drawn.wireframe && !part.edges.is_empty() {
            passes.wireframe.record(pass, &self.frame_group, &contents.mesh, part.edges.clone());
        }
        if drawn.light && part.is_last {
            passes.light.record(pass, &self.frame_group);
        }
    }
}

/// A size that the card can draw: at least one pixel.
fn drawable_size(device: &wgpu::Device, size: [u32; 2]) -> [u32; 2] {
    size.map(|pixels| pixels.clamp(1, device.limits().max_texture_dimension_2d))
}
