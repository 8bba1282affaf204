//! Fine elements that follow direct light.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{COARSEST_EDGE, Coarse, Context, FINEST_EDGE, FINEST_SAMPLED_EDGE, NOISE, Rounds, cut, edge_length};
use crate::{
    scene::{Tessellation, mesh::interpolate, tessellate::Refinement},
    solver::{
        kept::{DirectAtVertices, SmoothValues, in_the_middle, mean},
        monitor::Stage,
    },
    trace::{SurfacePoint, surface::lift},
    transport::{
        VertexOrigins,
        direct::{DirectLight, ShadowRays},
        visible_light::Scratch,
    },
};

/// Vertices or elements that one task handles.
const PER_TASK: usize = 64;

/// While direct light is followed, other elements are shown no sooner than after this time.
const SHOWN_INTERVAL: Duration = Duration::from_millis(250);

/// The light of a vertex's starts may differ by so much of the largest for it to be found in their middle when it is lit anew.
const LARGEST_UNEVENNESS: f32 = 0.1;

pub(super) struct DirectElements<'a> {
    context: &'a Context<'a>,
    pub(super) refinement: Refinement,
    pub(super) tessellation: Arc<Tessellation>,
    /// Direct light at the vertices, but for the gather rays' share.
    pub(super) direct: DirectAtVertices,
    pub(super) buried: Vec<bool>,
    pub(super) shadow_rays: ShadowRays,
    /// What all threads together spent on direct light.
    pub(super) nanoseconds: AtomicU64,
    /// Mean direct light [W/m²] of what is lit.
    pub(super) scale: f32,
    rounds: Rounds<'a>,
    last_shown: Instant,
}

/// Direct light at one vertex.
#[derive(Clone, Copy, Default)]
struct Found {
    is_buried: bool,
    rays: ShadowRays,
}

impl<'a> DirectElements<'a> {
    pub(super) fn new(context: &'a Context<'a>) -> Self {
        let refinement = Refinement::new(&context.problem.scene);
        let tessellation = Arc::clone(&context.problem.tessellation);
        let (direct, buried, shadow_rays, nanoseconds) = Default::default();
        let (scale, rounds, last_shown) = (1.0, Rounds::new(context.monitor), Instant::now());
        Self { context, refinement, tessellation, direct, buried, shadow_rays, nanoseconds, scale, rounds, last_shown }
    }

    /// Cuts until direct light is near what the corners say, in every element.
    pub(super) fn follow_light(&mut self, tolerance: f32) {
        self.context.monitor.enter_stage(Stage::FollowingDirect, 0, 1, 1.0);
        let mut first_new = 0;
        loop {
            self.find_direct_light();
            let nodes: Vec<u32> = self.refinement.nodes().collect();
            let wanted = self.wanted(|scratch, element| {
                nodes[element as usize] >= first_new && {
                    let started = Instant::now();
                    let bends = self.direct_light_bends(element, tolerance, scratch);
                    self.nanoseconds.fetch_add(started.elapsed().as_nanos() as u64, Relaxed);
                    bends
                }
            });
            first_new = self.refinement.node_count();
            if !self.cut(&wanted) {
                break;
            }
        }
        self.context.monitor.show_elements(&self.tessellation, &self.field());
    }

    /// Cuts until the elements are no coarser than the coarse ones, nor than the bends of the smooth field on those.
    pub(super) fn follow_smooth_field(&mut self, coarse: &Coarse, field: &[Vec3], tolerance: f32) {
        let below_all = &coarse.sources.tessellation;
        let smooth = SmoothValues::new(&coarse.smooth, below_all, field);
        loop {
            let wanted = self.wanted(|_, element| {
                let fine = &self.tessellation;
                let middle = fine.corner_barycentrics[element as usize].iter().sum::<Vec2>() / 3.0;
                let below = below_all.locate(fine.scene_triangle[element as usize], middle).0;
                if fine.mesh.area(element) > 1.4 * below_all.mesh.area(below) {
                    return true;
                }
                let ends = self.refinement.longest_edge(element);
                let length = edge_length(fine, ends);
                let corners = fine.mesh.triangles[element as usize];
                let inside = fine.corner_barycentrics[element as usize];
                let place = |vertex: u32| inside[corners.iter().position(|&corner| corner == vertex).unwrap_or(0)];
                let [a, b] = ends.map(place);
                let triangle = fine.scene_triangle[element as usize];
                let at = |place| smooth.at(below_all.locate(triangle, place)).max(Vec3::ZERO);
                let left = (at(0.5 * (a + b)) - 0.5 * (at(a) + at(b))).abs().max_element() / self.scale;
                length > FINEST_EDGE && left * length > tolerance
            });
            if !self.cut(&wanted) {
                return;
            }
            self.find_direct_light();
        }
    }

