//! A solution as a mesh with vertex colours (PLY) or as a table (CSV).

use std::{f32::consts::PI, io::Write};

use anyhow::Context as _;
use glam::{Vec2, Vec3};
use ply_rs_bw::{
    ply::{Addable as _, ElementDef, Encoding, Header, PropertyAccess, PropertyDef, PropertyType, ScalarType},
    writer::Writer,
};

use crate::{
    math::color::ToneMap,
    scene::{Scene, Tessellation},
    solver::Solution,
};

/// The float properties of a vertex in the PLY file, in their order; the colour comes between normal and irradiance.
const PLY_FLOATS: [&str; 9] = ["x", "y", "z", "nx", "ny", "nz", "irradiance_r", "irradiance_g", "irradiance_b"];
const PLY_COLOURS: [&str; 3] = ["red", "green", "blue"];
const PLY_CORNERS: &str = "vertex_indices";

/// Writes a binary PLY file: positions in metres, normals, `red green blue` (radiosity through the tone map, 8 bits),
/// and `irradiance_r`, `_g`, `_b` (all bounces, linear, W/m²). Numbers are f32, which all readers know: a mesh far
/// from zero keeps fewer digits.
pub fn write_ply(
    writer: &mut dyn Write,
    scene: &Scene,
    tessellation: &Tessellation,
    solution: &Solution,
    tone_map: &ToneMap,
) -> anyhow::Result<()> {
    let mesh = &tessellation.mesh;
    let header = ply_header(scene, mesh.positions.len(), mesh.triangles.len());
    let (vertex_definition, face_definition) = (&header.elements["vertex"], &header.elements["face"]);
    // The writer takes sized types only.
    let mut writer = writer;
    let ply = Writer::<PlyVertex>::new();
    ply.write_header(&mut writer, &header)?;
    let materials = vertex_materials(scene, tessellation);
    for (vertex, irradiance) in solution.total().into_iter().enumerate() {
        let VertexMaterial { reflectance, emitted_radiance } = materials[vertex];
        let [red, green, blue, _] = tone_map.apply_to_bytes(emitted_radiance + reflectance * irradiance / PI);
        let position = scene.frame.point_to_metres(mesh.positions[vertex]).as_vec3();
        let mut floats = [0.0; 9];
        for (place, value) in floats.as_chunks_mut::<3>().0.iter_mut().zip([position, mesh.normals[vertex], irradiance])
        {
            *place = value.to_array();
        }
        let element = PlyVertex { floats, colour: [red, green, blue] };
        ply.write_little_endian_element(&mut writer, &element, vertex_definition)?;
    }
    let ply = Writer::<PlyFace>::new();
    for corners in &mesh.triangles {
        ply.write_little_endian_element(&mut writer, &PlyFace { corners: corners.map(|v| v as i32) }, face_definition)?;
    }
    Ok(())
}

fn ply_header(scene: &Scene, vertex_count: usize, face_count: usize) -> Header {
    let mut header = Header::new();
    header.encoding = Encoding::BinaryLittleEndian;
    let name: String = scene.name.chars().filter(|character| (' '..='~').contains(character)).collect();
    header.comments.push(format!("radiosity {}, scene {name}", env!("CARGO_PKG_VERSION")));
    header.comments.push(String::from("red green blue: tone-mapped radiosity; irradiance: linear, W/m^2"));
    let mut vertex = ElementDef::new(String::from("vertex"));
    vertex.count = vertex_count;
    let (geometry, irradiance) = PLY_FLOATS.split_at(6);
    let floats = |names: &'static [&str]| names.iter().map(|name| (*name, ScalarType::Float));
    let colours = PLY_COLOURS.iter().map(|name| (*name, ScalarType::UChar));
    for (name, scalar) in floats(geometry).chain(colours).chain(floats(irradiance)) {
        vertex.properties.add(PropertyDef::new(String::from(name), PropertyType::Scalar(scalar)));
    }
    let mut face = ElementDef::new(String::from("face"));
    face.count = face_count;
    let list = PropertyType::List(ScalarType::UChar, ScalarType::Int);
    face.properties.add(PropertyDef::new(String::from(PLY_CORNERS), list));
    header.elements.add(vertex);
    header.elements.add(face);
    header
}

/// A vertex as the PLY writer asks for it: by the names of its properties.
#[derive(Default)]
struct PlyVertex {
    floats: [f32; 9],
    colour: [u8; 3],
}

impl PropertyAccess for PlyVertex {
    fn new() -> Self {
        Self::default()
    }

    fn get_float(&self, name: &str) -> Option<f32> {
        PLY_FLOATS.iter().position(|known| *known == name).map(|index| self.floats[index])
    }

    fn get_uchar(&self, name: &str) -> Option<u8> {
        PLY_COLOURS.iter().position(|known| *known == name).map(|index| self.colour[index])
    }
}

