//! Form factors by item buffers on the graphics card, for `radiosity form-factors`; and its table of resolutions.

use std::time::Instant;

use super::{
    Outcome,
    form_factors::{Elements, Found, Task, Watch},
};
use crate::{
    gpu::{
        device,
        lightmap::item_buffer::{ItemBuffers, Viewpoint, weights_of},
    },
    lightmap::PixelWeights,
    solver::form_factors::FormFactors,
};

type Card = (wgpu::Device, wgpu::Queue);

fn open(name: Option<&str>) -> anyhow::Result<Card> {
    device::choose(name).and_then(|device| device.open()).map_err(anyhow::Error::msg)
}

/// Draws the hemicubes of all patches, and of the placed light; none if it was stopped.
pub(super) fn find(task: &Task<'_>, elements: Elements<'_>, watch: &Watch<'_>) -> anyhow::Result<Option<Found>> {
    let buffers = elements.item_buffers(&open(task.device)?, task.settings.resolution, task.settings.weights)?;
    let Some(factors) = elements.form_factors(&buffers, |done| watch(done, "hemicubes"))? else {
        return Ok(None);
    };
    let placed = task.light.map(|light| light.to_local(&elements.scene.frame));
    let direct = buffers.direct_irradiance(placed.as_ref(), &elements.patches.areas).map_err(anyhow::Error::msg)?;
    let Elements { patches, tessellation, .. } = elements;
    Ok(Some(Found { patches, tessellation, factors, direct, rays: 0, tree_seconds: 0.0 }))
}

impl Elements<'_> {
    fn item_buffers(&self, card: &Card, resolution: u32, weights: PixelWeights) -> anyhow::Result<ItemBuffers> {
        let weights = weights_of(weights, resolution);
        ItemBuffers::of_elements((&card.0, &card.1), (self.scene, &self.tessellation), resolution, &weights)
            .map_err(anyhow::Error::msg)
    }

    fn form_factors(
        &self,
        buffers: &ItemBuffers,
        mut go_on: impl FnMut(f32) -> bool,
    ) -> anyhow::Result<Option<FormFactors>> {
        let viewpoints: Vec<Viewpoint> =
            self.patches.places.iter().map(|(origin, normal)| Viewpoint { origin: *origin, normal: *normal }).collect();
        let rows = buffers.all_rows(&viewpoints, &mut go_on).map_err(anyhow::Error::msg)?;
        Ok(rows.map(|rows| FormFactors { areas: self.patches.areas.clone(), rows }))
    }
}

/// Resolutions and weights against the finest delta form factors.
pub(super) fn print_table(elements: &Elements<'_>, device: Option<&str>) -> anyhow::Result<Outcome> {
    const FINEST: u32 = 512;
    let card = open(device)?;
    let rows_of = |kind, resolution| -> anyhow::Result<FormFactors> {
        let buffers = elements.item_buffers(&card, resolution, kind)?;
        Ok(elements.form_factors(&buffers, |_| true)?.unwrap_or_default())
    };
    let reference = rows_of(PixelWeights::Delta, FINEST)?;
    println!(
        "patches {}; error: mean over rows of Σ |F - F_512|, F_512 the delta form factors of {FINEST} pixels",
        elements.patches.areas.len()
    );
    println!("pixels  weights     error   reciprocity  row sums: least    mean  greatest  seconds");
    for resolution in [32, 64, 128, 256, 512] {
        for kind in [PixelWeights::Plain, PixelWeights::Delta] {
            let started = Instant::now();
            let factors = rows_of(kind, resolution)?;
            let seconds = started.elapsed().as_secs_f64();
            let Some(quality) = factors.quality(&|| false) else { continue };
            println!(
                "{resolution:6}  {:7}  {:8.4}  {:10.3} %  {:15.4}  {:6.4}  {:8.4}  {seconds:7.2}",
                if kind == PixelWeights::Plain { "plain" } else { "delta" },
                mean_difference(&factors, &reference),
                100.0 * quality.reciprocity_error,
                quality.least_row_sum,
                quality.mean_row_sum,
                quality.greatest_row_sum,
            );
        }
    }
    Ok(Outcome::Done)
}

/// Mean over rows of Σ |F_ij - G_ij|.
fn mean_difference(factors: &FormFactors, reference: &FormFactors) -> f64 {
    let row_difference = |from: usize| -> f64 {
        let known = reference.rows[from].iter();
        let from_known: f64 =
            known.map(|(to, value)| f64::from((value - factors.factor(from as u32, *to)).abs())).sum();
        let unknown = factors.rows[from].iter().filter(|(to, _)| reference.factor(from as u32, *to) == 0.0);
        from_known + unknown.map(|(_, value)| f64::from(*value)).sum::<f64>()
    };
    (0..factors.rows.len()).map(row_difference).sum::<f64>() / factors.rows.len() as f64
}
