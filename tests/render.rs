//! Pictures: pixel values that geometry and the tone map give by hand, by a ray tracer that tries every triangle.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use image::RgbaImage;
use radiosity::{
    math::color::{ToneCurve, ToneMap, linear_to_srgb},
    render::{RenderSettings, Subject, View, render},
    scene::{
        AreaLight, Camera, LocalFrame, Material, Mesh, Scene, Tessellation, Texture, tessellate::TessellationOptions,
        texture::TextureFilter,
    },
    trace::{Hit, Ray, RayTracer},
};

/// Tests every triangle by Cramer's rule.
struct EveryTriangle<'a>(&'a Scene);

impl RayTracer for EveryTriangle<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let hits = (0..self.0.mesh.triangles.len() as u32).filter(|&triangle| triangle != ray.origin_triangle);
        let hits = hits.filter_map(|triangle| {
            let [a, b, c] = self.0.mesh.corners(triangle);
            let normal = (b - a).cross(c - a);
            let distance = (a - ray.origin).dot(normal) / ray.direction.dot(normal);
            let offset = ray.origin + distance * ray.direction - a;
            let u = offset.cross(c - a).dot(normal) / normal.length_squared();
            let v = (b - a).cross(offset).dot(normal) / normal.length_squared();
            let inside = distance > 0.0 && distance < ray.max_distance && u >= 0.0 && v >= 0.0 && u + v <= 1.0;
            let front = ray.direction.dot(normal) < 0.0;
            inside.then_some(Hit { triangle, barycentric: Vec2::new(u, v), distance, front })
        });
        hits.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.closest_hit(ray).is_some()
    }
}

/// Squares of side 2 across the z axis at these heights, facing +z where `true`; texture coordinates run from 0 to 1.
fn squares(places: &[(f32, bool)]) -> Scene {
    let mut mesh = Mesh::default();
    for &(z, faces_up) in places {
        let first = mesh.positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions.push(Vec3::new(x, y, z));
            mesh.normals.push(if faces_up { Vec3::Z } else { Vec3::NEG_Z });
        }
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
            let corners = if faces_up { [a, b, c] } else { [a, c, b] };
            mesh.triangles.push(corners.map(|corner| first + corner));
            let texcoord = |vertex: u32| 0.5 * mesh.positions[(first + vertex) as usize].truncate() + 0.5;
            mesh.texcoords.push(corners.map(texcoord));
            mesh.material_indices.push(0);
        }
    }
    Scene {
        name: String::from("squares"),
        mesh,
        materials: vec![Material::default()], // reflectance 0.6
        textures: Vec::new(),
        frame: LocalFrame::default(),
        enclosed: Vec::new(),
        two_sided: false,
        faceted: false,
        warnings: Vec::new(),
    }
}

/// Looks down the z axis from height 2 and sees the square at height 0 fill its picture.
const CAMERA: Camera =
    Camera { position: Vec3::new(0.0, 0.0, 2.0), forward: Vec3::NEG_Z, right: Vec3::X, up: Vec3::Y, tan_half_fov: 0.5 };
const PLAIN: ToneMap = ToneMap { exposure: 0.0, white: 1.0, gamma: 1.0, curve: ToneCurve::Plain };
const BACKGROUND: [u8; 4] = [28, 28, 28, 255];

/// A picture of 64×64 pixels; `field` gives the irradiance at a position.
fn picture(scene: &Scene, view: View, light: Option<AreaLight>, field: impl Fn(Vec3) -> Vec3) -> RgbaImage {
    let tessellation = Tessellation::new(scene, &TessellationOptions { subdivide: 1, max_edge: None }).unwrap();
    let field: Vec<Vec3> = tessellation.mesh.positions.iter().map(|&position| field(position)).collect();
    let tracer = EveryTriangle(scene);
    let subject = Subject {
        scene,
        tracer: &tracer,
        tessellation: &tessellation,
        charts: None,
        field: &field,
        direct: None,
        light,
    };
    let settings = RenderSettings { width: 64, height: 64, view, samples: 4, tone_map: PLAIN };
    render(&subject, &CAMERA, &settings)
}

fn uniform(_: Vec3) -> Vec3 {
    Vec3::new(PI, 0.5 * PI, 0.0)
}