/// A face as the PLY writer asks for it.
#[derive(Default)]
struct PlyFace {
    corners: [i32; 3],
}

impl PropertyAccess for PlyFace {
    fn new() -> Self {
        Self::default()
    }

    fn get_list_int(&self, name: &str) -> Option<&[i32]> {
        (name == PLY_CORNERS).then_some(self.corners.as_slice())
    }
}

/// Writes a table of the vertices: position in metres, normal, the area it stands for in m², whether it is buried (0 or
/// 1), reflectance, and irradiance in W/m² of each bounce (`direct`, `bounce1`, ...) and of all together (`total`).
pub fn write_csv(
    writer: &mut dyn Write,
    scene: &Scene,
    tessellation: &Tessellation,
    solution: &Solution,
) -> anyhow::Result<()> {
    let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(writer);
    let mut names: Vec<String> = ["px", "py", "pz", "nx", "ny", "nz", "area", "buried"].map(String::from).to_vec();
    let bounce_names = (1..solution.bounces.len()).map(|bounce| format!("bounce{bounce}"));
    let colours = ["reflectance", "direct"].map(String::from).into_iter().chain(bounce_names);
    for name in colours.chain([String::from("total")]) {
        names.extend(["r", "g", "b"].map(|band| format!("{name}_{band}")));
    }
    table.write_record(&names)?;
    let mesh = &tessellation.mesh;
    let materials = vertex_materials(scene, tessellation);
    let areas = tessellation.vertex_areas();
    let square_metres = scene.frame.square_metres_per_unit();
    for (vertex, total) in solution.total().into_iter().enumerate() {
        let bounces: Vec<[f32; 3]> = solution.bounces.iter().map(|bounce| bounce[vertex].to_array()).collect();
        let row = (
            scene.frame.point_to_metres(mesh.positions[vertex]).to_array(),
            mesh.normals[vertex].to_array(),
            f64::from(areas[vertex]) * square_metres,
            u8::from(solution.buried[vertex]),
            materials[vertex].reflectance.to_array(),
            bounces,
            total.to_array(),
        );
        table.serialize(row).context("a row of the table")?;
    }
    Ok(table.flush()?)
}

/// What a vertex is made of, where it has to be one thing.
#[derive(Clone, Copy, Default)]
struct VertexMaterial {
    reflectance: Vec3,
    emitted_radiance: Vec3,
}

