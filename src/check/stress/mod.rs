//! Numerical stability under stress: scenes and settings from the edges of what can be given, each solved, and held to
//! what must be true of the answer.
//!
//! Of every field: all values are finite and none is negative; and no vertex gets more than eq. 5 lets it have, which is
//! the largest direct irradiance over 1 minus the largest reflectance, since a vertex's rays carry the mean of what they
//! meet. More is asked of a case where more is known.

mod cases;
mod draft;

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
    time::Instant,
};

use glam::{Vec2, Vec3};
use serde::Serialize;

use crate::{
    check::closed_form::furnace_irradiance,
    scene::{LoadOptions, Scene, load::load_from_memory},
    solver::{Monitor, Problem, Reconstruction, Reconstructor, SolveSettings, Solved, solve},
    trace::{Located, Tracer, locate_point},
    transport::visible_light::Scratch,
};
use cases::{Asked, Case};
use draft::Draft;

/// What a case came to.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What is stressed; `follow` are cases of the others, on elements that follow the light.
    pub group: &'static str,
    /// How.
    pub name: String,
    /// What must be true, besides being finite, not negative and within eq. 5's limit.
    pub asked: String,
    /// What was found.
    pub found: String,
    /// True if it is as asked.
    pub passed: bool,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// Runs the cases in turn and tells each row as it comes. `full` adds those that take seconds each.
pub fn run(full: bool, mut tell: impl FnMut(&Row)) -> Vec<Row> {
    let cases = cases::cases(full).into_iter();
    let rows = cases.map(|case| {
        let row = row(&case);
        tell(&row);
        row
    });
    rows.collect()
}

fn row(case: &Case) -> Row {
    let started = Instant::now();
    // A panic is what the test looks for, too.
    let verdict = catch_unwind(AssertUnwindSafe(|| verdict(case)));
    let verdict = verdict.unwrap_or_else(|_| Err(String::from("panicked")));
    let (passed, found) = match verdict {
        Ok(found) => (true, found),
        Err(found) => (false, found),
    };
    let (name, asked) = (case.name.clone(), case.asked.to_string());
    Row { group: case.group, name, asked, found, passed, seconds: started.elapsed().as_secs_f64() }
}

/// Ok if all is as asked; either way what was found.
fn verdict(case: &Case) -> Result<String, String> {
    let expected = match &case.asked {
        Asked::SameAs { other, .. } => Some(Answer::of(other, &case.settings, None)?),
        _ => None,
    };
    let found = Answer::of(&case.draft, &case.settings, expected.as_ref().map(|expected| &expected.places[..]))?;
    let limit = found.check_bounds()?;
    match &case.asked {
        Asked::Bounds => Ok(format!("largest {:.3} of its limit", found.largest() / limit.max(f64::MIN_POSITIVE))),
        Asked::SameAs { factor, tolerance, .. } => {
            let expected = expected.map(|expected| expected.values).unwrap_or_default();
            let difference = relative_difference(&found.values, &expected, *factor);
            within(difference <= *tolerance, format!("differs by {difference:.1e}"))
        }
        Asked::Dark => within(found.largest() == 0.0, format!("largest {:e} W/m²", found.largest())),
        Asked::DirectOnly => {
            let indirect = found.indirect;
            within(indirect == 0.0 && found.largest() > 0.0, format!("largest indirect {indirect:e} W/m²"))
        }
        Asked::Furnace { reflectance, tolerance } => {
            let expected = furnace_irradiance(std::f64::consts::PI, *reflectance, found.bounces - 1);
            let worst = found.values.iter().map(|value| (f64::from(value.x) / expected - 1.0).abs());
            let worst = worst.fold(0.0, f64::max);
            within(worst <= *tolerance, format!("off by {worst:.1e} after {} bounces", found.bounces - 1))
        }
    }
}

fn within(passed: bool, found: String) -> Result<String, String> {
    if passed { Ok(found) } else { Err(found) }
}

/// Root of the mean squared difference between `found` over `factor` and `expected`, over the mean of `expected`.
fn relative_difference(found: &[Vec3], expected: &[Vec3], factor: f64) -> f64 {
    let pairs = || found.iter().zip(expected).map(|(found, expected)| (found.as_dvec3() / factor, expected.as_dvec3()));
    let square: f64 = pairs().map(|(found, expected)| (found - expected).length_squared()).sum();
    let mean: f64 = pairs().map(|(_, expected)| expected.length()).sum();
    let count = expected.len().max(1) as f64;
    (square / count).sqrt() / (mean / count).max(f64::MIN_POSITIVE)
}

/// What a solve gave.
struct Answer {
    /// Where it is compared with another.
    places: Vec<Place>,
    /// Irradiance [W/m²] there.
    values: Vec<Vec3>,
    /// All bounces at all vertices.
    total: Vec<Vec3>,
    largest_direct: f64,
    largest_reflectance: f64,
    /// The largest sum of indirect bounces at a vertex.
    indirect: f64,
    /// Bounces computed, direct light among them.
    bounces: u32,
}

/// A place on a surface: for each scene of the same shape the same, whatever its size and place, and the order and number
/// of its triangles.
#[derive(Clone, Copy)]
struct Place {
    /// From the middle of the scene, in parts of its largest half-extent.
    position: Vec3,
    /// Unit normal.
    normal: Vec3,
}

/// The places are those of so many triangles: as many as the Cornell box has.
const COMPARED: u32 = 30;

