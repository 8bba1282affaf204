//! Wrong frames and wrong interpolation.

use glam::{Mat3, Vec2, Vec3};
use radiosity::student;

use super::{Mutant, mutant};

fn from_fixed_axis(normal: Vec3) -> Mat3 {
    let tangent = Vec3::Z.cross(normal).normalize();
    Mat3::from_cols(tangent, normal.cross(tangent), normal)
}

fn from_y_axis(normal: Vec3) -> Mat3 {
    let tangent = Vec3::Y.cross(normal).normalize();
    Mat3::from_cols(tangent, normal.cross(tangent), normal)
}

fn left_handed(normal: Vec3) -> Mat3 {
    let basis = student::form_basis(normal);
    Mat3::from_cols(basis.y_axis, basis.x_axis, normal)
}

fn not_orthogonal(normal: Vec3) -> Mat3 {
    let tangent = if normal.x.abs() < 0.7 { Vec3::X } else { Vec3::Y };
    Mat3::from_cols(tangent, normal.cross(tangent).normalize(), normal)
}

fn not_normalised(normal: Vec3) -> Mat3 {
    let axis = if normal.x.abs() < 0.7 { Vec3::X } else { Vec3::Y };
    let tangent = axis.cross(normal);
    Mat3::from_cols(tangent, normal.cross(tangent), normal)
}

fn rows_for_columns(normal: Vec3) -> Mat3 {
    student::form_basis(normal).transpose()
}

fn flipped(normal: Vec3) -> Mat3 {
    student::form_basis(-normal)
}

fn upper_half_only(normal: Vec3) -> Mat3 {
    let a = 1.0 / (1.0 + normal.z.abs());
    let b = -normal.x * normal.y * a;
    let tangent = Vec3::new(1.0 - normal.x * normal.x * a, b, -normal.x);
    Mat3::from_cols(tangent, Vec3::new(b, 1.0 - normal.y * normal.y * a, -normal.y), normal)
}

fn fails_at_minus_z(normal: Vec3) -> Mat3 {
    let a = 1.0 / (1.0 + normal.z);
    let b = -normal.x * normal.y * a;
    let tangent = Vec3::new(1.0 - normal.x * normal.x * a, b, -normal.x);
    Mat3::from_cols(tangent, Vec3::new(b, 1.0 - normal.y * normal.y * a, -normal.y), normal)
}

fn normal_first(normal: Vec3) -> Mat3 {
    let basis = student::form_basis(normal);
    Mat3::from_cols(normal, basis.x_axis, basis.y_axis)
}

fn weighted([a, b, c]: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    weights[0] * a + weights[1] * b + weights[2] * c
}

fn rest_at_the_last_corner(values: [Vec3; 3], point: Vec2) -> Vec3 {
    weighted(values, [point.x, point.y, 1.0 - point.x - point.y])
}

fn swapped(values: [Vec3; 3], point: Vec2) -> Vec3 {
    weighted(values, [1.0 - point.x - point.y, point.y, point.x])
}

fn complement(values: [Vec3; 3], point: Vec2) -> Vec3 {
    weighted(values, [point.x + point.y, 1.0 - point.x, 1.0 - point.y])
}

fn weights_above_one(values: [Vec3; 3], point: Vec2) -> Vec3 {
    weighted(values, [1.0, point.x, point.y])
}

fn v_unused([a, b, _]: [Vec3; 3], point: Vec2) -> Vec3 {
    a * (1.0 - point.x) + b * point.x
}

fn complements_of_two(values: [Vec3; 3], point: Vec2) -> Vec3 {
    weighted(values, [1.0 - point.x - point.y, 1.0 - point.x, 1.0 - point.y])
}

fn first_corner(values: [Vec3; 3], _: Vec2) -> Vec3 {
    values[0]
}

fn mean_of_corners([a, b, c]: [Vec3; 3], _: Vec2) -> Vec3 {
    (a + b + c) / 3.0
}

fn out_of_range(values: [Vec3; 3], point: Vec2) -> Vec3 {
    values[(3.0 * point.x.max(point.y)) as usize]
}

/// The wrong versions.
pub(crate) fn mutants() -> Vec<Mutant> {
    vec![
        mutant!("basis", "fails for n = ±z", "breaks down for n = +z and -z", form_basis: from_fixed_axis),
        mutant!("basis", "fails for n = ±y", "breaks down for n = +y and -y", form_basis: from_y_axis),
        mutant!("basis", "fails for n = -z", "breaks down for n = -z", form_basis: fails_at_minus_z),
        mutant!("basis", "left-handed", "left-handed", form_basis: left_handed),
        mutant!("basis", "tangent not orthogonal", "not at right angles", form_basis: not_orthogonal),
        mutant!("basis", "tangent not normalised", "normalise the tangent", form_basis: not_normalised),
        mutant!("basis", "rows for columns", "rows and columns are swapped", form_basis: rows_for_columns),
        mutant!("basis", "normal flipped", "turned round", form_basis: flipped),
        mutant!("basis", "upper half only", "z < 0 fail", form_basis: upper_half_only),
        mutant!("basis", "normal in the first column", "wrong column", form_basis: normal_first),
        mutant!("barycentric", "weight of the wrong corner", "wrong corners",
            interpolate_barycentric: rest_at_the_last_corner),
        mutant!("barycentric", "u and v swapped", "u and v are swapped", interpolate_barycentric: swapped),
        mutant!("barycentric", "complementary weights", "complement", interpolate_barycentric: complement),
        mutant!("barycentric", "weights sum above 1", "weight of a is 1", interpolate_barycentric: weights_above_one),
        mutant!("barycentric", "v not used", "v is not used", interpolate_barycentric: v_unused),
        mutant!("barycentric", "complements of two", "complements of u and v", interpolate_barycentric: complements_of_two),
        mutant!("barycentric", "first corner only", "one corner alone", interpolate_barycentric: first_corner),
        mutant!("barycentric", "mean of the corners", "plain mean", interpolate_barycentric: mean_of_corners),
        mutant!("barycentric", "index out of range", "panics", interpolate_barycentric: out_of_range),
    ]
}
