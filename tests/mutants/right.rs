//! Right solutions that are written differently.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, TAU};

use glam::{Mat3, Vec2, Vec3};
use radiosity::{
    math::color::srgb_to_linear,
    scene::AreaLight,
    student::{self, Functions, LightSample, Receiver, SurfaceHit, World},
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

/// Directions in a cone around the light, of which those count that meet it.
fn direct_by_directions(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = &world.light else { return Vec3::ZERO };
    let (axis, distance) = (light.centre - receiver.point.origin).normalize_and_length();
    let radius = light.half_extent_u.length() + light.half_extent_v.length();
    let lowest = (1.0 - (radius / distance).powi(2)).max(0.0).sqrt();
    let lowest = if radius < distance { lowest } else { -1.0 };
    let basis = basis_by_cross_products(axis);
    let (mut sum, mut count) = (0.0, 0);
    for point in world.light_points(receiver) {
        count += 1;
        let height = 1.0 - point.x * (1.0 - lowest);
        let direction = basis * (Vec2::from_angle(TAU * point.y) * (1.0 - height * height).sqrt()).extend(height);
        let facing = -direction.dot(light.normal());
        if facing <= 0.0 {
            continue;
        }
        let distance = (receiver.point.origin - light.centre).dot(light.normal()) / facing;
        let target = receiver.point.origin + distance * direction;
        let place = light_by_normal_equations(light, target);
        let is_on_light = place.min_element() >= 0.0 && place.max_element() <= 1.0;
        if distance > 0.0 && is_on_light {
            let is_free = receiver.point.ray_to(target).is_some_and(|ray| !world.occluded(&ray));
            let cosine = direction.dot(receiver.normal()).max(0.0);
            sum += if is_free { cosine * TAU * (1.0 - lowest) } else { 0.0 };
        }
    }
    light.radiance * sum / count.max(1) as f32
}

/// Form factors of small parts, with the nearest hit as the test of visibility.
fn direct_by_nearest_hit(world: &World, receiver: &Receiver) -> Vec3 {
    let Some(light) = world.light else { return Vec3::ZERO };
    let samples: Vec<Vec3> = world
        .light_points(receiver)
        .map(|point| {
            let position = light_from_a_corner(&light, point).position;
            let offset = position - receiver.point.origin;
            let squared = offset.length_squared();
            let product = offset.dot(receiver.point.shading_normal).max(0.0) * offset.dot(-light.normal()).max(0.0);
            let is_seen = receiver.point.ray_to(position).is_some_and(|ray| world.trace(&ray).is_none());
            if is_seen { light.radiance * light.area() * product / (squared * squared) } else { Vec3::ZERO }
        })
        .collect();
    samples.iter().sum::<Vec3>() / samples.len().max(1) as f32
}

/// Uniform directions, each weighed by twice its cosine.
fn gather_uniformly(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let basis = basis_of_frisvad(receiver.normal());
    let field = bounces[bounces.len() - 1];
    let value = |point: Vec2| {
        let height = point.y;
        let direction = (Vec2::from_angle(TAU * point.x) * (1.0 - height * height).sqrt()).extend(height);
        let hit = world.trace(&receiver.point.ray(basis * direction)?)?;
        let corners = hit.vertices.map(|vertex| field[vertex as usize]);
        let radiosity = interpolate_from_the_first(corners, hit.barycentric) * multiplied(world, &hit);
        Some(if hit.front { 2.0 * height * radiosity } else { Vec3::ZERO })
    };
    let values: Vec<Vec3> = world.hemisphere_points(receiver).map(|point| value(point).unwrap_or_default()).collect();
    if values.is_empty() { Vec3::ZERO } else { values.iter().sum::<Vec3>() / values.len() as f32 }
}

/// By the polar map.
fn gather_by_polar_map(world: &World, receiver: &Receiver, bounces: &[&[Vec3]]) -> Vec3 {
    let basis = basis_by_cross_products(receiver.normal());
    let (mut sum, mut count) = (Vec3::ZERO, 0_u16);
    for point in world.hemisphere_points(receiver) {
        count += 1;
        let Some(ray) = receiver.point.ray(basis.mul_vec3(hemisphere_by_polar_disk(point))) else { continue };
        if let Some(hit) = world.trace(&ray)
            && hit.front
        {
            let [a, b, c] = hit.vertices.map(|vertex| bounces[bounces.len() - 1][vertex as usize]);
            sum += (world.functions.surface_reflectance)(world, &hit)
                * interpolate_from_the_first([a, b, c], hit.barycentric);
        }
    }
    sum / f32::from(count.max(1))
}

fn multiplied(world: &World, hit: &SurfaceHit) -> Vec3 {
    let colour = hit.material.reflectance_texture.map_or(Vec3::ONE, |index| {
        let texture = &world.scene.textures[index as usize];
        texel_by_remainder(texture.size(), texture.texels(), hit.texcoord)
    });
    colour * hit.material.reflectance
}

fn texel_by_remainder((width, height): (u32, u32), texels: &[[u8; 4]], texcoord: Vec2) -> Vec3 {
    let column = (texcoord.x * width as f32).floor().rem_euclid(width as f32) as u32;
    let row = (-texcoord.y * height as f32).ceil() - 1.0;
    let row = row.rem_euclid(height as f32) as u32;
    let texel = texels[(row * width + column) as usize];
    Vec3::new(
        srgb_to_linear(f32::from(texel[0]) / 255.0),
        srgb_to_linear(f32::from(texel[1]) / 255.0),
        srgb_to_linear(f32::from(texel[2]) / 255.0),
    )
}

/// Columns first, and the narrow column last.
fn strata_by_columns(index: u32, count: u32, jitter: Vec2) -> Vec2 {
    let by_rows = student::stratified_point(index, count, Vec2::new(jitter.y, jitter.x));
    Vec2::new(by_rows.y, by_rows.x)
}

/// Roberts 2018: multiples of the plastic number's powers.
fn additive_recurrence(index: u32) -> Vec2 {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let index = f64::from(index);
    let (x, y) = ((0.5 + index / PLASTIC).fract(), (0.5 + index / (PLASTIC * PLASTIC)).fract());
    Vec2::new(x as f32, y as f32).min(Vec2::splat(1.0 - f32::EPSILON))
}

/// Sobol's first two dimensions, as they are.
fn sobol(index: u32) -> Vec2 {
    let mut second = 0_u32;
    let mut direction = 1_u32 << 31;
    for digit in 0..32 {
        if index >> digit & 1 == 1 {
            second ^= direction;
        }
        direction ^= direction >> 1;
    }
    let fraction = |bits: u32| (bits >> 8) as f32 / 16_777_216.0;
    Vec2::new(fraction(index.reverse_bits()), fraction(second))
}

/// Polar disk, cross products.
pub(crate) const POLAR: Functions = Functions {
    form_basis: basis_by_cross_products,
    square_to_cosine_hemisphere: hemisphere_by_polar_disk,
    cosine_hemisphere_to_square: hemisphere_by_polar_disk_back,
    cosine_hemisphere_pdf_solid_angle: pdf_by_branch,
    sample_area_light: light_from_a_corner,
    interpolate_barycentric: interpolate_from_the_first,
    sample_texture: texel_by_remainder,
    direct_irradiance: direct_by_nearest_hit,
    indirect_irradiance: gather_by_polar_map,
    stratified_point: strata_by_columns,
    low_discrepancy_point: additive_recurrence,
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
    surface_reflectance: multiplied,
    direct_irradiance: direct_by_directions,
    indirect_irradiance: gather_uniformly,
    low_discrepancy_point: sobol,
    ..POLAR
};
