//! Form factors between patches by rays, as the first radiosity programs on a ray tracer found them: constant patches,
//! each pair once, and one ray between the middles of two patches to tell whether they see each other.
//!
//! What two patches exchange, A_i F_ij = A_j F_ji (reciprocity), is found for pairs i < j alone. The middle is the centre
//! of the incircle: the point of a triangle that lies farthest from its edges, so that no ray runs along one.

use std::{
    f64::consts::PI,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{SolveSettings, form_factors::FormFactors, patches::Patches, reconstruct::point_context};
use crate::{
    lightmap::{FormFactorSettings, PairKernel},
    math::sequence::{Sampler, Sequence, Stream},
    scene::{AreaLight, Scene, Tessellation, mesh::interpolate},
    trace::{Ray, RayTracer, SurfacePoint, surface::lift},
    transport::{
        Lights, direct::DirectContext, direct::ShadowRays, polygon_form_factor, sampling::triangle_point,
        visible_light::Scratch,
    },
};

/// Rays between two looks at whether to go on: well below a millisecond of work.
const RAYS_PER_LOOK: u32 = 1024;

/// Cosines below this are rounding errors of places in one plane.
const LEAST_COSINE: f32 = 1e-6;

/// [`PairKernel::Polygon`] takes the closed form where two patches are nearer than so many times their size, the root of
/// the sum of their areas; beyond that points err by less than a hundredth.
const NEAR: f32 = 5.0;

/// Patches, ready for rays.
pub struct PatchRays<'a> {
    scene: &'a Scene,
    tracer: &'a dyn RayTracer,
    settings: &'a FormFactorSettings,
    places: Vec<Place>,
}

/// Where a patch lies.
struct Place {
    corners: [Vec3; 3],
    centre: SurfacePoint,
    area: f32,
}

impl<'a> PatchRays<'a> {
    /// Takes the elements of a tessellation as patches.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a dyn RayTracer,
        tessellation: &Tessellation,
        patches: &Patches,
        settings: &'a FormFactorSettings,
    ) -> Self {
        let place = |(element, area): (usize, &f32)| {
            let corners = tessellation.mesh.corners(element as u32);
            let inside = interpolate(tessellation.corner_barycentrics[element], incircle_centre(corners));
            let centre = SurfacePoint::new(scene, tessellation.scene_triangle[element], inside);
            Place { corners, centre, area: *area }
        };
        Self { scene, tracer, settings, places: patches.areas.iter().enumerate().map(place).collect() }
    }

    /// Irradiance of all lights, the emissive triangles among them, at the patches' centres [W/m²]; of no use once
    /// `is_cancelled`.
    pub fn direct_irradiance(&self, light: Option<AreaLight>, is_cancelled: &(dyn Fn() -> bool + Sync)) -> Vec<Vec3> {
        let (lights, settings) = (Lights::new(self.scene, light), SolveSettings::even());
        let context = point_context(self.scene, self.tracer, &lights, &settings);
        let context = DirectContext { is_cancelled, ..context };
        let at = |scratch: &mut Scratch, place: &Place| {
            context.at_point(&place.centre, scratch, &mut ShadowRays::default()).irradiance()
        };
        self.places.par_iter().map_init(Scratch::default, at).collect()
    }

    /// All form factors, and the number of rays that were traced; none if it was stopped. `go_on` gets the part that is
    /// done, from any thread, and stops it by returning false.
    pub fn form_factors(&self, go_on: &(dyn Fn(f32) -> bool + Sync)) -> Option<(FormFactors, u64)> {
        let count = self.places.len();
        let all_pairs = (count * count.saturating_sub(1) / 2).max(1);
        let (pairs, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let advance = |done: usize| {
            let done = pairs.fetch_add(done as u64, Relaxed) + done as u64;
            go_on(done as f32 / all_pairs as f32)
        };
        let rows = (0..count).into_par_iter().map(|from| self.exchanges(from, &advance, &rays));
        let rows = rows.collect::<Option<Vec<Vec<(u32, f32)>>>>()?;
        both_ways(rows, &self.places, || go_on(1.0)).map(|factors| (factors, rays.into_inner()))
    }

    /// What one patch exchanges with those of higher numbers; none if it was stopped.
    fn exchanges(&self, from: usize, advance: &dyn Fn(usize) -> bool, rays: &AtomicU64) -> Option<Vec<(u32, f32)>> {
        let pairs_per_look = (RAYS_PER_LOOK / self.settings.pair_rays).max(1) as usize;
        let (mut row, mut traced) = (Vec::new(), 0);
        let mut to = from + 1;
        while to < self.places.len() {
            let end = (to + pairs_per_look).min(self.places.len());
            for other in to..end {
                let exchange = self.exchange(from, other, &mut traced);
                if exchange > 0.0 {
                    row.push((other as u32, exchange as f32));
                }
            }
            if !advance(end - to) {
                return None;
            }
            to = end;
        }
        row.shrink_to_fit();
        rays.fetch_add(traced, Relaxed);
        Some(row)
    }

    /// A_i F_ij of two patches: the mean of the kernel over pairs of points that see each other.
    fn exchange(&self, from: usize, to: usize, traced: &mut u64) -> f64 {
        let pair = [&self.places[from], &self.places[to]];
        let normals = pair.map(|place| place.centre.geometric_normal);
        if pair[0].centre.triangle == pair[1].centre.triangle {
            return 0.0;
        }
        let count = self.settings.pair_rays;
        // A sequence for each pair: the first number is its element, the second its seed.
        let points = Sequence::new(Sampler::Stratified, to as u64, from as u32, Stream::Surface, count);
        let mut sum = 0.0;
        for index in 0..count {
            let [origin, target] = if count == 1 {
                pair.map(|place| place.centre.origin)
            } else {
                let (here, there) = points.sample_4d(index);
                [pair[0].point(here), pair[1].point(there)]
            };
            let distance = origin.distance(target);
            let direction = (target - origin) / distance;
            let cosines = [normals[0].dot(direction), -normals[1].dot(direction)];
            if !cosines.iter().all(|cosine| *cosine > LEAST_COSINE) {
                continue;
            }
            *traced += 1;
            let ray = Ray { origin, direction, max_distance: distance, origin_triangle: pair[0].centre.triangle };
            if !self.tracer.occluded(&ray) {
                sum += self.kernel(pair, [origin, target], cosines);
            }
        }
        // No patch sends more than all, or gets more than fills its view.
        (sum / f64::from(count)).min(f64::from(pair[0].area.min(pair[1].area)))
    }

    /// What two patches that see each other exchange, by one point of each.
    fn kernel(&self, pair: [&Place; 2], [origin, target]: [Vec3; 2], cosines: [f32; 2]) -> f64 {
        let areas = pair.map(|place| f64::from(place.area));
        let squared = origin.distance_squared(target);
        let is_near = squared < NEAR * NEAR * (pair[0].area + pair[1].area);
        if self.settings.kernel == PairKernel::Polygon && is_near {
            let seen = |here: Vec3, from: &Place, to: &Place| {
                polygon_form_factor(here, from.centre.geometric_normal, &to.corners)
            };
            let there = areas[0] * seen(origin, pair[0], pair[1]);
            return 0.5 * (there + areas[1] * seen(target, pair[1], pair[0]));
        }
        areas[0] * areas[1] * f64::from(cosines[0]) * f64::from(cosines[1]) / (PI * f64::from(squared))
    }
}

