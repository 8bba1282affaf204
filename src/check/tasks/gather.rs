//! What a gather of one bounce gives in a small scene, right or with one of the known mistakes.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Vec2, Vec3};

use super::{
    bounce::FUNCTION,
    probe::{Problem, Trial, call, quiet},
    stage::{Estimate, POINTS, Piece, Stage, Witness, estimate, turned_back},
};
use crate::{
    check::closed_form::polygon_irradiance,
    scene::mesh::interpolate,
    student::{Receiver, World},
};

/// A scene, a receiver, and the irradiance of the bounce before at every vertex.
pub(super) struct Case {
    pub stage: Stage,
    pub receiver: Receiver,
    pub field: Vec<Vec3>,
}

/// A way to gather: [`Shape::default`] is the right one.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    /// How often the reflectance is multiplied in.
    reflectance: i32,
    /// Whether it is that of the receiver's own surface.
    receivers_own: bool,
    /// The density of the directions: cosθ to this power, normalised.
    cosine: i32,
    /// The axis of the hemisphere.
    axis: Axis,
    /// Whose value the first, second and third weight gets.
    corners: [usize; 3],
    /// What is made of the three values.
    corner_weights: Weights,
    /// The power of the distance that is multiplied in.
    distance: i32,
    /// Whether the receiver's own value of the bounce before is added.
    adds_own: bool,
    /// Whether rays that meet nothing are left out of the mean.
    only_hits: bool,
    /// The axis of [`Axis::Transposed`].
    transposed: Vec3,
}

#[derive(Clone, Copy, PartialEq)]
enum Axis {
    Shading,
    Geometric,
    Z,
    /// Where the transposed frame turns z to.
    Transposed,
}

#[derive(Clone, Copy, PartialEq)]
enum Weights {
    Barycentric,
    Equal,
    Nearest,
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            reflectance: 1,
            receivers_own: false,
            cosine: 1,
            axis: Axis::Shading,
            corners: [0, 1, 2],
            corner_weights: Weights::Barycentric,
            distance: 0,
            adds_own: false,
            only_hits: false,
            transposed: Vec3::Z,
        }
    }
}

impl Case {
    /// `field` gets the number of the quad and the place, before it was turned.
    pub(super) fn new(stage: Stage, receiver: Receiver, field: impl Fn(usize, Vec3) -> Vec3) -> Self {
        let mesh = &stage.tessellation.mesh;
        let mut quads = vec![0; mesh.positions.len()];
        for (element, corners) in mesh.triangles.iter().enumerate() {
            for &vertex in corners {
                quads[vertex as usize] = stage.tessellation.scene_triangle[element] as usize / 2;
            }
        }
        let places = quads.iter().zip(&mesh.positions);
        let field = places.map(|(quad, position)| field(*quad, turned_back(*position))).collect();
        Self { stage, receiver, field }
    }

    pub(super) fn estimate(&self, trial: &Trial) -> Result<Estimate, Problem> {
        self.estimate_of(trial, &[&self.field])
    }

    pub(super) fn estimate_of(&self, trial: &Trial, bounces: &[&[Vec3]]) -> Result<Estimate, Problem> {
        let world = self.stage.world(trial, None);
        let input = format_args!("a receiver at {:.3}", self.receiver.point.origin);
        estimate(FUNCTION, input, &world, |world| (trial.functions.indirect_irradiance)(world, &self.receiver, bounces))
    }

    /// What gathering in this shape gives.
    pub(super) fn expected(&self, shape: &Shape) -> Vec3 {
        let mut receiver = self.receiver;
        receiver.point.shading_normal = match shape.axis {
            Axis::Shading => receiver.point.shading_normal,
            Axis::Geometric => receiver.point.geometric_normal,
            Axis::Z => Vec3::Z,
            Axis::Transposed => shape.transposed,
        };
        let own = self.reflectance_of(receiver.point.triangle);
        let (mut sum, mut hits) = (Vec3::ZERO, 0.0);
        for piece in self.stage.pieces() {
            let triangle = self.stage.tessellation.scene_triangle[piece.element as usize];
            let weight = weight(&receiver, &piece, shape);
            // A surface does not see itself, though a hemisphere about a wrong axis reaches below it.
            if weight <= 0.0 || triangle / 2 == receiver.point.triangle / 2 {
                continue;
            }
            let hit = self.reflectance_of(triangle);
            let reflectance = if shape.receivers_own { own } else { hit };
            sum += weight * reflectance.powf(shape.reflectance as f32) * self.value(&piece, shape);
            hits += weight;
        }
        let mean = if shape.only_hits { sum / hits } else { sum };
        mean + if shape.adds_own { self.field[receiver.vertex as usize] } else { Vec3::ZERO }
    }

