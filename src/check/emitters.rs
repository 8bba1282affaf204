//! The lights of the reference path tracer: where they are sampled, and how dense when they are met by chance.

use glam::{Vec2, Vec3};
use rand::{RngExt, rngs::SmallRng};

use crate::{
    math::color::luminance,
    scene::{AreaLight, Scene},
    trace::Hit,
};

/// A sampled point of a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPoint {
    pub(super) position: Vec3,
    /// Unit normal of the side that shines.
    pub(super) normal: Vec3,
    pub(super) radiance: Vec3,
    /// Density of the sample per local unit².
    pub(super) pdf_area: f32,
}

/// A light as a ray meets it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    pub(super) radiance: Vec3,
    /// Density [1/sr] with which sampling the light would have taken this direction.
    pub(super) pdf_solid_angle: f32,
}

/// The placed area light.
pub(super) struct AreaEmitter {
    light: AreaLight,
    normal: Vec3,
    pdf_area: f32,
}

impl AreaEmitter {
    /// `None` for a light without area or radiance.
    pub(super) fn new(light: &AreaLight) -> Option<Self> {
        let pdf_area = 1.0 / light.area();
        let shines = pdf_area.is_finite() && light.radiance.max_element() > 0.0;
        shines.then(|| Self { light: *light, normal: light.normal(), pdf_area })
    }

    pub(super) fn sample(&self, generator: &mut SmallRng) -> LightPoint {
        let along_u = self.light.half_extent_u * (2.0 * generator.random::<f32>() - 1.0);
        let along_v = self.light.half_extent_v * (2.0 * generator.random::<f32>() - 1.0);
        LightPoint {
            position: self.light.centre + along_u + along_v,
            normal: self.normal,
            radiance: self.light.radiance,
            pdf_area: self.pdf_area,
        }
    }

    /// The light where a ray of unit `direction` meets its shining side before `nearest`.
    pub(super) fn meet(&self, origin: Vec3, direction: Vec3, nearest: f32) -> Option<Light> {
        let cosine = -direction.dot(self.normal);
        let distance = (origin - self.light.centre).dot(self.normal) / cosine;
        if !(cosine > 0.0 && distance > 0.0 && distance < nearest) {
            return None;
        }
        let (u, v) = (self.light.half_extent_u, self.light.half_extent_v);
        let offset = origin + distance * direction - self.light.centre;
        let doubled_area = u.cross(v).dot(self.normal);
        let place = Vec2::new(offset.cross(v).dot(self.normal), u.cross(offset).dot(self.normal)) / doubled_area;
        (place.abs().max_element() <= 1.0).then(|| Light {
            radiance: self.light.radiance,
            pdf_solid_angle: self.pdf_area * distance * distance / cosine,
        })
    }
}

/// The triangles whose material emits, chosen by their power.
pub(super) struct EmissiveTriangles<'a> {
    scene: &'a Scene,
    triangles: Vec<u32>,
    /// Sum of area × luminance up to and with each triangle.
    cumulative: Vec<f64>,
}

impl<'a> EmissiveTriangles<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        let triangles: Vec<u32> = scene.emissive_triangles().collect();
        let mut sum = 0.0;
        let cumulative = triangles
            .iter()
            .map(|&triangle| {
                let radiance = scene.material(triangle).emitted_radiance;
                sum += f64::from(scene.mesh.area(triangle)) * f64::from(luminance(radiance));
                sum
            })
            .collect();
        Self { scene, triangles, cumulative }
    }

    /// A point on one of the triangles, and which; `None` if none shines.
    pub(super) fn sample(&self, generator: &mut SmallRng) -> Option<(u32, LightPoint)> {
        let power = self.power();
        if power <= 0.0 {
            return None;
        }
        let choice = generator.random::<f64>() * power;
        let place = self.cumulative.partition_point(|&sum| sum <= choice).min(self.triangles.len() - 1);
        let triangle = self.triangles[place];
        // Uniform over the triangle (Osada et al. 2002).
        let root = generator.random::<f32>().sqrt();
        let share = generator.random::<f32>();
        let barycentric = Vec2::new(root * (1.0 - share), root * share);
        let is_hole = self.scene.may_be_cut_out(triangle) && self.scene.is_cut_out(triangle, barycentric);
        let radiance = self.scene.material(triangle).emitted_radiance;
        let point = LightPoint {
            position: self.scene.mesh.position(triangle, barycentric),
            normal: self.scene.mesh.geometric_normal(triangle),
            radiance: if is_hole { Vec3::ZERO } else { radiance },
            pdf_area: self.pdf_area(radiance),
        };
        Some((triangle, point))
    }

    /// The light at a hit by a ray of unit `direction`, if it is the shining side of one of the triangles.
    pub(super) fn meet(&self, hit: &Hit, direction: Vec3) -> Option<Light> {
        let radiance = self.scene.material(hit.triangle).emitted_radiance;
        if !hit.front || radiance.max_element() <= 0.0 {
            return None;
        }
        let cosine = -direction.dot(self.scene.mesh.geometric_normal(hit.triangle));
        let pdf_solid_angle = self.pdf_area(radiance) * hit.distance * hit.distance / cosine.max(f32::MIN_POSITIVE);
        Some(Light { radiance, pdf_solid_angle })
    }

    /// Density per local unit² of a point on a triangle of this radiance: its area cancels.
    fn pdf_area(&self, radiance: Vec3) -> f32 {
        (f64::from(luminance(radiance)) / self.power()) as f32
    }

    fn power(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }
}
