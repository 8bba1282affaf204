//! What each pass takes, by the device's own clock (timestamp queries), where it has one.

use serde::Serialize;

/// The passes of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Choosing shooters, and the matrices of their faces.
    Choose,
    /// Drawing hemicubes.
    Hemicubes,
    /// Receiving.
    Receive,
    /// The ledger.
    Ledger,
    /// Filling the pages that are shown.
    Pages,
}

impl Pass {
    /// All of them, in their order.
    pub const ALL: [Self; 5] = [Self::Choose, Self::Hemicubes, Self::Receive, Self::Ledger, Self::Pages];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Choose => "choose shooters",
            Self::Hemicubes => "draw hemicubes",
            Self::Receive => "receive",
            Self::Ledger => "ledger",
            Self::Pages => "pages to show",
        }
    }
}

/// What a pass took so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// The pass.
    pub pass: &'static str,
    /// How often it ran.
    pub runs: u64,
    /// Seconds on the device, all runs together.
    pub seconds: f64,
}

const QUERIES: u32 = 2 * Pass::ALL.len() as u32;

/// Takes the times; does nothing on a device without timestamps.
pub(super) struct PassTimer {
    device_side: Option<DeviceSide>,
    used: [bool; Pass::ALL.len()],
    times: [(u64, f64); Pass::ALL.len()],
}

struct DeviceSide {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
    seconds_per_tick: f64,
}

impl PassTimer {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let device_side = device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            let buffer = |usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("timestamps"),
                    size: u64::from(QUERIES) * 8,
                    usage,
                    mapped_at_creation: false,
                })
            };
            DeviceSide {
                queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("passes"),
                    ty: wgpu::QueryType::Timestamp,
                    count: QUERIES,
                }),
                resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
                read: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
                seconds_per_tick: 1e-9 * f64::from(queue.get_timestamp_period()),
            }
        });
        Self { device_side, used: Default::default(), times: Default::default() }
    }

    /// Begins a compute pass that is timed. A pass is in a submission at most once.
    pub(super) fn compute<'encoder>(
        &mut self,
        encoder: &'encoder mut wgpu::CommandEncoder,
        pass: Pass,
    ) -> wgpu::ComputePass<'encoder> {
        self.used[pass as usize] = true;
        let timestamp_writes = self.device_side.as_ref().map(|side| wgpu::ComputePassTimestampWrites {
            query_set: &side.queries,
            beginning_of_pass_write_index: Some(2 * pass as u32),
            end_of_pass_write_index: Some(2 * pass as u32 + 1),
        });
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(pass.name()), timestamp_writes })
    }

    /// What makes a render pass timed.
    pub(super) fn render(&mut self, pass: Pass) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.used[pass as usize] = true;
        self.device_side.as_ref().map(|side| wgpu::RenderPassTimestampWrites {
            query_set: &side.queries,
            beginning_of_pass_write_index: Some(2 * pass as u32),
            end_of_pass_write_index: Some(2 * pass as u32 + 1),
        })
    }

    /// Ends a submission's timed part.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(side) = &self.device_side {
            for pass in (0..self.used.len()).filter(|pass| self.used[*pass]) {
                let (first, offset) = (2 * pass as u32, 0);
                // The place that results are resolved to must be a multiple of 256 bytes: so one after the other.
                encoder.resolve_query_set(&side.queries, first..first + 2, &side.resolved, offset);
                encoder.copy_buffer_to_buffer(&side.resolved, 0, &side.read, u64::from(first) * 8, 16);
            }
        }
    }

    /// Takes the times of the last submission in, which must have ended or be waited for.
    pub(super) fn collect(&mut self, device: &wgpu::Device) -> Result<(), String> {
        let used = std::mem::take(&mut self.used);
        let Some(side) = &self.device_side else { return Ok(()) };
        let ticks: Vec<u64> = super::readback::read(device, &side.read)?;
        for (pass, (runs, seconds)) in self.times.iter_mut().enumerate().filter(|(pass, _)| used[*pass]) {
            *runs += 1;
            *seconds += ticks[2 * pass + 1].saturating_sub(ticks[2 * pass]) as f64 * side.seconds_per_tick;
        }
        Ok(())
    }

    /// What each pass took so far; none if the device has no timestamps.
    pub(super) fn times(&self) -> Option<Vec<PassTime>> {
        let named = |(pass, (runs, seconds)): (Pass, (u64, f64))| PassTime { pass: pass.name(), runs, seconds };
        self.device_side.as_ref().map(|_| Pass::ALL.into_iter().zip(self.times).map(named).collect())
    }
}