#[test]
fn a_wall_of_known_irradiance_shows_its_radiance() {
    // L = E ρ/π = (0.6, 0.3, 0); IEC 61966-2-1 codes 0.6 as 0.7977 (203) and 0.3 as 0.5838 (149).
    let scene = squares(&[(0.0, true)]);
    let image = picture(&scene, View::Radiosity, None, uniform);
    assert!(image.pixels().all(|pixel| pixel.0 == [203, 149, 0, 255]));
    // Irradiance is shown on white: (1, 0.5, 0); 0.5 is coded as 0.7354 (188).
    let image = picture(&scene, View::Irradiance, None, uniform);
    assert!(image.pixels().all(|pixel| pixel.0 == [255, 188, 0, 255]));
    // Reflectance 0.6 without any tone map; the normal (0, 0, 1) is (0.5, 0.5, 1).
    assert_eq!(picture(&scene, View::Albedo, None, uniform)[(5, 5)].0, [203, 203, 203, 255]);
    assert_eq!(picture(&scene, View::Normals, None, uniform)[(5, 5)].0, [128, 128, 255, 255]);
}

#[test]
fn a_surface_that_emits_shows_emission_and_reflection() {
    let mut scene = squares(&[(0.0, true)]);
    scene.materials[0].emitted_radiance = Vec3::new(0.0, 0.0, 0.5);
    assert_eq!(picture(&scene, View::Radiosity, None, uniform)[(9, 50)].0, [203, 149, 188, 255]);
}

#[test]
fn irradiance_between_vertices_is_linear() {
    // E/π = (x + 1)/2, and the picture shows x from -1 to 1 from left to right; column i is centred at (i + 1/2)/64.
    let scene = squares(&[(0.0, true)]);
    let image = picture(&scene, View::Direct, None, |position| Vec3::splat(0.5 * PI * (position.x + 1.0)));
    for (column, row, pixel) in image.enumerate_pixels() {
        let expected = 255.0 * linear_to_srgb((column as f32 + 0.5) / 64.0);
        let [red, ..] = pixel.0;
        // The mean of coded samples differs from the coded mean where the coding bends: near black.
        let tolerance = if column < 2 { 4.0 } else { 1.0 };
        assert!((f32::from(red) - expected).abs() <= tolerance, "{column}, {row}: {red}, not {expected}");
    }
}

#[test]
fn textures_are_read_for_every_pixel() {
    let mut scene = squares(&[(0.0, true)]);
    let texels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
    scene.textures.push(Texture::new(String::from("four"), 2, 2, texels, TextureFilter::Nearest));
    scene.materials[0] =
        Material { reflectance: Vec3::ONE, reflectance_texture: Some(0), ..scene.materials[0].clone() };
    let image = picture(&scene, View::Radiosity, None, |_| Vec3::splat(PI));
    let at = |column, row| image[(column, row)].0;
    assert_eq!([at(31, 31), at(32, 31)], [[255, 0, 0, 255], [0, 255, 0, 255]]);
    assert_eq!([at(31, 32), at(32, 32)], [[0, 0, 255, 255], [255; 4]]);
}

#[test]
fn camera_rays_pass_through_back_faces() {
    let seen = |places: &[(f32, bool)]| picture(&squares(places), View::Radiosity, None, uniform)[(20, 30)].0;
    let wall = [203, 149, 0, 255];
    assert_eq!(seen(&[(0.0, false)]), BACKGROUND);
    assert_eq!(seen(&[(0.0, true), (0.5, false), (0.7, false)]), wall);
    // In the same place: a front and a back face in either order, and back faces that are there twice and three times.
    assert_eq!(seen(&[(0.3, false), (0.3, true)]), wall);
    assert_eq!(seen(&[(0.3, true), (0.3, false)]), wall);
    assert_eq!(seen(&[(0.3, false), (0.3, false), (0.0, true)]), wall);
    assert_eq!(seen(&[(0.3, false), (0.3, false), (0.3, false), (0.0, true)]), wall);
}

