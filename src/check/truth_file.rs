//! Files of surface points and the irradiance there: CSV with named columns and `#` comments.
//!
//! | columns | meaning |
//! | --- | --- |
//! | `px,py,pz` | point, metres |
//! | `nx,ny,nz` | shading normal |
//! | `direct_r,g,b` | bounce 0, W/m² |
//! | `bounce1_r,g,b`, `bounce2_r,g,b` | those bounces alone |
//! | `total_r,g,b` | all bounces |
//! | `se_r,g,b` | standard error of the total |
//!
//! A file of points alone has the first two rows only; further columns are left unread.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use glam::DVec3;

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthPoint {
    /// Where it lies, in metres.
    pub position: DVec3,
    /// Unit shading normal.
    pub normal: DVec3,
}

/// Irradiance at a point [W/m²].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TruthValue {
    /// Bounce 0.
    pub direct: DVec3,
    /// Bounce 1 alone.
    pub bounce1: DVec3,
    /// Bounce 2 alone.
    pub bounce2: DVec3,
    /// All bounces.
    pub total: DVec3,
    /// Standard error of the total.
    pub standard_error: DVec3,
}

/// What a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TruthFile {
    /// The lines that start with `#`, without it.
    pub comments: Vec<String>,
    /// The points.
    pub points: Vec<TruthPoint>,
    /// The values at the points; `None` for a file of points alone.
    pub values: Option<Vec<TruthValue>>,
}

/// Why a file of points cannot be read or written. Prints as one line.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct TruthFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, with the line, and what to do.
    pub problem: String,
}

/// The quantities of a point and of its value, in the order of the columns.
const POINT_COLUMNS: [&str; 2] = ["p", "n"];
const VALUE_COLUMNS: [&str; 5] = ["direct", "bounce1", "bounce2", "total", "se"];

/// The three column names of a quantity.
fn column_names(quantity: &str) -> [String; 3] {
    if POINT_COLUMNS.contains(&quantity) {
        ["x", "y", "z"].map(|axis| format!("{quantity}{axis}"))
    } else {
        ["r", "g", "b"].map(|band| format!("{quantity}_{band}"))
    }
}

/// Reads a file of points, with or without values.
pub fn read(path: &Path) -> Result<TruthFile, TruthFileError> {
    let error = |problem| TruthFileError { path: path.to_path_buf(), problem };
    let text = std::fs::read_to_string(path).map_err(|cause| error(format!("cannot be read: {cause}")))?;
    parse(&text).map_err(error)
}

/// [`read`] of a file's text; the error is the problem in words.
pub fn parse(text: &str) -> Result<TruthFile, String> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let headers = reader.headers().map_err(|cause| cause.to_string())?.clone();
    let place = |name: String| {
        let place = headers.iter().position(|header| header == name);
        place.ok_or_else(|| format!("has no column '{name}'; the columns are described under `radiosity truth --help`"))
    };
    let places = |quantity: &&str| -> Result<[usize; 3], String> {
        let [first, second, third] = column_names(quantity);
        Ok([place(first)?, place(second)?, place(third)?])
    };
    let point_places = POINT_COLUMNS.iter().map(places).collect::<Result<Vec<_>, _>>()?;
    let has_values = headers.iter().any(|header| header == "total_r");
    let value_columns: &[&str] = if has_values { &VALUE_COLUMNS } else { &[] };
    let value_places = value_columns.iter().map(places).collect::<Result<Vec<_>, _>>()?;
    let mut points = Vec::new();
    let mut values = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|cause| cause.to_string())?;
        points.push(parse_point(&record, &point_places)?);
        if has_values {
            values.push(parse_value(&record, &value_places)?);
        }
    }
    let comments = text.lines().filter_map(|line| line.strip_prefix('#')).map(|line| line.trim().to_owned()).collect();
    Ok(TruthFile { comments, points, values: has_values.then_some(values) })
}

fn parse_point(record: &csv::StringRecord, places: &[[usize; 3]]) -> Result<TruthPoint, String> {
    let position = parse_vector(record, places[0])?;
    let normal = parse_vector(record, places[1])?;
    let normal = normal.try_normalize().ok_or_else(|| format!("line {}: the normal has no length", line_of(record)))?;
    Ok(TruthPoint { position, normal })
}

