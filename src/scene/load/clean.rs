//! The lines of an OBJ file, freed of all that a strict parser stumbles over.
//!
//! What is left: `v`, `vt` and `vn` with readable, finite numbers, then `usemtl` and `f` whose indices are absolute,
//! in range and complete. A corner without texture coordinate or normal gets element 1, which is put in front: zeros.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write;

use super::counted;

/// In m: coordinates beyond this count as broken.
const LARGEST_COORDINATE: f64 = 1e18;

/// What is dropped or mended here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Problem {
    FewCorners,
    BadIndex,
    BadVertex,
    BadAttribute,
    BadNumber,
    Lines,
    Points,
    Colours,
}

/// All of them, in the order in which they are told.
const PROBLEMS: [Problem; 8] = [
    Problem::FewCorners,
    Problem::BadIndex,
    Problem::BadVertex,
    Problem::BadAttribute,
    Problem::BadNumber,
    Problem::Lines,
    Problem::Points,
    Problem::Colours,
];

impl Problem {
    fn describe(self, count: usize, line: usize) -> String {
        let place = if count == 1 { format!("in line {line}") } else { format!("first in line {line}") };
        let faces = || counted(count, "face");
        match self {
            Self::FewCorners => format!("dropped {} with fewer than 3 corners, {place}", faces()),
            Self::BadIndex => {
                format!("dropped {} with an index that is 0, unreadable or out of range, {place}", faces())
            }
            Self::BadVertex => {
                format!("dropped {} with a coordinate that is not finite or beyond 1e18, {place}", faces())
            }
            Self::BadAttribute => {
                format!("ignored the texture coordinate or normal indices out of range in {}, {place}", faces())
            }
            Self::BadNumber => format!("could not read the numbers of {}, {place}", counted(count, "line")),
            Self::Lines => format!("ignored {}, {place}: only faces are used", counted(count, "line element")),
            Self::Points => format!("ignored {}, {place}: only faces are used", counted(count, "point element")),
            Self::Colours => format!("ignored the colours of {}", counted(count, "vertex")),
        }
    }
}

/// A cleaned OBJ file.
#[derive(Debug, Default)]
pub(super) struct CleanObj {
    /// The lines to parse; `usemtl` names an index into `materials`.
    pub(super) text: String,
    /// Names after `usemtl`, each once, in the order met.
    pub(super) materials: Vec<String>,
    /// What follows each `mtllib`, each once, in the order met.
    pub(super) libraries: Vec<String>,
    /// The line that each face is in.
    pub(super) face_lines: Vec<u32>,
    /// True if a face refers to a texture coordinate.
    pub(super) has_texcoords: bool,
    /// Count and first line number of each of `PROBLEMS`.
    tallies: [(usize, usize); PROBLEMS.len()],
    /// For each vertex in the file: may faces use it, and does one.
    vertices: Vec<VertexState>,
    texcoord_count: usize,
    normal_count: usize,
}

#[derive(Clone, Copy, Debug)]
struct VertexState {
    usable: bool,
    used: bool,
}

/// Indices of a face's corner in the cleaned file.
#[derive(Clone, Copy, Debug)]
struct CleanCorner {
    vertex: usize,
    texcoord: usize,
    normal: usize,
}

/// Cleans the text of an OBJ file.
pub(super) fn clean(text: &str) -> CleanObj {
    let mut cleaned = CleanObj::default();
    cleaned.text.reserve(text.len() + text.len() / 4);
    cleaned.text.push_str("mtllib all\nvt 0 0\nvn 0 0 0\n");
    cleaned.add_vertices(text);
    cleaned.add_faces(text);
    cleaned
}

impl CleanObj {
    /// What was dropped or mended, one line for each kind.
    pub(super) fn warnings(&self) -> Vec<String> {
        let told = PROBLEMS.iter().zip(self.tallies).filter(|(_, (count, _))| *count > 0);
        let mut lines: Vec<String> = told.map(|(problem, (count, line))| problem.describe(count, line)).collect();
        let unused = self.vertices.iter().filter(|vertex| !vertex.used).count();
        if unused > 0 {
            lines.push(format!("ignored {} that no face uses", counted(unused, "vertex")));
        }
        lines
    }

