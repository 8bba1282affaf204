//! The lights in pieces, and a shadow map for each.
//!
//! Every light here shines to one side, so the half of a cube map that its light can reach is a hemicube: the lightmap's own
//! pass draws them, cut-outs and all, and its shader looks them up.

use std::{f32::consts::PI, ops::Range};

use glam::{Vec3, Vec4};

use super::settings::ScreenSettings;
use crate::{
    gpu::lightmap::{
        hemicube::{FACE_COUNT, HemicubePass, NEAR, SceneBuffers, TileLayout},
        patches::{BatchSettings, Face, Shooter},
        pipelines::{compute_pipeline, module},
        shaders::{FACES_WGSL, PATCHES_WGSL, Shaders, VISIBILITY_WGSL},
    },
    lightmap::Visibility,
    math::color::luminance,
    scene::{AreaLight, Material, Scene},
};

/// The shader of direct light; comes after `patches.wgsl`, `visibility.wgsl` and `screen.wgsl`.
pub const LIGHT_WGSL: &str = include_str!("light.wgsl");

/// The whole of that shader.
pub fn light_source() -> String {
    format!("{PATCHES_WGSL}{VISIBILITY_WGSL}{}{LIGHT_WGSL}", super::uniforms::SCREEN_WGSL)
}

/// A piece of a light, laid out as `Lamp` in `light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Lamp {
    /// The whole light, the same for all of its pieces: a quadrangle; a triangle has its last corner twice. The w of the
    /// first three are its middle.
    pub corners: [Vec4; 4],
    /// Where the piece's hemicube stands.
    pub origin: Vec3,
    /// Points nearer to its plane than this get nothing.
    pub least_height: f32,
    /// Unit normal of the side that shines.
    pub normal: Vec3,
    /// Pieces of the same light from this one on.
    pub pieces: u32,
    /// Unit vector in its plane.
    pub tangent: Vec3,
    /// Area of the whole light.
    pub area: f32,
    /// What leaves it [W/m²].
    pub radiosity: Vec3,
    /// Not used.
    pub spare: f32,
}

/// A parallelogram, or the half of it at its corner, that shines to the side of u × v.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    corner: Vec3,
    u: Vec3,
    v: Vec3,
    is_triangle: bool,
    radiance: Vec3,
}

/// Heights over a lamp's plane below this part of its size are rounding.
const LEAST_HEIGHT: f32 = 1e-3;

impl Piece {
    fn area(&self) -> f32 {
        self.u.cross(self.v).length() * if self.is_triangle { 0.5 } else { 1.0 }
    }

    fn power(&self) -> f32 {
        self.area() * luminance(self.radiance)
    }

    /// Cut along both sides into equal pieces, no more than `count` of them.
    fn cut(&self, count: u32) -> Vec<Self> {
        let across = count.max(1).isqrt();
        let along = if self.is_triangle { across } else { count.max(1) / across };
        let (u, v) = (self.u / across as f32, self.v / along as f32);
        let place = |column: u32, row: u32| self.corner + column as f32 * u + row as f32 * v;
        let mut pieces = Vec::new();
        for (row, column) in (0..along).flat_map(|row| (0..across).map(move |column| (row, column))) {
            if !self.is_triangle || row + column < across {
                pieces.push(Self { corner: place(column, row), u, v, ..*self });
            }
            if self.is_triangle && row + column + 1 < across {
                pieces.push(Self { corner: place(column + 1, row + 1), u: -u, v: -v, ..*self });
            }
        }
        pieces
    }

