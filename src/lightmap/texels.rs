//! The texel table: what a lightmap's texels are in the scene.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{
    charts::Charts,
    coverage::{Piece, TexelTriangle},
    openness::{openness, points_in},
};
use crate::{
    scene::{Scene, mesh::unit_or_zero},
    trace::{RayTracer, surface::lift},
};

/// A texel that is covered by surface: wholly, or by what a triangle leaves in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// Its number among the texels of all pages ([`Charts::pixel`]).
    pub pixel: u32,
    /// The triangle of its largest part.
    pub triangle: u32,
    /// The chart it lies in.
    pub chart: u32,
    /// Middle of the covered, open part [local units], lifted off the surface by its rounding error.
    pub position: Vec3,
    /// Unit normal of the surface.
    pub geometric_normal: Vec3,
    /// Unit shading normal.
    pub shading_normal: Vec3,
    /// Step on the surface from a texel to the next in its row, and to the next in its column [local units].
    pub steps: [Vec3; 2],
    /// Area of the covered part [local units²]; all texels together have the scene's.
    pub area: f32,
    /// Share of that area that is open: 0 for a texel under an object.
    pub open: f32,
    /// Mean reflectance over the covered part.
    pub reflectance: Vec3,
    /// Emission M = π L [W/m²].
    pub emission: Vec3,
}

impl Texel {
    /// Area that light can reach [local units²].
    pub fn open_area(&self) -> f32 {
        self.area * self.open
    }
}

/// Points along each side of a texel that its mean reflectance is taken from.
const TEXTURE_POINTS: u32 = 4;

