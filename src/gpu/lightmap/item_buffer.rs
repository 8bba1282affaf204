//! Form factors by item buffers: each patch's hemicube is drawn with the numbers of the triangles, and the weights of the
//! pixels that show a triangle are added up (Cohen and Greenberg 1985).

use std::time::Instant;

use glam::Vec3;
use wgpu::util::DeviceExt as _;

use super::{
    cutouts::{CutTriangle, CutoutBuffers, CutoutPass, has_mask},
    hemicube::{FACE_COUNT, NEAR, TileLayout, delta_form_factors},
    lamps::lamps_of,
    pace::SUBMISSION_TIME,
    patches::{BatchSettings, Face, Shooter},
    pipelines::{FaceDraw, POSITIONS, compute_pipeline, face_pipeline, module},
    readback::read_part,
    shaders::{CUTOUTS_WGSL, FACES_WGSL, ON_FACE_WGSL, PATCHES_WGSL},
};
use crate::{
    gpu::targets::drawn_texture,
    lightmap::PixelWeights,
    math::ratio_or_zero,
    scene::{AreaLight, Scene, Tessellation},
};

/// The shader that draws items.
pub const ITEM_BUFFER_WGSL: &str = include_str!("item_buffer.wgsl");
/// The shader that adds their pixels up.
pub const ROWS_WGSL: &str = include_str!("rows.wgsl");

/// Where a hemicube stands, and which way its top looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Its middle [local units].
    pub origin: Vec3,
    /// Unit normal of the patch.
    pub normal: Vec3,
}

/// One row of form factors: triangle and form factor, for all triangles that are seen, in order.
pub type Row = Vec<(u32, f32)>;

/// What each pixel of a hemicube counts.
pub fn weights_of(kind: PixelWeights, resolution: u32) -> Vec<f32> {
    match kind {
        PixelWeights::Delta => delta_form_factors(resolution),
        PixelWeights::Plain => {
            let count = 3 * resolution * resolution;
            vec![1.0 / count as f32; count as usize]
        }
    }
}

/// Hemicubes in one submission, at most.
const MOST_SLOTS: u32 = 64;
/// Entries of the rows of one submission, at most: 64 MiB.
const MOST_ENTRIES: u32 = 1 << 24;

/// Draws hemicubes over a list of triangles.
pub struct ItemBuffers {
    device: wgpu::Device,
    queue: wgpu::Queue,
    layout: TileLayout,
    triangle_count: u32,
    positions: wgpu::Buffer,
    draw: wgpu::RenderPipeline,
    cutouts: Option<(CutoutPass, CutoutBuffers)>,
    find_faces: wgpu::ComputePipeline,
    add_pixels: wgpu::ComputePipeline,
    settings: wgpu::Buffer,
    shooters: wgpu::Buffer,
    faces: wgpu::Buffer,
    rows: wgpu::Buffer,
    faces_group: wgpu::BindGroup,
    rows_group: wgpu::BindGroup,
    items: wgpu::TextureView,
    depth: wgpu::TextureView,
}

/// What item buffers show.
pub(super) const ITEM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