    /// As lamps: cut along both sides into equal pieces, no more than `count` of them, each with its hemicube at its
    /// middle, or moved about with the number of still frames (Roberts' sequence).
    fn lamps(&self, count: u32, still: u32) -> Vec<Lamp> {
        let part = if self.is_triangle { 1.0 / 3.0 } else { 0.5 };
        let middle = self.corner + part * (self.u + self.v);
        let moved = |step: f32| (part + still as f32 * step).fract();
        let (mut a, mut b) = (moved(0.754_877_7), moved(0.569_840_3));
        if self.is_triangle && a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        let normal = self.u.cross(self.v).normalize_or_zero();
        let (first, second, last) = (self.corner, self.corner + self.u, self.corner + self.v);
        let third = if self.is_triangle { last } else { second + self.v };
        let corners = [(first, middle.x), (second, middle.y), (third, middle.z), (last, 0.0)];
        let corners = corners.map(|(corner, of_middle)| corner.extend(of_middle));
        let pieces = self.cut(count);
        let left = (1..=pieces.len() as u32).rev();
        let lamp = |(piece, left): (&Self, u32)| Lamp {
            corners,
            origin: piece.corner + a * piece.u + b * piece.v,
            least_height: LEAST_HEIGHT * (self.u.length() + self.v.length()),
            normal,
            pieces: left,
            tangent: normal.any_orthonormal_vector(),
            area: self.area(),
            radiosity: PI * self.radiance,
            ..Lamp::default()
        };
        pieces.iter().zip(left).map(lamp).collect()
    }
}

/// The lights as at most `count` lamps: each light whole or cut, larger powers into more. Of more lights than that, some are
/// chosen by their power, others with each still frame, and shine for all.
pub fn lamps(scene: &Scene, materials: &[Material], light: Option<&AreaLight>, count: u32, still: u32) -> Vec<Lamp> {
    let placed = light.map(|light| Piece {
        corner: light.corners()[0],
        u: 2.0 * light.half_extent_u,
        v: 2.0 * light.half_extent_v,
        is_triangle: false,
        radiance: light.radiance,
    });
    let emissive = (0..scene.mesh.triangles.len() as u32).filter_map(|triangle| {
        let material = materials.get(scene.mesh.material_indices[triangle as usize] as usize)?;
        let [a, b, c] = scene.mesh.corners(triangle);
        let radiance = material.emitted_radiance;
        (radiance != Vec3::ZERO).then(|| Piece { corner: a, u: b - a, v: c - a, is_triangle: true, radiance })
    });
    let lights: Vec<Piece> = placed.into_iter().chain(emissive).filter(|piece| piece.power() > 0.0).collect();
    let total: f32 = lights.iter().map(Piece::power).sum();
    let spare = count.checked_sub(lights.len() as u32);
    if let Some(spare) = spare {
        let pieces = |piece: &Piece| piece.lamps(1 + (spare as f32 * piece.power() / total) as u32, still);
        return lights.iter().flat_map(pieces).collect();
    }
    let mut chosen = Vec::new();
    let offset = (0.5 + still as f32 * 0.618_034).fract();
    let mut before = 0.0;
    for piece in &lights {
        let share = count as f32 * piece.power() / total;
        // As many of the points offset, 1 + offset, ... as lie in its share of the line.
        let within = (before + share - offset).ceil().max(0.0) - (before - offset).ceil().max(0.0);
        if within > 0.0 {
            chosen.extend(Piece { radiance: piece.radiance * within / share, ..*piece }.lamps(1, still));
        }
        before += share;
    }
    chosen.truncate(count as usize);
    chosen
}

/// Shadow maps of the lamps, and what the shader of direct light reads of them.
pub(super) struct LampPass {
    scene: SceneBuffers,
    shaders: Shaders,
    hemicubes: HemicubePass,
    find_faces: wgpu::ComputePipeline,
    faces_group: wgpu::BindGroup,
    faces: wgpu::Buffer,
    shooters: wgpu::Buffer,
    pub(super) settings: wgpu::Buffer,
    pub(super) lamps: wgpu::Buffer,
    count: u32,
}

