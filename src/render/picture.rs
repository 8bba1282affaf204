//! The picture: rays through pixels, surfaces to colours.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use image::RgbaImage;
use rayon::prelude::*;

use super::{view::View, wireframe};
use crate::{
    lightmap::Charts,
    math::color::{ToneMap, linear_to_srgb},
    scene::{AreaLight, Camera, Scene, Tessellation},
    trace::{Hit, NO_TRIANGLE, Ray, RayTracer, SurfacePoint},
    transport::visible_light::Scratch,
};

/// Direct irradiance [W/m²] at a point, as it is computed for a picture.
pub type PointLight<'a> = dyn Fn(&SurfacePoint, &mut Scratch) -> Vec3 + Sync + 'a;

/// What is drawn.
pub struct Subject<'a, Tracer> {
    /// The scene.
    pub scene: &'a Scene,
    /// A ray tracer over the scene.
    pub tracer: &'a Tracer,
    /// The elements that carry the field; wireframes show their edges.
    pub tessellation: &'a Tessellation,
    /// Where the texels that carry the field lie, if they do and not the elements.
    pub charts: Option<&'a Charts>,
    /// Irradiance [W/m²] at the tessellation's vertices, from [`View::field`], or at all texels of the pages, from
    /// [`View::texels`]; may be empty for views that show none.
    pub field: &'a [Vec3],
    /// Direct light, where it is computed at each shown point and not a part of `field`.
    pub direct: Option<&'a PointLight<'a>>,
    /// The placed area light, drawn in the views of radiosity.
    pub light: Option<AreaLight>,
}

/// How it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// What is shown.
    pub view: View,
    /// Rays a pixel, at least 1: each lies in its own column and its own row of the pixel.
    pub samples: u32,
    /// From radiance to colour.
    pub tone_map: ToneMap,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self { width: 960, height: 720, view: View::Radiosity, samples: 4, tone_map: ToneMap::default() }
    }
}

/// sRGB-coded colour where there is no surface.
const BACKGROUND: Vec3 = Vec3::splat(0.11);
/// sRGB-coded colour of the dark side of the placed light.
const LIGHT_BACK: Vec3 = Vec3::splat(0.05);
/// Back faces that a camera ray passes before it is given up as background.
const MAX_PASSED_FACES: u32 = 64;
/// Faces nearer to each other than this, in local units, are taken as lying in the same place.
const SAME_PLACE: f32 = 2e-6;

/// The picture, opaque, row by row from the top. A pixel is the mean of its samples' sRGB-coded colours. It has the
/// same bits on any number of threads.
pub fn render<Tracer: RayTracer>(
    subject: &Subject<'_, Tracer>,
    camera: &Camera,
    settings: &RenderSettings,
) -> RgbaImage {
    let mut image = RgbaImage::new(settings.width, settings.height);
    let size = Vec2::new(settings.width as f32, settings.height as f32);
    image.par_enumerate_pixels_mut().for_each_init(Scratch::default, |scratch, (column, row, pixel)| {
        let corner = Vec2::new(column as f32, row as f32);
        let samples = settings.samples.max(1);
        let sum: Vec3 = (0..samples)
            .map(|index| {
                let place = (corner + sample_offset(index, samples)) / size;
                sample_colour(subject, camera, settings, place, scratch)
            })
            .sum();
        let coded = (sum / samples as f32 * 255.0).round();
        pixel.0 = [coded.x as u8, coded.y as u8, coded.z as u8, 255];
    });
    image
}

/// Place in the pixel of sample `index` of `count`: Hammersley's points, moved to the middle of their cells.
fn sample_offset(index: u32, count: u32) -> Vec2 {
    let column = (index as f32 + 0.5) / count as f32;
    let reversed = (f64::from(index.reverse_bits()) / 2.0_f64.powi(32)) as f32;
    let finest = 0.5 / count.next_power_of_two() as f32;
    Vec2::new(column, reversed + finest)
}

