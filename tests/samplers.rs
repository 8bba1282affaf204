//! Every sampler against its density and its inverse, three ways; and each way against samplers that are wrong.
#![cfg(feature = "reference")]

use std::f32::consts::{FRAC_1_PI, FRAC_1_SQRT_2, PI, TAU};

use glam::{Mat3, UVec2, Vec2, Vec3};
use radiosity::{
    check::{
        chi_square::{Chart, ChiSquareReport, ChiSquareSettings, chi_square, random_points},
        jacobian::{check_jacobian, fixed_points},
    },
    math::sequence::{Sampler, Sequence, Stream},
    scene::AreaLight,
    student,
    transport::sampling,
};

const SAMPLE_COUNT: u32 = 100_000;

/// 12 right samplers are tested below; together they may be rejected by chance once in a hundred seeds.
fn settings(columns: u32, rows: u32) -> ChiSquareSettings {
    ChiSquareSettings { cells: UVec2::new(columns, rows), significance: 0.01, test_count: 12 }
}

fn assert_accepted(name: &str, report: &ChiSquareReport) {
    let reason = report.rejection.as_deref().unwrap_or_default();
    assert!(
        report.rejection.is_none(),
        "{name}: {reason}\nobserved {:?}\nexpected {:?}",
        report.observed,
        report.expected
    );
}

/// Angle and squared radius: equal areas of the disk are equal areas of the square.
fn disk_chart() -> Chart<'static, Vec2> {
    Chart {
        to_square: Box::new(|disk: Vec2| Vec2::new(disk.to_angle() / TAU + 0.5, disk.length_squared())),
        from_square: Box::new(|place| place.y.sqrt() * Vec2::from_angle((place.x - 0.5) * TAU)),
        measure: f64::from(PI),
    }
}

/// Angle and height on the whole sphere (Archimedes).
fn sphere_chart() -> Chart<'static, Vec3> {
    Chart {
        to_square: Box::new(|direction: Vec3| {
            Vec2::new(direction.truncate().to_angle() / TAU + 0.5, 0.5 + 0.5 * direction.z)
        }),
        from_square: Box::new(|place| {
            let z = 2.0 * place.y - 1.0;
            ((1.0 - z * z).sqrt() * Vec2::from_angle((place.x - 0.5) * TAU)).extend(z)
        }),
        measure: 2.0 * f64::from(TAU),
    }
}

/// The plane of a light with u at right angles to v, half as far again as the light reaches.
fn light_chart(light: &AreaLight) -> Chart<'_, Vec3> {
    let (u, v) = (light.half_extent_u, light.half_extent_v);
    Chart {
        to_square: Box::new(move |position: Vec3| {
            let offset = position - light.centre;
            Vec2::new(offset.dot(u) / u.length_squared(), offset.dot(v) / v.length_squared()) / 3.0 + 0.5
        }),
        from_square: Box::new(move |place| light.centre + 3.0 * (place.x - 0.5) * u + 3.0 * (place.y - 0.5) * v),
        measure: 9.0 * f64::from(u.length() * v.length()),
    }
}

/// Barycentric coordinates, along (Osada et al. 2002).
fn triangle_chart(area: f64) -> Chart<'static, Vec2> {
    Chart {
        to_square: Box::new(|barycentric: Vec2| {
            let sum = barycentric.element_sum();
            Vec2::new(sum * sum, barycentric.y / sum.max(f32::MIN_POSITIVE))
        }),
        from_square: Box::new(|place| place.x.sqrt() * Vec2::new(1.0 - place.y, place.y)),
        measure: area,
    }
}

fn square_chart() -> Chart<'static, Vec2> {
    Chart { to_square: Box::new(|point| point), from_square: Box::new(|point| point), measure: 1.0 }
}

fn light() -> AreaLight {
    AreaLight {
        centre: Vec3::new(0.2, 0.9, -0.1),
        half_extent_u: Vec3::new(0.3, 0.1, 0.0),
        half_extent_v: Vec3::new(-0.02, 0.06, 0.1),
        radiance: Vec3::ONE,
    }
}

/// The light's density at a position of its plane, from the sampler's own `pdf_area`.
fn light_pdf(light: &AreaLight, position: Vec3) -> f32 {
    let inside = student::area_light_inverse(light, position);
    let is_inside = inside.cmpge(Vec2::ZERO).all() && inside.cmple(Vec2::ONE).all();
    if is_inside { student::sample_area_light(light, inside).pdf_area } else { 0.0 }
}