impl LampPass {
    pub(super) fn new(device: &wgpu::Device, scene: &Scene, settings: &ScreenSettings) -> Self {
        use wgpu::BufferUsages as Usage;
        let buffer = |label, bytes: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let (scene, shaders) = (SceneBuffers::new(device, scene, Visibility::Hemicube), Shaders::default());
        let hemicubes = HemicubePass::new(device, &shaders, &scene, layout(device, settings));
        let most = super::settings::MOST_LAMPS as usize;
        let shooters = buffer("lamp shooters", most * size_of::<Shooter>(), Usage::STORAGE | Usage::COPY_DST);
        let faces_bytes = most * FACE_COUNT as usize * size_of::<Face>();
        let faces = buffer("lamp faces", faces_bytes, Usage::STORAGE | Usage::VERTEX);
        let settings = buffer("lamp settings", size_of::<BatchSettings>(), Usage::UNIFORM | Usage::COPY_DST);
        let faces_module = module(device, "faces.wgsl", &format!("{PATCHES_WGSL}{FACES_WGSL}"));
        let find_faces = compute_pipeline(device, &faces_module, "find_faces");
        let faces_group = super::passes::bind(device, &find_faces, &[(0, &settings), (1, &shooters), (2, &faces)], &[]);
        Self {
            lamps: buffer("lamps", most * size_of::<Lamp>(), Usage::UNIFORM | Usage::COPY_DST),
            scene,
            shaders,
            hemicubes,
            find_faces,
            faces_group,
            faces,
            shooters,
            settings,
            count: 0,
        }
    }

    /// Makes room for the shadow maps that the settings ask for: true if that is another texture.
    pub(super) fn resize(&mut self, device: &wgpu::Device, settings: &ScreenSettings) -> bool {
        let wanted = layout(device, settings);
        let differs = wanted != self.hemicubes.layout;
        if differs {
            self.hemicubes = HemicubePass::new(device, &self.shaders, &self.scene, wanted);
        }
        differs
    }

    /// Lamps that there is room for.
    pub(super) fn slots(&self) -> u32 {
        self.hemicubes.layout.slots
    }

    /// Depth of the shadow maps.
    pub(super) fn depth(&self) -> &wgpu::TextureView {
        &self.hemicubes.depth
    }

    /// Takes other lamps; their shadow maps have to be drawn then.
    pub(super) fn set(&mut self, queue: &wgpu::Queue, lamps: &[Lamp], settings: &ScreenSettings) {
        let layout = self.hemicubes.layout;
        let lamps = &lamps[..lamps.len().min(layout.slots as usize)];
        self.count = lamps.len() as u32;
        let shooter = |lamp: &Lamp| Shooter {
            origin: lamp.origin,
            normal: lamp.normal,
            tangent: lamp.tangent,
            area: 1.0,
            ..Shooter::default()
        };
        let shooters: Vec<Shooter> = lamps.iter().map(shooter).collect();
        queue.write_buffer(&self.shooters, 0, bytemuck::cast_slice(&shooters));
        queue.write_buffer(&self.lamps, 0, bytemuck::cast_slice(lamps));
        let settings = BatchSettings {
            slot_count: self.count,
            resolution: layout.resolution,
            tiles_per_row: layout.tiles_per_row,
            near: NEAR,
            bias: settings.shadow_bias,
            filtered: 1,
            end_slot: self.count,
            ..BatchSettings::default()
        };
        queue.write_buffer(&self.settings, 0, bytemuck::bytes_of(&settings));
    }

    /// Faces of the shadow maps.
    pub(super) fn face_count(&self) -> u32 {
        FACE_COUNT * self.count
    }

    /// Triangles of the scene.
    pub(super) fn triangle_count(&self) -> u32 {
        self.scene.index_count / 3
    }

    /// Draws faces by their number; before the first, all are cleared.
    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, faces: Range<u32>) {
        let begins = faces.start == 0;
        if begins {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.find_faces);
            pass.set_bind_group(0, &self.faces_group, &[]);
            pass.dispatch_workgroups(self.face_count().div_ceil(64), 1, 1);
        }
        let draws = self.scene.draws(faces.start)..self.scene.draws(faces.end);
        self.hemicubes.draw(encoder, &self.scene, &self.faces, (draws, begins), None);
    }
}

fn layout(device: &wgpu::Device, settings: &ScreenSettings) -> TileLayout {
    TileLayout::new(settings.shadow_map, settings.light_samples, device.limits().max_texture_dimension_2d.min(4096))
}
