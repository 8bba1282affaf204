//! A solve: the order of the passes, and the ledger, which is all that is read back while it runs.

use std::time::{Duration, Instant};

use glam::Vec3;

use super::{
    hemicube::{FACE_COUNT, NEAR, SceneBuffers, TileLayout},
    ledger::GpuLedger,
    pace::{Batch, Pace, Submission},
    pages::PagePass,
    patches::{BatchSettings, LedgerSums, Patches, Shooter},
    readback::read,
    resources::{BindGroups, Buffers, HemicubeSet, MOST_SLOTS, Pipelines, check_size, device_bytes},
    rest::Moments,
    shaders::Shaders,
    timing::{Pass, PassTime, PassTimer},
};
use crate::{
    gpu::device::wait,
    lightmap::{Atlas, GpuSettings, ShootingOrder},
    scene::{AreaLight, Scene},
};

/// So many times the emitted power cannot wait to be shot.
const RUNAWAY: f64 = 10.0;

/// A solve on a card, submission by submission. Between two it may be left alone for any time (pause), read, or dropped.
pub struct GpuSolver {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) settings: GpuSettings,
    pub(super) patches: Patches,
    pub(super) texel_count: usize,
    pub(super) patch_area: f32,
    pub(super) bytes: u64,
    pub(super) square_metres: f64,
    pub(super) scene: SceneBuffers,
    pub(super) pipelines: Pipelines,
    pub(super) buffers: Buffers,
    pub(super) groups: BindGroups,
    pub(super) light_hemicubes: HemicubeSet,
    pub(super) hemicubes: HemicubeSet,
    pub(super) pages: PagePass,
    pub(super) paces: [Pace; 2],
    pub(super) batch: Batch,
    pub(super) from_lamps: bool,
    pub(super) lamps_done: u32,
    pub(super) ledger: GpuLedger,
    pub(super) moments: Moments,
    pub(super) timer: PassTimer,
    pub(super) submissions: u64,
    pub(super) longest: Duration,
    /// The device failed: nothing can be asked of it any more.
    pub(super) is_lost: bool,
}

