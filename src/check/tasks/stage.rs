//! Small scenes made in code, and what the functions estimate in them.

use std::{
    fmt::Display,
    sync::{Arc, Mutex},
};

use glam::{EulerRot, Quat, Vec2, Vec3};

use super::probe::{Check, Failure, Problem, Trial, call};
use crate::{
    math::sequence::Sampler,
    scene::{
        AreaLight, LocalFrame, Material, Mesh, Scene, Tessellation, Texture, mesh::interpolate,
        tessellate::TessellationOptions,
    },
    solver::monitor::locked,
    student::{Functions, Receiver, World},
    trace::{Hit, Ray, RayTracer, Tracer},
    transport::VertexOrigins,
};

/// Runs of a function, each with points of its own: their mean has a standard error.
const RUNS: u16 = 32;

/// Sample points of a run.
pub(super) const POINTS: u32 = 64;

/// More standard errors than this between a mean and what is expected happen once in a million (Student's t with 31
/// degrees of freedom, both sides).
const MOST_STANDARD_ERRORS: f32 = 6.05;

/// Rounding, and the difference between a sum of small pieces and the integral.
const ROUNDING: f32 = 2e-3;

/// A parallelogram of one material: it faces along `along` × `up`.
pub(super) struct Quad {
    pub corner: Vec3,
    pub along: Vec3,
    pub up: Vec3,
    pub material: u32,
}

/// A scene with all that a gather needs.
pub(super) struct Stage {
    pub scene: Arc<Scene>,
    pub tracer: Tracer,
    pub tessellation: Tessellation,
    origins: VertexOrigins,
}

/// A turn by no special angles, so that nothing lies along an axis.
fn turn() -> Quat {
    Quat::from_euler(EulerRot::XYZ, 0.3, 0.7, -0.4)
}

/// A vector of a set-up that is described along the axes, turned away from them.
pub(super) fn turned(vector: Vec3) -> Vec3 {
    turn() * vector
}

/// [`turned`], undone.
pub(super) fn turned_back(vector: Vec3) -> Vec3 {
    turn().inverse() * vector
}

pub(super) fn turned_light(light: &AreaLight) -> AreaLight {
    AreaLight {
        centre: turned(light.centre),
        half_extent_u: turned(light.half_extent_u),
        half_extent_v: turned(light.half_extent_v),
        ..*light
    }
}

/// A material of this reflectance.
pub(super) fn matt(reflectance: Vec3) -> Material {
    Material { reflectance, ..Material::default() }
}

/// The inside of a box: floor, ceiling, and four walls, of materials 0 to 5.
pub(super) fn box_inside(low: Vec3, high: Vec3) -> Vec<Quad> {
    let size = high - low;
    let (x, y, z) = (size.x * Vec3::X, size.y * Vec3::Y, size.z * Vec3::Z);
    let sides = [(low, z, x), (low + y, x, z), (low, x, y), (low + z, y, x), (low, y, z), (low + x, z, y)];
    (0..).zip(sides).map(|(material, (corner, along, up))| Quad { corner, along, up, material }).collect()
}

impl Stage {
    /// The quads, all [`turned`].
    pub(super) fn new(quads: &[Quad], materials: Vec<Material>, textures: Vec<Texture>, subdivide: u32) -> Self {
        let mut mesh = Mesh::default();
        for quad in quads {
            let Quad { corner, along, up, .. } = *quad;
            let first = mesh.positions.len() as u32;
            for place in [corner, corner + along, corner + along + up, corner + up].map(turned) {
                // Corners that meet do so to the last bit, so that there are no cracks.
                let known = mesh.positions.iter().find(|position| position.abs_diff_eq(place, 1e-6));
                let place = *known.unwrap_or(&place);
                mesh.positions.push(place);
            }
            mesh.normals.extend([turned(along.cross(up)).normalize_or_zero(); 4]);
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            mesh.texcoords.extend([[Vec2::ZERO, Vec2::X, Vec2::ONE], [Vec2::ZERO, Vec2::ONE, Vec2::Y]]);
            mesh.material_indices.extend([quad.material; 2]);
        }
        let name = String::from("stage");
        let frame = LocalFrame::default();
        Self::of(
            Scene {
                name,
                mesh,
                materials,
                textures,
                frame,
                enclosed: Vec::new(),
                two_sided: false,
                faceted: false,
                warnings: Vec::new(),
            }
            .into(),
            subdivide,
        )
    }

