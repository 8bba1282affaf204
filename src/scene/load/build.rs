//! From repaired triangles to the mesh, in local units.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};

use super::contacts::{self, Rules};
use super::merge::{Faces, ShadedCorners, merge_flat};
use super::normals::corner_normals;
use super::obj::{Corner, Soup, Triangle};
use super::{repair, weld};
use crate::scene::{LoadOptions, LocalFrame, Material, Mesh};

/// In m: smaller scenes have areas that f32 cannot hold.
const SMALLEST_SIZE: f64 = 1e-15;

/// More triangles do not fit 32-bit numbers when each gets a second side.
const MOST_TRIANGLES: usize = 1 << 29;

/// A mesh in local units.
pub(super) struct Built {
    pub(super) mesh: Mesh,
    pub(super) frame: LocalFrame,
    /// See [`crate::scene::Scene::enclosed`].
    pub(super) enclosed: Vec<[Vec3; 3]>,
}

/// Puts triangles with area into local units, drops what repeats or vanishes there, and gives them normals.
pub(super) fn build(
    mut soup: Soup,
    materials: &[Material],
    options: &LoadOptions,
    warnings: &mut Vec<String>,
) -> Result<Built, String> {
    if soup.triangles.len() > MOST_TRIANGLES {
        return Err(format!("{} triangles are more than the {MOST_TRIANGLES} that fit", soup.triangles.len()));
    }
    let size = |(minimum, maximum): (DVec3, DVec3)| (maximum - minimum).max_element();
    if size(weld::bounds(&soup)) < SMALLEST_SIZE {
        return Err(format!("the scene is only {:e} m wide", size(weld::bounds(&soup))));
    }
    if options.unit_size {
        let factor = 1.0 / size(weld::bounds(&soup));
        soup.positions.iter_mut().for_each(|position| *position *= factor);
    }
    let (minimum, maximum) = weld::bounds(&soup);
    let frame = LocalFrame::of_bounds(minimum, maximum);
    let mut positions = merge_equal_positions(&mut soup, &frame);
    repair::keep(&mut soup.triangles, ["too thin for single precision"; 2], warnings, |triangle| {
        has_local_area(triangle, &positions)
    });
    repair::drop_duplicates(&mut soup.triangles, options.two_sided, warnings);
    let exact = |position: &DVec3| (*position - frame.origin) / frame.metres_per_unit;
    let points: Vec<DVec3> = soup.positions.iter().map(exact).collect();
    let normals = corner_normals(&soup, &points, options.crease_angle, warnings);
    let mut faces = oriented(&soup, &normals, options.flip);
    if options.merge_flat == Some(true) {
        merge_flat(&mut faces, &positions);
    }
    let emits = |material: &Material| material.emitted_radiance.max_element() > 0.0;
    let is_lamp = |material: &Material| emits(material) && material.reflectance == Vec3::ZERO;
    let rules = Rules {
        emits: &materials.iter().map(emits).collect::<Vec<_>>(),
        is_lamp: &materials.iter().map(is_lamp).collect::<Vec<_>>(),
        has_holes: &materials.iter().map(|one| one.opacity_texture.is_some() || one.opacity < 0.5).collect::<Vec<_>>(),
        two_sided: options.two_sided,
    };
    let settled = if options.faces_as_read {
        contacts::Settled::unsettled(faces)
    } else {
        contacts::settle(faces, &mut positions, &rules)
    };
    warnings.extend(settled.findings.told(materials, &frame));
    let mesh = assemble(settled.faces, &settled.fans, &positions, options.two_sided);
    Ok(Built { mesh, frame, enclosed: settled.findings.enclosed_places })
}

