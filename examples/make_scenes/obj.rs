//! OBJ text in which every position, texture coordinate and normal stands once.

use std::collections::HashMap;
use std::fmt::Write;

use glam::{DVec2, DVec3};

/// One corner of a face; what is `None` is left out of the file.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: DVec3,
    pub(super) texcoord: Option<DVec2>,
    pub(super) normal: Option<DVec3>,
}

/// The lines of one kind, numbered from 1.
#[derive(Default)]
struct Lines {
    text: String,
    numbers: HashMap<String, usize>,
}

impl Lines {
    fn number_of(&mut self, keyword: &str, values: &[f64], digits: usize) -> usize {
        let line = values.iter().map(|value| short(*value, digits)).collect::<Vec<_>>().join(" ");
        let next = self.numbers.len() + 1;
        *self.numbers.entry(line).or_insert_with_key(|line| {
            self.text.push_str(&format!("{keyword} {line}\n"));
            next
        })
    }
}

/// A number with at most so many digits after the point, and no more than it needs.
pub(super) fn short(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let trimmed = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if trimmed == "-0" { String::from("0") } else { String::from(trimmed) }
}

/// An OBJ file being written: positions to a tenth of a millimetre.
#[derive(Default)]
pub(super) struct Obj {
    positions: Lines,
    texcoords: Lines,
    normals: Lines,
    faces: String,
    material: String,
}

impl Obj {
    pub(super) fn object(&mut self, name: &str) {
        self.faces.push_str(&format!("o {name}\n"));
    }

    pub(super) fn material(&mut self, name: &str) {
        if self.material != name {
            self.faces.push_str(&format!("usemtl {name}\n"));
            self.material = String::from(name);
        }
    }

    /// A polygon, counter-clockwise from the front. Corners at the place of the one before are left out, and so is
    /// a face with fewer than three corners left.
    pub(super) fn face(&mut self, corners: &[Corner]) {
        let mut numbered: Vec<(usize, &Corner)> = Vec::new();
        for corner in corners {
            let number = self.positions.number_of("v", &corner.position.to_array(), 4);
            if numbered.last().is_none_or(|last| last.0 != number) {
                numbered.push((number, corner));
            }
        }
        if numbered.len() > 1 && numbered.first().map(|first| first.0) == numbered.last().map(|last| last.0) {
            numbered.pop();
        }
        if numbered.len() < 3 {
            return;
        }
        self.faces.push('f');
        for (position, corner) in numbered {
            let texcoord = corner.texcoord.map(|uv| self.texcoords.number_of("vt", &uv.to_array(), 4).to_string());
            let normal = corner.normal.map(|normal| self.normals.number_of("vn", &normal.to_array(), 3));
            let _ = match (texcoord, normal) {
                (None, None) => write!(self.faces, " {position}"),
                (Some(texcoord), None) => write!(self.faces, " {position}/{texcoord}"),
                (texcoord, Some(normal)) => {
                    write!(self.faces, " {position}/{}/{normal}", texcoord.unwrap_or_default())
                }
            };
        }
        self.faces.push('\n');
    }

    /// The whole file: `comment` on its first line, then the name of its material library.
    pub(super) fn text(&self, comment: &str, library: &str) -> String {
        let Self { positions, texcoords, normals, faces, .. } = self;
        format!("# {comment}\nmtllib {library}\n{}{}{}{faces}", positions.text, texcoords.text, normals.text)
    }
}
