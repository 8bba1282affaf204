//! One vertex under the magnifying glass: every ray that a student's functions trace for it, and what comes of them.

use std::sync::{Mutex, PoisonError};

use glam::Vec3;

use super::{
    faults::Fault,
    monitor::{Monitor, locked},
    solve::Problem,
    student_engine::{StudentSolve, direct_pass, indirect_pass},
};
use crate::{
    student::{Functions, Receiver},
    trace::{Hit, Ray, RayTracer},
    transport::Lights,
};

/// A ray that was traced, in local units.
#[derive(Clone, Copy, Debug)]
pub struct SeenRay {
    /// The ray.
    pub ray: Ray,
    /// What came of it.
    pub found: Found,
}

/// What came of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// It was asked what it meets first.
    Met(Option<Hit>),
    /// It was asked whether anything lies between.
    Blocked(bool),
}

/// What happened at one vertex in one bounce.
#[derive(Clone, Debug)]
pub struct VertexRays {
    /// The vertex.
    pub vertex: u32,
    /// The bounce; 0 is direct light.
    pub bounce: usize,
    /// The points that its rays start from; none if it is buried.
    pub receivers: Vec<Receiver>,
    /// Its rays, in the order in which they were traced.
    pub rays: Vec<SeenRay>,
    /// Its irradiance in this bounce [W/m²], or what a function did instead.
    pub irradiance: Result<Vec3, Fault>,
}

/// Calls the functions for one vertex. `bounces` are the bounces before the one that is wanted: none for direct light.
pub fn rays_of_vertex(problem: &Problem, functions: &Functions, bounces: &[&[Vec3]], vertex: u32) -> VertexRays {
    let monitor = Monitor::new(&problem.tessellation, None);
    let light = problem.light.map(|light| light.to_local(&problem.scene.frame));
    let lights = Lights::new(&problem.scene, light);
    let solve = StudentSolve::new(problem, functions, &monitor, &lights);
    let recorder = Recorder { tracer: solve.tracer(), rays: Mutex::default() };
    let world = solve.world(&recorder);
    let usable = solve.usable_at(vertex, &mut Vec::new());
    let receivers = solve.receivers(vertex, usable).collect();
    let irradiance = match bounces {
        [] => solve.at_vertex(&direct_pass(), &world, vertex, usable),
        _ => indirect_pass(bounces, |pass| solve.at_vertex(pass, &world, vertex, usable)),
    };
    let rays = recorder.rays.into_inner().unwrap_or_else(PoisonError::into_inner);
    VertexRays { vertex, bounce: bounces.len(), receivers, rays, irradiance }
}

/// Remembers every ray.
struct Recorder<'a> {
    tracer: &'a dyn RayTracer,
    rays: Mutex<Vec<SeenRay>>,
}

impl Recorder<'_> {
    fn note(&self, ray: &Ray, found: Found) {
        locked(&self.rays).push(SeenRay { ray: *ray, found });
    }
}

impl RayTracer for Recorder<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.tracer.closest_hit(ray);
        self.note(ray, Found::Met(hit));
        hit
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let is_blocked = self.tracer.occluded(ray);
        self.note(ray, Found::Blocked(is_blocked));
        is_blocked
    }
}