    fn value(&self, piece: &Piece, shape: &Shape) -> Vec3 {
        let values =
            self.stage.tessellation.mesh.triangles[piece.element as usize].map(|vertex| self.field[vertex as usize]);
        let Vec2 { x: u, y: v } = piece.barycentric;
        let place = match shape.corner_weights {
            Weights::Barycentric => piece.barycentric,
            Weights::Equal => Vec2::splat(1.0 / 3.0),
            Weights::Nearest if u >= v && u >= 1.0 - u - v => Vec2::X,
            Weights::Nearest if v >= u && v >= 1.0 - u - v => Vec2::Y,
            Weights::Nearest => Vec2::ZERO,
        };
        interpolate(shape.corners.map(|corner| values[corner]), place)
    }

    fn reflectance_of(&self, triangle: u32) -> Vec3 {
        self.stage.scene.material(triangle).reflectance
    }
}

/// The part of the rays that meets a piece: its form factor, for directions of density cosθ/π.
fn weight(receiver: &Receiver, piece: &Piece, shape: &Shape) -> f32 {
    let (origin, cosine) = (receiver.point.origin, shape.cosine);
    let factor = |normal| FRAC_1_PI * polygon_irradiance(origin, normal, &piece.corners, Vec3::ONE).x;
    let offset = piece.corners.into_iter().sum::<Vec3>() / 3.0 - origin;
    if cosine == 1 {
        return factor(receiver.normal()) * offset.length().powi(shape.distance);
    }
    let direction = offset.normalize_or_zero();
    let height = direction.dot(receiver.normal());
    let solid_angle = PI * factor(direction);
    if height > 0.0 { solid_angle * height.powi(cosine) * (cosine + 1) as f32 / TAU } else { 0.0 }
}

/// Other values for the same three corners, in all wrong orders.
const ORDERS: [[usize; 3]; 8] =
    [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0], [0, 0, 0], [1, 1, 1], [2, 2, 2]];

/// Known mistakes that are more than a factor, and what to say.
fn shapes() -> Vec<(Shape, &'static str)> {
    let right = Shape::default();
    let mut shapes = vec![
        (right, ""),
        (Shape { reflectance: 0, ..right }, "the reflectance is missing: what arrives at the hit is not all sent on"),
        (Shape { reflectance: 2, ..right }, "the reflectance is multiplied in twice"),
        (
            Shape { receivers_own: true, ..right },
            "the reflectance is that of the receiver's own surface: it must be that of the surface that the ray meets",
        ),
        (
            Shape { adds_own: true, ..right },
            "direct light at the receiver is added: this bounce alone is wanted, the solver sums the bounces",
        ),
        (
            Shape { only_hits: true, ..right },
            "the sum is divided by the number of rays that meet something: the others count as rays that bring 0",
        ),
        (
            Shape { cosine: 0, ..right },
            "the directions are spread evenly over the hemisphere, but weighed as cosine-weighted ones: take \
             square_to_cosine_hemisphere",
        ),
        (
            Shape { cosine: 2, ..right },
            "the directions crowd about the normal, as if the cosine counted twice: density cosθ/π, not cos²θ",
        ),
        (
            Shape { axis: Axis::Z, ..right },
            "the directions stand about +z: turn them into the receiver's frame (form_basis)",
        ),
        (
            Shape { axis: Axis::Transposed, ..right },
            "the directions are turned by the transposed frame: form_basis times the local direction, not the reverse",
        ),
        (
            Shape { distance: -2, ..right },
            "divided by the square of the distance: that is for points on a light; a ray brings radiosity undiminished",
        ),
        (Shape { distance: -1, ..right }, "divided by the distance: a ray brings radiosity undiminished"),
        (
            Shape { axis: Axis::Geometric, ..right },
            "the directions stand about the triangle's normal: take the receiver's normal()",
        ),
        (
            Shape { corner_weights: Weights::Equal, ..right },
            "the mean of the three vertices is taken: weigh them by the barycentric coordinates of the hit",
        ),
    ];
    let order = "the values of the vertices are interpolated in the wrong order: the weights are 1-u-v, u, v";
    let single = "the value of one vertex alone is taken: weigh all three by the barycentric coordinates of the hit";
    shapes.push((Shape { corner_weights: Weights::Nearest, ..right }, single));
    shapes.extend(
        ORDERS.map(|corners| (Shape { corners, ..right }, if corners[0] == corners[1] { single } else { order })),
    );
    shapes
}

