//! Elements that follow the light, from a scene as it comes.
//!
//! Direct and indirect light have needs of their own. Fine elements follow direct light (`direct`): each is cut until
//! direct light at two points inside is near what its corners say. Coarse elements follow indirect light (`indirect`):
//! gather rays are traced at their vertices alone, and they are cut until the first bounce at a new vertex is near what
//! a smooth field through the others says (`smooth`). In the end the fine elements are cut where the smooth field needs
//! it, and take its values: they cost no ray.
//!
//! The finer a difference, the less it counts: what is held to the tolerance is the difference times the length of the
//! edge, so that all elements share the error evenly.

mod direct;
mod indirect;
pub(super) mod smooth;

use std::{sync::Arc, time::Instant};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use self::{
    direct::DirectElements,
    indirect::IndirectElements,
    smooth::{SmoothField, SmoothValues},
};
use super::{buried::fill_buried, reconstruct::point_context, settings::SolveSettings};
use crate::{
    scene::{Scene, Tessellation, area_light::AreaLightState, tessellate::Refinement},
    trace::RayTracer,
    transport::{
        Lights, RowChunk, VertexOrigins,
        direct::{DirectContext, ShadowRays},
    },
};

/// Edges longer than this are cut in any case, in local units (a scene's half-extent is between 1/2 and 1): what lies
/// within one element unseen cannot be followed.
const COARSEST_EDGE: f32 = 0.3;

/// Edges shorter than this are not cut.
const FINEST_EDGE: f32 = 2e-4;

/// Where direct light must be sampled, edges shorter than this are not cut: noise would be taken for shadows.
const FINEST_SAMPLED_EDGE: f32 = 0.02;

/// Differences that are allowed, times edge length in local units, for a target error of 1: of direct light, of the
/// first bounce, and of the smooth field from the fine elements; all relative to mean direct light. Found by experiment
/// on the Cornell box.
const DIRECT_TOLERANCE: f32 = 0.08;
const INDIRECT_TOLERANCE: f32 = 0.15;
const SMOOTH_TOLERANCE: f32 = 0.015;

/// Elements that follow the light, and what is known on them.
pub struct Adapted {
    /// The fine elements: those of the solution.
    pub tessellation: Arc<Tessellation>,
    /// Direct irradiance [W/m²] at each vertex.
    pub(super) direct: Vec<Vec3>,
    /// Vertices that see mostly back faces.
    pub(super) buried: Vec<bool>,
    /// The gather rays, of the coarse elements' vertices, to the fine elements.
    pub(super) rows: Vec<(Vec<u32>, RowChunk)>,
    coarse: Coarse,
    /// Where in the coarse elements each vertex lies.
    places: Vec<(u32, Vec2)>,
    /// Wall-clock seconds until the elements followed direct light.
    pub(super) direct_seconds: f64,
    /// Wall-clock seconds of the whole.
    pub(super) seconds: f64,
    /// Shadow rays.
    pub(super) shadow_rays: ShadowRays,
}

/// The coarse elements in the end.
struct Coarse {
    tessellation: Tessellation,
    origins: VertexOrigins,
    buried: Vec<bool>,
    smooth: SmoothField,
}

/// What both kinds of elements are made with.
struct Making<'a> {
    scene: &'a Scene,
    tracer: &'a dyn RayTracer,
    settings: &'a SolveSettings,
    lights: Lights,
    is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Cuts a scene's triangles to follow its light, to the error that the settings ask for.