const TRIANGLE: [Vec3; 3] = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.9, 0.1, 0.2), Vec3::new(0.3, 0.4, 1.1)];

fn triangle_area() -> f32 {
    let [a, b, c] = TRIANGLE;
    0.5 * (b - a).cross(c - a).length()
}

/// The largest distance between a point and what comes back.
fn round_trip_error(there_and_back: impl Fn(Vec2) -> Vec2) -> f32 {
    let near_sides = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5], [0.5, 0.0], [0.5, 1.0], [1e-4, 0.3]];
    let points = random_points(5, 1000).chain(near_sides.map(Vec2::from_array));
    points.map(|point| there_and_back(point).distance(point)).fold(0.0, f32::max)
}

/// Rounding of single precision, where a square root near 0 makes the most of it.
const ROUND_TRIP_TOLERANCE: f32 = 1e-5;

// What a student gets wrong.

/// A hemisphere of constant density.
fn uniform_hemisphere(point: Vec2) -> Vec3 {
    let radius = (1.0 - point.x * point.x).sqrt();
    (radius * Vec2::from_angle(TAU * point.y)).extend(point.x)
}

/// A polar disk whose radius lacks its square root.
fn disk_without_root(point: Vec2) -> Vec2 {
    point.x * Vec2::from_angle(TAU * point.y)
}

/// A triangle whose first coordinate lacks its square root.
fn triangle_without_root(point: Vec2) -> Vec2 {
    point.x * Vec2::new(1.0 - point.y, point.y)
}

/// The half extents taken for the full ones.
fn quarter_of_the_light(light: &AreaLight, point: Vec2) -> Vec3 {
    let centred = point - 0.5;
    light.centre + centred.x * light.half_extent_u + centred.y * light.half_extent_v
}

/// The doubled extents taken for the half ones.
fn four_times_the_light(light: &AreaLight, point: Vec2) -> Vec3 {
    let centred = 4.0 * (point - 0.5);
    light.centre + centred.x * light.half_extent_u + centred.y * light.half_extent_v
}

#[test]
fn densities_equal_one_over_the_jacobian() {
    let (light, corners) = (light(), TRIANGLE);
    let disk = |point| student::square_to_disk_concentric(point).extend(0.0);
    assert_eq!(check_jacobian(fixed_points(), disk, |_| FRAC_1_PI), Ok(()));
    let pdf = student::cosine_hemisphere_pdf_solid_angle;
    assert_eq!(check_jacobian(fixed_points(), student::square_to_cosine_hemisphere, pdf), Ok(()));
    let on_light = |point| student::sample_area_light(&light, point).position;
    assert_eq!(check_jacobian(fixed_points(), on_light, |position| light_pdf(&light, position)), Ok(()));
    let on_triangle = |point| sampling::triangle_point(corners, point).1;
    assert_eq!(check_jacobian(fixed_points(), on_triangle, |_| 1.0 / triangle_area()), Ok(()));
    let pdf = |direction: Vec3| sampling::cosine_pdf_solid_angle(direction.z);
    assert_eq!(check_jacobian(fixed_points(), sampling::cosine_direction, pdf), Ok(()));
    let on_light = |point| sampling::area_light_point(&light, point);
    assert_eq!(check_jacobian(fixed_points(), on_light, |_| 1.0 / light.area()), Ok(()));
}

#[test]
fn the_jacobian_test_rejects_wrong_samplers_and_wrong_densities() {
    let light = light();
    let cosine = student::cosine_hemisphere_pdf_solid_angle;
    assert!(check_jacobian(fixed_points(), uniform_hemisphere, cosine).is_err());
    assert!(check_jacobian(fixed_points(), |point| disk_without_root(point).extend(0.0), |_| FRAC_1_PI).is_err());
    let triangle = |point| radiosity::scene::mesh::interpolate(TRIANGLE, triangle_without_root(point));
    assert!(check_jacobian(fixed_points(), triangle, |_| 1.0 / triangle_area()).is_err());
    let quarter = |point| quarter_of_the_light(&light, point);
    assert!(check_jacobian(fixed_points(), quarter, |position| light_pdf(&light, position)).is_err());
    let right = |point| student::sample_area_light(&light, point).position;
    assert!(check_jacobian(fixed_points(), right, |_| 2.0 / light.area()).is_err());
    assert!(check_jacobian(fixed_points(), right, |_| f32::NAN).is_err());
}

