//! The texel table: what a lightmap's texels are in the scene.

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{
    charts::Charts,
    coverage::{Piece, TexelTriangle},
    openness::{openness, points_in},
    rooms::rooms,
};
use crate::{
    scene::{Scene, mesh::unit_or_zero},
    trace::{RayTracer, SurfacePoint, surface::lift},
};

/// A texel that is covered by surface: wholly, or by what a triangle leaves in it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Texel {
    /// Its number among the texels of all pages ([`Charts::pixel`]).
    pub pixel: u32,
    /// The triangle of its largest part.
    pub triangle: u32,
    /// The chart it lies in.
    pub chart: u32,
    /// The number of its room: no light comes from another one.
    pub room: u32,
    /// Middle of the covered, open part [local units], lifted off the surface by its rounding error.
    pub position: Vec3,
    /// Unit normal of the surface.
    pub geometric_normal: Vec3,
    /// Unit shading normal.
    pub shading_normal: Vec3,
    /// Step on the surface from a texel to the next in its row, and to the next in its column [local units].
    pub steps: [Vec3; 2],
    /// Area that it stands for: of the covered part, and of slivers beside it [local units²]. All texels together have
    /// the scene's.
    pub area: f32,
    /// Share of that area that is open: 0 for a texel under an object, and for a sliver.
    pub open: f32,
    /// Mean reflectance over the covered part.
    pub reflectance: Vec3,
    /// Emission M = π L [W/m²].
    pub emission: Vec3,
    /// Distance of the nearest other surface, as far as rays tell [local units]; infinite if there is none.
    pub clearance: f32,
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
/// With the second of `charts` set, a texel counts whole if its middle is covered, and not at all else.
///
/// `progress` gets the part that is done, and may stop it by returning false: then the result is `None`.
pub fn texel_table(
    scene: &Scene,
    tracer: &dyn RayTracer,
    (charts, middles_only): (&Charts, bool),
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Option<Vec<Texel>> {
    let triangle_count = charts.pages.len();
    let (done, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    const TRIANGLES_PER_TASK: usize = 64;
    let found: Vec<(Vec<Part>, Vec<[u32; 2]>)> = (0..triangle_count.div_ceil(TRIANGLES_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let (mut parts, mut sights) = (Vec::new(), Vec::new());
            let end = ((task + 1) * TRIANGLES_PER_TASK).min(triangle_count);
            for triangle in task * TRIANGLES_PER_TASK..end {
                if stopped.load(Relaxed) {
                    break;
                }
                let mut seen = HashSet::new();
                parts_of_triangle(
                    scene,
                    tracer,
                    (charts, middles_only),
                    triangle as u32,
                    &stopped,
                    &mut parts,
                    |other| {
                        if seen.insert(other) {
                            sights.push([triangle as u32, other]);
                        }
                    },
                );
            }
            let done = done.fetch_add(TRIANGLES_PER_TASK, Relaxed) + TRIANGLES_PER_TASK;
            if !progress((done as f32 / triangle_count as f32).min(1.0)) {
                stopped.store(true, Relaxed);
            }
            (parts, sights)
        })
        .collect();
    if stopped.into_inner() {
        return None;
    }
    let rooms = rooms(&scene.mesh, found.iter().flat_map(|(_, sights)| sights.iter().copied()));
    let mut parts: Vec<Part> = found.into_iter().flat_map(|(parts, _)| parts).collect();
    parts.sort_by_key(|part| part.pixel); // stable: parts of one texel stay in the order of their triangles
    let mut texels: Vec<Texel> =
        parts.chunk_by(|a, b| a.pixel == b.pixel).map(|parts| merged(scene, tracer, charts, &rooms, parts)).collect();
    give_away_slivers(charts, &mut texels);
    texels.sort_by_cached_key(|texel| (block_key(charts, texel, 0), texel.pixel));
    Some(texels)
}

/// A texel that is covered by less than this part gives its area to a neighbour, and is filled from its neighbours like
/// a buried one: its middle lies so near a crease that nothing can be measured there.
const SLIVER: f32 = 0.25;

/// The texels are in the order of their pixels.
fn give_away_slivers(charts: &Charts, texels: &mut [Texel]) {
    let coverage = |texel: &Texel| texel.area / texel.steps[0].cross(texel.steps[1]).length();
    let [width, height] = charts.page_size.map(i64::from);
    for index in 0..texels.len() {
        let sliver = texels[index];
        if coverage(&sliver) >= SLIVER || sliver.area == 0.0 {
            continue;
        }
        let [page, column, row] = charts.place(sliver.pixel as usize);
        let around = (-1..=1).flat_map(|y| (-1..=1).map(move |x| (i64::from(column) + x, i64::from(row) + y)));
        let inside = around.filter(|(x, y)| (0..width).contains(x) && (0..height).contains(y));
        let found = inside.filter_map(|(x, y)| {
            let pixel = charts.pixel(page, x as u32, y as u32) as u32;
            texels.binary_search_by_key(&pixel, |texel| texel.pixel).ok()
        });
        let fits = |other: &usize| {
            let texel = &texels[*other];
            let faces_alike = texel.geometric_normal.dot(sliver.geometric_normal) > 0.8;
            texel.chart == sliver.chart && faces_alike && texel.open > 0.0 && coverage(texel) >= SLIVER
        };
        let best = found.filter(fits).max_by(|a, b| coverage(&texels[*a]).total_cmp(&coverage(&texels[*b])));
        if let Some(best) = best {
            let (area, open) = (texels[best].area + sliver.area, texels[best].open_area() + sliver.open_area());
            (texels[best].area, texels[best].open) = (area, open / area);
            (texels[index].area, texels[index].open) = (0.0, 0.0);
        }
    }
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
    clearance: f32,
}

fn parts_of_triangle(
    scene: &Scene,
    tracer: &dyn RayTracer,
    (charts, middles_only): (&Charts, bool),
    triangle: u32,
    stopped: &AtomicBool,
    parts: &mut Vec<Part>,
    mut see: impl FnMut(u32),
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
        let Some(piece) = (if middles_only { piece.whole_texel(&flat) } else { Some(piece) }) else {
            return;
        };
        let open = openness(scene, tracer, triangle, &flat, &piece, &mut see);
        parts.push(Part {
            pixel: charts.pixel(charts.pages[index], piece.texel[0], piece.texel[1]) as u32,
            triangle,
            area: (piece.share * f64::from(area)) as f32,
            open: open.share,
            barycentric: open.centroid,
            clearance: open.clearance,
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
fn merged(scene: &Scene, tracer: &dyn RayTracer, charts: &Charts, rooms: &[u32], parts: &[Part]) -> Texel {
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
    let shading_normal = if shading == Vec3::ZERO { geometric_normal } else { shading };
    let origin = lift(position, geometric_normal, [a, b, c]);
    let point =
        SurfacePoint { origin, geometric_normal, shading_normal, triangle }.on_curve(scene, barycentric, tracer);
    Texel {
        pixel: parts[0].pixel,
        triangle,
        chart: charts.chart_of_triangle[triangle as usize],
        room: rooms[triangle as usize],
        position: point.origin,
        geometric_normal: point.geometric_normal,
        shading_normal,
        steps: steps.map(|step| step.x * (b - a) + step.y * (c - a)),
        area,
        open: (open / area).min(1.0),
        reflectance: mean(&|part| part.reflectance) / total,
        emission: std::f32::consts::PI * radiance,
        clearance: parts.iter().fold(f32::INFINITY, |least, part| least.min(part.clearance)),
    }
}
