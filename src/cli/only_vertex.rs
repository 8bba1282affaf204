//! `radiosity solve --only-vertex`: every ray that the functions of src/student trace for one vertex.

use std::fmt::Write as _;

use anyhow::bail;
use glam::Vec3;

use super::{Outcome, scene_args::LoadedScene, solve};
use crate::{
    scene::{Scene, area_light::AreaLightState},
    solver::{
        Engine, Problem, SolveSettings,
        one_vertex::{Found, SeenRay, VertexRays, rays_of_vertex},
    },
    student::FUNCTIONS,
};

/// Solves as far as the bounces before the one that is wanted, then prints that one's rays at the vertex.
pub fn run(
    loaded: &LoadedScene,
    light: Option<AreaLightState>,
    settings: SolveSettings,
    vertex: u32,
    bounce: u32,
) -> anyhow::Result<Outcome> {
    let settings = SolveSettings { engine: Engine::Student, bounces: Some(bounce.saturating_sub(1)), ..settings };
    let solved = solve::solve_with_progress(loaded, light, settings.clone(), 0, true)?;
    let vertices = solved.tessellation.mesh.positions.len();
    if vertex as usize >= vertices {
        bail!("--only-vertex {vertex}: the mesh has {vertices} vertices, counted from 0");
    }
    let problem = Problem {
        scene: loaded.scene.clone(),
        tracer: solved.tracer,
        tessellation: solved.tessellation,
        load: loaded.load.clone(),
        light,
        settings,
    };
    let bounces: Vec<&[Vec3]> = solved.solution.bounces.iter().map(Vec::as_slice).collect();
    let before = if bounce == 0 { &[][..] } else { &bounces };
    print!("{}", text(&problem, &rays_of_vertex(&problem, &FUNCTIONS, before, vertex)));
    Ok(if solved.solution.info.complete { Outcome::Done } else { Outcome::Cancelled })
}

/// Positions in metres, one line a ray.
fn text(problem: &Problem, found: &VertexRays) -> String {
    let (scene, mesh) = (&problem.scene, &problem.tessellation.mesh);
    let place = |point: Vec3| {
        let metres = scene.frame.point_to_metres(point);
        format!("{:9.4} {:9.4} {:9.4}", metres.x, metres.y, metres.z)
    };
    let vertex = found.vertex as usize;
    let [position, normal] = [mesh.positions[vertex], mesh.normals[vertex]];
    let what = if found.bounce == 0 { String::from("direct light") } else { format!("bounce {}", found.bounce) };
    let mut text = format!("vertex {vertex}, {what}: at {} m, normal {normal:.4}\n", place(position));
    // Writing to a string cannot fail.
    for (number, receiver) in found.receivers.iter().enumerate() {
        let _ = writeln!(text, "receiver {number}: {} m", place(receiver.point.origin));
    }
    if found.receivers.is_empty() {
        let _ = writeln!(text, "it is buried: no rays");
    }
    let _ = writeln!(text, "{:>5}  {:29}  {:29}  what came of it", "ray", "from [m]", "direction");
    for (number, seen) in found.rays.iter().enumerate() {
        let Vec3 { x, y, z } = seen.ray.direction;
        let (from, outcome) = (place(seen.ray.origin), outcome(scene, seen));
        let _ = writeln!(text, "{number:5}  {from}  {x:9.4} {y:9.4} {z:9.4}  {outcome}");
    }
    let _ = match &found.irradiance {
        Ok(value) => writeln!(text, "irradiance {:.5} {:.5} {:.5} W/m2", value.x, value.y, value.z),
        Err(fault) => writeln!(text, "no irradiance: {fault}"),
    };
    text
}

fn outcome(scene: &Scene, seen: &SeenRay) -> String {
    let metres = |distance: f32| f64::from(distance) * scene.frame.metres_per_unit;
    match seen.found {
        Found::Blocked(is_blocked) => {
            let verdict = if is_blocked { "blocked" } else { "free" };
            format!("{verdict} up to {:.4} m", metres(seen.ray.max_distance))
        }
        Found::Met(None) => String::from("meets nothing"),
        Found::Met(Some(hit)) => {
            let side = if hit.front { "" } else { ", from behind" };
            let material = &scene.material(hit.triangle).name;
            format!("triangle {} ({material}) at {:.4} m{side}", hit.triangle, metres(hit.distance))
        }
    }
}
