//! Lightmaps: a place on a picture for every point of the scene's surfaces, and what each texel of it is in the scene.
//!
//! [`unwrap()`] finds the places ([`Charts`]), [`texel_table`] what lies in each texel ([`Texel`]): exact areas and
//! centroids by clipping ([`coverage`]), and how much of it is open (`openness`). [`pages_of`] turns values of the texels
//! into pages without holes, which [`Charts::interpolate`] reads.

pub mod charts;
pub mod coverage;
pub mod dilate;
mod openness;
mod rooms;
pub mod settings;
pub mod texels;
pub mod unwrap;

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests;

pub use charts::Charts;
pub use dilate::{fill_rings, pages_of};
#[cfg(feature = "reference")]
pub use settings::PairKernel;
pub use settings::{
    Ambient, Attenuation, FormFactorMethod, FormFactorSettings, GpuSettings, PageUpdate, PixelWeights, ShootingOrder,
    Visibility,
};
pub use texels::{Texel, texel_table};
pub use unwrap::{LightmapSettings, unwrap};

use crate::{scene::Scene, trace::RayTracer};

/// A scene's lightmap without its light: charts, and the texels that they cover.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// Where triangles lie.
    pub charts: Charts,
    /// The covered texels.
    pub texels: Vec<Texel>,
}

impl Atlas {
    /// Unwraps a scene and finds its texels. `progress` gets what is being done and, where it is known, how far it is;
    /// it may stop the work by returning false.
    ///
    /// # Errors
    /// One line; `Ok(None)` if it was stopped.
    pub fn new(
        scene: &Scene,
        tracer: &dyn RayTracer,
        settings: &LightmapSettings,
        progress: &unwrap::UnwrapProgress<'_>,
    ) -> Result<Option<Self>, String> {
        let Some(charts) = unwrap(scene, settings, progress)? else {
            return Ok(None);
        };
        let report = |done| progress("measuring texels", Some(done));
        let texels = texel_table(scene, tracer, (&charts, settings.no_coverage), &report);
        Ok(texels.map(|texels| Self { charts, texels }))
    }
}