    /// A scene that there is.
    pub(super) fn of(scene: Arc<Scene>, subdivide: u32) -> Self {
        let options = TessellationOptions { subdivide, max_edge: None };
        // Only meshes that are far too large are refused.
        let tessellation = Tessellation::new(&scene, &options).unwrap_or_else(|problem| panic!("{problem}"));
        let (tracer, origins) = (Tracer::new(Arc::clone(&scene)), VertexOrigins::new(&tessellation));
        Self { scene, tracer, tessellation, origins }
    }

    /// The world of the functions under test. The points are random ones, whatever the student's own are.
    pub(super) fn world<'a>(&'a self, trial: &Trial<'a>, light: Option<AreaLight>) -> World<'a> {
        World {
            scene: &self.scene,
            tracer: &self.tracer,
            tessellation: &self.tessellation,
            light,
            functions: trial.functions,
            sampler: Sampler::Random,
            seed: trial.seed,
            light_rays: POINTS,
            rays: POINTS,
        }
    }

    /// The receiver at the vertex that is nearest to `place` (before it was [`turned`]) and faces along `normal`.
    pub(super) fn receiver(&self, place: Vec3, normal: Vec3) -> Receiver {
        let (place, normal) = (turned(place), turned(normal));
        let mesh = &self.tessellation.mesh;
        let faces = |vertex: &u32| mesh.normals[*vertex as usize].dot(normal) > 0.9;
        let distance = |vertex: u32| mesh.positions[vertex as usize].distance(place);
        let vertices = (0..mesh.positions.len() as u32).filter(faces);
        let vertex = vertices.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(0);
        let mut points = Vec::new();
        self.origins.collect((&self.scene, &self.tracer), &self.tessellation, vertex, &mut points);
        Receiver { vertex, place: (0, 1), point: points[0] }
    }

    /// All elements, cut into small triangles.
    pub(super) fn pieces(&self) -> impl Iterator<Item = Piece> {
        let element_count = self.tessellation.mesh.triangles.len() as u32;
        let side: u16 = if element_count < 20 { 30 } else { 6 };
        let step = 1.0 / f32::from(side);
        let places = (0..side).flat_map(move |row| (0..side - row).map(move |column| (row, column)));
        let small = places.flat_map(move |(row, column)| {
            let low = step * Vec2::new(f32::from(column), f32::from(row));
            let lower = [low, low + step * Vec2::X, low + step * Vec2::Y];
            let upper = [low + step * Vec2::X, low + Vec2::splat(step), low + step * Vec2::Y];
            [Some(lower), (row + column + 1 < side).then_some(upper)].into_iter().flatten()
        });
        let small: Vec<[Vec2; 3]> = small.collect();
        (0..element_count).flat_map(move |element| {
            let corners = self.tessellation.mesh.corners(element);
            let piece = move |places: &[Vec2; 3]| Piece {
                element,
                corners: places.map(|place| interpolate(corners, place)),
                barycentric: (places[0] + places[1] + places[2]) / 3.0,
            };
            small.iter().map(piece).collect::<Vec<_>>()
        })
    }
}

/// A small part of an element.
pub(super) struct Piece {
    pub element: u32,
    pub corners: [Vec3; 3],
    /// Of its middle, in the element.
    pub barycentric: Vec2,
}

/// A mean over runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub mean: Vec3,
    pub standard_error: Vec3,
}

impl Estimate {
    /// Whether the mean is `expected` but for chance.
    pub(super) fn is(&self, expected: Vec3) -> bool {
        let tolerance = MOST_STANDARD_ERRORS * self.standard_error + ROUNDING * expected.abs();
        (self.mean - expected).abs().cmple(tolerance + 1e-6).all()
    }

    /// Whether the mean is close to what a wrong version would give.
    pub(super) fn is_near(&self, wrong: Vec3) -> bool {
        self.distance(wrong) <= 1.0
    }

    /// How far the mean is from what a wrong version would give, in units of what is called near.
    pub(super) fn distance(&self, wrong: Vec3) -> f32 {
        let tolerance = 4.0 * self.standard_error + 0.01 * wrong.abs() + 1e-5;
        ((self.mean - wrong).abs() / tolerance).max_element()
    }
}

/// The mean of `run` over runs of different points.
pub(super) fn estimate(
    function: &'static str,
    input: impl Display,
    world: &World,
    run: impl Fn(&World) -> Vec3,
) -> Result<Estimate, Problem> {
    let (mut sum, mut squares) = (Vec3::ZERO, Vec3::ZERO);
    let mut first = None;
    for index in 0..RUNS {
        let seed = world.seed.wrapping_mul(0x1000).wrapping_add(u64::from(index));
        let value = call(function, &input, || run(&World { seed, ..*world }))?;
        // Sums of differences: of equal values the standard error is 0.
        let difference = value - *first.get_or_insert(value);
        sum += difference;
        squares += difference * difference;
    }
    let count = f32::from(RUNS);
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(Vec3::ZERO) / (count - 1.0);
    let mean = mean + first.unwrap_or_default();
    Ok(Estimate { mean, standard_error: Vec3::from(variance.to_array().map(f32::sqrt)) })
}

