//! Area-averaged vertices (eq. 7): sample points over all elements around a vertex, dense where its weight is large.

use glam::{Vec2, Vec3};

use super::{sampling::hat_point, trace_rows::Transport};
use crate::{
    math::sequence::{Sequence, Stream},
    scene::{Tessellation, mesh::interpolate},
    trace::SurfacePoint,
};

/// Direct light is computed at no more than this many of a vertex's sample points.
const MOST_DIRECT: usize = 64;

/// Where the sample points of one vertex lie: the element and the place in it.
#[derive(Debug, Default)]
pub struct Star {
    places: Vec<(u32, Vec2)>,
    areas: Vec<f32>,
}

/// What a vertex's value weighs at each vertex, in the mean over its sample points: it sums to 1.
pub type HatRow = Vec<(u32, f32)>;

impl Star {
    /// Puts one point a ray into `points`, with density b_i(x) / ∫ b_i dA around vertex i: eq. 7 is then a plain mean.
    pub fn collect(&mut self, transport: &Transport, vertex: u32, points: &mut Vec<SurfacePoint>) {
        let &Transport { scene, tracer, tessellation, sampler, seed, .. } = transport;
        let rays = transport.rays_of(vertex);
        let around = transport.origins.elements_around(vertex);
        points.clear();
        self.places.clear();
        self.areas.clear();
        self.areas.extend(around.iter().map(|&element| tessellation.mesh.area(element)));
        let total: f32 = self.areas.iter().sum();
        if total <= 0.0 {
            return;
        }
        let sequence = Sequence::new(sampler, seed, vertex, Stream::Hemisphere, rays);
        for index in 0..rays {
            let place = sequence.sample_4d(index).1;
            let (chosen, rest) = choose(&self.areas, place.x * total);
            let element = around[chosen];
            let corner = tessellation.mesh.triangles[element as usize].iter().position(|&corner| corner == vertex);
            let barycentric = hat_point(Vec2::new(rest, place.y), corner.unwrap_or(0));
            let triangle = tessellation.scene_triangle[element as usize];
            let on_triangle = interpolate(tessellation.corner_barycentrics[element as usize], barycentric);
            points.push(SurfacePoint::new(scene, triangle, on_triangle).on_curve(scene, on_triangle, tracer));
            self.places.push((element, barycentric));
        }
    }

    /// The mean weights of the vertices at those sample points that `is_used`, and at the few of them where direct light
    /// is computed.
    pub fn hat_rows(&self, tessellation: &Tessellation, is_used: impl Fn(usize) -> bool) -> [HatRow; 2] {
        let used: Vec<usize> = (0..self.places.len()).filter(|&place| is_used(place)).collect();
        let mean = |places: &mut dyn Iterator<Item = usize>| {
            let mut row = HatRow::new();
            let mut count = 0.0;
            for place in places {
                let (element, Vec2 { x, y }) = self.places[place];
                let corners = tessellation.mesh.triangles[element as usize];
                for (vertex, weight) in corners.into_iter().zip([1.0 - x - y, x, y]) {
                    match row.iter_mut().find(|(other, _)| *other == vertex) {
                        Some((_, sum)) => *sum += weight,
                        None => row.push((vertex, weight)),
                    }
                }
                count += 1.0;
            }
            row.iter_mut().for_each(|(_, weight)| *weight /= count);
            row
        };
        let direct = used.iter().enumerate().filter(|(index, _)| is_direct(*index, used.len()));
        [mean(&mut used.iter().copied()), mean(&mut direct.map(|(_, &place)| place))]
    }
}

/// True if direct light is computed at used sample `index` of `count`: some [`MOST_DIRECT`] evenly among them.
fn is_direct(index: usize, count: usize) -> bool {
    let group = |index: usize| index * MOST_DIRECT / count.max(1);
    index == 0 || group(index) != group(index - 1)
}

/// Leaves the origins where direct light is computed, each with what was found from all that it stands for.
pub(super) fn thin_out(origins: &mut Vec<SurfacePoint>, found: &mut Vec<Vec3>) {
    let count = origins.len();
    let mut kept = 0;
    for index in 0..count {
        if is_direct(index, count) {
            (origins[kept], found[kept]) = (origins[index], found[index]);
            kept += 1;
        } else {
            let more = found[index];
            found[kept - 1] += more;
        }
    }
    origins.truncate(kept);
    found.truncate(kept);
}

/// Which part of the areas `place` lies in, and where within it, from 0 to 1.
fn choose(areas: &[f32], place: f32) -> (usize, f32) {
    let mut before = 0.0;
    for (index, &area) in areas.iter().enumerate() {
        if place < before + area || index + 1 == areas.len() {
            // An area may be nothing.
            return (index, ((place - before) / area.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0));
        }
        before += area;
    }
    (0, 0.0)
}
