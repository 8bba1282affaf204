//! A frame in screen space: the order of its passes.

use std::{
    collections::VecDeque,
    sync::Arc,
    time::{Duration, Instant},
};

use glam::{Vec3, Vec4};

use super::{
    g_buffer::{GBuffer, Layer},
    lamps::{LampPass, lamps},
    pace::{Pace, Step, Work},
    passes::{Dispatch, Filtered, Groups, Pass, Pipelines, Uniforms},
    picture::{Picture, record},
    quality::Quality,
    settings::{ScreenSettings, SecondLayer},
    show::{ShowUniforms, ShownBuffer},
    targets::Targets,
    uniforms::{ScreenUniforms, wider},
    view::{ScreenFields, ScreenView, depths_of_box},
};
use crate::gpu::{
    ViewGeometry,
    device::wait,
    lightmap::{
        readback::{read_copy, read_depths},
        timing::PassTime,
    },
    mesh_buffers::MeshBuffers,
    projection::NEAR,
    view_projection,
};

/// Draws frames, submission by submission.
pub struct ScreenRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    geometry: Arc<ViewGeometry>,
    mesh: Arc<MeshBuffers>,
    /// The scene's lowest and highest corner, and its largest extent.
    ends: [Vec3; 2],
    scene_size: f32,
    g_buffer: GBuffer,
    lamps: LampPass,
    pipelines: Pipelines,
    uniforms: Uniforms,
    /// The one that is drawn comes first; another of a different size may follow.
    pictures: Vec<Picture>,
    known: Option<(ScreenView, ScreenSettings)>,
    /// The settings of the frame that is drawn.
    drawn: ScreenSettings,
    still: u32,
    shown: (ShownBuffer, u32),
    screen: ScreenUniforms,
    frame: VecDeque<Step>,
    pace: Pace,
    quality: Quality,
    /// How often each pass ran, and what it took.
    times: [(u64, Duration); Pass::NAMES.len()],
    frame_time: Duration,
    submissions: u64,
    longest: Duration,
}

