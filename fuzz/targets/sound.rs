//! What must hold of every scene that is read.

use std::sync::Arc;

use radiosity::{
    scene::{LoadOptions, load},
    solver::{Monitor, Problem, SolveSettings, solve},
    trace::Tracer,
};

/// Reads a scene from two texts. A small one is solved with a few rays: its field is finite and nowhere negative.
pub fn check_load(obj: &str, mtl: &str) {
    let options = LoadOptions::default();
    let scene = match load::load_from_memory("any", obj, mtl, &options) {
        Ok(scene) => scene,
        Err(error) => {
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
            return;
        }
    };
    let mesh = &scene.mesh;
    assert!(mesh.positions.iter().all(|position| position.abs().max_element() <= 1.0));
    assert!(mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
    assert!(mesh.triangles.iter().flatten().all(|&vertex| (vertex as usize) < mesh.positions.len()));
    if mesh.triangles.len() > 64 {
        return;
    }
    let scene = Arc::new(scene);
    let tracer = Arc::new(Tracer::new(Arc::clone(&scene)));
    let settings = SolveSettings { rays: 4, bounces: Some(2), light_rays: 2, ..SolveSettings::even() };
    if let Ok(problem) = Problem::new(scene, tracer, options, None, settings) {
        let solved = solve(&problem, &Monitor::new(&problem.tessellation, None));
        for value in solved.solution.bounces.iter().flatten() {
            assert!(value.is_finite() && value.min_element() >= 0.0, "{value}");
        }
    }
}
