//! The rays that a student's functions trace for one vertex, drawn over the view.

use std::sync::Arc;

use egui::{Color32, Painter, Rect, Stroke};
use glam::Vec3;

use super::{App, light_handles::on_screen, results::Field};
use crate::{
    scene::Camera,
    solver::one_vertex::{Found, SeenRay, VertexRays, rays_of_vertex},
    student::FUNCTIONS,
};

/// Rays that are drawn at most; of more, an even choice.
const MOST_DRAWN: usize = 512;
/// How long a ray that meets nothing is drawn, in local units.
const OPEN_LENGTH: f32 = 0.5;

/// Which rays are wanted, and the rays once they are traced.
#[derive(Default)]
pub struct VertexRaysView {
    /// Whether they are drawn.
    pub show: bool,
    /// Of which bounce; 0 is direct light.
    pub bounce: usize,
    /// The rays.
    pub rays: Option<VertexRays>,
    /// Direct light of the solution that they belong to.
    solution: Option<Field>,
}

impl App {
    /// Traces the rays of the vertex nearest to the clicked point, if they are to be drawn and are not there yet.
    pub(super) fn trace_rays_of_vertex(&mut self) {
        let view = &mut self.assignment.rays;
        let (Some(picked), Some(results), true) = (self.picked, &self.results, view.show) else { return };
        let elements = &results.elements;
        let vertex = picked.nearest_vertex(elements);
        let bounce = view.bounce.min(results.bounces.len());
        let solution = results.bounces.first();
        let same_solution = match (&view.solution, solution) {
            (Some(known), Some(now)) => Arc::ptr_eq(known, now),
            (known, now) => known.is_none() && now.is_none(),
        };
        if same_solution && view.rays.as_ref().is_some_and(|rays| (rays.vertex, rays.bounce) == (vertex, bounce)) {
            return;
        }
        let problem = elements.problem(&results.input);
        let before: Vec<&[Vec3]> = results.bounces[..bounce].iter().map(|field| field.as_slice()).collect();
        view.rays = Some(rays_of_vertex(&problem, &FUNCTIONS, &before, vertex));
        view.solution = solution.cloned();
    }
}

/// Draws the rays in one view.
pub(super) fn draw(painter: &Painter, rect: Rect, camera: &Camera, rays: &VertexRays) {
    for seen in rays.rays.iter().step_by(rays.rays.len().div_ceil(MOST_DRAWN).max(1)) {
        let (brings_light, length) = end(seen);
        let ends = [seen.ray.origin, seen.ray.origin + length * seen.ray.direction];
        if let [Some(from), Some(to)] = ends.map(|end| on_screen(rect, camera, end)) {
            painter.line_segment([from, to], Stroke::new(1.0, colour(brings_light).gamma_multiply(0.6)));
        }
    }
}

/// The colour of a ray that may bring light, or of one that brings none.
pub(super) fn colour(brings_light: bool) -> Color32 {
    if brings_light { Color32::from_rgb(255, 220, 90) } else { Color32::from_rgb(190, 60, 60) }
}

/// Whether a ray may bring light, and where it ends.
fn end(seen: &SeenRay) -> (bool, f32) {
    match seen.found {
        Found::Blocked(is_blocked) => (!is_blocked, seen.ray.max_distance.min(4.0)),
        Found::Met(None) => (false, OPEN_LENGTH),
        Found::Met(Some(hit)) => (hit.front, hit.distance),
    }
}