///
/// # Errors
/// One line, if there would be too many elements or it was cancelled.
pub fn adapt(
    scene: &Scene,
    tracer: &dyn RayTracer,
    light: Option<AreaLightState>,
    settings: &SolveSettings,
    error: f32,
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<Adapted, String> {
    let started = Instant::now();
    let lights = Lights::new(scene, light.map(|light| light.to_local(&scene.frame)));
    if lights.emitters.as_polygons(scene).is_none() {
        return Err(String::from(
            "adaptive follows the light of at most 32 emissive triangles without cut-outs, and this scene has others; \
             cut it evenly instead, by --subdivide or --max-edge",
        ));
    }
    let making = Making { scene, tracer, settings, lights, is_cancelled };
    let mut fine = DirectElements::new(&making)?;
    fine.follow_light(DIRECT_TOLERANCE * error)?;
    let direct_seconds = started.elapsed().as_secs_f64();
    let mut coarse = IndirectElements::new(&making, &fine)?;
    coarse.follow_light(INDIRECT_TOLERANCE * error)?;
    let IndirectElements { rows, first_bounce, buried, tessellation, origins, .. } = coarse;
    let coarse = Coarse { smooth: SmoothField::new(&tessellation, &origins, &buried), tessellation, origins, buried };
    let nodes_before: Vec<u32> = fine.refinement.nodes().collect();
    fine.follow_smooth_field(&coarse, &first_bounce, SMOOTH_TOLERANCE * error)?;
    let rows = relocated(rows, &nodes_before, &fine.refinement);
    let DirectElements { tessellation, direct, buried, shadow_rays, .. } = fine;
    Ok(Adapted {
        places: places_in(&coarse.tessellation, &tessellation),
        tessellation: Arc::new(tessellation),
        direct,
        buried,
        rows,
        coarse,
        direct_seconds,
        seconds: started.elapsed().as_secs_f64(),
        shadow_rays,
    })
}

/// Brings rows to the fine elements as they are in the end, from those with these nodes.
fn relocated(rows: Vec<(Vec<u32>, RowChunk)>, nodes: &[u32], refinement: &Refinement) -> Vec<(Vec<u32>, RowChunk)> {
    rows.into_par_iter()
        .map(|(vertices, mut chunk)| {
            chunk.relocate(|element, place| refinement.locate_in_node(nodes[element as usize], place));
            (vertices, chunk)
        })
        .collect()
}

/// Where in the coarse elements the vertices of the fine ones lie.
fn places_in(coarse: &Tessellation, fine: &Tessellation) -> Vec<(u32, Vec2)> {
    let mut places = vec![(0, Vec2::ZERO); fine.mesh.positions.len()];
    for (element, corners) in fine.mesh.triangles.iter().enumerate() {
        for (corner, &vertex) in corners.iter().enumerate() {
            let place = fine.corner_barycentrics[element][corner];
            places[vertex as usize] = coarse.locate(fine.scene_triangle[element], place);
        }
    }
    places
}

impl Adapted {
    /// How many vertices have rows.
    pub(super) fn gathered_vertices(&self) -> usize {
        self.coarse.buried.len()
    }

    /// A field [W/m²] at the vertices from its values at the coarse elements' vertices.
    pub(super) fn spread(&self, mut values: Vec<Vec3>) -> Vec<Vec3> {
        let Coarse { tessellation, origins, buried, smooth } = &self.coarse;
        for (vertex, value) in fill_buried(&tessellation.mesh, origins, &values, buried) {
            values[vertex] = value;
        }
        let values = SmoothValues::new(smooth, tessellation, &values);
        self.places.par_iter().with_min_len(256).map(|&place| values.at(place)).collect()
    }
}

impl Making<'_> {
    fn direct_context(&self) -> DirectContext<'_> {
        let context = point_context(self.scene, self.tracer, &self.lights, self.settings);
        DirectContext { is_cancelled: self.is_cancelled, ..context }
    }

    /// Cuts; false if nothing was cut: nothing is wanted, or there would be too many.
    fn cut(&self, refinement: &mut Refinement, wanted: &[u32]) -> Result<bool, String> {
        // A triangulated surface has about twice as many triangles as vertices.
        let most = 2 * u64::from(self.settings.max_vertices);
        if wanted.is_empty() || refinement.count_after_cut(wanted) > most {
            return Ok(false);
        }
        if (self.is_cancelled)() {
            return Err(String::from("cancelled"));
        }
        refinement.cut(wanted)?;
        Ok(true)
    }
}

fn edge_length(tessellation: &Tessellation, [a, b]: [u32; 2]) -> f32 {
    tessellation.mesh.positions[a as usize].distance(tessellation.mesh.positions[b as usize])
}
