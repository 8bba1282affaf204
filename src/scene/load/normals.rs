//! Shading normals of corners.

use glam::DVec3;
use rayon::prelude::*;

use super::counted;
use super::obj::Soup;
use crate::math::sets::Sets;

/// In degrees: faces that bend by less are one plane, so that the two halves of a quad share their vertices.
const FLAT_ANGLE: f64 = 0.01;

/// So many triangles at one edge are compared with each other.
const EDGE_NEIGHBOURS: usize = 8;

/// The unit shading normals of every triangle's corners: the file's, and flat ones where it has none; with a crease
/// angle (in degrees) all are new, smooth across edges that bend by less than it. `points` are the positions, which the
/// triangles index, in any unit.
pub(super) fn corner_normals(
    soup: &Soup,
    points: &[DVec3],
    crease_angle: Option<f32>,
    warnings: &mut Vec<String>,
) -> Vec<[DVec3; 3]> {
    let ids: Vec<[u32; 3]> = soup.triangles.par_iter().map(|triangle| triangle.position_ids()).collect();
    let faces: Vec<DVec3> = ids.par_iter().map(|ids| unit_normal(ids.map(|id| points[id as usize]))).collect();
    if let Some(angle) = crease_angle {
        return smooth_normals(&ids, points, &faces, f64::from(angle));
    }
    let given = |index: u32| unit_or_zero(soup.normals[index as usize]);
    let mut normals: Vec<[DVec3; 3]> =
        soup.triangles.par_iter().map(|triangle| triangle.corners.map(|corner| given(corner.normal))).collect();
    let incomplete = normals.par_iter().filter(|corners| corners.contains(&DVec3::ZERO)).count();
    if incomplete > 0 {
        let flat = smooth_normals(&ids, points, &faces, FLAT_ANGLE);
        for (normal, flat) in normals.iter_mut().flatten().zip(flat.iter().flatten()) {
            if *normal == DVec3::ZERO {
                *normal = *flat;
            }
        }
        // A file without any normals means flat faces: nothing is repaired then.
        if incomplete < ids.len() {
            warnings.push(format!("computed flat normals for {} that had none", counted(incomplete, "triangle")));
        }
    }
    let backward = normals.par_iter().zip(&faces).filter(|(normals, face)| face_away(normals, **face)).count();
    if backward > 0 {
        let count = counted(backward, "triangle");
        warnings.push(format!("the normals of {count} point to the back; the order of the corners says what is front"));
    }
    normals
}

/// True if a triangle's shading normals point, on average, to the back of its winding. The winding decides which side
/// is the front; the normals stay as they are.
fn face_away(normals: &[DVec3; 3], face: DVec3) -> bool {
    normals.iter().sum::<DVec3>().dot(face) < 0.0
}

/// Corners at one position that are linked by edges bending less than `angle` share the mean of their triangles'
/// normals, weighted by the angle at the corner (Thürmer and Wüthrich 1998).
fn smooth_normals(ids: &[[u32; 3]], points: &[DVec3], faces: &[DVec3], angle: f64) -> Vec<[DVec3; 3]> {
    let groups = smooth_groups(ids, faces, angle.max(FLAT_ANGLE));
    let mut sums = vec![DVec3::ZERO; 3 * ids.len()];
    for (corner, &group) in groups.iter().enumerate() {
        let (triangle, place) = (corner / 3, corner % 3);
        let [here, next, last] = [0, 1, 2].map(|step| points[ids[triangle][(place + step) % 3] as usize]);
        sums[group as usize] += faces[triangle] * (next - here).angle_between(last - here);
    }
    let normal = |corner: usize| match unit_or_zero(sums[groups[corner] as usize]) {
        DVec3::ZERO => faces[corner / 3],
        unit => unit,
    };
    (0..ids.len()).map(|triangle| [0, 1, 2].map(|place| normal(3 * triangle + place))).collect()
}