impl ScreenRenderer {
    /// For a geometry whose buffers are `mesh`.
    pub fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        geometry: &Arc<ViewGeometry>,
        mesh: Arc<MeshBuffers>,
    ) -> Self {
        let settings = ScreenSettings::default();
        let scene = &geometry.scene;
        let lamps = LampPass::new(device, scene, &settings);
        let ends = geometry
            .positions
            .iter()
            .fold([Vec3::MAX, Vec3::MIN], |[low, high], position| [low.min(*position), high.max(*position)]);
        Self {
            device: device.clone(),
            queue: queue.clone(),
            geometry: Arc::clone(geometry),
            mesh,
            ends,
            scene_size: (ends[1] - ends[0]).max_element().max(1e-6),
            g_buffer: GBuffer::new(device, scene.materials.len()),
            pace: Pace::new(lamps.triangle_count()),
            lamps,
            pipelines: Pipelines::new(device),
            uniforms: Uniforms::new(device),
            pictures: Vec::new(),
            known: None,
            drawn: settings,
            still: 0,
            shown: (ShownBuffer::Total, 0),
            screen: ScreenUniforms::default(),
            frame: VecDeque::new(),
            quality: Quality::default(),
            times: Default::default(),
            frame_time: Duration::ZERO,
            submissions: 0,
            longest: Duration::ZERO,
        }
    }

    /// Frames of the same view that the last one is a mean of.
    pub fn still_frames(&self) -> u32 {
        self.still + 1
    }

    /// What the last frame took, its submissions waited for one by one.
    pub fn frame_time(&self) -> Duration {
        self.frame_time
    }

    /// Submissions so far, and what the longest took.
    pub fn submissions(&self) -> (u64, Duration) {
        (self.submissions, self.longest)
    }

    /// What each pass took so far, in the order of [`Pass`], from its submission to its end: the clocks of software drivers know nothing of compute
    /// passes.
    pub fn pass_times(&self) -> Vec<PassTime> {
        let named = |(pass, (runs, taken)): (&'static str, (u64, Duration))| PassTime {
            pass,
            runs,
            seconds: taken.as_secs_f64(),
        };
        Pass::NAMES.into_iter().zip(self.times).map(named).collect()
    }

    /// Changes what a submission should take. It changes no bit of the picture.
    pub fn set_submission_time(&mut self, time: Duration) {
        self.pace.submission_time = time;
    }

    /// Chooses what the page shows from the next frame on: a buffer, and its layer (0 or 1).
    pub fn show(&mut self, buffer: ShownBuffer, layer: u32) {
        self.shown = (buffer, layer);
    }

    /// Forgets what was drawn: the next frame is as the first one.
    pub fn forget(&mut self) {
        (self.known, self.frame) = (None, VecDeque::new());
        self.pictures.iter_mut().for_each(|picture| picture.last_camera = None);
    }

    /// The page of the last frame, and its columns and rows; none before the first.
    pub fn page(&self) -> Option<(wgpu::Buffer, [u32; 2])> {
        let picture = self.pictures.first()?;
        Some((picture.targets.pages[1 - picture.next_page].clone(), picture.targets.size))
    }

    /// True if nothing of a frame is left to do.
    pub fn is_done(&self) -> bool {
        self.frame.is_empty()
    }

    /// Draws a whole frame. `settings` must have no problem.
    ///
    /// # Errors
    /// One line, if the device was lost, or the picture is larger than it takes.
    pub fn draw(&mut self, view: &ScreenView, settings: &ScreenSettings) -> Result<(), String> {
        self.begin(view, settings)?;
        while !self.is_done() {
            self.submit()?;
        }
        Ok(())
    }

    /// Begins a frame; what is left of the one before is dropped. `settings` must have no problem.
    ///
    /// # Errors
    /// One line, if the picture is larger than the device takes.
    pub fn begin(&mut self, view: &ScreenView, settings: &ScreenSettings) -> Result<(), String> {
        let is_complete = self.frame.is_empty();
        let known = self.known.take();
        let is_still =
            is_complete && known.as_ref().is_some_and(|(known, before)| known.is_same(view) && before == settings);
        let moves = known.is_some() && !is_still && settings.frame_budget > 0;
        let (drawn, size) = if moves { self.quality.apply(settings, view.size) } else { (settings.clone(), view.size) };
        // The first frame of full size after smaller ones begins a new mean.
        let is_still =
            is_still && self.drawn == drawn && self.pictures.first().is_some_and(|one| one.targets.size == size);
        self.still = if is_still { self.still + 1 } else { 0 };
        self.drawn = drawn;
        let lit_anew = known.as_ref().is_none_or(|(known, before)| {
            !known.is_lit_as(view)
                || (before.light_samples, before.shadow_map) != (settings.light_samples, settings.shadow_map)
        });
        let shadows_anew = self.prepare_lamps(view, lit_anew);
        self.prepare_picture(size)?;
        let has_last = self.prepare_g_buffer(view, size);
        self.screen = ScreenUniforms::new(&view.camera, size, &self.drawn, self.still, self.scene_size);
        let [nearest, farthest] = depths_of_box(self.ends, &view.camera);
        let layer = self.shown.1.min(self.drawn.layers() - 1);
        let show = ShowUniforms { buffer: self.shown.0 as u32, layer, nearest, farthest };
        self.queue.write_buffer(&self.uniforms.show, 0, bytemuck::bytes_of(&show));
        self.uniforms.set_spirals(&self.queue, &self.drawn);
        self.known = Some((view.clone(), settings.clone()));
        self.frame = self.steps(shadows_anew, has_last);
        self.frame_time = Duration::ZERO;
        Ok(())
    }

    /// Chooses the lamps anew where the light is another, or the view stands still and they move about: true then.
    fn prepare_lamps(&mut self, view: &ScreenView, lit_anew: bool) -> bool {
        if self.lamps.resize(&self.device, &self.drawn) {
            self.pictures.clear();
        } else if !lit_anew && self.still == 0 {
            return false;
        }
        let count = self.lamps.slots().min(self.drawn.light_samples);
        let found = lamps(&self.geometry.scene, &view.materials, view.light.as_ref(), count, self.still);
        self.lamps.set(&self.queue, &found, &self.drawn);
        true
    }

    /// Makes the picture of this size the first one; another of a different size is kept.
    fn prepare_picture(&mut self, size: [u32; 2]) -> Result<(), String> {
        const KEPT: usize = 2;
        let place = self.pictures.iter().position(|picture| picture.targets.is_for(size, &self.drawn));
        if let Some(place) = place {
            self.pictures[..=place].rotate_right(1);
            return Ok(());
        }
        let most = Targets::most_pixels(&self.device, &self.drawn);
        if u64::from(size[0]) * u64::from(size[1]) > most {
            return Err(format!(
                "a picture of {} × {} pixels is too large for the device: {most} at most",
                size[0], size[1]
            ));
        }
        self.pictures.truncate(KEPT - 1);
        let targets = Targets::new(&self.device, size, &self.drawn);
        let picture = Picture {
            layers: self.g_buffer.bind(&self.device, &targets),
            groups: Groups::new(&self.device, &self.pipelines, (&self.uniforms, &self.lamps, &targets)),
            targets,
            last_camera: None,
            next_page: 0,
        };
        self.pictures.insert(0, picture);
        Ok(())
    }

    /// Hands the camera to the G-buffer: true if there is a last frame to look behind.
    fn prepare_g_buffer(&mut self, view: &ScreenView, size: [u32; 2]) -> bool {
        let Some(picture) = self.pictures.first_mut() else { return false };
        let scene = &self.geometry.scene;
        if !self.g_buffer.materials.is_for(&view.materials) {
            self.g_buffer.set_material_count(&self.device, view.materials.len());
        }
        self.g_buffer.materials.upload(&self.queue, scene, &view.materials);
        let matrix = view_projection(&view.camera, size[0] as f32 / size[1] as f32);
        let last = picture.last_camera.replace(matrix);
        let separation = self.drawn.separation * self.scene_size;
        let reference = last.unwrap_or(matrix);
        let around = wider(&view.camera, self.drawn.surround);
        let cameras = [(&view.camera, size), (&around, picture.targets.surround)];
        self.g_buffer.prepare((&self.device, &self.queue), scene, cameras, reference, separation);
        last.is_some()
    }

    fn steps(&self, shadows_anew: bool, has_last: bool) -> VecDeque<Step> {
        let Some(picture) = self.pictures.first() else { return VecDeque::new() };
        let mut steps = VecDeque::new();
        let mut add = |work, units| {
            if units > 0 {
                steps.push_back(Step::new(work, units));
            }
        };
        if shadows_anew {
            add(Work::Shadows, self.lamps.face_count());
        }
        let layers = self.drawn.layers();
        let (pixels, around) = (picture.targets.pixels(), picture.targets.surround_pixels());
        // A still frame's surfaces are the last one's; but the one after the first looks behind another frame than that did.
        let looks_back = self.drawn.second_layer == SecondLayer::LastFrame;
        let triangles = self.mesh.triangles.count();
        if self.still < 1 + u32::from(looks_back) {
            add(Work::Surface(Layer::First), triangles);
            match self.drawn.second_layer {
                SecondLayer::Off => {}
                SecondLayer::LastFrame if has_last => add(Work::Surface(Layer::BehindLast), triangles),
                _ => add(Work::Surface(Layer::BehindFirst), triangles),
            }
            if around > 0 {
                add(Work::Surface(Layer::Around), triangles);
                let behind = if layers > 1 { triangles } else { 0 };
                add(Work::Surface(Layer::BehindAround), behind);
            }
        }
        add(Work::Pixels(Dispatch::Light), (pixels + around) * layers);
        let [columns, rows] = self.drawn.grid(picture.targets.size);
        let (grid, grid_rows) = (columns * rows, picture.targets.size[0] * rows);
        let filtered = |field| [(Dispatch::Across(field), grid_rows), (Dispatch::Down(field), pixels)];
        let is_filtered = self.drawn.filter_radius(self.still) > 0;
        let mut add_filtered = |works: &[(Dispatch, u32)], field| {
            let filter = filtered(field).into_iter().filter(|_| is_filtered);
            works.iter().copied().chain(filter).for_each(|(dispatch, units)| add(Work::Pixels(dispatch), units));
        };
        if self.drawn.obscurance > 0 {
            add_filtered(&[(Dispatch::Obscure, grid)], Filtered::Obscurance);
        }
        let bounces = self.drawn.bounces as usize;
        if bounces > 0 {
            // Of the last bounce, only what is seen counts; in still frames, what it is fed from, too.
            let of_last = if picture.targets.has_tail && self.still > 0 { grid + around } else { grid };
            let units = |bounce| if bounce + 1 == bounces { of_last } else { (grid + around) * layers };
            let gathers: Vec<_> = (0..bounces).map(|bounce| (Dispatch::Gather(bounce), units(bounce))).collect();
            add_filtered(&gathers, Filtered::Light);
        }
        add(Work::Pixels(Dispatch::Show(picture.next_page)), pixels);
        steps
    }

    /// Makes one submission and waits for it: some 40 ms, and what was submitted before.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn submit(&mut self) -> Result<(), String> {
        let Some(picture) = self.pictures.first() else { return Ok(()) };
        let Some(step) = self.pace.next(&mut self.frame) else { return Ok(()) };
        // What a window has submitted is not this one's time: the pace would cut finer and finer, and wait more often.
        wait(&self.device)?;
        let started = Instant::now();
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let uniforms = ScreenUniforms { first: step.units.start, end: step.units.end, ..self.screen };
        self.queue.write_buffer(&self.uniforms.screen, 0, bytemuck::bytes_of(&uniforms));
        let passes = (&self.lamps, &self.g_buffer, &self.pipelines);
        record(&mut encoder, &step, passes, (&self.geometry, &self.mesh, picture), self.still == 0);
        self.queue.submit([encoder.finish()]);
        wait(&self.device)?;
        let taken = started.elapsed();
        self.pace.learn(&step, taken);
        let (runs, time) = &mut self.times[step.pass() as usize];
        (*runs, *time) = (*runs + 1, *time + taken);
        self.frame_time += taken;
        (self.submissions, self.longest) = (self.submissions + 1, self.longest.max(taken));
        if self.frame.is_empty() {
            self.end_frame();
        }
        Ok(())
    }

    fn end_frame(&mut self) {
        if let Some(picture) = self.pictures.first_mut() {
            picture.next_page = 1 - picture.next_page;
        }
        let is_smaller = self.known.as_ref().is_some_and(|(_, settings)| settings.frame_budget > 0);
        if is_smaller && self.still == 0 {
            self.quality.learn(self.frame_time, Duration::from_millis(self.drawn.frame_budget.into()));
        }
    }

    /// Reads the last frame back. Waits for the card.
    ///
    /// # Errors
    /// One line, if the device was lost, or nothing was drawn.
    pub fn fields(&self) -> Result<ScreenFields, String> {
        let picture = self.pictures.first().ok_or("nothing was drawn in screen space")?;
        let targets = &picture.targets;
        let pixels = targets.pixels() as usize;
        let read = |buffer| read_copy::<Vec4>(&self.device, &self.queue, buffer);
        let (direct, indirect, obscurance) =
            (read(&targets.direct)?, read(&targets.indirect)?, read(&targets.obscurance)?);
        let stored = read_depths(&self.device, &self.queue, &targets.depths.texture, targets.layers)?;
        // Reversed: nothing is at 0.
        let depths: Vec<f32> =
            stored.into_iter().map(|stored| if stored > 0.0 { NEAR / stored } else { 0.0 }).collect();
        Ok(ScreenFields {
            size: targets.size,
            depth: depths[..pixels].to_vec(),
            second_depth: depths[pixels..].to_vec(),
            direct: direct[..pixels].iter().map(|value| value.truncate()).collect(),
            total: (0..pixels).map(|index| (direct[index] + indirect[index]).truncate()).collect(),
            obscurance: obscurance.iter().map(|value| value.x).collect(),
        })
    }
}
