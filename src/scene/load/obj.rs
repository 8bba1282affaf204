//! Faces as triangles with the file's own corners, in f64.

use glam::{DVec2, DVec3};

use super::clean::CleanObj;
use super::polygon::Triangulator;

/// Triangles before repair. Indices are checked: they lie inside the arrays.
#[derive(Debug, Default)]
pub(super) struct Soup {
    /// Positions in m; several may be equal.
    pub(super) positions: Vec<DVec3>,
    /// Normals of any length; 0 where the file gives none.
    pub(super) normals: Vec<DVec3>,
    /// Texture coordinates.
    pub(super) texcoords: Vec<DVec2>,
    /// True if the file's faces use texture coordinates.
    pub(super) has_texcoords: bool,
    /// Corners of polygons that no triangle uses: repeated, on a straight edge, or where edges cross.
    pub(super) left_out_corners: usize,
    /// The line of the first face that has such a corner.
    pub(super) left_out_line: u32,
    /// The triangles, in the order of the file.
    pub(super) triangles: Vec<Triangle>,
    /// The names of the materials that triangles use; none before the first `usemtl`.
    pub(super) materials: Vec<Option<String>>,
}

/// A triangle of a [`Soup`], counter-clockwise seen from the front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) corners: [Corner; 3],
    pub(super) material: u32,
    /// The file's line that its face is in.
    pub(super) line: u32,
}

/// Indices into the arrays of a [`Soup`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) normal: u32,
    pub(super) texcoord: u32,
}

impl Triangle {
    /// Indices of the corners' positions.
    pub(super) fn position_ids(&self) -> [u32; 3] {
        self.corners.map(|corner| corner.position)
    }
}

impl Soup {
    /// The corner positions of a triangle in m.
    pub(super) fn points(&self, triangle: &Triangle) -> [DVec3; 3] {
        triangle.position_ids().map(|position| self.positions[position as usize])
    }
}

/// Parses cleaned text and cuts its polygons.
pub(super) fn parse(cleaned: CleanObj) -> Result<Soup, tobj::LoadError> {
    let options =
        tobj::LoadOptions { single_index: false, triangulate: false, ignore_points: true, ignore_lines: true };
    // The parser is given numbers for names: names are matched with the MTL files later.
    let name_count = cleaned.materials.len();
    let materials = |_: &std::path::Path| {
        let named = |number: usize| tobj::Material { name: number.to_string(), ..Default::default() };
        Ok(((0..name_count).map(named).collect(), (0..name_count).map(|number| (number.to_string(), number)).collect()))
    };
    let (models, _) = tobj::load_obj_buf(&mut cleaned.text.as_bytes(), &options, materials)?;
    let mut soup = Soup { has_texcoords: cleaned.has_texcoords, ..Default::default() };
    let mut material_slots = vec![None; name_count + 1];
    let mut triangulator = Triangulator::default();
    let mut lines = cleaned.face_lines.iter().copied();
    for model in models.into_iter().filter(|model| !model.mesh.indices.is_empty()) {
        let slot = &mut material_slots[model.mesh.material_id.unwrap_or(name_count)];
        let material = *slot.get_or_insert_with(|| {
            soup.materials.push(model.mesh.material_id.map(|number| cleaned.materials[number].clone()));
            soup.materials.len() as u32 - 1
        });
        append(&mut soup, &model.mesh, material, &mut lines, &mut triangulator);
    }
    Ok(soup)
}

/// Appends a mesh whose faces are in the next of `lines`.
fn append(
    soup: &mut Soup,
    mesh: &tobj::Mesh,
    material: u32,
    lines: &mut impl Iterator<Item = u32>,
    triangulator: &mut Triangulator,
) {
    let base = [soup.positions.len() as u32, soup.normals.len() as u32, soup.texcoords.len() as u32];
    soup.positions.extend(mesh.positions.chunks_exact(3).map(DVec3::from_slice));
    soup.normals.extend(mesh.normals.chunks_exact(3).map(DVec3::from_slice));
    soup.texcoords.extend(mesh.texcoords.chunks_exact(2).map(DVec2::from_slice));
    let corner = |place: usize| Corner {
        position: base[0] + mesh.indices[place],
        normal: base[1] + mesh.normal_indices[place],
        texcoord: base[2] + mesh.texcoord_indices[place],
    };
    if mesh.face_arities.is_empty() {
        let starts = (0..mesh.indices.len()).step_by(3);
        soup.triangles.extend(starts.zip(lines).map(|(start, line)| {
            let corners = [0, 1, 2].map(|place| corner(start + place));
            Triangle { corners, material, line }
        }));
        return;
    }
    let mut start = 0;
    let mut points = Vec::new();
    for (&arity, line) in mesh.face_arities.iter().zip(lines) {
        let arity = arity as usize;
        let first_triangle = soup.triangles.len();
        points.clear();
        points.extend((start..start + arity).map(|place| soup.positions[corner(place).position as usize]));
        for cut in triangulator.triangulate(&points).chunks_exact(3) {
            let corners = [cut[0], cut[1], cut[2]].map(|place| corner(start + place as usize));
            soup.triangles.push(Triangle { corners, material, line });
        }
        let left_out = (arity - 2).saturating_sub(soup.triangles.len() - first_triangle);
        if left_out > 0 && soup.left_out_corners == 0 {
            soup.left_out_line = line;
        }
        soup.left_out_corners += left_out;
        start += arity;
    }
}