#[test]
fn inverses_lead_back() {
    let light = light();
    let disk = |point| student::disk_to_square_concentric(student::square_to_disk_concentric(point));
    assert!(round_trip_error(disk) < ROUND_TRIP_TOLERANCE);
    let hemisphere = |point| student::cosine_hemisphere_to_square(student::square_to_cosine_hemisphere(point));
    assert!(round_trip_error(hemisphere) < ROUND_TRIP_TOLERANCE);
    let on_light = |point| student::area_light_inverse(&light, student::sample_area_light(&light, point).position);
    assert!(round_trip_error(on_light) < ROUND_TRIP_TOLERANCE);
    let skewed = AreaLight { half_extent_v: Vec3::new(0.2, 0.2, 0.1), ..light };
    let on_skewed = |point| student::area_light_inverse(&skewed, student::sample_area_light(&skewed, point).position);
    assert!(round_trip_error(on_skewed) < ROUND_TRIP_TOLERANCE);
}

#[test]
fn the_round_trip_rejects_wrong_samplers() {
    let light = light();
    let hemisphere = |point| student::cosine_hemisphere_to_square(uniform_hemisphere(point));
    assert!(round_trip_error(hemisphere) > 0.1);
    assert!(round_trip_error(|point| student::disk_to_square_concentric(disk_without_root(point))) > 0.1);
    assert!(round_trip_error(|point| student::area_light_inverse(&light, quarter_of_the_light(&light, point))) > 0.1);
}

#[test]
fn samples_follow_their_densities() {
    let light = light();
    let points = || random_points(1, SAMPLE_COUNT);
    let disk = points().map(student::square_to_disk_concentric);
    assert_accepted("disk", &chi_square(&settings(20, 10), &disk_chart(), disk, |_| FRAC_1_PI));
    let hemisphere = points().map(student::square_to_cosine_hemisphere);
    let pdf = student::cosine_hemisphere_pdf_solid_angle;
    assert_accepted("hemisphere", &chi_square(&settings(20, 20), &sphere_chart(), hemisphere, pdf));
    let on_light = points().map(|point| student::sample_area_light(&light, point).position);
    let pdf = |position| light_pdf(&light, position);
    assert_accepted("light", &chi_square(&settings(24, 24), &light_chart(&light), on_light, pdf));
    let direction = points().map(sampling::cosine_direction);
    let pdf = |direction: Vec3| sampling::cosine_pdf_solid_angle(direction.z);
    assert_accepted("the engine's hemisphere", &chi_square(&settings(20, 20), &sphere_chart(), direction, pdf));
    let on_triangle = points().map(|point| sampling::triangle_point(TRIANGLE, point).0);
    let chart = triangle_chart(f64::from(triangle_area()));
    assert_accepted("triangle", &chi_square(&settings(15, 15), &chart, on_triangle, |_| 1.0 / triangle_area()));
}

#[test]
fn the_chi_square_test_rejects_wrong_samplers_and_wrong_densities() {
    let light = light();
    let rejected = |report: ChiSquareReport| report.rejection.is_some();
    let points = || random_points(1, SAMPLE_COUNT);
    let cosine = student::cosine_hemisphere_pdf_solid_angle;
    let uniform = points().map(uniform_hemisphere);
    assert!(rejected(chi_square(&settings(20, 20), &sphere_chart(), uniform, cosine)));
    let below = points().map(student::square_to_cosine_hemisphere).map(|direction| -direction);
    assert!(rejected(chi_square(&settings(20, 20), &sphere_chart(), below, cosine)));
    let disk = points().map(disk_without_root);
    assert!(rejected(chi_square(&settings(20, 10), &disk_chart(), disk, |_| FRAC_1_PI)));
    let triangle = points().map(triangle_without_root);
    let chart = triangle_chart(f64::from(triangle_area()));
    assert!(rejected(chi_square(&settings(15, 15), &chart, triangle, |_| 1.0 / triangle_area())));
    for wrong in [quarter_of_the_light, four_times_the_light] {
        let samples = points().map(|point| wrong(&light, point));
        let pdf = |position| light_pdf(&light, position);
        assert!(rejected(chi_square(&settings(24, 24), &light_chart(&light), samples, pdf)));
    }
    let right = points().map(|point| student::sample_area_light(&light, point).position);
    let double = |position| 2.0 * light_pdf(&light, position);
    assert!(rejected(chi_square(&settings(24, 24), &light_chart(&light), right, double)));
}

