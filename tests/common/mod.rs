//! What several test programs need; each uses a part of it.
#![allow(dead_code, reason = "which parts are unused differs from one test program to the next")]

#[cfg(all(feature = "gpu", feature = "reference"))]
pub(crate) mod lightmap;
#[cfg(feature = "reference")]
pub(crate) mod truths;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use radiosity::{
    scene::{LoadOptions, Scene, area_light::AreaLightState, load},
    solver::{Job, Monitor, Problem, Solution, SolveReport, SolveSettings, Solved, solve},
    trace::Tracer,
};

/// A file or folder of the shared test scenes, which lie beside the repository or where `RADIOSITY_SHARED` says.
/// None, with the reason printed, if they are absent: then a test has nothing to look at.
pub(crate) fn shared(relative: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let path = std::env::var_os("RADIOSITY_SHARED").map_or_else(beside, PathBuf::from).join(relative);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no {} (set RADIOSITY_SHARED to the folder of shared test scenes)", path.display());
    None
}

/// Reads one of the project's own scenes, such as `cornell/cornell`.
pub(crate) fn own_scene(name: &str, options: &LoadOptions) -> Arc<Scene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.obj"));
    Arc::new(load::load(&path, options).unwrap_or_else(|error| panic!("{error}")))
}

/// A problem ready to be solved.
pub(crate) fn problem(scene: &Arc<Scene>, light: Option<AreaLightState>, settings: SolveSettings) -> Problem {
    let tracer = Arc::new(Tracer::new(Arc::clone(scene)));
    Problem::new(Arc::clone(scene), tracer, LoadOptions::default(), light, settings)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Solves without watching.
pub(crate) fn solve_unwatched(problem: &Problem) -> (Solution, SolveReport) {
    let Solved { solution, report, .. } = solve_with_elements(problem);
    (solution, report)
}

/// Solves without watching; for elements that follow the light, which the solve makes.
pub(crate) fn solve_with_elements(problem: &Problem) -> Solved {
    solve(problem, &Monitor::new(&problem.tessellation, None))
}

/// The light of the Cornell box, as its state has it.
pub(crate) fn cornell_light() -> AreaLightState {
    AreaLightState {
        centre: [0.278, 0.5487, 0.2795],
        u: [0.065, 0.0, 0.0],
        v: [0.0, 0.0, 0.0525],
        radiance: [18.4, 15.6, 8.0],
    }
}

/// Cancels a job and waits for its end, which comes at once.
pub(crate) fn assert_ends_when_cancelled(job: &Job, what: &str) {
    let asked = Instant::now();
    job.monitor().cancel();
    while !job.is_finished() {
        std::thread::sleep(Duration::from_millis(1));
        assert!(asked.elapsed() < Duration::from_secs(20), "{what}: it does not end");
    }
    // A tenth of a second on an idle machine; a busy one may take its time.
    assert!(asked.elapsed() < Duration::from_millis(500), "{what}: {:?}", asked.elapsed());
}