/// The area-weighted mean over the elements around each vertex. An element's reflectance is read near the vertex but
/// inside, at (2/3, 1/6, 1/6): not where textures and materials meet.
fn vertex_materials(scene: &Scene, tessellation: &Tessellation) -> Vec<VertexMaterial> {
    let mesh = &tessellation.mesh;
    let mut sums = vec![(VertexMaterial::default(), 0.0_f32); mesh.positions.len()];
    for (element, corners) in mesh.triangles.iter().enumerate() {
        let area = mesh.area(element as u32);
        let scene_triangle = tessellation.scene_triangle[element];
        let places = tessellation.corner_barycentrics[element];
        let centre: Vec2 = places.iter().sum::<Vec2>() / 3.0;
        for (&vertex, place) in corners.iter().zip(places) {
            let (sum, weight) = &mut sums[vertex as usize];
            let reflectance = scene.reflectance(scene_triangle, 0.5 * (place + centre));
            sum.reflectance += area * reflectance;
            sum.emitted_radiance += area * scene.material(scene_triangle).emitted_radiance;
            *weight += area;
        }
    }
    let mean = |(sum, weight): (VertexMaterial, f32)| {
        let scale = if weight > 0.0 { 1.0 / weight } else { 0.0 };
        VertexMaterial {
            reflectance: (scale * sum.reflectance).min(Vec3::ONE),
            emitted_radiance: scale * sum.emitted_radiance,
        }
    };
    sums.into_iter().map(mean).collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use glam::DVec3;
    use ply_rs_bw::{parser::Parser, ply::DefaultElement};

    use super::*;
    use crate::{
        math::color::ToneCurve,
        scene::{LoadOptions, LocalFrame, Material, Mesh, tessellate::TessellationOptions},
        solver::{SolutionInfo, SolveSettings},
    };

    /// A triangle of reflectance (0.5, 0.5, 0) and a smaller one, half its area, that shines blue, at one vertex. A
    /// local unit is 2 m, and the local origin lies at (10, 0, 0) m.
    fn example() -> (Scene, Tessellation, Solution) {
        let shared = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::Y * -0.5];
        let mesh = Mesh {
            positions: shared.to_vec(),
            normals: vec![Vec3::Z; 5],
            triangles: vec![[0, 1, 2], [0, 3, 4]],
            texcoords: Vec::new(),
            material_indices: vec![0, 1],
        };
        let grey = Material { reflectance: Vec3::new(0.5, 0.5, 0.0), ..Material::default() };
        let lamp = Material {
            reflectance: Vec3::new(0.2, 0.5, 0.0),
            emitted_radiance: Vec3::new(0.0, 0.0, 0.75),
            ..Material::default()
        };
        let frame = LocalFrame { origin: DVec3::X * 10.0, metres_per_unit: 2.0 };
        let scene = Scene {
            name: String::from("größe\n"),
            mesh,
            materials: vec![grey, lamp],
            textures: Vec::new(),
            frame,
            enclosed: Vec::new(),
            two_sided: false,
            faceted: false,
            warnings: Vec::new(),
        };
        let tessellation = Tessellation::new(&scene, &TessellationOptions { subdivide: 0, max_edge: None }).unwrap();
        let info = SolutionInfo {
            scene_name: scene.name.clone(),
            scene_hash: scene.hash(),
            tessellation_hash: tessellation.hash(),
            load: LoadOptions::default(),
            settings: SolveSettings::default(),
            light: None,
            program_version: String::new(),
            complete: true,
        };
        let bounces = vec![vec![Vec3::new(0.75 * PI, 0.0, 0.0); 5], vec![Vec3::new(0.25 * PI, PI, 0.0); 5]];
        let solution = Solution { info, bounces, buried: vec![false, false, true, false, false], cuts: Vec::new() };
        (scene, tessellation, solution)
    }

    #[test]
    fn a_ply_file_reads_back_with_metres_colours_and_irradiance() {
        let (scene, tessellation, solution) = example();
        let mut bytes = Vec::new();
        let tone_map = ToneMap { curve: ToneCurve::Plain, ..ToneMap::default() };
        write_ply(&mut bytes, &scene, &tessellation, &solution, &tone_map).unwrap();
        let ply = Parser::<DefaultElement>::new().read_ply(&mut bytes.as_slice()).unwrap();
        let float = |vertex: usize, name: &str| ply.payload["vertex"][vertex][name].to_f32_lossy().unwrap();
        assert_eq!(["x", "y", "z", "nx", "ny", "nz"].map(|name| float(1, name)), [12.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(float(3, "irradiance_r"), PI);
        assert_eq!(float(3, "irradiance_b"), 0.0);
        // E ρ/π + L: (0.5, 0.5, 0) on grey; on the lamp (0.2, 0.5, 0.75); where they meet the mean by their areas,
        // 2 : 1: (0.4, 0.5, 0.25). IEC 61966-2-1 codes 0.2, 0.25, 0.4, 0.5, 0.75 as 124, 137, 170, 188, 225.
        let colour =
            |vertex: usize| PLY_COLOURS.map(|name| ply.payload["vertex"][vertex][name].to_f32_lossy().unwrap());
        assert_eq!(colour(1), [188.0, 188.0, 0.0]);
        assert_eq!(colour(3), [124.0, 188.0, 225.0]);
        assert_eq!(colour(0), [170.0, 188.0, 137.0]);
        let face = |index: usize| ply.payload["face"][index][PLY_CORNERS].to_u32_list().unwrap();
        assert_eq!([face(0), face(1)], [[0, 1, 2], [0, 3, 4]]);
        assert_eq!(ply.payload["face"].len(), 2);
    }

    #[test]
    fn a_table_has_a_row_a_vertex_with_areas_that_sum_to_the_scene() {
        let (scene, tessellation, solution) = example();
        let mut bytes = Vec::new();
        write_csv(&mut bytes, &scene, &tessellation, &solution).unwrap();
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let names = reader.headers().unwrap().clone();
        let rows: Vec<Vec<f64>> = reader.deserialize::<Vec<f64>>().collect::<Result<_, _>>().unwrap();
        let value = |row: usize, name: &str| rows[row][names.iter().position(|known| known == name).unwrap()];
        assert_eq!(rows.len(), 5);
        assert_eq!([value(1, "px"), value(2, "py"), value(2, "nz")], [12.0, 2.0, 1.0]);
        assert_eq!([value(1, "buried"), value(2, "buried")], [0.0, 1.0]);
        // Half of 2 m · 2 m, and half of 2 m · 1 m; a third of both at the vertex where they meet.
        let area: f64 = (0..5).map(|row| value(row, "area")).sum();
        assert!((area - 3.0).abs() < 1e-6 && (value(0, "area") - 1.0).abs() < 1e-6, "{area}");
        assert!((value(0, "reflectance_r") - 0.4).abs() < 1e-6);
        let pi = f64::from(PI);
        for (name, expected) in [("direct_r", 0.75 * pi), ("bounce1_r", 0.25 * pi), ("bounce1_g", pi), ("total_r", pi)]
        {
            assert!((value(4, name) - expected).abs() < 1e-6, "{name}");
        }
    }
}