    /// True if no direct light was found anywhere.
    pub(super) fn is_dark(&self) -> bool {
        self.direct.light.iter().all(|light| light.irradiance() == Vec3::ZERO)
    }

    /// Direct irradiance [W/m²] at the vertices.
    pub(super) fn field(&self) -> Vec<Vec3> {
        self.direct.light.iter().map(DirectLight::irradiance).collect()
    }

    /// The elements for which `is_wanted` says so.
    fn wanted(&self, is_wanted: impl Fn(&mut Scratch, u32) -> bool + Sync) -> Vec<u32> {
        let elements: Vec<u32> = (0..self.tessellation.mesh.triangles.len() as u32).collect();
        let wanted = |elements: &[u32]| {
            let mut scratch = Scratch::default();
            let go_on = |_: &&u32| !self.context.is_cancelled();
            let elements = elements.iter().take_while(go_on);
            elements.copied().filter(|&element| is_wanted(&mut scratch, element)).collect::<Vec<u32>>()
        };
        elements.par_chunks(PER_TASK).flat_map_iter(wanted).collect()
    }

    fn cut(&mut self, wanted: &[u32]) -> bool {
        let is_cut = cut(self.context, &mut self.refinement, wanted);
        if is_cut {
            self.tessellation = Arc::new(self.refinement.tessellation(&self.context.problem.scene));
        }
        is_cut
    }

    /// Direct light at the vertices that have come since the last call, from those origins that are not buried.
    fn find_direct_light(&mut self) {
        let monitor = self.context.monitor;
        if monitor.is_watched() && self.last_shown.elapsed() > SHOWN_INTERVAL {
            monitor.show_elements(&self.tessellation, &self.field());
            self.last_shown = Instant::now();
        }
        let origins = VertexOrigins::new(&self.tessellation);
        let vertices: Vec<u32> =
            (self.direct.light.len() as u32..self.tessellation.mesh.positions.len() as u32).collect();
        self.rounds.begin(vertices.len() as u64);
        let found: Vec<_> =
            vertices.par_chunks(PER_TASK).map(|vertices| self.direct_light_at(&origins, vertices)).collect();
        for (light, found) in found {
            self.direct.append(&light);
            for Found { is_buried, rays } in found {
                self.buried.push(is_buried);
                self.shadow_rays.add(&rays);
            }
        }
        self.scale = mean_of_lit(&self.field(), &self.tessellation.vertex_areas());
    }

    fn direct_light_at(&self, origins: &VertexOrigins, vertices: &[u32]) -> (DirectAtVertices, Vec<Found>) {
        let Context { problem, monitor, .. } = *self.context;
        monitor.wait_while_paused();
        let started = Instant::now();
        let (mut scratch, mut starts, mut usable) = (Scratch::default(), Vec::new(), Vec::new());
        let direct = self.context.direct();
        let (mut lights, mut traced) = (DirectAtVertices::default(), 0);
        let at = |&vertex: &u32| {
            let mut found = Found::default();
            if self.context.is_cancelled() {
                lights.push(DirectLight::default(), &[]);
                return found;
            }
            origins.collect((&problem.scene, &*problem.tracer), &self.tessellation, vertex, &mut starts);
            usable.clear();
            let (mut least, mut most) = (f32::INFINITY, 0.0_f32);
            let light = mean(starts.iter().filter_map(|origin| {
                let light = direct.at_point(origin, &mut scratch, &mut found.rays);
                let is_usable = light.irradiance() != Vec3::ZERO || !origin.is_buried(&*problem.tracer);
                usable.extend(is_usable.then_some(*origin));
                if is_usable {
                    let sum = light.irradiance().element_sum();
                    (least, most) = (least.min(sum), most.max(sum));
                }
                is_usable.then_some(light)
            }));
            found.is_buried = usable.is_empty() && !starts.is_empty();
            // At the corner of what stands there, some starts may lie in its shadow and others not.
            let is_even = most - least <= LARGEST_UNEVENNESS * most;
            match in_the_middle(&usable).filter(|_| is_even) {
                Some(middle) => lights.push(light, &[middle]),
                None => lights.push(light, &usable),
            }
            monitor.add_live(vertex as usize, light.irradiance());
            traced += found.rays.traced;
            found
        };
        let found = vertices.iter().map(at).collect();
        self.nanoseconds.fetch_add(started.elapsed().as_nanos() as u64, Relaxed);
        monitor.advance(vertices.len() as u64, traced);
        (lights, found)
    }

