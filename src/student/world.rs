//! What is given: the scene as the functions of [`super::irradiance`] see it. Nothing here is to be written.

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::Functions;
use crate::{
    math::sequence::{Sampler, Sequence, Stream},
    scene::{AreaLight, Material, Scene, Tessellation},
    trace::{Ray, RayTracer, SurfacePoint},
};

/// Everything there is to look at while irradiance is gathered.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// The triangles, materials and textures.
    pub scene: &'a Scene,
    /// Traces rays.
    pub tracer: &'a dyn RayTracer,
    /// The elements: the mesh whose vertices carry irradiance.
    pub tessellation: &'a Tessellation,
    /// The area light, if there is one.
    pub light: Option<AreaLight>,
    /// The functions in use: the points of `stratified` and `sobol` come from them once they are written.
    pub functions: &'a Functions,
    /// How sample points are placed.
    pub sampler: Sampler,
    /// Seed of all sample points.
    pub seed: u64,
    /// Samples a vertex on the light.
    pub light_rays: u32,
    /// Gather rays a vertex.
    pub rays: u32,
}

/// A point that receives light: close to a vertex, inside one of the elements around it. The irradiance of a vertex is
/// the mean over its receivers; each takes one run of the vertex's samples.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The vertex.
    pub vertex: u32,
    /// Which of the vertex's receivers this is, and how many there are.
    pub place: (u32, u32),
    /// The point; [`SurfacePoint::ray`] and [`SurfacePoint::ray_to`] make rays that leave it without meeting its own
    /// triangle.
    pub point: SurfacePoint,
}

/// What a ray met.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit<'a> {
    /// False if the ray met the back of a surface: surfaces are one-sided, and the ray is absorbed.
    pub front: bool,
    /// Distance along the ray, in local units.
    pub distance: f32,
    /// The vertices of the element that was met.
    pub vertices: [u32; 3],
    /// Where in that element: barycentric coordinates (u, v) for (1-u-v) a + u b + v c.
    pub barycentric: Vec2,
    /// The surface's material.
    pub material: &'a Material,
    /// Texture coordinates at the hit; v points up.
    pub texcoord: Vec2,
}

impl Receiver {
    /// The vertex's unit normal: the axis of the hemisphere.
    pub fn normal(&self) -> Vec3 {
        self.point.shading_normal
    }

    /// This receiver's share of `count` samples of the vertex.
    fn share(&self, count: u32) -> Range<u32> {
        let (place, places) = (u64::from(self.place.0), u64::from(self.place.1.max(1)));
        let start = |place: u64| (u64::from(count) * place / places) as u32;
        start(place)..start(place + 1)
    }
}

impl<'a> World<'a> {
    /// The receiver's sample points for the light, in the unit square; there may be none.
    pub fn light_points(&self, receiver: &Receiver) -> impl ExactSizeIterator<Item = Vec2> + use<'a> {
        self.points(receiver, Stream::AreaLight, self.light_rays)
    }

    /// The receiver's sample points for directions, in the unit square; there may be none.
    pub fn hemisphere_points(&self, receiver: &Receiver) -> impl ExactSizeIterator<Item = Vec2> + use<'a> {
        self.points(receiver, Stream::Hemisphere, self.rays)
    }

    fn points(&self, receiver: &Receiver, stream: Stream, count: u32) -> impl ExactSizeIterator<Item = Vec2> + use<'a> {
        let sequence = |sampler| Sequence::new(sampler, self.seed, receiver.vertex, stream, count);
        let (random, given) = (sequence(Sampler::Random), sequence(self.sampler));
        let (functions, sampler) = (self.functions, self.sampler);
        // One shift for all points of the vertex, so that neighbours differ (Cranley and Patterson 1976).
        let shift = Sequence::new(Sampler::Random, !self.seed, receiver.vertex, stream, 1).sample_2d(0);
        let is_written = functions.writes_points_of(sampler);
        receiver.share(count).map(move |index| match sampler {
            Sampler::Stratified => (functions.stratified_point)(index, count, random.sample_2d(index)),
            Sampler::Sobol if is_written => ((functions.low_discrepancy_point)(index) + shift).fract(),
            _ => given.sample_2d(index),
        })
    }

    /// What a ray meets first, if anything.
    pub fn trace(&self, ray: &Ray) -> Option<SurfaceHit<'a>> {
        let hit = self.tracer.closest_hit(ray)?;
        let (element, barycentric) = self.tessellation.locate(hit.triangle, hit.barycentric);
        Some(SurfaceHit {
            front: hit.front,
            distance: hit.distance,
            vertices: self.tessellation.mesh.triangles[element as usize],
            barycentric,
            material: self.scene.material(hit.triangle),
            texcoord: self.scene.mesh.texcoord(hit.triangle, hit.barycentric),
        })
    }

    /// True if anything lies between the ray's origin and its `max_distance`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.tracer.occluded(ray)
    }
}

impl Functions {
    /// Whether the points of a sampler come from these functions: `sobol` from `low_discrepancy_point` once it is
    /// written (until then from the crate), `stratified` always.
    fn writes_points_of(&self, sampler: Sampler) -> bool {
        let first = (self.low_discrepancy_point)(1);
        sampler == Sampler::Stratified || first != (super::PLACEHOLDERS.low_discrepancy_point)(1)
    }
}
