//! GMRES: the combination of a few vectors that leaves the least residual (Saad and Schultz 1986, "GMRES: A Generalized
//! Minimal Residual Algorithm for Solving Nonsymmetric Linear Systems", algorithm 4 with Givens rotations).
//!
//! The three bands are three systems; they share each look at the rows and nothing else.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Vectors that are kept before it starts again from what it has. Bright scenes need some ten.
const MOST_VECTORS: usize = 16;

/// Elements of a vector that one task sums.
const PER_TASK: usize = 4096;

/// Vectors whose products with A are known, from one system to the next with the same A.
#[derive(Clone, Default)]
pub(super) struct Known {
    /// Pairs of z and q = A z; the q are orthonormal in each band.
    pairs: Vec<(Vec<Vec3>, Vec<Vec3>)>,
}

/// More pairs than these are not kept: the first are worth most.
const MOST_PAIRS: usize = 8;

impl Known {
    /// True if another pair is of use.
    pub(super) fn has_room(&self) -> bool {
        self.pairs.len() < MOST_PAIRS
    }

    /// Adds a vector and its product with A.
    pub(super) fn add(&mut self, mut vector: Vec<Vec3>, mut product: Vec<Vec3>) {
        for (known_vector, known_product) in &self.pairs {
            let part = dot(known_product, &product);
            add_scaled(&mut product, known_product, -part);
            add_scaled(&mut vector, known_vector, -part);
        }
        let inverse = norm(&product).map(inverse_or_zero);
        self.pairs.push((scaled(vector, inverse), scaled(product, inverse)));
    }

    /// The x that leaves the least of b - A x with what is known, and that rest.
    pub(super) fn start(&self, right_side: &[Vec3]) -> (Vec<Vec3>, Vec<Vec3>) {
        let (mut start, mut rest) = (vec![Vec3::ZERO; right_side.len()], right_side.to_vec());
        for (vector, product) in &self.pairs {
            let part = dot(product, &rest);
            add_scaled(&mut start, vector, part);
            add_scaled(&mut rest, product, -part);
        }
        (start, rest)
    }
}

/// What has been found so far of the x with A x = b.
pub(super) struct Gmres {
    /// Where it started.
    start: Vec<Vec3>,
    /// Orthonormal in each band.
    basis: Vec<Vec<Vec3>>,
    /// Columns of the triangular matrix that the rotations have made of A, in the basis.
    triangle: Vec<Vec<DVec3>>,
    rotations: Vec<(DVec3, DVec3)>,
    /// The residual in the basis, rotated; the last is what is left.
    rotated: Vec<DVec3>,
}

impl Gmres {
    /// Starts from `start`, whose residual b - A `start` is given.
    pub(super) fn new(start: Vec<Vec3>, residual: Vec<Vec3>) -> Self {
        let norm = norm(&residual);
        let basis = vec![scaled(residual, norm.map(inverse_or_zero))];
        Self { start, basis, triangle: Vec::new(), rotations: Vec::new(), rotated: vec![norm] }
    }

    /// The norm of the residual that is left, in each band.
    pub(super) fn residual(&self) -> DVec3 {
        self.rotated[self.triangle.len()].abs()
    }

    /// True once it should start again.
    pub(super) fn is_full(&self) -> bool {
        self.triangle.len() >= MOST_VECTORS
    }

    /// One vector more; `apply` multiplies by A. What it finds out goes to `known`.
    pub(super) fn step(&mut self, apply: impl FnOnce(&[Vec3]) -> Vec<Vec3>, known: &mut Known) {
        let size = self.triangle.len();
        let mut next = apply(&self.basis[size]);
        if known.has_room() {
            known.add(self.basis[size].clone(), next.clone());
        }
        let mut column = Vec::with_capacity(size + 1);
        for known in &self.basis {
            let part = dot(known, &next);
            add_scaled(&mut next, known, -part);
            column.push(part);
        }
        for (row, (cosine, sine)) in self.rotations.iter().enumerate() {
            let (upper, lower) = (column[row], column[row + 1]);
            column[row] = *cosine * upper + *sine * lower;
            column[row + 1] = *cosine * lower - *sine * upper;
        }
        let below = norm(&next);
        let length = (column[size] * column[size] + below * below).map(f64::sqrt);
        let inverse = length.map(inverse_or_zero);
        // A band that is solved stays as it is.
        let (cosine, sine) = (column[size] * inverse, below * inverse);
        column[size] = length;
        let left = self.rotated[size];
        self.rotated[size] = cosine * left;
        self.rotated.push(-sine * left);
        self.rotations.push((cosine, sine));
        self.triangle.push(column);
        self.basis.push(scaled(next, below.map(inverse_or_zero)));
    }

