//! Solutions of either kind, per vertex or on a lightmap, and the field between their elements.

use std::path::Path;

use anyhow::anyhow;
use glam::{Vec2, Vec3};

use super::{elements_of, read_bytes};
use crate::{
    lightmap::Charts,
    scene::{LoadOptions, Scene, Tessellation},
    solver::{
        LightmapSolution, Reconstruction, Reconstructor, Solution,
        lightmap_solution::{self, is_lightmap},
        solution_file,
    },
    trace::RayTracer,
};

/// What a solution file holds.
#[derive(Clone, Debug)]
pub enum AnySolution {
    /// Irradiance at vertices, bounce by bounce.
    Vertices(Solution),
    /// Irradiance at the texels of a lightmap.
    Lightmap(LightmapSolution),
}

impl AnySolution {
    /// Reads a solution of either kind.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let bytes = read_bytes(path)?;
        let found = if is_lightmap(&bytes) {
            lightmap_solution::decode(&bytes).map(Self::Lightmap)
        } else {
            solution_file::decode(&bytes).map(Self::Vertices)
        };
        found.map_err(|problem| anyhow!("{}: {problem}", path.display()))
    }

    /// How its scene was read.
    pub fn load_options(&self) -> &LoadOptions {
        match self {
            Self::Vertices(solution) => &solution.info.load,
            Self::Lightmap(solution) => &solution.info.load,
        }
    }
}

/// What carries the values.
#[derive(Clone, Debug)]
enum Elements {
    /// The vertices of triangles.
    Vertices(Box<(Tessellation, Solution)>),
    /// The texels of a lightmap.
    Lightmap(Charts),
}

/// A solution as irradiance at any point of its scene's surfaces.
#[derive(Clone, Debug)]
pub struct SolvedField {
    elements: Elements,
    direct: Vec<Vec3>,
    total: Vec<Vec3>,
}

impl SolvedField {
    /// The field of a solution that was read from `path`.
    ///
    /// # Errors
    /// The solution belongs to another scene, or to other elements.
    pub fn new(path: &Path, solution: AnySolution, scene: &Scene) -> anyhow::Result<Self> {
        match solution {
            AnySolution::Vertices(solution) => Ok(Self {
                direct: solution.direct().to_vec(),
                total: solution.total(),
                elements: Elements::Vertices(Box::new((elements_of(path, &solution, scene)?, solution))),
            }),
            AnySolution::Lightmap(solution) => {
                let checked = lightmap_solution::check_scene(&solution, scene);
                checked.map_err(|problem| anyhow!("{}: {problem}", path.display()))?;
                let LightmapSolution { charts, direct, total, .. } = solution;
                Ok(Self { elements: Elements::Lightmap(charts), direct, total })
            }
        }
    }

    /// Irradiance of the lights alone, and all irradiance [W/m²], at a point of a scene triangle.
    pub fn at(&self, triangle: u32, barycentric: Vec2) -> (Vec3, Vec3) {
        let at = |field: &[Vec3]| match &self.elements {
            Elements::Vertices(solved) => solved.0.interpolate(field, triangle, barycentric),
            Elements::Lightmap(charts) => charts.interpolate(field, triangle, barycentric),
        };
        (at(&self.direct), at(&self.total))
    }

    /// The same at any point, by the way `how` says; a lightmap has its own way, between its texels.
    pub fn rebuilt<'a>(
        &'a self,
        scene: &'a Scene,
        tracer: &'a dyn RayTracer,
        how: Reconstruction,
    ) -> Box<dyn Fn(u32, Vec2) -> (Vec3, Vec3) + Sync + 'a> {
        match &self.elements {
            Elements::Vertices(solved) => {
                let field = Reconstructor::new(scene, tracer, &solved.0, &solved.1, how);
                Box::new(move |triangle, barycentric| field.direct_and_total(triangle, barycentric))
            }
            Elements::Lightmap(_) => Box::new(|triangle, barycentric| self.at(triangle, barycentric)),
        }
    }
}