#[test]
fn the_placed_light_is_drawn_on_both_sides_where_nothing_hides_it() {
    // Half the size of the square and at half the distance: it fills the middle half of the picture in x; twice as
    // high, all of it in y.
    let down = AreaLight {
        centre: Vec3::new(0.0, 0.0, 1.0),
        half_extent_u: Vec3::X * 0.25,
        half_extent_v: Vec3::Y,
        radiance: Vec3::new(0.5, 0.0, 9.0),
    };
    let scene = squares(&[(0.0, true)]);
    let radiosity = |light: AreaLight| picture(&scene, View::Radiosity, Some(light), uniform);
    let image = radiosity(down); // u × v = +z: it shines at the camera
    assert_eq!([15, 16, 47, 48].map(|column| image[(column, 3)].0[2]), [0, 255, 255, 0]);
    assert_eq!(image[(30, 30)].0, [188, 0, 255, 255]);
    let turned = AreaLight { half_extent_u: -down.half_extent_u, ..down };
    assert_eq!(radiosity(turned)[(30, 30)].0, [13, 13, 13, 255]);
    let behind = AreaLight { centre: Vec3::NEG_Z, ..down };
    assert_eq!(radiosity(behind)[(30, 30)].0, [203, 149, 0, 255]);
    let none = AreaLight { half_extent_u: Vec3::ZERO, ..down };
    assert_eq!(radiosity(none)[(30, 30)].0, [203, 149, 0, 255]);
    assert_eq!(picture(&scene, View::Irradiance, Some(down), uniform)[(30, 30)].0, [255, 188, 0, 255]);
}

#[test]
fn a_pixel_half_covered_is_half_way_between_both_colours() {
    // The camera moved by half a pixel: the square's left edge, at x = -1, runs through the middle of column 0.
    let scene = squares(&[(0.0, true)]);
    let tessellation = Tessellation::new(&scene, &TessellationOptions { subdivide: 0, max_edge: None }).unwrap();
    let tracer = EveryTriangle(&scene);
    let subject = Subject {
        scene: &scene,
        tracer: &tracer,
        tessellation: &tessellation,
        charts: None,
        field: &[Vec3::splat(PI); 4],
        direct: None,
        light: None,
    };
    for samples in [2, 4, 6, 16] {
        let settings = RenderSettings { width: 64, height: 64, view: View::Irradiance, samples, tone_map: PLAIN };
        let camera = Camera { position: CAMERA.position - Vec3::X / 64.0, ..CAMERA };
        let image = render(&subject, &camera, &settings);
        assert_eq!(image[(0, 20)].0[0], 142, "{samples} samples"); // (0.11 + 1)/2 · 255 = 141.5
        assert_eq!(image[(1, 20)].0[0], 255);
    }
}

#[test]
fn wireframe_lines_have_their_width_in_pixels_at_any_distance_and_hide_behind_surfaces() {
    // Cut once, the square has a vertical edge at x = 0. Along a row that meets no slanted edge nearby, coverage
    // min(1, 1.1 - |x|) integrates to 1.2 pixels.
    let scene = squares(&[(0.0, true)]);
    let tessellation = Tessellation::new(&scene, &TessellationOptions { subdivide: 1, max_edge: None }).unwrap();
    let field = vec![Vec3::ZERO; tessellation.mesh.positions.len()];
    let tracer = EveryTriangle(&scene);
    let subject = Subject {
        scene: &scene,
        tracer: &tracer,
        tessellation: &tessellation,
        charts: None,
        field: &field,
        direct: None,
        light: None,
    };
    for size in [64_u32, 200] {
        let view = View::Wireframe;
        let settings = RenderSettings { width: size, height: size, view, samples: 16, tone_map: PLAIN };
        let image = render(&subject, &CAMERA, &settings);
        let row = size / 4;
        let sum: f32 = (size / 2 - 4..size / 2 + 4).map(|column| f32::from(image[(column, row)].0[2])).sum();
        let width = sum / (0.95 * 255.0); // black under a line of blue 0.95
        assert!((width - 1.2).abs() < 0.1, "{width} pixels wide at {size}");
        assert_eq!(image[(size / 2 + 6, row)].0, [0, 0, 0, 255]);
    }
    // A wall right before the camera hides a smaller square, whose outline would be seen without it.
    let lines = |places: &[(f32, bool)]| picture(&squares(places), View::Wireframe, None, |_| Vec3::ZERO);
    assert_eq!(lines(&[(-1.0, true), (1.9, true)]), lines(&[(1.9, true)]));
    assert_ne!(lines(&[(-1.0, true)]), lines(&[(1.9, true)]));
}

#[test]
fn views_are_read_as_they_are_written() {
    let bounces = [View::Bounce(0), View::Bounce(17)];
    let views = [View::Radiosity, View::Irradiance, View::Direct, View::Indirect, View::Normals, View::Albedo];
    for view in views.into_iter().chain(bounces).chain([View::Wireframe]) {
        assert_eq!(view.to_string().parse(), Ok(view));
    }
    for wrong in ["", "bounce", "bounce=", "bounce=-1", "bounce=x", "Direct"] {
        assert!(wrong.parse::<View>().unwrap_err().contains("radiosity, irradiance"), "{wrong}");
    }
}
