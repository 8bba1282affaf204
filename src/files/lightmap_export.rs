//! A lightmap for other programs: pages as OpenEXR and PNG, and the scene with lightmap coordinates as OBJ.

use std::{
    f32::consts::PI,
    fs,
    io::{Cursor, Write},
    path::Path,
};

use anyhow::Context as _;
use glam::Vec3;
use image::{ExtendedColorType, ImageEncoder as _, RgbaImage, codecs::openexr::OpenExrEncoder};

use super::{write_atomically, write_picture};
use crate::{
    lightmap::Charts,
    math::color::ToneMap,
    scene::Scene,
    solver::{LightmapSolution, lightmap_solution},
};

/// The solution's name in its folder.
pub const SOLUTION_NAME: &str = "lightmap.safetensors";

/// Writes a folder: `lightmap.safetensors`; for each page `lightmap-0.exr` (irradiance [W/m²], linear, f32) and
/// `lightmap-0.png` (irradiance / π through the tone map); `lightmap.obj` with `lightmap.mtl`. Makes the folder if there
/// is none.
pub fn write_lightmap(
    folder: &Path,
    scene: &Scene,
    solution: &LightmapSolution,
    tone_map: &ToneMap,
) -> anyhow::Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("{}: the folder cannot be made", folder.display()))?;
    let bytes = lightmap_solution::encode(solution).with_context(|| folder.display().to_string())?;
    write_atomically(&folder.join(SOLUTION_NAME), |writer| Ok(writer.write_all(&bytes)?))?;
    let charts = &solution.charts;
    let [width, height] = charts.page_size;
    for (page, texels) in solution.total.chunks(width as usize * height as usize).enumerate() {
        let mut bytes = Cursor::new(Vec::new());
        let encoder = OpenExrEncoder::new(&mut bytes);
        encoder.write_image(bytemuck::cast_slice(texels), width, height, ExtendedColorType::Rgb32F)?;
        let bytes = bytes.into_inner();
        write_atomically(&folder.join(format!("lightmap-{page}.exr")), |writer| Ok(writer.write_all(&bytes)?))?;
        write_picture(&folder.join(format!("lightmap-{page}.png")), &picture(texels, width, height, tone_map))?;
    }
    write_atomically(&folder.join("lightmap.obj"), |writer| write_obj(writer, scene, charts))?;
    write_atomically(&folder.join("lightmap.mtl"), |writer| write_mtl(writer, charts.page_count))
}

/// A page through the tone map.
pub fn picture(texels: &[Vec3], width: u32, height: u32, tone_map: &ToneMap) -> RgbaImage {
    let mut picture = RgbaImage::new(width, height);
    for (pixel, value) in picture.pixels_mut().zip(texels) {
        pixel.0 = tone_map.apply_to_bytes(*value / PI);
    }
    picture
}

/// Positions in metres, normals, and lightmap coordinates: (0, 0) is a page's lower left corner, as OBJ has it. A page
/// is a material.
fn write_obj(writer: &mut dyn Write, scene: &Scene, charts: &Charts) -> anyhow::Result<()> {
    let mesh = &scene.mesh;
    writeln!(writer, "# radiosity {}: the scene with lightmap coordinates", env!("CARGO_PKG_VERSION"))?;
    writeln!(writer, "mtllib lightmap.mtl")?;
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        let position = scene.frame.point_to_metres(*position);
        writeln!(writer, "v {} {} {}", position.x, position.y, position.z)?;
        writeln!(writer, "vn {} {} {}", normal.x, normal.y, normal.z)?;
    }
    let [width, height] = charts.page_size.map(|side| side as f32);
    for corner in charts.coordinates.iter().flatten() {
        writeln!(writer, "vt {} {}", corner.x / width, 1.0 - corner.y / height)?;
    }
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    order.sort_by_key(|&triangle| charts.pages[triangle]);
    for page in order.chunk_by(|a, b| charts.pages[*a] == charts.pages[*b]) {
        writeln!(writer, "usemtl lightmap-{}", charts.pages[page[0]])?;
        for &triangle in page {
            write!(writer, "f")?;
            for (corner, vertex) in mesh.triangles[triangle].iter().enumerate() {
                write!(writer, " {0}/{1}/{0}", vertex + 1, 3 * triangle + corner + 1)?;
            }
            writeln!(writer)?;
        }
    }
    Ok(())
}

fn write_mtl(writer: &mut dyn Write, page_count: u32) -> anyhow::Result<()> {
    for page in 0..page_count {
        writeln!(writer, "newmtl lightmap-{page}\nKd 1 1 1\nmap_Kd lightmap-{page}.png")?;
    }
    Ok(())
}