    /// True if an element is too coarse for direct light: at its middle, or in the middle of its longest edge.
    fn direct_light_bends(&self, element: u32, tolerance: f32, scratch: &mut Scratch) -> bool {
        let corners = self.tessellation.mesh.triangles[element as usize];
        let ends = self.refinement.longest_edge(element);
        let length = edge_length(&self.tessellation, ends);
        if length > COARSEST_EDGE {
            return true;
        }
        let free = corners.iter().filter(|&&vertex| !self.buried[vertex as usize]);
        let at_corner = |vertex: u32| self.direct.light[vertex as usize].irradiance();
        let (sum, count) = free.fold((Vec3::ZERO, 0.0), |(sum, count), &vertex| (sum + at_corner(vertex), count + 1.0));
        if length < FINEST_EDGE || count == 0.0 || self.context.lights.is_empty() {
            return false;
        }
        let values = corners.map(|vertex| if self.buried[vertex as usize] { sum / count } else { at_corner(vertex) });
        let error_at = |vertex: u32| self.direct.light[vertex as usize].squared_error;
        let corner_error = corners.map(error_at).into_iter().sum::<Vec3>() / 9.0;
        let opposite = corners.iter().position(|vertex| !ends.contains(vertex)).unwrap_or(0);
        let middle = Vec3::splat(1.0 / 3.0);
        let edge_middle = (0.5 * (Vec3::ONE - Vec3::AXES[opposite])).lerp(middle, 0.01);
        let direct = self.context.direct();
        [edge_middle, middle].into_iter().any(|weights| {
            let place = Vec2::new(weights.y, weights.z);
            let point = self.point_in_element(element, place);
            let mut rays = ShadowRays::default();
            let light = direct.at_point(&point, scratch, &mut rays);
            let (found, squared_error) = (light.irradiance(), light.squared_error);
            let finest = if rays.traced > 0 { FINEST_SAMPLED_EDGE } else { FINEST_EDGE };
            // What may be noise of the samples says nothing.
            let noise = NOISE * (squared_error + corner_error).max_element().sqrt();
            let difference = ((found - interpolate(values, place)).abs().max_element() - noise) / self.scale;
            difference * length > tolerance
                && length > finest
                && (found != Vec3::ZERO || !point.is_buried(&*self.context.problem.tracer))
        })
    }

    fn point_in_element(&self, element: u32, place: Vec2) -> SurfacePoint {
        let (mesh, problem) = (&self.tessellation.mesh, self.context.problem);
        let scene = &problem.scene;
        let triangle = self.tessellation.scene_triangle[element as usize];
        let geometric_normal = scene.mesh.geometric_normal(triangle);
        let normals = mesh.triangles[element as usize].map(|vertex| mesh.normals[vertex as usize]);
        let position = interpolate(mesh.corners(element), place);
        let on_triangle = interpolate(self.tessellation.corner_barycentrics[element as usize], place);
        let point = SurfacePoint {
            origin: lift(position, geometric_normal, scene.mesh.corners(triangle)),
            geometric_normal,
            shading_normal: interpolate(normals, place).normalize_or(geometric_normal),
            triangle,
        };
        point.on_curve(scene, on_triangle, &*problem.tracer)
    }
}

/// What is lit at once may be brighter than the mean of all surface by this factor, for its mean to be that of all light.
const MOST_OVER_MEAN: f64 = 1.6;

/// The area mean of what is not dark; 1 if all is dark. Where little is lit at once, bounces make most of the light: then
/// [`MOST_OVER_MEAN`] times the mean of all.
pub(super) fn mean_of_lit(field: &[Vec3], areas: &[f32]) -> f32 {
    let lit = field.iter().zip(areas).filter(|(value, _)| value.max_element() > 0.0);
    let (sum, area) = lit.fold((0.0_f64, 0.0_f64), |(sum, area), (value, share)| {
        (sum + f64::from(value.element_sum() / 3.0 * share), area + f64::from(*share))
    });
    let all: f64 = areas.iter().map(|&area| f64::from(area)).sum();
    if sum > 0.0 { (sum / area.max(all / MOST_OVER_MEAN)) as f32 } else { 1.0 }
}