impl ItemBuffers {
    /// For the elements of a scene, with the holes that its materials cut into them; the rest as [`Self::new`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_elements(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        (scene, elements): (&Scene, &Tessellation),
        resolution: u32,
        weights: &[f32],
    ) -> Result<Self, String> {
        let mesh = &elements.mesh;
        let count = mesh.triangles.len() as u32;
        let scene_triangle = |element: u32| elements.scene_triangle[element as usize];
        // What may have holes keeps its number, and shows nothing here.
        let opaque = |element: u32| match scene.may_be_cut_out(scene_triangle(element)) {
            true => [mesh.corners(element)[0]; 3],
            false => mesh.corners(element),
        };
        let triangles: Vec<[Vec3; 3]> = (0..count).map(opaque).collect();
        let made = Self::new((device, queue), &triangles, resolution, weights)?;
        let masked = (0..count).filter(|element| has_mask(scene, scene_triangle(*element)));
        let cut = masked.map(|element| CutTriangle {
            item: element,
            scene_triangle: scene_triangle(element),
            corners: mesh.corners(element),
            places: elements.corner_barycentrics[element as usize],
        });
        let cutouts = CutoutBuffers::of(device, scene, cut).map(|buffers| {
            let shader = format!("{ON_FACE_WGSL}{CUTOUTS_WGSL}");
            let fragment = ("cut_out_item", Some(ITEM_FORMAT));
            (CutoutPass::new(device, &shader, &buffers, fragment), buffers)
        });
        Ok(Self { cutouts, ..made })
    }

    /// For triangles given by their corners, and hemicubes of `resolution` pixels (even) whose pixels have `weights`
    /// (3 `resolution`² of them; see [`super::hemicube::delta_form_factors`]).
    ///
    /// # Errors
    /// One line, if there are more triangles than the device can keep rows of.
    pub fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        triangles: &[[Vec3; 3]],
        resolution: u32,
        weights: &[f32],
    ) -> Result<Self, String> {
        let triangle_count = triangles.len() as u32;
        if triangle_count == 0 || triangle_count > MOST_ENTRIES {
            return Err(format!("rows of {triangle_count} triangles; between 1 and {MOST_ENTRIES} are possible"));
        }
        let slots = (MOST_ENTRIES / triangle_count).clamp(1, MOST_SLOTS);
        let layout = TileLayout::new(resolution, slots, device.limits().max_texture_dimension_2d.min(4096));
        let [items, depth] = [ITEM_FORMAT, wgpu::TextureFormat::Depth32Float]
            .map(|format| drawn_texture(device, "item buffer", layout.size(), format));
        let filled = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let zeros = |bytes: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: bytes as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let slots = layout.slots as usize;
        let settings = zeros(size_of::<BatchSettings>(), Usage::UNIFORM | Usage::COPY_DST);
        let shooters = zeros(slots * size_of::<Shooter>(), Usage::STORAGE | Usage::COPY_DST);
        let faces = zeros(slots * FACE_COUNT as usize * size_of::<Face>(), Usage::STORAGE | Usage::VERTEX);
        let rows = zeros(4 * slots * triangles.len(), Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST);
        let weights = filled(bytemuck::cast_slice(weights), Usage::STORAGE);
        let items_shader = module(device, "item_buffer.wgsl", &format!("{ON_FACE_WGSL}{ITEM_BUFFER_WGSL}"));
        let find_faces = compute(device, FACES_WGSL, "find_faces");
        let add_pixels = compute(device, ROWS_WGSL, "add_pixels");
        let entry = |binding, buffer: &'_ wgpu::Buffer| (binding, buffer.clone());
        let faces_group =
            bind(device, &find_faces, &[entry(0, &settings), entry(1, &shooters), entry(2, &faces)], None);
        let rows_entries = [entry(0, &settings), entry(1, &weights), entry(2, &rows)];
        let rows_group = bind(device, &add_pixels, &rows_entries, Some(&items));
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            layout,
            triangle_count,
            positions: filled(bytemuck::cast_slice(triangles), Usage::VERTEX),
            draw: face_pipeline(
                device,
                &FaceDraw {
                    label: "item buffer",
                    module: &items_shader,
                    vertex: POSITIONS,
                    fragment: Some(("write_item", Some(ITEM_FORMAT))),
                },
            ),
            cutouts: None,
            find_faces,
            add_pixels,
            settings,
            shooters,
            faces,
            rows,
            faces_group,
            rows_group,
            items,
            depth,
        })
    }

    /// Viewpoints that [`Self::rows`] takes at once.
    pub fn batch(&self) -> usize {
        self.layout.slots as usize
    }

    /// The rows of any number of viewpoints, in submissions of some [`SUBMISSION_TIME`], or of one hemicube. `report` gets the
    /// part that is done before each, and stops it by returning false: then there are none.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn all_rows(
        &self,
        viewpoints: &[Viewpoint],
        report: &mut dyn FnMut(f32) -> bool,
    ) -> Result<Option<Vec<Row>>, String> {
        let mut rows = Vec::with_capacity(viewpoints.len());
        let mut count = 1;
        while rows.len() < viewpoints.len() {
            if !report(rows.len() as f32 / viewpoints.len() as f32) {
                return Ok(None);
            }
            let end = (rows.len() + count).min(viewpoints.len());
            let started = Instant::now();
            rows.extend(self.rows(&viewpoints[rows.len()..end])?);
            let faster = SUBMISSION_TIME.as_secs_f64() / started.elapsed().as_secs_f64().max(1e-6);
            count = ((count as f64 * faster.min(2.0)) as usize).clamp(1, self.batch());
        }
        Ok(Some(rows))
    }

    /// What a placed light gives to each triangle, of these areas [W/m²]: the light's own rows, turned round
    /// (A_i F_ij = A_j F_ji).
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn direct_irradiance(&self, light: Option<&AreaLight>, areas: &[f32]) -> Result<Vec<Vec3>, String> {
        /// Parts of the light along each side.
        const LIGHT_SIDE: u32 = 8;
        let mut direct = vec![Vec3::ZERO; areas.len()];
        let lamps = light.map_or(Vec::new(), |light| lamps_of(light, LIGHT_SIDE));
        let viewpoints: Vec<Viewpoint> =
            lamps.iter().map(|lamp| Viewpoint { origin: lamp.origin, normal: lamp.normal }).collect();
        let rows = self.all_rows(&viewpoints, &mut |_| true)?;
        for (row, lamp) in rows.iter().flatten().zip(&lamps) {
            for &(triangle, factor) in row {
                let share = ratio_or_zero(f64::from(lamp.area * factor), f64::from(areas[triangle as usize]));
                direct[triangle as usize] += share as f32 * lamp.radiosity;
            }
        }
        Ok(direct)
    }

    /// The rows of some viewpoints, no more than [`Self::batch`]. Waits for the card.
    ///
    /// # Errors
    /// One line, if the device was lost.
    pub fn rows(&self, viewpoints: &[Viewpoint]) -> Result<Vec<Row>, String> {
        let slots = viewpoints.len().min(self.batch());
        let mut encoder = self.draw(&viewpoints[..slots]);
        let bytes = 4 * slots as u64 * u64::from(self.triangle_count);
        encoder.clear_buffer(&self.rows, 0, Some(bytes));
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.add_pixels);
            pass.set_bind_group(0, &self.rows_group, &[]);
            let pixels = 3 * self.layout.resolution * self.layout.resolution;
            pass.dispatch_workgroups(pixels.div_ceil(64), slots as u32, 1);
        }
        self.queue.submit([encoder.finish()]);
        let sums: Vec<u32> = read_part(&self.device, &self.queue, &self.rows, bytes)?;
        let row = |sums: &[u32]| {
            let seen = sums.iter().enumerate().filter(|(_, sum)| **sum > 0);
            seen.map(|(triangle, sum)| (triangle as u32, *sum as f32 / (1 << 30) as f32)).collect()
        };
        Ok(sums.chunks(self.triangle_count as usize).take(slots).map(row).collect())
    }

    /// A command encoder with the hemicubes of some viewpoints drawn.
    fn draw(&self, viewpoints: &[Viewpoint]) -> wgpu::CommandEncoder {
        let shooter = |viewpoint: &Viewpoint| Shooter {
            origin: viewpoint.origin,
            normal: viewpoint.normal,
            tangent: viewpoint.normal.any_orthonormal_vector(),
            area: 1.0,
            ..Shooter::default()
        };
        let shooters: Vec<Shooter> = viewpoints.iter().map(shooter).collect();
        let slots = viewpoints.len() as u32;
        let settings = BatchSettings {
            receiver_count: self.triangle_count,
            slot_count: slots,
            resolution: self.layout.resolution,
            tiles_per_row: self.layout.tiles_per_row,
            near: NEAR,
            ..BatchSettings::default()
        };
        self.queue.write_buffer(&self.settings, 0, bytemuck::bytes_of(&settings));
        self.queue.write_buffer(&self.shooters, 0, bytemuck::cast_slice(&shooters));
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.find_faces);
            pass.set_bind_group(0, &self.faces_group, &[]);
            pass.dispatch_workgroups((slots * FACE_COUNT).div_ceil(64), 1, 1);
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("item buffer"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.items,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&self.draw);
        pass.set_vertex_buffer(0, self.positions.slice(..));
        pass.set_vertex_buffer(1, self.faces.slice(..));
        for instance in 0..slots * FACE_COUNT {
            self.layout.aim(&mut pass, instance);
            pass.draw(0..3 * self.triangle_count, instance..instance + 1);
        }
        if let Some((cutouts, buffers)) = &self.cutouts {
            let corners = cutouts.begin(&mut pass, buffers);
            for instance in 0..slots * FACE_COUNT {
                self.layout.aim(&mut pass, instance);
                pass.draw(0..corners, instance..instance + 1);
            }
        }
        drop(pass);
        encoder
    }
}

fn compute(device: &wgpu::Device, source: &str, entry: &'static str) -> wgpu::ComputePipeline {
    compute_pipeline(device, &module(device, entry, &format!("{PATCHES_WGSL}{source}")), entry)
}

fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::ComputePipeline,
    buffers: &[(u32, wgpu::Buffer)],
    items: Option<&wgpu::TextureView>,
) -> wgpu::BindGroup {
    let mut entries: Vec<_> = buffers
        .iter()
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
        .collect();
    let items =
        items.map(|items| wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(items) });
    entries.extend(items);
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}
