//! The screen-space view on a thread of its own, which shares the window's device: the window goes on whatever it takes.
//!
//! It draws the newest wish, then adds still frames to it; views show the last finished frame, from where that looked.

use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    thread::JoinHandle,
    time::Duration,
};

use super::{elements::Elements, results::Field};
use crate::{
    check::picture_errors::{PictureErrors, PictureTruth},
    gpu::{
        ViewGeometry,
        lightmap::timing::PassTime,
        mesh_buffers::MeshBuffers,
        screen_space::{ScreenRenderer, ScreenSettings, ScreenView, ShownBuffer},
    },
    scene::Camera,
    solver::monitor::locked,
};

/// Still frames that are added up; then it rests.
const MOST_STILL: u32 = 64;
/// Frames that are judged.
const JUDGED: [u32; 2] = [8, MOST_STILL];
/// What a submission should take here, where the window's own wait behind it.
const SUBMISSION_TIME: Duration = Duration::from_millis(25);

/// What is drawn with.
pub struct ScreenInput {
    /// The window's device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The elements.
    pub geometry: Arc<ViewGeometry>,
    /// Their buffers, which the views have made.
    pub mesh: Arc<MeshBuffers>,
}

/// What is to be drawn.
#[derive(Clone)]
pub struct ScreenRequest {
    /// Camera, size, light and materials.
    pub view: ScreenView,
    /// How.
    pub settings: ScreenSettings,
    /// What is shown of it, and its layer.
    pub shown: (ShownBuffer, u32),
    /// The solution that judges it: its elements, direct and all irradiance at their vertices.
    pub judge: Option<(Elements, [Field; 2])>,
}

impl ScreenRequest {
    /// True if another picture is to be drawn than by the other, whatever is shown of it.
    fn moves(&self, other: &Self) -> bool {
        !self.view.is_same(&other.view) || self.settings != other.settings
    }

    fn is_same(&self, other: &Self) -> bool {
        let same_judge = match (&self.judge, &other.judge) {
            (Some((_, a)), Some((_, b))) => Arc::ptr_eq(&a[1], &b[1]),
            (None, None) => true,
            _ => false,
        };
        !self.moves(other) && self.shown == other.shown && same_judge
    }
}

/// A finished frame.
#[derive(Clone)]
pub struct ShownScreen {
    /// Its page, and columns and rows of it.
    pub page: wgpu::Buffer,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Where it looked from.
    pub camera: Camera,
    /// What it shows.
    pub buffer: ShownBuffer,
    /// Counts the frames.
    pub version: u64,
    /// Frames that it is a mean of.
    pub still: u32,
    /// What it took.
    pub frame_time: Duration,
    /// What each of its passes took.
    pub times: Vec<PassTime>,
    /// How far it is from the solution, once still frames were added up.
    pub errors: Option<PictureErrors>,
}

#[derive(Default)]
struct Shared {
    ended: AtomicBool,
    request: Mutex<Option<ScreenRequest>>,
    shown: Mutex<Option<ShownScreen>>,
    failure: Mutex<Option<String>>,
}

/// The thread. Dropping it ends it, after the submission that it waits for: a program that ended before its thread had let
/// go of the device would crash in the driver.
pub struct ScreenJob {
    thread: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
    geometry: Arc<ViewGeometry>,
}

impl ScreenJob {
    /// Starts it; `wake` is called after each frame.
    ///
    /// # Errors
    /// If no thread can be made.
    pub fn start(input: ScreenInput, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let (of_thread, geometry) = (Arc::clone(&shared), Arc::clone(&input.geometry));
        let thread = std::thread::Builder::new().name(String::from("screen space")).spawn(move || {
            if let Err(problem) = run(&input, &of_thread, &wake) {
                *locked(&of_thread.failure) = Some(problem);
                wake();
            }
        })?;
        Ok(Self { thread: Some(thread), shared, geometry })
    }