    fn note(&mut self, problem: Problem, line_number: usize) {
        let (count, first) = &mut self.tallies[problem as usize];
        if *count == 0 {
            *first = line_number;
        }
        *count += 1;
    }

    /// First pass: everything that faces refer to, so that they may also refer to what follows them.
    fn add_vertices(&mut self, text: &str) {
        for (line_number, line) in logical_lines(text) {
            let mut words = line.split_ascii_whitespace().take_while(|word| !word.starts_with('#'));
            let (keyword, fallback): (&str, &[&str]) = match words.next() {
                Some("v") => ("v", &["0", "0", "0"]),
                Some("vt") => ("vt", &["0", "0"]),
                Some("vn") => ("vn", &["0", "0", "0"]),
                _ => continue,
            };
            let mut values: [&str; 3] = ["0"; 3];
            let mut given = 0;
            for (value, word) in values.iter_mut().zip(words.by_ref().take(fallback.len())) {
                *value = word;
                given += 1;
            }
            // One texture coordinate is enough: the other is 0.
            let complete = given == fallback.len() || (keyword == "vt" && given == 1);
            let numbers = values.map(|value| value.parse::<f64>().ok());
            if !complete || numbers.contains(&None) {
                self.note(Problem::BadNumber, line_number);
            }
            let usable =
                complete && numbers.iter().flatten().filter(|number| number.abs() <= LARGEST_COORDINATE).count() == 3;
            self.text.push_str(keyword);
            for value in if usable { &values[..fallback.len()] } else { fallback } {
                self.text.push(' ');
                self.text.push_str(value);
            }
            self.text.push('\n');
            match keyword {
                "v" => self.vertices.push(VertexState { usable, used: false }),
                "vt" => self.texcoord_count += 1,
                _ => self.normal_count += 1,
            }
            if keyword == "v" && words.count() >= 3 {
                self.note(Problem::Colours, line_number);
            }
        }
    }

    /// Second pass: faces and materials.
    fn add_faces(&mut self, text: &str) {
        let mut seen = [0_usize; 3];
        let mut material_numbers = HashMap::new();
        let mut corners = Vec::new();
        for (line_number, line) in logical_lines(text) {
            let line = line.trim_ascii();
            let (keyword, rest) =
                line.split_once(|character: char| character.is_ascii_whitespace()).unwrap_or((line, ""));
            match keyword {
                "v" => seen[0] += 1,
                "vt" => seen[1] += 1,
                "vn" => seen[2] += 1,
                "f" | "fo" => match self.read_face(rest, seen, line_number, &mut corners) {
                    Ok(()) => {
                        self.face_lines.push(line_number as u32);
                        self.write_face(&corners);
                    }
                    Err(problem) => self.note(problem, line_number),
                },
                "l" => self.note(Problem::Lines, line_number),
                "p" => self.note(Problem::Points, line_number),
                "mtllib" if !self.libraries.iter().any(|known| known == rest.trim()) => {
                    self.libraries.push(rest.trim().to_owned());
                }
                "usemtl" => {
                    let name = rest.trim();
                    if !material_numbers.contains_key(name) {
                        material_numbers.insert(name.to_owned(), self.materials.len());
                        self.materials.push(name.to_owned());
                    }
                    let _ = writeln!(self.text, "usemtl {}", material_numbers[name]);
                }
                _ => {}
            }
        }
    }

    fn read_face(
        &mut self,
        rest: &str,
        seen: [usize; 3],
        line_number: usize,
        corners: &mut Vec<CleanCorner>,
    ) -> Result<(), Problem> {
        let totals = [self.vertices.len(), self.texcoord_count, self.normal_count];
        let mut bad_attribute = false;
        corners.clear();
        for word in rest.split_ascii_whitespace().take_while(|word| !word.starts_with('#')) {
            let mut parts = word.split('/');
            let vertex = resolve(parts.next().unwrap_or(""), seen[0], totals[0]).ok_or(Problem::BadIndex)?;
            let mut attribute = |kind: usize| match parts.next() {
                None | Some("") => 1,
                Some(part) => resolve(part, seen[kind], totals[kind]).map_or_else(
                    || {
                        bad_attribute = true;
                        1
                    },
                    |index| index + 1,
                ),
            };
            corners.push(CleanCorner { vertex, texcoord: attribute(1), normal: attribute(2) });
        }
        if corners.len() < 3 {
            return Err(Problem::FewCorners);
        }
        if corners.iter().any(|corner| !self.vertices[corner.vertex - 1].usable) {
            return Err(Problem::BadVertex);
        }
        if bad_attribute {
            self.note(Problem::BadAttribute, line_number);
        }
        Ok(())
    }