/// For each corner (3 · triangle + place) the first corner of its group.
fn smooth_groups(ids: &[[u32; 3]], faces: &[DVec3], angle: f64) -> Vec<u32> {
    let mut edges: Vec<(u32, u32, u32)> = (0..3 * ids.len() as u32)
        .into_par_iter()
        .map(|corner| {
            let triangle = ids[corner as usize / 3];
            let (a, b) = (triangle[corner as usize % 3], triangle[(corner as usize + 1) % 3]);
            (a.min(b), a.max(b), corner)
        })
        .collect();
    edges.par_sort_unstable();
    let cosine = angle.to_radians().cos();
    let mut groups = Sets::of_one(3 * ids.len() as u32);
    let corner_at = |triangle: usize, id: u32| {
        let place = ids[triangle].iter().position(|&other| other == id).unwrap_or(0);
        (3 * triangle + place) as u32
    };
    for edge in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
        for (place, &(low, high, corner)) in edge.iter().enumerate() {
            for &(_, _, other_corner) in edge[place + 1..].iter().take(EDGE_NEIGHBOURS) {
                let (one, other) = (corner as usize / 3, other_corner as usize / 3);
                if faces[one].dot(faces[other]) > cosine {
                    for id in [low, high] {
                        groups.join(corner_at(one, id), corner_at(other, id));
                    }
                }
            }
        }
    }
    groups.into_lowest()
}

fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    unit_or_zero((b - a).cross(c - a))
}

/// `vector` at unit length without -0; 0 if it has no length or is not finite.
fn unit_or_zero(vector: DVec3) -> DVec3 {
    let largest = vector.abs().max_element();
    if largest > 0.0 && largest.is_finite() {
        (vector / largest).normalize_or_zero() + DVec3::ZERO
    } else {
        DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism of `sides` quads around the y axis, wound outwards; returns the angle between a corner's normal and its
    /// position's direction from the axis, the largest of all.
    fn largest_tilt(sides: u32, crease_angle: f64) -> f64 {
        let point = |side: u32, y: f64| {
            let angle = f64::from(side % sides) / f64::from(sides) * std::f64::consts::TAU;
            DVec3::new(angle.cos(), y, -angle.sin())
        };
        let points: Vec<DVec3> = (0..sides).flat_map(|side| [point(side, 0.0), point(side, 1.0)]).collect();
        let quad = |side: u32| {
            let next = (side + 1) % sides;
            [[2 * side, 2 * next, 2 * next + 1], [2 * side, 2 * next + 1, 2 * side + 1]]
        };
        let ids: Vec<[u32; 3]> = (0..sides).flat_map(quad).collect();
        let faces: Vec<DVec3> = ids.iter().map(|ids| unit_normal(ids.map(|id| points[id as usize]))).collect();
        let normals = smooth_normals(&ids, &points, &faces, crease_angle);
        let corners = ids.iter().flatten().zip(normals.iter().flatten());
        let tilt = |(id, normal): (&u32, &DVec3)| {
            let position = points[*id as usize];
            DVec3::new(position.x, 0.0, position.z).angle_between(*normal).to_degrees()
        };
        corners.map(tilt).fold(0.0, f64::max)
    }

    #[test]
    fn a_prism_is_smooth_below_the_crease_angle_and_flat_above_it() {
        // 36 sides bend by 10° at each edge: smooth normals are radial, flat ones are tilted by half of that.
        assert!(largest_tilt(36, 11.0) < 1e-6);
        assert!((largest_tilt(36, 9.0) - 5.0).abs() < 1e-6);
        assert!((largest_tilt(36, 0.0) - 5.0).abs() < 1e-6);
        // Four sides bend by 90°.
        assert!(largest_tilt(4, 91.0) < 1e-6);
        assert!((largest_tilt(4, 89.0) - 45.0).abs() < 1e-6);
    }

    #[test]
    fn the_two_halves_of_a_nearly_flat_quad_have_the_same_normal_bits() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 1e-9], [1.1, 0.9, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from_array);
        let ids = [[0, 1, 2], [0, 2, 3]];
        let faces = ids.map(|ids| unit_normal(ids.map(|id| points[id as usize])));
        assert_ne!(faces[0], faces[1]);
        let normals = smooth_normals(&ids, &points, &faces, 0.0);
        assert_eq!(normals[0][0], normals[1][0]);
        assert_eq!(normals[0][2], normals[1][1]);
    }
}
