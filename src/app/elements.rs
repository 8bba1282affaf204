//! A scene cut into elements, with all that solving and drawing it takes.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::{App, solving::SolveInput};
#[cfg(feature = "reference")]
use crate::scene::Material;
use crate::{
    gpu::ViewGeometry,
    scene::{LoadOptions, Scene, Tessellation},
    solver::{Problem, SolveSettings},
    trace::Tracer,
};

/// A scene with what a solve needs of it.
#[derive(Clone)]
pub struct Elements {
    /// The scene, with its materials as they were edited.
    pub scene: Arc<Scene>,
    /// How it was read.
    pub load: LoadOptions,
    /// Its elements.
    pub tessellation: Arc<Tessellation>,
    /// Its ray tracer.
    pub tracer: Arc<Tracer>,
    /// The elements, ready to be drawn.
    pub geometry: Arc<ViewGeometry>,
}

impl App {
    /// Elements to begin a solve with, and the settings that they were made with.
    pub(super) fn elements_at_hand(&self) -> (Elements, SolveSettings) {
        match &self.results {
            Some(results) => (results.elements.clone(), results.input.settings.clone()),
            None => (self.document.elements.clone(), self.document.original.settings.clone()),
        }
    }
}

impl Elements {
    /// What is to be solved on these elements.
    pub(super) fn problem(&self, input: &SolveInput) -> Problem {
        Problem {
            scene: Arc::clone(&self.scene),
            tracer: self.tracer.clone(),
            tessellation: Arc::clone(&self.tessellation),
            load: self.load.clone(),
            light: input.light,
            settings: input.settings.clone(),
        }
    }

    /// Cuts a scene and builds its tree.
    ///
    /// # Errors
    /// One line, for settings out of range or elements without end.
    pub fn new(scene: Arc<Scene>, load: LoadOptions, settings: &SolveSettings) -> Result<Self, String> {
        let tracer = Arc::new(Tracer::new(Arc::clone(&scene)));
        Self::with_tracer(scene, tracer, load, settings)
    }

    fn with_tracer(
        scene: Arc<Scene>,
        tracer: Arc<Tracer>,
        load: LoadOptions,
        settings: &SolveSettings,
    ) -> Result<Self, String> {
        if let Some(problem) = settings.problem() {
            return Err(problem);
        }
        let tessellation = Arc::new(Tessellation::new(&scene, &settings.tessellation())?);
        let geometry = Arc::new(ViewGeometry::new(&scene, &tessellation)?);
        Ok(Self { scene, load, tessellation, tracer, geometry })
    }

    /// Builds the tree of a scene that is cut already.
    ///
    /// # Errors
    /// One line, if the elements are too many to draw.
    pub fn of_tessellation(scene: Arc<Scene>, load: LoadOptions, tessellation: Tessellation) -> Result<Self, String> {
        let geometry = Arc::new(ViewGeometry::new(&scene, &tessellation)?);
        let tracer = Arc::new(Tracer::new(Arc::clone(&scene)));
        Ok(Self { scene, load, tessellation: Arc::new(tessellation), tracer, geometry })
    }

    /// A field on other elements of the same scene, at the vertices of these.
    pub fn resampled(&self, field: &Arc<Vec<Vec3>>, on: &Self) -> Arc<Vec<Vec3>> {
        let (here, there) = (&self.tessellation, &on.tessellation);
        let are_equal = here.mesh.triangles == there.mesh.triangles && here.mesh.positions.len() == field.len();
        if are_equal {
            return Arc::clone(field);
        }
        let mut resampled = vec![Vec3::ZERO; here.mesh.positions.len()];
        for (element, corners) in here.mesh.triangles.iter().enumerate() {
            let inside = here.corner_barycentrics[element];
            let middle = inside.iter().sum::<Vec2>() / 3.0;
            for (&vertex, place) in corners.iter().zip(inside) {
                // In the corner itself another element begins.
                let place = place.lerp(middle, 1e-3);
                resampled[vertex as usize] = there.interpolate(field, here.scene_triangle[element], place);
            }
        }
        Arc::new(resampled)
    }

    /// The same elements in a scene of these materials.
    #[cfg(feature = "reference")]
    pub(super) fn with_materials(&self, materials: &[Material]) -> Self {
        if self.scene.materials == materials {
            return self.clone();
        }
        let scene = Arc::new(Scene { materials: materials.to_vec(), ..Scene::clone(&self.scene) });
        Self { scene, ..self.clone() }
    }

    /// The same scene, cut otherwise.
    pub(super) fn cut_as(&self, tessellation: &Arc<Tessellation>) -> Result<Self, String> {
        let geometry = Arc::new(ViewGeometry::new(&self.scene, tessellation)?);
        Ok(Self { tessellation: Arc::clone(tessellation), geometry, ..self.clone() })
    }
}

/// The elements that `input` asks for, or asks to begin with: `base`, which was made with the settings `made_with`, if
/// it still serves.
pub(super) fn elements_for(base: &Elements, made_with: &SolveSettings, input: &SolveInput) -> Result<Elements, String> {
    if base.scene.materials != *input.materials {
        let scene = Arc::new(Scene { materials: input.materials.to_vec(), ..Scene::clone(&base.scene) });
        return Elements::new(scene, base.load.clone(), &input.settings);
    }
    let is_uncut = base.tessellation.cuts.is_empty();
    if is_uncut && made_with.tessellation() == input.settings.tessellation() {
        return input.settings.problem().map_or_else(|| Ok(base.clone()), Err);
    }
    Elements::with_tracer(Arc::clone(&base.scene), Arc::clone(&base.tracer), base.load.clone(), &input.settings)
}
