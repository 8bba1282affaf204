//! What others see of a solve: its pages, for views on the same device, and its fields, read back.

use glam::{Vec3, Vec4};

use super::{GpuSolver, pages::Stage, readback::read_copy, timing::Pass};

/// What the work of a solve is, in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveSize {
    /// Texels that light arrives at.
    pub texels: usize,
    /// Groups of them that shoot as one.
    pub groups: usize,
    /// Shooters that the lights are cut into.
    pub lamps: usize,
    /// Bytes on the device.
    pub bytes: u64,
    /// Open area of all texels, in m².
    pub square_metres: f64,
}

/// The fields of a solve, by texel of the atlas [W/m²].
#[derive(Clone, Debug, PartialEq)]
pub struct TexelFields {
    /// Irradiance of the lights alone.
    pub direct: Vec<Vec3>,
    /// All irradiance so far, and what is added for the light that has still to be shot.
    pub total: Vec<Vec3>,
}

/// Hemicubes that a picture of them shows: a whole batch's would be too small.
const TILES_TO_SHOW: u32 = 4;

impl GpuSolver {
    /// How much there is to do.
    pub fn size(&self) -> SolveSize {
        SolveSize {
            texels: self.patches.receivers.len(),
            groups: self.patches.groups.len(),
            lamps: self.patches.lamps.len(),
            bytes: self.bytes,
            square_metres: f64::from(self.open_area()) * self.square_metres,
        }
    }

    pub(super) fn open_area(&self) -> f32 {
        self.patches.receivers.iter().map(|receiver| receiver.area).sum()
    }

    /// Fills the pages with what a view is to show. They stay on the card.
    pub fn fill_pages(&mut self, stage: Stage) -> Result<(), String> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = self.timer.compute(&mut encoder, Pass::Pages);
        self.pages.record(&self.queue, &mut pass, (stage, self.ledger.shooters, self.rest()));
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

    /// Depth of the last batch's hemicubes, lights apart, for whoever shows it; and the columns and rows of the first few.
    pub fn hemicube_depth(&self) -> (&wgpu::TextureView, [u32; 2]) {
        let pass = &self.hemicubes.pass;
        let tiles = self.usual_batch().min(TILES_TO_SHOW).min(pass.layout.tiles_per_row);
        let resolution = pass.layout.resolution;
        let rows = if pass.hemispheres.is_some() { resolution } else { 3 * resolution };
        (&pass.depth, [tiles * resolution, rows])
    }

    /// Items of the last batch's hemispheres, lights apart, if it has them: numbers of triangles + 1.
    pub fn item_buffer(&self) -> Option<&wgpu::TextureView> {
        self.hemicubes.pass.hemispheres.as_ref().and(self.hemicubes.pass.sides.as_ref())
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
        let rest = self.rest();
        if rest.even != Vec3::ZERO {
            self.patches.texel_of_receiver.iter().for_each(|texel| fields.total[*texel as usize] += rest.even);
        }
        if rest.trend != Vec3::ZERO {
            let before = self.texel_field(&self.buffers.older)?;
            fields.total.iter_mut().zip(before).for_each(|(total, before)| *total += rest.trend * (*total - before));
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