impl Answer {
    /// Compared at `places`, or at places of its own first triangles.
    fn of(draft: &Draft, settings: &SolveSettings, places: Option<&[Place]>) -> Result<Self, String> {
        // As much as a scene may reflect.
        let load = LoadOptions { reflectance_limit: 0.999, ..LoadOptions::default() };
        let scene = load_from_memory("stress", &draft.obj, &draft.mtl, &load).map_err(|error| error.to_string())?;
        let scene = Arc::new(scene);
        let tracer = Arc::new(Tracer::new(Arc::clone(&scene)));
        let problem = Problem::new(Arc::clone(&scene), tracer.clone(), load, draft.light, settings.clone())?;
        let Solved { solution, tessellation, .. } = solve(&problem, &Monitor::new(&problem.tessellation, None));
        let reconstructor = Reconstructor::new(&scene, &*tracer, &tessellation, &solution, Reconstruction::Vertex);
        let mut scratch = Scratch::default();
        let half_extent = scene.mesh.positions.iter().fold(0.0_f32, |most, point| most.max(point.abs().max_element()));
        let places = places.map_or_else(|| places_of(&scene, half_extent), <[Place]>::to_vec);
        // A place that is not found makes the difference no number, and the case fail.
        let value = |place: &Place| match locate_point(&*tracer, &scene, place.position * half_extent, place.normal) {
            Some(Located::On(triangle, at)) => reconstructor.irradiance(triangle, at, &mut scratch).total,
            Some(Located::Enclosed) => Vec3::ZERO,
            None => Vec3::NAN,
        };
        let values = places.iter().map(value).collect();
        let largest_reflectance = scene.materials.iter().map(|material| f64::from(material.reflectance.max_element()));
        Ok(Self {
            places,
            values,
            largest_direct: largest(solution.direct()),
            largest_reflectance: largest_reflectance.fold(0.0, f64::max),
            indirect: largest(&solution.indirect()),
            bounces: solution.bounces.len() as u32,
            total: solution.total(),
        })
    }

    fn largest(&self) -> f64 {
        largest(&self.total)
    }

    /// The largest value that eq. 5 allows [W/m²], if all values are below it and proper.
    fn check_bounds(&self) -> Result<f64, String> {
        let all = || self.total.iter().chain(&self.values);
        if let Some(value) = all().find(|value| !value.is_finite()) {
            return Err(format!("irradiance {value}"));
        }
        if let Some(value) = all().find(|value| value.min_element() < 0.0) {
            return Err(format!("negative irradiance {value}"));
        }
        let limit = self.largest_direct / (1.0 - self.largest_reflectance);
        // Each bounce is rounded to 24 bits.
        let rounding = 1.0 + 1e-6 * f64::from(self.bounces);
        within(self.largest() <= limit * rounding, format!("{:e} W/m² above the limit {limit:e}", self.largest()))?;
        Ok(limit)
    }
}

fn largest(field: &[Vec3]) -> f64 {
    field.iter().map(|value| f64::from(value.max_element())).fold(0.0, f64::max)
}

/// Places of a scene's first triangles.
fn places_of(scene: &Scene, half_extent: f32) -> Vec<Place> {
    let triangles = 0..COMPARED.min(scene.mesh.triangles.len() as u32);
    let points = triangles.flat_map(|triangle| spread_points().map(move |point| (triangle, point)));
    let place = |(triangle, point)| Place {
        position: scene.mesh.position(triangle, point) / half_extent,
        normal: scene.mesh.shading_normal(triangle, point),
    };
    points.map(place).collect()
}

/// Barycentric (u, v) of ten points spread over a triangle.
fn spread_points() -> impl Iterator<Item = Vec2> {
    let rows = (0..4_u8).flat_map(|u| (0..4 - u).map(move |v| (u, v)));
    rows.map(|(u, v)| (Vec2::new(f32::from(u), f32::from(v)) + 1.0 / 3.0) / 4.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(total: Vec<Vec3>) -> Answer {
        let values = total.clone();
        Answer {
            places: Vec::new(),
            values,
            total,
            largest_direct: 1.0,
            largest_reflectance: 0.5,
            indirect: 0.0,
            bounces: 3,
        }
    }

    #[test]
    fn a_field_that_is_not_a_number_or_negative_or_above_its_limit_is_found() {
        let proper = Vec3::new(0.0, 1.0, 2.0);
        assert_eq!(answer(vec![proper]).check_bounds(), Ok(2.0));
        for (wrong, word) in [
            (Vec3::new(0.0, f32::NAN, 0.0), "irradiance"),
            (Vec3::new(0.0, f32::INFINITY, 0.0), "irradiance"),
            (Vec3::new(0.0, -1e-9, 0.0), "negative"),
            (Vec3::new(0.0, 2.001, 0.0), "above the limit"),
        ] {
            let found = answer(vec![proper, wrong]).check_bounds();
            assert!(found.as_ref().is_err_and(|found| found.contains(word)), "{wrong}: {found:?}");
        }
    }

    #[test]
    fn a_case_fails_if_its_field_differs_if_it_is_refused_or_if_it_is_lit_where_it_should_be_dark() {
        // Half the light is not the same light.
        let half = Draft::cornell().lit_by(|light| light.radiance = light.radiance.map(|value| 0.5 * value));
        let settings = SolveSettings { rays: 4, ..SolveSettings::even() };
        let asked = Asked::SameAs { other: Box::new(Draft::cornell()), factor: 1.0, tolerance: 0.4 };
        let case = |draft, asked| Case { group: "test", name: String::new(), draft, settings: settings.clone(), asked };
        let row = row(&case(half.clone(), asked));
        assert!(!row.passed && row.found.contains("differs by"), "{row:?}");
        let refused = super::row(&case(Draft { obj: String::from("nothing"), ..half }, Asked::Bounds));
        assert!(!refused.passed, "{refused:?}");
        let lit = super::row(&case(Draft::cornell(), Asked::Dark));
        assert!(!lit.passed, "{lit:?}");
    }
}
