//! What others see of a solve: its pages, for views on the same device, and its fields, read back.

use glam::{Vec3, Vec4};

use super::{GpuLedger, GpuSolver, pages::Stage, readback::read_copy, timing::Pass};
use crate::math::ratio_or_zero;

/// The fields of a solve, by texel of the atlas [W/m²].
#[derive(Clone, Debug, PartialEq)]
pub struct TexelFields {
    /// Irradiance of the lights alone.
    pub direct: Vec<Vec3>,
    /// All irradiance so far.
    pub total: Vec<Vec3>,
}

impl GpuSolver {
    /// Fills the pages with what a view is to show. They stay on the card.
    pub fn fill_pages(&mut self, stage: Stage) -> Result<(), String> {
        let ambient = if self.settings.ambient { self.ambient_irradiance() } else { Vec3::ZERO };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = self.timer.compute(&mut encoder, Pass::Pages);
        self.pages.record(&self.queue, &mut pass, (stage, self.ledger.shooters, ambient));
        drop(pass);
        self.timer.resolve(&mut encoder);
        self.queue.submit([encoder.finish()]);
        self.timer.collect(&self.device)
    }

    /// The pages as [`GpuSolver::fill_pages`] left them, for whoever draws them: four numbers (columns and rows of a page,
    /// pages, 0), then the texels, each a vector of four.
    pub fn pages(&self) -> &wgpu::Buffer {
        &self.pages.pages
    }

    /// Depth of the last batch's hemicubes, lights apart, for whoever shows it; and its size in pixels.
    pub fn hemicube_depth(&self) -> (&wgpu::TextureView, [u32; 2]) {
        (&self.hemicubes.pass.depth, self.hemicubes.pass.layout.size())
    }

    /// What the light that has still to be shot will add to every texel in the mean: its power by the area of all
    /// texels, reflected over and over at their mean reflectance (Cohen, Chen, Wallace and Greenberg 1988, the ambient
    /// term); less the part that leaves the scene, as far as is known.
    pub fn ambient_irradiance(&self) -> Vec3 {
        let area = self.open_area();
        let reflected: Vec3 = self.patches.receivers.iter().map(|receiver| receiver.area * receiver.reflectance).sum();
        let GpuLedger { arrived, escaped, unshot, .. } = self.ledger;
        let inside = ratio_or_zero(arrived.element_sum(), (arrived + escaped).element_sum()) as f32;
        let mean = inside * (unshot / self.square_metres).as_vec3() / area;
        mean / (1.0 - inside * reflected / area)
    }

    /// Reads the fields back, for a file or a comparison.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn fields(&self) -> Result<TexelFields, String> {
        if self.is_lost {
            return Err(String::from("the graphics device was lost"));
        }
        let all_lamps =
            self.lamps_done == self.patches.lamps.len() as u32 && (!self.from_lamps || self.batch.is_done());
        let direct = if all_lamps { &self.buffers.direct } else { &self.buffers.irradiance };
        let mut fields =
            TexelFields { direct: self.texel_field(direct)?, total: self.texel_field(&self.buffers.irradiance)? };
        if self.settings.ambient {
            let ambient = self.ambient_irradiance();
            self.patches.texel_of_receiver.iter().for_each(|texel| fields.total[*texel as usize] += ambient);
        }
        Ok(fields)
    }

    fn texel_field(&self, buffer: &wgpu::Buffer) -> Result<Vec<Vec3>, String> {
        let mut field = vec![Vec3::ZERO; self.texel_count];
        let values: Vec<Vec4> = read_copy(&self.device, &self.queue, buffer)?;
        for (texel, value) in self.patches.texel_of_receiver.iter().zip(values) {
            field[*texel as usize] = value.truncate();
        }
        Ok(field)
    }
}