impl Place {
    /// A point, lifted as rays leave from it.
    fn point(&self, sample: Vec2) -> Vec3 {
        lift(triangle_point(self.corners, sample).1, self.centre.geometric_normal, self.corners)
    }
}

/// Barycentric coordinates of the centre of a triangle's incircle: each corner weighs as much as the side opposite to it.
fn incircle_centre([a, b, c]: [Vec3; 3]) -> Vec2 {
    let sides = Vec3::new(b.distance(c), c.distance(a), a.distance(b));
    Vec2::new(sides.y, sides.z) / sides.element_sum()
}

/// The rows of form factors from what pairs exchange, which is used up on the way; none if it was stopped.
fn both_ways(exchanges: Vec<Vec<(u32, f32)>>, places: &[Place], go_on: impl Fn() -> bool) -> Option<FormFactors> {
    let areas: Vec<f32> = places.iter().map(|place| place.area).collect();
    let mut lengths: Vec<usize> = exchanges.iter().map(Vec::len).collect();
    exchanges.iter().flatten().for_each(|(to, _)| lengths[*to as usize] += 1);
    let mut rows: Vec<Vec<(u32, f32)>> = lengths.into_iter().map(Vec::with_capacity).collect();
    for (from, row) in exchanges.into_iter().enumerate() {
        if !go_on() {
            return None;
        }
        for (to, exchange) in row {
            rows[from].push((to, exchange / areas[from]));
            rows[to as usize].push((from as u32, exchange / areas[to as usize]));
        }
    }
    Some(FormFactors { areas, rows })
}

/// Why form factors between so many patches cannot be kept in so many bytes, if they may not fit.
pub fn memory_problem(patches: usize, bytes: u64) -> Option<String> {
    let most = size_of::<(u32, f32)>() as u64 * (patches as u64).saturating_pow(2);
    let mebibytes = |bytes: u64| bytes.div_ceil(1 << 20);
    (most > bytes).then(|| {
        format!(
            "{patches} patches may have {} MiB of form factors, more than the {} MiB that a quarter of the memory is; cut \
             less finely (--subdivide, --max-edge)",
            mebibytes(most),
            mebibytes(bytes)
        )
    })
}