/// Finds the texels of a map. They are sorted so that any square block of 2^n texels a side, aligned to its own size and
/// within one chart and one main direction of the surface, is one run ([`block_key`]).
///
/// `progress` gets the part that is done, and may stop it by returning false: then the result is `None`.
pub fn texel_table(
    scene: &Scene,
    tracer: &dyn RayTracer,
    charts: &Charts,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Option<Vec<Texel>> {
    let triangle_count = charts.pages.len();
    let (done, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    const TRIANGLES_PER_TASK: usize = 64;
    let parts: Vec<Vec<Part>> = (0..triangle_count.div_ceil(TRIANGLES_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let mut parts = Vec::new();
            let end = ((task + 1) * TRIANGLES_PER_TASK).min(triangle_count);
            for triangle in task * TRIANGLES_PER_TASK..end {
                if stopped.load(Relaxed) {
                    return parts;
                }
                parts_of_triangle(scene, tracer, charts, triangle as u32, &stopped, &mut parts);
            }
            let done = done.fetch_add(TRIANGLES_PER_TASK, Relaxed) + TRIANGLES_PER_TASK;
            if !progress((done as f32 / triangle_count as f32).min(1.0)) {
                stopped.store(true, Relaxed);
            }
            parts
        })
        .collect();
    if stopped.into_inner() {
        return None;
    }
    let mut parts: Vec<Part> = parts.into_iter().flatten().collect();
    parts.sort_by_key(|part| part.pixel); // stable: parts of one texel stay in the order of their triangles
    let mut texels: Vec<Texel> =
        parts.chunk_by(|a, b| a.pixel == b.pixel).map(|parts| merged(scene, charts, parts)).collect();
    texels.sort_by_cached_key(|texel| (block_key(charts, texel, 0), texel.pixel));
    Some(texels)
}

/// What the texels of one block of 2^`level` texels a side have in common: page, chart, main direction of the surface,
/// and the block's place as a Morton number.
pub fn block_key(charts: &Charts, texel: &Texel, level: u32) -> (u32, u32, u32, u64) {
    let [page, column, row] = charts.place(texel.pixel as usize);
    let axis = texel.geometric_normal.abs().max_position();
    let direction = 2 * axis as u32 + u32::from(texel.geometric_normal[axis] < 0.0);
    let spread = |value: u32| (0..16).fold(0_u64, |sum, bit| sum | u64::from(value >> bit & 1) << (2 * bit));
    let morton = spread(column) | spread(row) << 1;
    (page, texel.chart, direction, morton >> (2 * level))
}

/// What one triangle has in one texel.
struct Part {
    pixel: u32,
    triangle: u32,
    area: f32,
    open: f32,
    barycentric: Vec2,
    reflectance: Vec3,
}

fn parts_of_triangle(
    scene: &Scene,
    tracer: &dyn RayTracer,
    charts: &Charts,
    triangle: u32,
    stopped: &AtomicBool,
    parts: &mut Vec<Part>,
) {
    let index = triangle as usize;
    if charts.chart_of_triangle[index] == u32::MAX {
        return;
    }
    let Some(flat) = TexelTriangle::new(charts.coordinates[index]) else {
        return;
    };
    let area = scene.mesh.area(triangle);
    flat.for_each_piece(charts.page_size, |piece| {
        if stopped.load(Relaxed) {
            return;
        }
        let open = openness(scene, tracer, triangle, &flat, &piece);
        parts.push(Part {
            pixel: charts.pixel(charts.pages[index], piece.texel[0], piece.texel[1]) as u32,
            triangle,
            area: (piece.share * f64::from(area)) as f32,
            open: open.share,
            barycentric: open.centroid,
            reflectance: mean_reflectance(scene, triangle, &flat, &piece),
        });
    });
}

fn mean_reflectance(scene: &Scene, triangle: u32, flat: &TexelTriangle, piece: &Piece) -> Vec3 {
    let points = match scene.material(triangle).reflectance_texture {
        Some(_) => points_in(flat, piece, TEXTURE_POINTS),
        None => Vec::new(),
    };
    if points.is_empty() {
        return scene.reflectance(triangle, piece.centroid);
    }
    points.iter().map(|point| scene.reflectance(triangle, *point)).sum::<Vec3>() / points.len() as f32
}

/// The parts of one texel as one.
fn merged(scene: &Scene, charts: &Charts, parts: &[Part]) -> Texel {
    let mesh = &scene.mesh;
    let area: f32 = parts.iter().map(|part| part.area).sum();
    let open: f32 = parts.iter().map(|part| part.area * part.open).sum();
    // What is open decides where the texel is; a buried one lies where its surface does.
    let weight = |part: &Part| if open > 0.0 { part.area * part.open } else { part.area };
    let mean = |value: &dyn Fn(&Part) -> Vec3| parts.iter().map(|part| weight(part) * value(part)).sum::<Vec3>();
    let largest = parts.iter().reduce(|a, b| if weight(b) > weight(a) { b } else { a });
    let largest = largest.map_or((0, Vec2::ZERO), |part| (part.triangle, part.barycentric));
    let total: f32 = parts.iter().map(weight).sum();
    let normals = mean(&|part| mesh.geometric_normal(part.triangle));
    // On a plane the middle of all parts lies on the surface; else that of the largest.
    let is_flat = normals.length() > 0.999_999 * total;
    let (triangle, barycentric) = largest;
    let position = if is_flat {
        mean(&|part| mesh.position(part.triangle, part.barycentric)) / total
    } else {
        mesh.position(triangle, barycentric)
    };
    let geometric_normal = if is_flat { unit_or_zero(normals) } else { mesh.geometric_normal(triangle) };
    let [a, b, c] = mesh.corners(triangle);
    let flat = TexelTriangle::new(charts.coordinates[triangle as usize]);
    let steps = flat.map_or([Vec2::ZERO; 2], |flat| flat.barycentric_steps());
    let shading = unit_or_zero(mean(&|part| mesh.shading_normal(part.triangle, part.barycentric)));
    let radiance = mean(&|part| scene.material(part.triangle).emitted_radiance) / total;
    Texel {
        pixel: parts[0].pixel,
        triangle,
        chart: charts.chart_of_triangle[triangle as usize],
        position: lift(position, geometric_normal, [a, b, c]),
        geometric_normal,
        shading_normal: if shading == Vec3::ZERO { geometric_normal } else { shading },
        steps: steps.map(|step| step.x * (b - a) + step.y * (c - a)),
        area,
        open: (open / area).min(1.0),
        reflectance: mean(&|part| part.reflectance) / total,
        emission: std::f32::consts::PI * radiance,
    }
}