/// The failure of an estimate.
pub(super) fn differs(
    function: &'static str,
    test: &'static str,
    place: &str,
    found: &Estimate,
    (expected, source): (Vec3, &str),
) -> Failure {
    let measured = format!("{:.4} ± {:.4} {place}", found.mean, found.standard_error);
    Failure::new(function, test, measured, &format!("{expected:.4}: {source}"))
}

/// The points that a function takes are those of its world: others for each vertex and seed, as many as are set, and
/// none at all does no harm.
pub(super) fn takes_its_own_points(
    function: &'static str,
    world: &World,
    receiver: &Receiver,
    run: impl Fn(&World, &Receiver) -> Vec3,
) -> Check {
    // Enough that a right function that seldom finds the light finds it.
    let few = World { light_rays: 256, rays: 256, ..*world };
    let at = |world: &World, vertex| {
        let receiver = Receiver { vertex, ..*receiver };
        call(function, format_args!("vertex {vertex}"), || run(world, &receiver))
    };
    let last = world.tessellation.mesh.positions.len() as u32 - 1;
    let vertices = [0, last / 3, last / 2, last];
    let fails = |test, measured: &str, expected: &str, hint: &str| {
        Err(Failure::new(function, test, String::from(measured), expected).hint(hint).into())
    };
    let (mut of_vertices, mut of_seeds) = (Vec::new(), Vec::new());
    for vertex in vertices {
        of_vertices.push(at(&few, vertex)?);
        of_seeds.push(at(&World { seed: world.seed ^ u64::from(vertex + 1), ..few }, 0)?);
    }
    let all_equal = |values: &[Vec3]| values.iter().all(|value| *value == values[0]);
    if all_equal(&of_vertices) {
        return fails(
            "points of each vertex",
            "four vertices get the same value to the last bit at the same place",
            "other sample points at each vertex, and so other values",
            "the points are the same at every vertex (one seed for all?): neighbours err alike, which shows as patterns; \
             take the points that `world` gives for the receiver",
        );
    }
    if all_equal(&of_seeds) {
        return fails(
            "points of each seed",
            "four seeds give the same value to the last bit",
            "other sample points with each seed",
            "the seed has no part in the points: take the points that `world` gives for the receiver",
        );
    }
    if at(&World { light_rays: 1, rays: 1, ..*world }, 0)? == at(&World { light_rays: 500, rays: 500, ..*world }, 0)? {
        return fails(
            "number of points",
            "1 and 500 points give the same value to the last bit",
            "as many points as the settings say",
            "the number of points is fixed: take all that `world` gives for the receiver",
        );
    }
    let none = World { light_rays: 0, rays: 0, ..*world };
    let value = call(function, "no sample points", || run(&none, receiver)).map_err(|problem| match problem {
        Problem::Wrong(failure) => failure.hint("without points 0 is divided by 0: divide by at least 1").into(),
        other @ Problem::NotDone(_) => other,
    })?;
    if value == Vec3::ZERO {
        return Ok(());
    }
    fails("no points", &format!("{value} without sample points"), "0", "without points there is nothing to sum: 0")
}

/// A tracer that keeps the rays it is asked for, for diagnoses.
pub(super) struct Witness<'a> {
    tracer: &'a Tracer,
    rays: Mutex<Vec<Ray>>,
}

impl<'a> Witness<'a> {
    pub(super) fn new(stage: &'a Stage) -> Self {
        Self { tracer: &stage.tracer, rays: Mutex::default() }
    }

    /// The rays so far.
    pub(super) fn rays(&self) -> Vec<Ray> {
        locked(&self.rays).clone()
    }

    fn note(&self, ray: &Ray) {
        locked(&self.rays).push(*ray);
    }
}

impl RayTracer for Witness<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.note(ray);
        self.tracer.closest_hit(ray)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.note(ray);
        self.tracer.occluded(ray)
    }
}

/// A tracer that gives the same answer to every shadow ray and meets nothing.
pub(super) struct Always {
    pub occluded: bool,
}

impl RayTracer for Always {
    fn closest_hit(&self, _: &Ray) -> Option<Hit> {
        None
    }

    fn occluded(&self, _: &Ray) -> bool {
        self.occluded
    }
}

/// The direct irradiance under test.
pub(super) fn direct(functions: &Functions, world: &World, receiver: &Receiver) -> Vec3 {
    (functions.direct_irradiance)(world, receiver)
}