/// sRGB-coded colour seen through a point of the picture: (0,0) is its top left corner, (1,1) the bottom right one.
fn sample_colour<Tracer: RayTracer>(
    subject: &Subject<'_, Tracer>,
    camera: &Camera,
    settings: &RenderSettings,
    picture_point: Vec2,
    scratch: &mut Scratch,
) -> Vec3 {
    let aspect = settings.width as f32 / settings.height as f32;
    let direction = camera.direction(picture_point, aspect).normalize_or(camera.forward);
    let hit = first_front_face(subject.tracer, camera.position, direction);
    let shows_light = matches!(settings.view, View::Radiosity | View::Wireframe);
    if let Some(light) = subject.light.as_ref().filter(|_| shows_light)
        && let Some(distance) = distance_to_light(light, camera.position, direction)
        && hit.is_none_or(|hit| distance <= hit.distance + SAME_PLACE)
    {
        let front = direction.dot(light.normal()) < 0.0;
        return if front { settings.tone_map.apply(light.radiance) } else { LIGHT_BACK };
    }
    let Some(hit) = hit else {
        return BACKGROUND;
    };
    let colour = surface_colour(subject, settings, &hit, scratch);
    if settings.view != View::Wireframe {
        return colour;
    }
    let footprint = wireframe::Footprint::new(camera, direction, hit.distance, settings);
    colour.lerp(wireframe::LINE_COLOUR, wireframe::coverage(subject, &hit, &footprint))
}

/// sRGB-coded colour of the front side of a surface.
fn surface_colour<Tracer: RayTracer>(
    subject: &Subject<'_, Tracer>,
    settings: &RenderSettings,
    hit: &Hit,
    scratch: &mut Scratch,
) -> Vec3 {
    let (scene, triangle, barycentric) = (subject.scene, hit.triangle, hit.barycentric);
    let mut irradiance = || {
        let interpolated = match subject.charts {
            _ if subject.field.is_empty() => Vec3::ZERO,
            Some(charts) => charts.interpolate(subject.field, triangle, barycentric),
            None => subject.tessellation.interpolate(subject.field, triangle, barycentric),
        };
        let point = || SurfacePoint::new(scene, triangle, barycentric).on_curve(scene, barycentric, subject.tracer);
        interpolated + subject.direct.map_or(Vec3::ZERO, |direct| direct(&point(), scratch))
    };
    match settings.view {
        View::Radiosity | View::Wireframe => {
            let reflected = scene.reflectance(triangle, barycentric) * irradiance() / PI;
            settings.tone_map.apply(scene.material(triangle).emitted_radiance + reflected)
        }
        View::Irradiance | View::Direct | View::Indirect | View::Bounce(_) => {
            settings.tone_map.apply(irradiance() / PI)
        }
        View::Normals => 0.5 * scene.mesh.shading_normal(triangle, barycentric) + 0.5,
        View::Albedo => scene.reflectance(triangle, barycentric).clamp(Vec3::ZERO, Vec3::ONE).map(linear_to_srgb),
    }
}

/// The nearest front face, at its distance from `eye`, behind any number of back faces up to [`MAX_PASSED_FACES`].
pub(super) fn first_front_face(tracer: &impl RayTracer, eye: Vec3, direction: Vec3) -> Option<Hit> {
    let mut ray = Ray { origin: eye, direction, max_distance: f32::INFINITY, origin_triangle: NO_TRIANGLE };
    let (mut start, mut passed) = (0.0_f32, f32::NEG_INFINITY);
    for _ in 0..=MAX_PASSED_FACES {
        let hit = tracer.closest_hit(&ray)?;
        let distance = start + hit.distance;
        if hit.front {
            return Some(Hit { distance, ..hit });
        }
        // Go on from just before the back face, so as not to miss a front face in the same place; from just behind
        // it where that was done already, so as not to go back and forth between two back faces.
        let same_place = distance - passed <= 2.0 * SAME_PLACE;
        start = if same_place { distance + SAME_PLACE } else { distance - SAME_PLACE };
        passed = distance;
        ray.origin = eye + start * direction;
        ray.origin_triangle = hit.triangle;
    }
    None
}

/// Distance from `eye` along the unit `direction` to the light's rectangle, from either side.
fn distance_to_light(light: &AreaLight, eye: Vec3, direction: Vec3) -> Option<f32> {
    let normal = light.half_extent_u.cross(light.half_extent_v);
    let distance = (light.centre - eye).dot(normal) / direction.dot(normal);
    let offset = eye + distance * direction - light.centre;
    // Coordinates of the offset in the basis (u, v), which need not be at right angles; both are in [-1, 1] inside.
    let along_u = offset.cross(light.half_extent_v).dot(normal) / normal.length_squared();
    let along_v = light.half_extent_u.cross(offset).dot(normal) / normal.length_squared();
    (distance > 0.0 && along_u.abs() <= 1.0 && along_v.abs() <= 1.0).then_some(distance)
}