    /// b - A x of the [`Gmres::solution`] x.
    pub(super) fn rest(&self) -> Vec<Vec3> {
        let size = self.triangle.len();
        let mut weights = vec![DVec3::ZERO; size];
        weights.push(self.rotated[size]);
        for (row, (cosine, sine)) in self.rotations.iter().enumerate().rev() {
            let (upper, lower) = (weights[row], weights[row + 1]);
            weights[row] = *cosine * upper - *sine * lower;
            weights[row + 1] = *cosine * lower + *sine * upper;
        }
        let mut rest = vec![Vec3::ZERO; self.start.len()];
        self.basis.iter().zip(weights).for_each(|(vector, weight)| add_scaled(&mut rest, vector, weight));
        rest
    }

    /// The x with the least residual.
    pub(super) fn solution(&self) -> Vec<Vec3> {
        let size = self.triangle.len();
        let mut weights = self.rotated[..size].to_vec();
        for row in (0..size).rev() {
            let known: DVec3 = (row + 1..size).map(|column| self.triangle[column][row] * weights[column]).sum();
            weights[row] = (weights[row] - known) * self.triangle[row][row].map(inverse_or_zero);
        }
        let mut solution = self.start.clone();
        for (vector, weight) in self.basis.iter().zip(weights) {
            add_scaled(&mut solution, vector, weight);
        }
        solution
    }
}

fn inverse_or_zero(value: f64) -> f64 {
    if value > 0.0 { value.recip() } else { 0.0 }
}

/// The sum of products in each band, in f64 and in a fixed order.
pub(super) fn dot(a: &[Vec3], b: &[Vec3]) -> DVec3 {
    let part = |(a, b): (&[Vec3], &[Vec3])| a.iter().zip(b).map(|(a, b)| a.as_dvec3() * b.as_dvec3()).sum::<DVec3>();
    let parts: Vec<DVec3> = a.par_chunks(PER_TASK).zip(b.par_chunks(PER_TASK)).map(part).collect();
    parts.into_iter().sum()
}

/// The Euclidean norm in each band.
pub(super) fn norm(vector: &[Vec3]) -> DVec3 {
    dot(vector, vector).map(f64::sqrt)
}

/// Adds `weight` times `vector` to `sum`.
pub(super) fn add_scaled(sum: &mut [Vec3], vector: &[Vec3], weight: DVec3) {
    let weight = weight.as_vec3();
    sum.iter_mut().zip(vector).for_each(|(sum, value)| *sum += weight * *value);
}

fn scaled(mut vector: Vec<Vec3>, factor: DVec3) -> Vec<Vec3> {
    // In f64: a factor may be too large for f32 where the values are small.
    vector.iter_mut().for_each(|value| *value = (value.as_dvec3() * factor).as_vec3());
    vector
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected: the solution that the system was made from, to f32's rounding; and in as many steps as it has unknowns.
    #[test]
    fn a_small_system_is_solved_in_as_many_steps_as_it_has_unknowns() {
        let matrix = [[1.0, -0.3, 0.0, -0.2], [-0.1, 1.0, -0.4, 0.0], [0.0, -0.5, 1.0, -0.1], [-0.3, 0.0, -0.2, 1.0]];
        let apply = |x: &[Vec3]| -> Vec<Vec3> {
            matrix.iter().map(|row| row.iter().zip(x).map(|(entry, x)| *entry * *x).sum()).collect()
        };
        // The second band has nothing to solve.
        let expected = [[1.0, 0.0, -2.0], [3.0, 0.0, 0.5], [-1.0, 0.0, 7.0], [0.25, 0.0, 1.0]].map(Vec3::from_array);
        let mut gmres = Gmres::new(vec![Vec3::ZERO; 4], apply(&expected));
        let mut known = Known::default();
        for step in 0..4 {
            gmres.step(apply, &mut known);
            let (rest, product) = (gmres.rest(), apply(&gmres.solution()));
            for ((rest, product), right_side) in rest.iter().zip(product).zip(apply(&expected)) {
                assert!((product + *rest).abs_diff_eq(right_side, 1e-5), "step {step}: {rest} is left");
            }
        }
        assert!(gmres.residual().max_element() < 1e-5, "{}", gmres.residual());
        for (found, expected) in gmres.solution().iter().zip(expected) {
            assert!(found.abs_diff_eq(expected, 1e-5), "{found}, not {expected}");
        }
        // Four vectors are all: another right side is solved without a step.
        let other = expected.map(|value| Vec3::new(value.x * value.x, 0.0, 1.0 - value.z));
        let (start, _) = known.start(&apply(&other));
        for (found, expected) in start.iter().zip(other) {
            assert!(found.abs_diff_eq(expected, 1e-4), "{found}, not {expected}");
        }
        // Going on where nothing is left does no harm.
        gmres.step(apply, &mut known);
        assert!(gmres.solution().iter().all(|value| value.is_finite()));
    }
}
