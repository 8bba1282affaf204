//! A frame around a normal.

use glam::{Mat3, Vec3};

/// The frame whose third axis is `normal`: columns tangent, bitangent, normal, orthonormal and right-handed
/// (tangent × bitangent = normal). It turns the local directions of eq. 4, whose z points up, into directions of the
/// scene: `form_basis(normal) * local`; the transpose turns them back.
///
/// `normal` must have unit length; every direction works, ±z too. The turn about the normal is free, and jumps where
/// the normal's z changes sign, as it must somewhere.
///
/// Placeholder while not done: the identity. Tests: `radiosity check`, task `basis`.
///
/// Method: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
///
/// Hint: a cross product with a fixed axis fails where the normal is that axis. Find the two vectors for z > 0 without
/// a division by something that can vanish, then mirror them for z < 0.
pub fn form_basis(normal: Vec3) -> Mat3 {
    // <answer>
    // The sign bit rather than a comparison, so that z = -0 has a sign as well.
    let sign = 1.0_f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    let tangent = Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    let bitangent = Vec3::new(b, sign + normal.y * normal.y * a, -normal.y);
    Mat3::from_cols(tangent, bitangent, normal)
    // </answer> (super::PLACEHOLDERS.form_basis)(normal)
}