/// What is left of the density cos²θ if the cosine is multiplied in once more than it is divided by.
const COSINE_AGAIN: f32 = 2.0 / 3.0;

/// Factors that are wrong alike in every scene.
const FACTORS: [(f32, &str); 13] = [
    (1.0, ""),
    (PI, "multiplied by π: the π of the density and that of B = π L cancel"),
    (FRAC_1_PI, "divided by π: the π of the density and that of B = π L cancel"),
    (PI * PI, "multiplied by π twice"),
    (FRAC_1_PI * FRAC_1_PI, "divided by π twice"),
    (POINTS as f32, "the sum is not divided by the number of rays"),
    (1.0 / POINTS as f32, "divided by the number of rays twice"),
    (COSINE_AGAIN, "multiplied by the mean of a cosine"),
    (2.0, "twice too bright in every scene (a uniform hemisphere's density 1/2π?)"),
    (0.5, "half as bright as it should be in every scene"),
    (3.0, "three times too bright: a sum of three vertices where their weights sum to 1?"),
    (TAU, "multiplied by 2π: that is for directions spread evenly, with their cosine"),
    (POINTS as f32 * PI, "multiplied by π, and the sum is not divided by the number of rays"),
];

/// The known mistake that explains what the function gives in all these scenes.
pub(super) fn mistake(trial: &Trial, cases: &[(Case, Vec3)]) -> Option<String> {
    let found: Vec<Estimate> = cases.iter().filter_map(|(case, _)| case.estimate(trial).ok()).collect();
    if found.len() < cases.len() {
        return None;
    }
    let mut best: Option<(f32, String)> = None;
    for (mut shape, text) in shapes() {
        let gathered: Vec<Vec3> = cases
            .iter()
            .map(|(case, _)| {
                shape.transposed = transposed(trial, case);
                case.expected(&shape)
            })
            .collect();
        for (factor, factor_text) in FACTORS {
            let distances = found.iter().zip(&gathered).map(|(found, wrong)| found.distance(factor * *wrong));
            let worst = distances.fold(0.0, f32::max);
            let texts = if shape.cosine == 2 && factor == COSINE_AGAIN {
                vec!["the cosine counts twice: it is in the density of the directions, and must not be multiplied in"]
            } else {
                [text, factor_text].into_iter().filter(|text| !text.is_empty()).collect()
            };
            if worst <= 1.0 && !texts.is_empty() && best.as_ref().is_none_or(|(least, _)| worst < *least) {
                best = Some((worst, texts.join("; and ")));
            }
        }
    }
    best.map(|(_, text)| text)
}

/// The axis that the transposed frame of the function under test has at a receiver.
fn transposed(trial: &Trial, case: &Case) -> Vec3 {
    let basis = quiet(|| (trial.functions.form_basis)(case.receiver.normal()));
    basis.map_or(Vec3::Z, |basis| basis.transpose() * Vec3::Z)
}

/// Whether any ray is traced at a receiver.
pub(super) fn traces(trial: &Trial, case: &Case) -> bool {
    let witness = Witness::new(&case.stage);
    let world = World { tracer: &witness, ..case.stage.world(trial, None) };
    let _ = call(FUNCTION, "", || (trial.functions.indirect_irradiance)(&world, &case.receiver, &[&case.field]));
    !witness.rays().is_empty()
}