    /// True if it draws this geometry.
    pub fn is_for(&self, geometry: &Arc<ViewGeometry>) -> bool {
        Arc::ptr_eq(&self.geometry, geometry)
    }

    /// What it is to draw from now on.
    pub fn request(&self, request: ScreenRequest) {
        *locked(&self.shared.request) = Some(request);
    }

    /// The last finished frame.
    pub fn shown(&self) -> Option<ShownScreen> {
        locked(&self.shared.shown).clone()
    }

    /// Why it has ended by itself, once.
    pub fn failure(&self) -> Option<String> {
        locked(&self.shared.failure).take()
    }
}

impl Drop for ScreenJob {
    fn drop(&mut self) {
        self.shared.ended.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            // What it panicked of was printed.
            let _ = thread.join();
        }
    }
}

fn run(input: &ScreenInput, shared: &Shared, wake: &(impl Fn() + Send + Sync)) -> Result<(), String> {
    let mut renderer = ScreenRenderer::new((&input.device, &input.queue), &input.geometry, Arc::clone(&input.mesh));
    renderer.set_submission_time(SUBMISSION_TIME);
    let mut last: Option<ScreenRequest> = None;
    let (mut version, mut errors) = (0, None);
    while !shared.ended.load(Relaxed) {
        let request = locked(&shared.request).clone();
        let is_same = last.as_ref().zip(request.as_ref()).is_some_and(|(last, request)| last.is_same(request));
        let Some(request) = request.filter(|_| !is_same || renderer.still_frames() < MOST_STILL) else {
            std::thread::sleep(Duration::from_millis(10));
            continue;
        };
        let before = renderer.pass_times();
        renderer.show(request.shown.0, request.shown.1);
        renderer.begin(&request.view, &request.settings)?;
        let mut is_outdated = false;
        while !renderer.is_done() && !is_outdated {
            if shared.ended.load(Relaxed) {
                return Ok(());
            }
            renderer.submit()?;
            // A still frame, of full size, is not worth waiting for when something moves; a moving one is shown.
            let newest = locked(&shared.request);
            is_outdated = renderer.still_frames() > 1 && newest.as_ref().is_some_and(|newest| newest.moves(&request));
        }
        if is_outdated {
            last = None;
            continue;
        }
        let still = renderer.still_frames();
        if still == 1 {
            errors = None;
        }
        if let Some(judge) = request.judge.as_ref().filter(|_| JUDGED.contains(&still)) {
            errors = Some(judged(&renderer, &request.view, judge)?);
        }
        version += 1;
        if let Some((page, size)) = renderer.page() {
            *locked(&shared.shown) = Some(ShownScreen {
                page,
                size,
                camera: request.view.camera,
                buffer: request.shown.0,
                version,
                still,
                frame_time: renderer.frame_time(),
                times: passes_since(&before, &renderer.pass_times()),
                errors,
            });
        }
        last = Some(request);
        wake();
    }
    Ok(())
}

/// The passes that ran since then.
fn passes_since(before: &[PassTime], now: &[PassTime]) -> Vec<PassTime> {
    let since = |(now, before): (&PassTime, &PassTime)| PassTime {
        pass: now.pass,
        runs: now.runs - before.runs,
        seconds: now.seconds - before.seconds,
    };
    now.iter().zip(before).map(since).filter(|pass| pass.runs > 0).collect()
}

fn judged(
    renderer: &ScreenRenderer,
    view: &ScreenView,
    (elements, [direct, total]): &(Elements, [Field; 2]),
) -> Result<PictureErrors, String> {
    let fields = renderer.fields()?;
    let at = |triangle, place| {
        let value = |field: &Field| elements.tessellation.interpolate(field, triangle, place);
        (value(direct), value(total))
    };
    let truth = PictureTruth::new(&*elements.tracer, &view.camera, fields.size, at);
    Ok(truth.errors(&fields.direct, &fields.total))
}