impl GpuSolver {
    /// Uploads a scene. `settings` must have no problem.
    ///
    /// # Errors
    /// One line, if the lightmap is larger than the card takes or than is allowed.
    pub fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        scene: &Scene,
        atlas: &Atlas,
        light: Option<&AreaLight>,
        settings: &GpuSettings,
    ) -> Result<Self, String> {
        let patches = Patches::new(atlas, light, settings);
        let most = device.limits().max_texture_dimension_2d.min(4096);
        let resolutions = [settings.light_hemicube, settings.hemicube];
        let layouts = resolutions.map(|resolution| TileLayout::new(resolution, MOST_SLOTS, most));
        let bytes = device_bytes(&patches, scene, &layouts, settings.visibility) + PagePass::bytes(atlas);
        check_size(device, &patches, bytes, settings.device_memory)?;
        let out_of_memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let shaders = Shaders::default();
        let pipelines = Pipelines::new(device, &shaders, settings.visibility);
        let buffers = Buffers::new(device, &patches);
        let groups = BindGroups::new(device, &pipelines, &buffers);
        let scene_buffers = SceneBuffers::new(device, scene, settings.visibility);
        let [light_hemicubes, hemicubes] =
            layouts.map(|layout| HemicubeSet::new(device, &shaders, &pipelines, &buffers, (&scene_buffers, layout)));
        if pollster::block_on(out_of_memory.pop()).is_some() {
            return Err(format!("the device has no {} MiB left: ask for fewer texels", bytes.div_ceil(1 << 20)));
        }
        let square_metres = scene.frame.square_metres_per_unit();
        let emitted = patches.emitted.as_dvec3() * square_metres;
        let mut solver = Self {
            patch_area: patches.leaves().map(|group| group.area).sum::<f32>() / patches.leaves().count() as f32,
            device: device.clone(),
            queue: queue.clone(),
            settings: settings.clone(),
            texel_count: atlas.texels.len(),
            bytes,
            square_metres,
            paces: resolutions.map(|resolution| {
                Pace::new(
                    scene_buffers.draws(FACE_COUNT),
                    scene_buffers.index_count / 3 / scene_buffers.parts,
                    resolution,
                )
            }),
            scene: scene_buffers,
            pages: PagePass::new(device, &shaders, &buffers, atlas, &patches),
            light_hemicubes,
            hemicubes,
            pipelines,
            buffers,
            groups,
            patches,
            batch: Batch::default(),
            from_lamps: false,
            lamps_done: 0,
            ledger: GpuLedger { emitted, unshot: emitted, ..GpuLedger::default() },
            moments: Moments::default(),
            timer: PassTimer::new(device, queue),
            submissions: 0,
            longest: Duration::ZERO,
            is_lost: false,
        };
        solver.warm_up()?;
        Ok(solver)
    }

    /// Runs the passes once on nothing: a driver compiles them only now, and may take longer than any submission should.
    fn warm_up(&mut self) -> Result<(), String> {
        let nothing = Submission { begins: true, draws: 0..1, slots: 0..0, receivers: 0..1, completes: true };
        for from_lamps in [true, false] {
            (self.from_lamps, self.batch) = (from_lamps, Batch::new(u32::from(!from_lamps)));
            let settings = BatchSettings { end_receiver: 0, ..self.submission_settings(&nothing) };
            self.queue.write_buffer(&self.buffers.settings, 0, bytemuck::bytes_of(&settings));
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if !from_lamps {
                self.choose(&mut encoder); // there is nothing to choose
            }
            self.draw_and_receive(&mut encoder, &nothing);
            self.queue.submit([encoder.finish()]);
            self.read_ledger()?;
        }
        self.batch = Batch::default();
        self.timer = PassTimer::new(&self.device, &self.queue);
        Ok(())
    }

    /// What is known of the power.
    pub fn ledger(&self) -> &GpuLedger {
        &self.ledger
    }

    /// True once the stop rule holds: all lights have shot, and what is unabsorbed is little enough. Or once every group
    /// has shot a hundred times on average: then texels are so coarse that they reflect what was not there.
    pub fn is_done(&self) -> bool {
        let lamps_left = self.lamps_done < self.patches.lamps.len() as u32;
        let most_shooters = self.patches.lamps.len() as u64 + 100 * self.patches.groups.len() as u64;
        let is_converged = self.ledger.unabsorbed() <= f64::from(self.settings.unabsorbed);
        self.batch.is_done() && !lamps_left && (is_converged || self.ledger.shooters >= most_shooters)
    }

    /// How far the solve is, 0 to 1, by the logarithm of what is unabsorbed.
    pub fn fraction(&self) -> f32 {
        let unabsorbed = self.ledger.unabsorbed();
        if unabsorbed <= 0.0 {
            return 1.0;
        }
        (unabsorbed.ln() / f64::from(self.settings.unabsorbed).ln()).clamp(0.0, 1.0) as f32
    }

    /// Changes the stop rule: a solve that is done may have to go on.
    pub fn set_unabsorbed(&mut self, unabsorbed: f32) {
        self.settings.unabsorbed = unabsorbed;
    }

    /// True if all shooters that were chosen together have shot.
    pub fn is_between_batches(&self) -> bool {
        self.batch.is_done()
    }

    /// Changes what a submission should take. It changes no bit of the solution.
    pub fn set_submission_time(&mut self, time: Duration) {
        self.paces.iter_mut().for_each(|pace| pace.submission_time = time);
    }

    /// Submissions so far, and what the longest took.
    pub fn submissions(&self) -> (u64, Duration) {
        (self.submissions, self.longest)
    }

    /// What each pass took so far, by the device's clock; none if it has no timestamps.
    pub fn pass_times(&self) -> Option<Vec<PassTime>> {
        self.timer.times()
    }

    /// Makes the rest of a batch's submissions, or all of the next batch's.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn step(&mut self) -> Result<(), String> {
        self.submit()?;
        while !self.batch.is_done() {
            self.submit()?;
        }
        Ok(())
    }

    /// Makes one submission and waits for it: some 25 ms. The fields are whole afterwards, but for texels of the very
    /// largest maps; power of shooters that were chosen and have to wait is in the ledger as unshot.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn submit(&mut self) -> Result<(), String> {
        let done = self.submit_next();
        self.is_lost |= done.is_err();
        if self.ledger.unabsorbed() > RUNAWAY {
            return Err(format!(
                "there is {RUNAWAY} times as much light as was emitted, and it grows: that attenuation makes light out of \
                 nothing here"
            ));
        }
        done
    }

    fn submit_next(&mut self) -> Result<(), String> {
        if self.batch.is_done() {
            self.begin_batch();
        }
        let pace = &self.paces[usize::from(!self.from_lamps)];
        let submission = self.batch.next(pace, self.patches.receivers.len() as u32);
        // What a window has submitted is not this one's time: the pace would cut finer and finer, and wait more often.
        wait(&self.device)?;
        let started = Instant::now();
        let settings = self.submission_settings(&submission);
        self.queue.write_buffer(&self.buffers.settings, 0, bytemuck::bytes_of(&settings));
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if submission.begins {
            self.choose(&mut encoder);
        }
        self.draw_and_receive(&mut encoder, &submission);
        let lamps_end = self.from_lamps && self.lamps_done == self.patches.lamps.len() as u32;
        if lamps_end && self.batch.is_done() {
            let size = self.buffers.irradiance.size();
            encoder.copy_buffer_to_buffer(&self.buffers.irradiance, 0, &self.buffers.direct, 0, size);
        }
        self.timer.resolve(&mut encoder);
        self.queue.submit([encoder.finish()]);
        if submission.completes {
            self.read_ledger()?;
        } else {
            wait(&self.device)?;
        }
        let taken = started.elapsed();
        self.timer.collect(&self.device)?;
        self.paces[usize::from(!self.from_lamps)].learn(&submission, taken);
        (self.submissions, self.longest) = (self.submissions + 1, self.longest.max(taken));
        self.ledger.batches += u64::from(submission.begins);
        self.remember();
        Ok(())
    }

    /// As many shooters as were asked for; else so many that one choice pays, and few enough that they stay the
    /// brightest.
    fn begin_batch(&mut self) {
        let lamps_left = self.patches.lamps.len() as u32 - self.lamps_done;
        self.from_lamps = lamps_left > 0;
        self.batch = Batch::new(match self.from_lamps {
            true => {
                let wanted = if self.settings.batch == 0 { MOST_SLOTS } else { self.settings.batch };
                wanted.clamp(1, lamps_left.min(self.light_hemicubes.pass.layout.slots))
            }
            false => self.usual_batch(),
        });
        if self.from_lamps {
            self.lamps_done += self.batch.slots;
        }
    }

    /// Groups of a batch.
    pub(super) fn usual_batch(&self) -> u32 {
        const USUAL: u32 = 32;
        let group_count = self.patches.leaves().count() as u32;
        let wanted = if self.settings.batch == 0 { USUAL.min(group_count / 32) } else { self.settings.batch };
        wanted.clamp(1, group_count.min(self.hemicubes.pass.layout.slots).max(1))
    }

    fn set(&self) -> &HemicubeSet {
        if self.from_lamps { &self.light_hemicubes } else { &self.hemicubes }
    }

    fn submission_settings(&self, submission: &Submission) -> BatchSettings {
        let layout = self.set().pass.layout;
        BatchSettings {
            receiver_count: self.patches.receivers.len() as u32,
            group_count: self.patches.groups.len() as u32,
            slot_count: self.batch.slots,
            resolution: layout.resolution,
            tiles_per_row: layout.tiles_per_row,
            near: NEAR,
            bias: self.settings.bias,
            filtered: u32::from(!self.settings.no_filter),
            first_slot: submission.slots.start,
            end_slot: submission.slots.end,
            first_receiver: submission.receivers.start,
            end_receiver: submission.receivers.end,
            shooter_count: self.ledger.shooters as u32,
            attenuation: self.settings.attenuation as u32,
            patch_area: self.patch_area,
            ..BatchSettings::default()
        }
    }

    /// The next lamps, or the groups of the most unshot power, become the batch's shooters.
    fn choose(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let slots = self.batch.slots;
        if self.from_lamps {
            let stride = size_of::<Shooter>() as u64;
            let (first, bytes) = (u64::from(self.lamps_done - slots) * stride, u64::from(slots) * stride);
            encoder.copy_buffer_to_buffer(&self.buffers.lamps, first, &self.buffers.shooters, 0, bytes);
        }
        let mut pass = self.timer.compute(encoder, Pass::Choose);
        if !self.from_lamps {
            let tiles = (self.patches.groups.len() as u32).div_ceil(256);
            dispatch(&mut pass, &self.pipelines.find_power, &self.groups.find_power, tiles);
            dispatch(&mut pass, &self.pipelines.find_best, &self.groups.find_best, tiles);
            let (choose, group) = match self.settings.order {
                ShootingOrder::Brightest => (&self.pipelines.choose, &self.groups.choose),
                ShootingOrder::Mesh => (&self.pipelines.choose_mesh, &self.groups.choose_mesh),
            };
            dispatch(&mut pass, choose, group, 1);
            dispatch(&mut pass, &self.pipelines.take, &self.groups.take, slots);
        }
        dispatch(&mut pass, &self.pipelines.faces, &self.groups.faces, (slots * FACE_COUNT).div_ceil(64));
    }

    /// Hemicubes, then what their shooters give, as far as the submission goes.
    fn draw_and_receive(&mut self, encoder: &mut wgpu::CommandEncoder, submission: &Submission) {
        let Self { light_hemicubes, hemicubes, timer, pipelines, groups, buffers, scene, .. } = self;
        let set = if self.from_lamps { light_hemicubes } else { hemicubes };
        if !submission.draws.is_empty() {
            let drawn = (submission.draws.clone(), submission.begins);
            set.pass.draw(encoder, scene, &buffers.faces, drawn, timer.render(Pass::Hemicubes));
        }
        if !submission.receivers.is_empty() {
            let workgroups = (submission.receivers.len() as u32).div_ceil(64);
            let mut pass = timer.compute(encoder, Pass::Receive);
            dispatch(&mut pass, &pipelines.receive, &set.receive, workgroups);
        }
        if submission.completes {
            let mut pass = timer.compute(encoder, Pass::Ledger);
            dispatch(&mut pass, &pipelines.find_lost, &set.lost, submission.slots.len() as u32);
            dispatch(&mut pass, &pipelines.add_up, &groups.add_up, 1);
            drop(pass);
            let bytes = size_of::<LedgerSums>() as u64;
            encoder.copy_buffer_to_buffer(&buffers.ledger, 0, &buffers.ledger_read, 0, bytes);
        }
    }

    fn read_ledger(&mut self) -> Result<(), String> {
        let sums: LedgerSums = read(&self.device, &self.buffers.ledger_read)?[0];
        let watts = |power: Vec3| power.as_dvec3() * self.square_metres;
        let lamps = self.patches.lamps[self.lamps_done as usize..].iter();
        let waiting: Vec3 = lamps.map(|lamp| lamp.area * lamp.radiosity).sum();
        self.ledger = GpuLedger {
            emitted: self.ledger.emitted,
            arrived: watts(sums.arrived),
            absorbed: watts(sums.arrived - sums.reflected),
            escaped: watts(sums.escaped),
            on_backs: watts(sums.on_backs),
            unshot: watts(sums.unshot + waiting),
            shooters: u64::from(sums.shooters),
            batches: self.ledger.batches,
        };
        Ok(())
    }

    /// Takes other shaders. Where one does not compile, all of the old ones stay.
    ///
    /// # Errors
    /// The compiler's message.
    pub fn reload(&mut self, shaders: &Shaders) -> Result<(), String> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let pipelines = Pipelines::new(&self.device, shaders, self.settings.visibility);
        let groups = BindGroups::new(&self.device, &pipelines, &self.buffers);
        let sets = [&self.light_hemicubes, &self.hemicubes]
            .map(|set| set.reloaded(&self.device, shaders, &pipelines, (&self.buffers, &self.scene)));
        let page_passes = self.pages.passes(&self.device, shaders, &self.buffers);
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(format!("the old shaders stay: {error}"));
        }
        self.pages.set_passes(page_passes);
        (self.pipelines, self.groups) = (pipelines, groups);
        [self.light_hemicubes, self.hemicubes] = sets;
        Ok(())
    }
}

fn dispatch(pass: &mut wgpu::ComputePass<'_>, pipeline: &wgpu::ComputePipeline, group: &wgpu::BindGroup, count: u32) {
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, group, &[]);
    pass.dispatch_workgroups(count, 1, 1);
}
