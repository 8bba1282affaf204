//! A model under construction: parametric patches, placed by a frame.

use glam::{DAffine3, DVec2, DVec3};

use super::obj::{Corner, Obj};

/// Step of the finite differences that give normals, in a patch's parameters.
const STEP: f64 = 1e-4;

/// Patches of one OBJ file. Everything that is added is placed by [`Model::frame`], which must not mirror.
#[derive(Default)]
pub(super) struct Model {
    pub(super) obj: Obj,
    pub(super) frame: DAffine3,
}

impl Model {
    /// `cells` quads of a surface over (u, v) in [0, 1]², with smooth normals; its front is where ∂u × ∂v points.
    pub(super) fn patch(&mut self, cells: [usize; 2], position: impl Fn(f64, f64) -> DVec3) {
        self.quads(cells, position, |_, _| None);
    }

    /// [`Model::patch`] with texture coordinates.
    pub(super) fn textured_patch(
        &mut self,
        cells: [usize; 2],
        position: impl Fn(f64, f64) -> DVec3,
        texcoord: impl Fn(f64, f64) -> DVec2,
    ) {
        self.quads(cells, position, |u, v| Some(texcoord(u, v)));
    }

    fn quads(
        &mut self,
        [columns, rows]: [usize; 2],
        position: impl Fn(f64, f64) -> DVec3,
        texcoord: impl Fn(f64, f64) -> Option<DVec2>,
    ) {
        let corner = |column: usize, row: usize| {
            let (u, v) = (column as f64 / columns as f64, row as f64 / rows as f64);
            Corner {
                position: self.frame.transform_point3(position(u, v)),
                texcoord: texcoord(u, v),
                normal: Some(self.frame.transform_vector3(normal(&position, u, v))),
            }
        };
        let corners: Vec<Vec<Corner>> =
            (0..=rows).map(|row| (0..=columns).map(|column| corner(column, row)).collect()).collect();
        for pair in corners.windows(2) {
            for column in 0..columns {
                self.obj.face(&[pair[0][column], pair[0][column + 1], pair[1][column + 1], pair[1][column]]);
            }
        }
    }
}

/// The unit normal of a surface by finite differences; where it has none (a pole), that of a point a little inside.
fn normal(position: &impl Fn(f64, f64) -> DVec3, u: f64, v: f64) -> DVec3 {
    let at = |u: f64, v: f64| {
        let (low, high) = ((u - STEP).max(0.0), (u + STEP).min(1.0));
        let (bottom, top) = ((v - STEP).max(0.0), (v + STEP).min(1.0));
        (position(high, v) - position(low, v)).cross(position(u, top) - position(u, bottom))
    };
    let inwards = |value: f64| value + (0.5 - value) * 0.01;
    let here = at(u, v);
    if here.length() > 1e-12 { here.normalize() } else { at(inwards(u), inwards(v)).normalize_or_zero() }
}
