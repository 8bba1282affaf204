//! What a student's function did that it must not do, and which function it was.

use std::{
    fmt::{self, Display, Formatter},
    panic::{AssertUnwindSafe, catch_unwind},
};

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::student::{Receiver, World};

/// The first time that one function failed in a solve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// The function of `student`, by its name.
    pub function: String,
    /// The vertex whose irradiance was wanted.
    pub vertex: u32,
    /// What the function was given.
    pub input: String,
    /// What it did: a panic with its message, or the value that it returned.
    pub problem: String,
}

impl Display for Fault {
    fn fmt(&self, formatter: &mut Formatter) -> fmt::Result {
        write!(formatter, "{} at vertex {}, given {}: {}", self.function, self.vertex, self.input, self.problem)
    }
}

/// So many sample points are tried to find the function that is to blame.
const MOST_INPUTS: usize = 4096;

/// What a call returns, or the message of its panic.
pub fn caught<Output>(call: impl FnOnce() -> Output) -> Result<Output, String> {
    catch_unwind(AssertUnwindSafe(call)).map_err(|payload| {
        let text = payload.downcast_ref::<&str>().map(|text| String::from(*text));
        text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| String::from("no message"))
    })
}

/// Irradiance from a student's function, or what was wrong with it: a panic, a number that is not finite or negative.
pub(super) fn irradiance(
    name: &'static str,
    world: &World,
    receiver: &Receiver,
    call: impl FnOnce() -> Vec3,
) -> Result<Vec3, Fault> {
    match problem_of(call, Vec3::is_finite, |value| value.min_element() >= 0.0) {
        Ok(value) => Ok(value),
        Err(problem) => {
            let outer = || {
                let place = receiver.point.origin;
                (name, format!("a receiver at {place:.4} (local units) with normal {:.4}", receiver.normal()), problem)
            };
            let inner = caught(|| inner_problem(world, receiver)).ok().flatten();
            let (function, input, problem) = inner.unwrap_or_else(outer);
            Err(Fault { function: String::from(function), vertex: receiver.vertex, input, problem })
        }
    }
}

fn problem_of<Output: std::fmt::Debug + Copy>(
    call: impl FnOnce() -> Output,
    is_finite: impl Fn(Output) -> bool,
    is_in_range: impl Fn(Output) -> bool,
) -> Result<Output, String> {
    match caught(call) {
        Err(message) => Err(format!("it panics: {message}")),
        Ok(value) if !is_finite(value) => Err(format!("it returns {value:?}, which is not finite")),
        Ok(value) if !is_in_range(value) => Err(format!("it returns {value:?}, which is negative")),
        Ok(value) => Ok(value),
    }
}

/// The function inside that is to blame, with its input and what it does: each is called with what it gets at this
/// receiver.
fn inner_problem(world: &World, receiver: &Receiver) -> Option<(&'static str, String, String)> {
    let functions = world.functions;
    let any = |_: Vec3| true;
    let normal = receiver.normal();
    let named = |name, input: String, problem: Result<(), String>| problem.err().map(|problem| (name, input, problem));
    let basis = problem_of(|| (functions.form_basis)(normal), |basis| basis.is_finite(), |_| true).map(drop);
    let from_basis = named("form_basis", format!("normal {normal:?}"), basis);
    let at_point = |point: Vec2| {
        let direction = problem_of(|| (functions.square_to_cosine_hemisphere)(point), Vec3::is_finite, any).map(drop);
        named("square_to_cosine_hemisphere", format!("point {point:?}"), direction)
    };
    let on_light = |point: Vec2| {
        let light = world.light.as_ref()?;
        let is_finite = |sample: crate::student::LightSample| {
            sample.position.is_finite() && sample.normal.is_finite() && sample.pdf_area.is_finite()
        };
        let is_in_range = |sample: crate::student::LightSample| sample.pdf_area >= 0.0;
        let sample = problem_of(|| (functions.sample_area_light)(light, point), is_finite, is_in_range).map(drop);
        named("sample_area_light", format!("point {point:?}"), sample)
    };
    let hemisphere =
        || caught(|| world.hemisphere_points(receiver).take(MOST_INPUTS).collect::<Vec<_>>()).unwrap_or_default();
    let light = || caught(|| world.light_points(receiver).take(MOST_INPUTS).collect::<Vec<_>>()).unwrap_or_default();
    from_basis
        .or_else(|| hemisphere().into_iter().find_map(at_point))
        .or_else(|| light().into_iter().find_map(on_light))
        .or_else(|| inner_of_hits(world, receiver, &hemisphere()))
}

/// The functions that are called for what a ray met.
fn inner_of_hits(world: &World, receiver: &Receiver, points: &[Vec2]) -> Option<(&'static str, String, String)> {
    let functions = world.functions;
    let basis = caught(|| (functions.form_basis)(receiver.normal())).ok()?;
    points.iter().find_map(|&point| {
        let direction = basis * caught(|| (functions.square_to_cosine_hemisphere)(point)).ok()?;
        let hit = receiver.point.ray(direction).and_then(|ray| world.trace(&ray))?;
        let positive = |value: Vec3| value.min_element() >= 0.0;
        let interpolate = || (functions.interpolate_barycentric)([Vec3::ONE; 3], hit.barycentric);
        if let Err(problem) = problem_of(interpolate, Vec3::is_finite, positive) {
            return Some(("interpolate_barycentric", format!("(u, v) = {:?}", hit.barycentric), problem));
        }
        if let Some(index) = hit.material.reflectance_texture {
            let texture = &world.scene.textures[index as usize];
            let read = || (functions.sample_texture)(texture.size(), texture.texels(), hit.texcoord);
            if let Err(problem) = problem_of(read, Vec3::is_finite, positive) {
                return Some(("sample_texture", format!("{}, {:?}", texture.name, hit.texcoord), problem));
            }
        }
        let reflectance = || (functions.surface_reflectance)(world, &hit);
        let problem = problem_of(reflectance, Vec3::is_finite, positive).err()?;
        Some(("surface_reflectance", format!("material {}", hit.material.name), problem))
    })
}