#[test]
fn a_bias_of_three_percent_is_enough_for_the_chi_square_test() {
    let bent = random_points(1, SAMPLE_COUNT).map(|point| Vec2::new(point.x.powf(1.03), point.y));
    assert!(chi_square(&settings(10, 10), &square_chart(), bent, |_| 1.0).rejection.is_some());
}

#[test]
fn corners_and_middles_are_where_the_formulas_put_them() {
    let disk = |x, y| student::square_to_disk_concentric(Vec2::new(x, y));
    let diagonal = FRAC_1_SQRT_2;
    let cases = [
        (disk(0.5, 0.5), Vec2::ZERO),
        (disk(1.0, 0.5), Vec2::X),
        (disk(0.5, 1.0), Vec2::Y),
        (disk(0.0, 0.5), -Vec2::X),
        (disk(0.5, 0.0), -Vec2::Y),
        (disk(1.0, 1.0), Vec2::new(diagonal, diagonal)),
        (disk(0.0, 1.0), Vec2::new(-diagonal, diagonal)),
        (disk(0.0, 0.0), Vec2::new(-diagonal, -diagonal)),
    ];
    for (found, expected) in cases {
        assert!(found.abs_diff_eq(expected, 1e-6), "{found} is not {expected}");
    }
    assert_eq!(student::square_to_cosine_hemisphere(Vec2::splat(0.5)), Vec3::Z);
    assert!(student::square_to_cosine_hemisphere(Vec2::new(1.0, 0.5)).abs_diff_eq(Vec3::X, 1e-3));
    assert_eq!(student::cosine_hemisphere_pdf_solid_angle(Vec3::Z), FRAC_1_PI);
    assert_eq!(student::cosine_hemisphere_pdf_solid_angle(Vec3::NEG_Z), 0.0);

    let light = light();
    let (u, v) = (light.half_extent_u, light.half_extent_v);
    for (corner, [x, y]) in light.corners().into_iter().zip([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) {
        let sample = student::sample_area_light(&light, Vec2::new(x, y));
        assert!(sample.position.abs_diff_eq(corner, 1e-6));
        assert!((sample.pdf_area - 1.0 / (4.0 * u.cross(v).length())).abs() < 1e-3);
        assert!(sample.normal.dot(u).abs() < 1e-6 && sample.normal.dot(v).abs() < 1e-6);
    }
    let [a, b, c] = TRIANGLE;
    for (x, y, expected) in [(0.0, 0.0, a), (1.0, 0.0, b), (0.0, 1.0, c), (1.0, 1.0, 0.5 * (b + c))] {
        let (_, position) = sampling::triangle_point(TRIANGLE, Vec2::new(x, y));
        assert!(position.abs_diff_eq(expected, 1e-6), "{x} {y}");
    }
}

#[test]
fn corner_values_tell_wrong_samplers_from_right_ones() {
    let light = light();
    assert!(!quarter_of_the_light(&light, Vec2::ZERO).abs_diff_eq(light.corners()[0], 1e-3));
    assert!(!disk_without_root(Vec2::splat(0.5)).abs_diff_eq(Vec2::ZERO, 1e-3));
    assert!(!uniform_hemisphere(Vec2::splat(0.5)).abs_diff_eq(Vec3::Z, 1e-3));
    assert!(!triangle_without_root(Vec2::ONE).abs_diff_eq(Vec2::splat(0.5), 1e-3));
}

#[test]
fn a_light_without_area_has_density_0_and_no_nan() {
    let line = AreaLight { half_extent_v: Vec3::ZERO, ..light() };
    let sample = student::sample_area_light(&line, Vec2::new(0.3, 0.7));
    assert!(sample.pdf_area == 0.0 && sample.position.is_finite() && sample.normal == Vec3::ZERO);
    assert_eq!(student::area_light_inverse(&line, line.centre), Vec2::splat(0.5));
}

/// What is wrong with a frame, if anything.
fn basis_problem(basis: Mat3, normal: Vec3) -> Option<&'static str> {
    let off_identity = (basis.transpose() * basis - Mat3::IDENTITY).to_cols_array().map(f32::abs);
    if basis.z_axis != normal {
        Some("the third axis is not the normal")
    } else if !off_identity.iter().all(|&value| value < 1e-6) {
        Some("not orthonormal")
    } else if basis.determinant() < 0.0 {
        Some("left-handed")
    } else {
        None
    }
}