fn parse_value(record: &csv::StringRecord, places: &[[usize; 3]]) -> Result<TruthValue, String> {
    Ok(TruthValue {
        direct: parse_vector(record, places[0])?,
        bounce1: parse_vector(record, places[1])?,
        bounce2: parse_vector(record, places[2])?,
        total: parse_vector(record, places[3])?,
        standard_error: parse_vector(record, places[4])?,
    })
}

fn parse_vector(record: &csv::StringRecord, places: [usize; 3]) -> Result<DVec3, String> {
    let mut vector = DVec3::ZERO;
    for (axis, place) in places.into_iter().enumerate() {
        let word = record.get(place).unwrap_or_default();
        vector[axis] = word
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
            .ok_or_else(|| format!("line {}: '{word}' is not a finite number", line_of(record)))?;
    }
    Ok(vector)
}

fn line_of(record: &csv::StringRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

/// Writes a file as [`read`] reads it. Values keep f32's digits, points all of theirs.
pub fn write(file: &TruthFile, mut output: impl Write) -> std::io::Result<()> {
    for comment in &file.comments {
        writeln!(output, "# {comment}")?;
    }
    let quantities = POINT_COLUMNS.iter().chain(file.values.as_ref().map_or(&[][..], |_| &VALUE_COLUMNS));
    let header: Vec<String> = quantities.flat_map(|quantity| column_names(quantity)).collect();
    writeln!(output, "{}", header.join(","))?;
    for (index, point) in file.points.iter().enumerate() {
        let mut words: Vec<String> =
            [point.position, point.normal].iter().flat_map(|vector| vector.to_array()).map(|x| x.to_string()).collect();
        if let Some(value) = file.values.as_ref().map(|values| values[index]) {
            let vectors = [value.direct, value.bounce1, value.bounce2, value.total, value.standard_error];
            words.extend(vectors.iter().flat_map(|vector| vector.as_vec3().to_array()).map(|x| x.to_string()));
        }
        writeln!(output, "{}", words.join(","))?;
    }
    output.flush()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    const POINTS: &str = "# scene: box\npx,py,pz,nx,ny,nz\n0,0.5,-1e-3,0,2,0\n";

    #[test]
    fn points_are_read_by_column_name_and_normals_get_unit_length() {
        let file = parse(POINTS).unwrap();
        assert_eq!(file.comments, ["scene: box"]);
        assert_eq!(file.points, [TruthPoint { position: DVec3::new(0.0, 0.5, -1e-3), normal: DVec3::Y }]);
        assert_eq!(file.values, None);
        let swapped = parse("extra,nz,ny,nx,pz,py,px\n9,1,0,0,3,2,1\n").unwrap();
        assert_eq!(swapped.points, [TruthPoint { position: DVec3::new(1.0, 2.0, 3.0), normal: DVec3::Z }]);
    }

    #[test]
    fn what_is_written_is_read_again() {
        let value = TruthValue {
            direct: DVec3::new(0.5, 1.0, 2.0),
            bounce1: DVec3::splat(0.25),
            bounce2: DVec3::splat(0.125),
            total: DVec3::splat(4.0),
            standard_error: DVec3::splat(0.0625),
        };
        let file = TruthFile { values: Some(vec![value]), ..parse(POINTS).unwrap() };
        let mut bytes = Vec::new();
        write(&file, &mut bytes).unwrap();
        assert_eq!(parse(std::str::from_utf8(&bytes).unwrap()).unwrap(), file);
    }

    #[test]
    fn errors_name_the_line_the_word_or_the_column() {
        let problem = |text: &str| parse(text).unwrap_err();
        assert!(problem("px,py,pz,nx,ny\n").contains("'nz'"));
        assert!(problem("px,py,pz,nx,ny,nz,total_r\n").contains("'direct_r'"));
        assert!(problem(&POINTS.replace("0.5", "high")).contains("line 3: 'high'"));
        assert!(problem(&POINTS.replace("0.5", "nan")).contains("line 3: 'nan'"));
        assert!(problem(&POINTS.replace("0,2,0", "0,0,0")).contains("normal has no length"));
        assert!(problem(&POINTS.replace(",2,0", "")).contains("fields"));
        assert!(problem("").contains("'px'"));
    }
}
