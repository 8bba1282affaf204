//! Task `basis`: a frame around a normal.

use std::f32::consts::TAU;

use glam::{Mat3, Vec3};

use super::{
    charts,
    probe::{Check, Failure, Trial, call, quiet, written},
};

const FUNCTION: &str = "form_basis";

/// Rounding of single precision, and of methods that lose some digits near a pole.
const TOLERANCE: f32 = 1e-4;

/// What a frame can be wrong in, in the order of the tests.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    Normal,
    Length,
    Angle,
    Hand,
}

fn fault(basis: Mat3, normal: Vec3) -> Option<Fault> {
    let (tangent, bitangent) = (basis.x_axis, basis.y_axis);
    let is_unit = |axis: Vec3| (axis.length() - 1.0).abs() <= TOLERANCE;
    let is_right = |a: Vec3, b: Vec3| a.dot(b).abs() <= TOLERANCE * a.length() * b.length();
    if !basis.z_axis.abs_diff_eq(normal, TOLERANCE) {
        Some(Fault::Normal)
    } else if !(is_right(tangent, normal) && is_right(bitangent, normal) && is_right(tangent, bitangent)) {
        Some(Fault::Angle)
    } else if !(is_unit(tangent) && is_unit(bitangent)) {
        Some(Fault::Length)
    } else if basis.determinant() < 0.0 {
        Some(Fault::Hand)
    } else {
        None
    }
}

const AXES: [(&str, Vec3); 6] =
    [("+x", Vec3::X), ("-x", Vec3::NEG_X), ("+y", Vec3::Y), ("-y", Vec3::NEG_Y), ("+z", Vec3::Z), ("-z", Vec3::NEG_Z)];

/// Normals that are nothing special.
fn anywhere(trial: &Trial) -> impl Iterator<Item = Vec3> {
    trial.points().take(1000).map(|point| charts::direction(2.0 * point.x - 1.0, TAU * point.y))
}

/// The axes, normals close to them, and any others.
fn normals(trial: &Trial) -> impl Iterator<Item = Vec3> {
    let near_axes = AXES.into_iter().flat_map(|(_, axis)| {
        [1e-2_f32, 1e-4, 1e-6, 1e-10].map(|tilt| (axis + tilt * Vec3::new(1.0, -0.7, 0.4)).normalize())
    });
    AXES.into_iter().map(|(_, axis)| axis).chain(near_axes).chain(anywhere(trial))
}

pub(super) fn tests(trial: &Trial) -> Check {
    let form_basis = trial.functions.form_basis;
    written(trial, FUNCTION, &[Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, 0.8)], |functions, normal| {
        (functions.form_basis)(normal)
    })?;
    for normal in normals(trial) {
        let basis = call(FUNCTION, format_args!("normal {normal}"), || form_basis(normal))?;
        let Some(fault) = fault(basis, normal) else { continue };
        let Mat3 { x_axis, y_axis, z_axis } = basis;
        let measured = format!("columns {x_axis:.4}, {y_axis:.4}, {z_axis:.4} for normal {normal:.4}");
        let (test, expected) = match fault {
            Fault::Normal => ("third column", "the normal in the third column"),
            Fault::Angle => ("right angles", "three columns at right angles"),
            Fault::Length => ("unit length", "three columns of length 1"),
            Fault::Hand => ("right-handed", "tangent × bitangent = normal"),
        };
        return Err(Failure::new(FUNCTION, test, measured, expected).into());
    }
    Ok(())
}

pub(super) fn diagnose(trial: &Trial, _: &Failure) -> Option<String> {
    let form_basis = trial.functions.form_basis;
    let found: Vec<(Vec3, Mat3)> =
        anywhere(trial).filter_map(|normal| Some((normal, quiet(|| form_basis(normal))?))).collect();
    let bad: Vec<(Vec3, Mat3)> =
        found.iter().filter(|(normal, basis)| fault(*basis, *normal).is_some()).copied().collect();
    if found.is_empty() {
        return None;
    }
    if bad.is_empty() {
        return special_axes(form_basis);
    }
    let all = |test: fn(Vec3, Mat3) -> bool| bad.iter().all(|&(normal, basis)| test(normal, basis));
    let hint = if all(|normal, basis| basis.z_axis.abs_diff_eq(-normal, TOLERANCE)) {
        "the third column is the normal turned round: its sign is wrong"
    } else if all(|normal, basis| fault(basis.transpose(), normal).is_none()) {
        "rows and columns are swapped (the transpose): the axes must be the columns"
    } else if all(|normal, basis| {
        basis.x_axis.abs_diff_eq(normal, TOLERANCE) || basis.y_axis.abs_diff_eq(normal, TOLERANCE)
    }) {
        "the normal stands in the wrong column: it must be the third"
    } else if all(|normal, basis| fault(basis, normal) == Some(Fault::Normal)) {
        "the third column is not the normal"
    } else if all(|normal, basis| fault(basis, normal) == Some(Fault::Hand)) {
        "the frame is left-handed: swap the factors of a cross product (bitangent = normal × tangent)"
    } else if all(|normal, basis| fault(basis, normal) == Some(Fault::Length)) {
        "a cross product is not of unit length unless its factors are at right angles: normalise the tangent"
    } else if bad.len() < found.len() && bad.iter().all(|(normal, _)| normal.z < 0.0) {
        "normals with z < 0 fail: the formula for the upper half has to be mirrored for the lower"
    } else if all(|normal, basis| fault(basis, normal) == Some(Fault::Angle)) {
        "the columns are not at right angles: make the tangent by a cross product with the normal, and so the bitangent"
    } else {
        return None;
    };
    Some(String::from(hint))
}

/// Where every plain normal works: which axes do not.
fn special_axes(form_basis: fn(Vec3) -> Mat3) -> Option<String> {
    let works = |axis: Vec3| quiet(|| form_basis(axis)).is_some_and(|basis| fault(basis, axis).is_none());
    let names: Vec<&str> = AXES.into_iter().filter(|(_, axis)| !works(*axis)).map(|(name, _)| name).collect();
    let which = if names.is_empty() { String::from("close to an axis") } else { format!("= {}", names.join(" and ")) };
    Some(format!(
        "the basis breaks down for n {which}: a cross product with a fixed axis, or a division, vanishes there; choose \
         another axis for such normals"
    ))
}