/// Local positions. Triangles are changed to use the first of those that are equal in local single precision.
fn merge_equal_positions(soup: &mut Soup, frame: &LocalFrame) -> Vec<Vec3> {
    let to_local = |position: &DVec3| frame.point_to_local(*position) + Vec3::ZERO;
    let positions: Vec<Vec3> = soup.positions.iter().map(to_local).collect();
    let mut first = HashMap::with_capacity(positions.len());
    let same: Vec<u32> = (0..positions.len() as u32)
        .map(|id| *first.entry(positions[id as usize].to_array().map(f32::to_bits)).or_insert(id))
        .collect();
    for corner in soup.triangles.iter_mut().flat_map(|triangle| &mut triangle.corners) {
        corner.position = same[corner.position as usize];
    }
    positions
}

fn has_local_area(triangle: &Triangle, positions: &[Vec3]) -> bool {
    let [a, b, c] = triangle.position_ids().map(|id| positions[id as usize]);
    let scaled_normal = (b - a).cross(c - a);
    scaled_normal != Vec3::ZERO && scaled_normal.is_finite()
}

fn turned([a, b, c]: ShadedCorners) -> ShadedCorners {
    [a, c, b].map(|(id, normal)| (id, Vec3::ZERO - normal))
}

/// The triangles with their normals, on the side that is to be the front.
fn oriented(soup: &Soup, normals: &[[DVec3; 3]], flip: bool) -> Faces {
    let front = soup.triangles.iter().zip(normals).map(|(triangle, normals)| {
        let corner = |place: usize| (triangle.corners[place].position, normals[place].as_vec3() + Vec3::ZERO);
        let corners = [0, 1, 2].map(corner);
        if flip { turned(corners) } else { corners }
    });
    let mut faces = Faces {
        corners: front.collect(),
        materials: soup.triangles.iter().map(|triangle| triangle.material).collect(),
        texcoords: Vec::new(),
    };
    if soup.has_texcoords {
        let swap = |[a, b, c]: [Vec2; 3]| if flip { [a, c, b] } else { [a, b, c] };
        faces.texcoords.extend(soup.triangles.iter().map(|triangle| swap(corner_texcoords(soup, &triangle.corners))));
    }
    faces
}

/// Adds the second sides and numbers the vertices (position, normal and fan) in the order in which triangles use them.
fn assemble(faces: Faces, fans: &[u32], positions: &[Vec3], two_sided: bool) -> Mesh {
    let Faces { corners: mut sides, materials: mut material_indices, mut texcoords } = faces;
    let mut side_fans: Vec<[u32; 3]> = fans.chunks_exact(3).map(|fans| [fans[0], fans[1], fans[2]]).collect();
    if two_sided {
        let count = sides.len();
        sides.extend_from_within(..);
        sides[count..].iter_mut().for_each(|side| *side = turned(*side));
        side_fans.extend_from_within(..);
        side_fans[count..].iter_mut().for_each(|fans| fans.swap(1, 2));
        material_indices.extend_from_within(..);
        texcoords.extend_from_within(..);
        texcoords.iter_mut().skip(count).for_each(|corners| corners.swap(1, 2));
    }
    let mut mesh = Mesh { texcoords, material_indices, ..Default::default() };
    let mut numbers = HashMap::with_capacity(positions.len());
    mesh.triangles.reserve(sides.len());
    for (side, fans) in sides.into_iter().zip(side_fans) {
        mesh.triangles.push([0, 1, 2].map(|place| {
            let ((id, normal), fan) = (side[place], fans[place]);
            *numbers.entry((id, normal.to_array().map(f32::to_bits), fan)).or_insert_with(|| {
                mesh.positions.push(positions[id as usize]);
                mesh.normals.push(normal);
                mesh.positions.len() as u32 - 1
            })
        }));
    }
    mesh
}

/// A triangle's texture coordinates. Far from 0 they are moved there by whole repeats, which keeps their digits.
fn corner_texcoords(soup: &Soup, corners: &[Corner; 3]) -> [Vec2; 3] {
    let exact = corners.map(|corner| soup.texcoords[corner.texcoord as usize]);
    let lowest = exact[0].min(exact[1]).min(exact[2]);
    let repeats = if lowest.abs().max_element() > 1024.0 { lowest.floor() } else { glam::DVec2::ZERO };
    exact.map(|texcoord| (texcoord - repeats).as_vec2())
}
