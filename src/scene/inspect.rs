//! What a scene holds, in numbers.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::reflectance::triangle_mean_reflectance;
use super::{Material, Scene, Texture};

/// A scene in numbers, as [`report`] finds them.
#[derive(Clone, Debug, Serialize)]
pub struct SceneReport {
    /// The scene's name.
    pub name: String,
    /// Hash of all that a solution depends on.
    pub hash: String,
    /// Triangles, second sides included.
    pub triangles: usize,
    /// Vertices: positions with a normal.
    pub vertices: usize,
    /// True if the second half of the triangles are the back sides of the first.
    pub two_sided: bool,
    /// Lowest corner of the bounding box in m.
    pub minimum: [f64; 3],
    /// Highest corner of the bounding box in m.
    pub maximum: [f64; 3],
    /// Area of all triangles in m².
    pub area: f64,
    /// The materials, in the scene's order.
    pub materials: Vec<MaterialReport>,
    /// The textures, in the scene's order.
    pub textures: Vec<TextureReport>,
    /// What was dropped, repaired or missing.
    pub warnings: Vec<String>,
}

/// One material of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct MaterialReport {
    /// Its name.
    pub name: String,
    /// Triangles that have it.
    pub triangles: usize,
    /// Their area in m².
    pub area: f64,
    /// Reflectance per band, mean over that area.
    pub mean_reflectance: [f32; 3],
    /// Name of the reflectance texture.
    pub reflectance_texture: Option<String>,
    /// Name of the texture that cuts holes.
    pub opacity_texture: Option<String>,
    /// Emitted radiance per band in W/(m² sr).
    pub emitted_radiance: [f32; 3],
    /// Emitted power per band, π · radiance · area in W.
    pub emitted_power: [f64; 3],
}

/// One texture of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct TextureReport {
    /// The file's name as the MTL writes it.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
}

/// Counts and measures a scene.
pub fn report(scene: &Scene) -> SceneReport {
    let mesh = &scene.mesh;
    let count = mesh.triangles.len() as u32;
    let measures: Vec<(f64, Vec3)> = (0..count)
        .into_par_iter()
        .map(|triangle| {
            let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
            let area = 0.5 * (b - a).cross(c - a).length() * scene.frame.square_metres_per_unit();
            (area, triangle_mean_reflectance(scene, triangle))
        })
        .collect();
    let mut sums = vec![Sum::default(); scene.materials.len()];
    for (material, (area, reflectance)) in mesh.material_indices.iter().zip(&measures) {
        let sum = &mut sums[*material as usize];
        sum.triangles += 1;
        sum.area += area;
        sum.reflected += *area * reflectance.as_dvec3();
    }
    let texture_report = |texture: &Texture| {
        let (width, height) = texture.size();
        TextureReport { name: texture.name.clone(), width, height }
    };
    let (minimum, maximum) = scene.bounds_in_metres();
    SceneReport {
        name: scene.name.clone(),
        hash: scene.hash(),
        triangles: mesh.triangles.len(),
        vertices: mesh.positions.len(),
        two_sided: scene.two_sided,
        minimum: minimum.to_array(),
        maximum: maximum.to_array(),
        area: measures.iter().map(|(area, _)| area).sum(),
        materials: scene
            .materials
            .iter()
            .zip(&sums)
            .map(|(material, sum)| material_report(scene, material, sum))
            .collect(),
        textures: scene.textures.iter().map(texture_report).collect(),
        warnings: scene.warnings.clone(),
    }
}

/// Sums over the triangles of a material.
#[derive(Clone, Copy, Default)]
struct Sum {
    triangles: usize,
    /// In m².
    area: f64,
    /// Reflectance times area.
    reflected: DVec3,
}

fn material_report(scene: &Scene, material: &Material, sum: &Sum) -> MaterialReport {
    let mean = if sum.area > 0.0 { (sum.reflected / sum.area).as_vec3() } else { material.reflectance };
    let name_of = |texture: Option<u32>| texture.map(|texture| scene.textures[texture as usize].name.clone());
    let emitted_radiance = material.emitted_radiance.to_array();
    MaterialReport {
        name: material.name.clone(),
        triangles: sum.triangles,
        area: sum.area,
        mean_reflectance: mean.to_array(),
        reflectance_texture: name_of(material.reflectance_texture),
        opacity_texture: name_of(material.opacity_texture),
        emitted_radiance,
        emitted_power: emitted_radiance.map(|radiance| std::f64::consts::PI * f64::from(radiance) * sum.area),
    }
}
