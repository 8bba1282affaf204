//! Right solutions that are written differently.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, TAU};

use glam::{Mat3, Vec2, Vec3};
use radiosity::{
    scene::AreaLight,
    student::{self, Functions, LightSample},
};

/// A frame by cross products with the axis that is furthest from the normal.
fn basis_by_cross_products(normal: Vec3) -> Mat3 {
    let size = normal.abs();
    let axis = if size.x <= size.y && size.x <= size.z {
        Vec3::X
    } else if size.y <= size.z {
        Vec3::Y
    } else {
        Vec3::Z
    };
    let tangent = axis.cross(normal).normalize();
    Mat3::from_cols(tangent, normal.cross(tangent), normal)
}

/// Frisvad 2012, mirrored for the lower half.
fn basis_of_frisvad(normal: Vec3) -> Mat3 {
    let mirror = if normal.z < 0.0 { -1.0 } else { 1.0 };
    let z = mirror * normal.z;
    let a = 1.0 / (1.0 + z);
    let b = -normal.x * normal.y * a;
    let tangent = Vec3::new(1.0 - normal.x * normal.x * a, b, -normal.x * mirror);
    Mat3::from_cols(tangent, normal.cross(tangent).normalize(), normal)
}

/// Angle by the second coordinate, radius by the first, and clockwise.
fn disk_the_other_way(point: Vec2) -> Vec2 {
    let angle = -TAU * point.y;
    Vec2::new(angle.cos(), angle.sin()) * (1.0 - point.x).sqrt()
}

fn disk_the_other_way_back(disk: Vec2) -> Vec2 {
    let turn = -disk.y.atan2(disk.x) / TAU;
    Vec2::new(1.0 - disk.length_squared(), turn.rem_euclid(1.0))
}

fn hemisphere_by_polar_disk(point: Vec2) -> Vec3 {
    let disk = student::square_to_disk_polar(point);
    Vec3::new(disk.x, disk.y, f32::sqrt(f32::max(0.0, 1.0 - disk.x * disk.x - disk.y * disk.y)))
}

fn hemisphere_by_polar_disk_back(direction: Vec3) -> Vec2 {
    student::disk_to_square_polar(Vec2::new(direction.x, direction.y))
}

/// The inverse of the cumulative distribution of θ.
fn hemisphere_by_inversion(point: Vec2) -> Vec3 {
    let theta = (1.0 - 2.0 * point.x).clamp(-1.0, 1.0).acos() / 2.0;
    let phi = TAU * point.y;
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn hemisphere_by_inversion_back(direction: Vec3) -> Vec2 {
    let turn = direction.y.atan2(direction.x) / TAU;
    Vec2::new(1.0 - direction.z * direction.z, turn.rem_euclid(1.0))
}

fn pdf_by_branch(direction: Vec3) -> f32 {
    if direction.z <= 0.0 { 0.0 } else { direction.z / std::f32::consts::PI }
}

/// The concentric map as a turn of the octant's wedge.
fn concentric_by_signs(point: Vec2) -> Vec2 {
    let Vec2 { x, y } = 2.0 * point - Vec2::ONE;
    let (radius, ratio) = (x.abs().max(y.abs()), x.abs().min(y.abs()) / x.abs().max(y.abs()).max(f32::MIN_POSITIVE));
    let (sine, cosine) = (FRAC_PI_4 * ratio).sin_cos();
    let (a, b) = if x.abs() >= y.abs() { (cosine, sine) } else { (sine, cosine) };
    Vec2::new((radius * a).copysign(x), (radius * b).copysign(y))
}

fn concentric_by_signs_back(disk: Vec2) -> Vec2 {
    let radius = disk.length();
    let size = disk.abs();
    let along = size.y.min(size.x).atan2(size.y.max(size.x)) / FRAC_PI_4 * radius;
    let (a, b) = if size.x >= size.y { (radius, along) } else { (along, radius) };
    (Vec2::new(a.copysign(disk.x), b.copysign(disk.y)) + 1.0) / 2.0
}

fn light_from_a_corner(light: &AreaLight, point: Vec2) -> LightSample {
    let [corner, next, _, last] = light.corners();
    let (along_x, along_y) = (next - corner, last - corner);
    let cross = along_x.cross(along_y);
    let area = cross.length();
    let (normal, pdf_area) = if area > 0.0 { (cross / area, 1.0 / area) } else { (Vec3::ZERO, 0.0) };
    LightSample { position: corner + point.x * along_x + point.y * along_y, normal, pdf_area }
}

fn light_by_normal_equations(light: &AreaLight, position: Vec3) -> Vec2 {
    let (u, v, offset) = (light.half_extent_u, light.half_extent_v, position - light.centre);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let determinant = uu * vv - uv * uv;
    if determinant <= 0.0 {
        return Vec2::splat(0.5);
    }
    let (a, b) = (offset.dot(u), offset.dot(v));
    (Vec2::new(vv * a - uv * b, uu * b - uv * a) / determinant + 1.0) / 2.0
}

fn interpolate_from_the_first([a, b, c]: [Vec3; 3], point: Vec2) -> Vec3 {
    a + (b - a) * point.x + (c - a) * point.y
}

/// Polar disk, cross products.
pub(crate) const POLAR: Functions = Functions {
    form_basis: basis_by_cross_products,
    square_to_cosine_hemisphere: hemisphere_by_polar_disk,
    cosine_hemisphere_to_square: hemisphere_by_polar_disk_back,
    cosine_hemisphere_pdf_solid_angle: pdf_by_branch,
    sample_area_light: light_from_a_corner,
    interpolate_barycentric: interpolate_from_the_first,
    ..student::FUNCTIONS
};

/// Inverse cumulative distributions, Frisvad's frame.
pub(crate) const INVERSION: Functions = Functions {
    form_basis: basis_of_frisvad,
    square_to_disk_polar: disk_the_other_way,
    disk_to_square_polar: disk_the_other_way_back,
    disk_pdf_area: |disk| if disk.length() > 1.0 { 0.0 } else { FRAC_1_PI },
    square_to_disk_concentric: concentric_by_signs,
    disk_to_square_concentric: concentric_by_signs_back,
    square_to_cosine_hemisphere: hemisphere_by_inversion,
    cosine_hemisphere_to_square: hemisphere_by_inversion_back,
    area_light_inverse: light_by_normal_equations,
    ..POLAR
};
