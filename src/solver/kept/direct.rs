//! Direct light at vertices, and the points where it was found, at which another light can be.

use glam::Vec3;

use crate::{trace::SurfacePoint, transport::direct::DirectLight};

/// Direct light at the vertices of a solve's elements.
#[derive(Clone, Default)]
pub(in crate::solver) struct DirectAtVertices {
    /// As it was found; 0 at buried vertices.
    pub(in crate::solver) light: Vec<DirectLight>,
    /// The points at which another light is found, of one vertex after the other.
    points: Vec<SurfacePoint>,
    /// Where those of each vertex end.
    ends: Vec<u32>,
}

impl DirectAtVertices {
    /// Adds a vertex with the points where its light was found.
    pub(in crate::solver) fn push(&mut self, light: DirectLight, points: &[SurfacePoint]) {
        self.light.push(light);
        self.points.extend(points);
        self.ends.push(self.points.len() as u32);
    }

    /// Adds the vertices of another one.
    pub(in crate::solver) fn append(&mut self, other: &Self) {
        let before = self.points.len() as u32;
        self.light.extend(&other.light);
        self.points.extend(&other.points);
        self.ends.extend(other.ends.iter().map(|end| before + end));
    }

    pub(super) fn points_of(&self, vertex: u32) -> &[SurfacePoint] {
        let end = |vertex: usize| self.ends[vertex] as usize;
        let start = (vertex as usize).checked_sub(1).map_or(0, end);
        &self.points[start..end(vertex as usize)]
    }
}

/// The mean of direct light found at several points.
pub(in crate::solver) fn mean(found: impl Iterator<Item = DirectLight>) -> DirectLight {
    let (mut mean, mut count) = (DirectLight::default(), 0.0_f32);
    for light in found {
        mean.area_light += light.area_light;
        mean.emitters += light.emitters;
        mean.squared_error += light.squared_error;
        count += 1.0;
    }
    mean.area_light /= count.max(1.0);
    mean.emitters /= count.max(1.0);
    mean.squared_error /= (count * count).max(1.0);
    mean
}

/// The middle of points on one plane, in place of them all, if they are: origins of one vertex lie so near to each other
/// that light changes in a line between them.
pub(in crate::solver) fn in_the_middle(points: &[SurfacePoint]) -> Option<SurfacePoint> {
    let first = points.first()?;
    let is_same = |point: &SurfacePoint| point.geometric_normal.dot(first.geometric_normal) > 1.0 - 1e-6;
    let middle = points.iter().map(|point| point.origin).sum::<Vec3>() / points.len() as f32;
    points.iter().all(is_same).then_some(SurfacePoint { origin: middle, ..*first })
}