fn normals() -> impl Iterator<Item = Vec3> {
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z, Vec3::new(1.0, 0.0, -0.0)];
    let near_poles = [1e-3_f32, 1e-5, 1e-7, 1e-20]
        .into_iter()
        .flat_map(|tilt| [1.0, -1.0].map(|z| Vec3::new(tilt, -tilt, z).normalize()));
    let anywhere =
        random_points(3, 1000).map(|point| uniform_hemisphere(point) * if point.y > 0.5 { 1.0 } else { -1.0 });
    axes.into_iter().chain(near_poles).chain(anywhere)
}

#[test]
fn the_basis_is_orthonormal_and_right_handed_around_every_normal() {
    for normal in normals() {
        assert_eq!(basis_problem(student::form_basis(normal), normal), None, "{normal}");
        assert_eq!(basis_problem(sampling::frame(normal), normal), None, "{normal}");
    }
}

#[test]
fn wrong_bases_are_rejected() {
    let from_fixed_axis = |normal: Vec3| {
        let tangent = Vec3::Z.cross(normal).normalize();
        Mat3::from_cols(tangent, normal.cross(tangent), normal)
    };
    let mirrored = |normal: Vec3| {
        let basis = student::form_basis(normal);
        Mat3::from_cols(basis.y_axis, basis.x_axis, normal)
    };
    assert_eq!(basis_problem(from_fixed_axis(Vec3::X), Vec3::X), None);
    assert!(normals().any(|normal| basis_problem(from_fixed_axis(normal), normal).is_some()));
    assert!(normals().all(|normal| basis_problem(mirrored(normal), normal) == Some("left-handed")));
}

const SAMPLERS: [Sampler; 3] = [Sampler::Random, Sampler::Stratified, Sampler::Sobol];

#[test]
fn sequences_are_uniform_over_elements_and_independent_between_neighbours() {
    let point = |sampler, element| Sequence::new(sampler, 11, element, Stream::Hemisphere, 64).sample_2d(5);
    for sampler in SAMPLERS {
        if sampler != Sampler::Stratified {
            // Point 5 of 64 strata stays in its own cell, so only the other samplers spread it over the square.
            let samples = (0..SAMPLE_COUNT).map(|element| point(sampler, element));
            let name = format!("{sampler:?} over elements");
            assert_accepted(&name, &chi_square(&settings(16, 16), &square_chart(), samples, |_| 1.0));
            let pairs =
                (0..SAMPLE_COUNT).map(|pair| Vec2::new(point(sampler, 2 * pair).x, point(sampler, 2 * pair + 1).x));
            let name = format!("{sampler:?} between neighbours");
            assert_accepted(&name, &chi_square(&settings(16, 16), &square_chart(), pairs, |_| 1.0));
        }
        // The whole of many short sequences.
        let all = (0..SAMPLE_COUNT)
            .map(|sample| Sequence::new(sampler, 11, sample / 50, Stream::AreaLight, 50).sample_2d(sample % 50));
        let name = format!("{sampler:?} whole");
        assert_accepted(&name, &chi_square(&settings(16, 16), &square_chart(), all, |_| 1.0));
    }
}

#[test]
fn a_sequence_that_repeats_or_stops_half_way_is_rejected() {
    let rejected = |samples: &mut dyn Iterator<Item = Vec2>| {
        chi_square(&settings(16, 16), &square_chart(), samples, |_| 1.0).rejection.is_some()
    };
    for sampler in SAMPLERS {
        let repeating = Sequence::new(sampler, 11, 0, Stream::Hemisphere, 64);
        assert!(rejected(&mut (0..SAMPLE_COUNT).map(|sample| repeating.sample_2d(sample % 64))));
    }
    let half_way = Sequence::new(Sampler::Stratified, 11, 0, Stream::Hemisphere, 2 * SAMPLE_COUNT);
    assert!(rejected(&mut (0..SAMPLE_COUNT).map(|sample| half_way.sample_2d(sample))));
}