    fn write_face(&mut self, corners: &[CleanCorner]) {
        self.text.push('f');
        for corner in corners {
            self.vertices[corner.vertex - 1].used = true;
            self.has_texcoords |= corner.texcoord > 1;
            let _ = write!(self.text, " {}/{}/{}", corner.vertex, corner.texcoord, corner.normal);
        }
        self.text.push('\n');
    }
}

/// An index of a face, from 1; negative ones count back from the last of the `seen` elements.
fn resolve(word: &str, seen: usize, total: usize) -> Option<usize> {
    let index: i64 = word.parse().ok()?;
    let absolute = if index < 0 { i64::try_from(seen).ok()?.checked_add(index)?.checked_add(1)? } else { index };
    usize::try_from(absolute).ok().filter(|absolute| (1..=total).contains(absolute))
}

/// Lines with their numbers from 1; a line that ends in a backslash is joined with the next one.
pub(super) fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let is_comment = first.trim_ascii_start().starts_with('#');
        let Some(start) = first.trim_ascii_end().strip_suffix('\\').filter(|_| !is_comment) else {
            return Some((index + 1, Cow::Borrowed(first)));
        };
        let mut joined = start.to_owned();
        for (_, line) in lines.by_ref() {
            joined.push(' ');
            let Some(part) = line.trim_ascii_end().strip_suffix('\\') else {
                joined.push_str(line);
                break;
            };
            joined.push_str(part);
        }
        Some((index + 1, Cow::Owned(joined)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    /// The cleaned `f` lines, and the warnings.
    fn faces(text: &str) -> (Vec<String>, Vec<String>) {
        let cleaned = clean(text);
        let lines = cleaned.text.lines().filter(|line| line.starts_with('f')).map(str::to_owned).collect();
        (lines, cleaned.warnings())
    }

    #[test]
    fn faces_become_absolute_and_complete() {
        let same = vec![String::from("f 1/1/1 2/1/1 3/1/1")];
        for face in ["f 1 2 3", "f -3 -2 -1", "f 1 2 \\\n 3", "\tf  1// 2/ 3 # note", "f 1/9/1 2//0 3/x"] {
            assert_eq!(faces(&format!("{CORNERS}{face}\n")).0, same, "{face}");
        }
        let forward = format!("f 1 2 3\n{CORNERS}");
        assert_eq!(faces(&forward).0, same, "absolute indices may point forwards");
        let textured = format!("{CORNERS}vt 0 0\nvt 1\nvn 0 0 1\nf 1/1/1 2/-1/-1 3/2\n");
        assert_eq!(faces(&textured).0, ["f 1/2/2 2/3/2 3/3/1"]);
    }

    #[test]
    fn every_unusable_face_is_counted_with_its_first_line() {
        let text = format!(
            "{CORNERS}v nan 0 0\nv 1e19 0 0\nv 1 x 2\nv 1 2\nf 1 2\nf\nf 0 1 2\nf 1 2 9\nf -9 1 2\nf 1 2 3.5\n"
        );
        let (lines, warnings) = faces(&format!("{text}f 1 2 4\nf 1 2 5\nf 1 2 6\nf 1 2 7\nl 1 2\np 1\n"));
        assert!(lines.is_empty());
        assert_eq!(
            warnings,
            [
                "dropped 2 faces with fewer than 3 corners, first in line 8",
                "dropped 4 faces with an index that is 0, unreadable or out of range, first in line 10",
                "dropped 4 faces with a coordinate that is not finite or beyond 1e18, first in line 14",
                "could not read the numbers of 2 lines, first in line 6",
                "ignored 1 line element, in line 18: only faces are used",
                "ignored 1 point element, in line 19: only faces are used",
                "ignored 7 vertices that no face uses",
            ]
        );
    }

    #[test]
    fn comments_that_end_in_a_backslash_join_nothing() {
        let (lines, warnings) = faces(&format!("# C:\\scenes\\\n{CORNERS}f 1 2 3\n"));
        assert_eq!((lines.len(), warnings.len()), (1, 0));
    }
}
