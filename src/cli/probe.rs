//! `radiosity probe`: irradiance from a solution at points of the surfaces.

use std::{io::Write, ops::Range, path::PathBuf};

use anyhow::{Context as _, anyhow};
use clap::Args;
use csv::{ByteRecord, ReaderBuilder, Trim};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Outcome, files, solved_scene};
use crate::{
    scene::mesh,
    solver::{PointIrradiance, Reconstruction},
    trace::{Located, Tracer, locate_point},
};

/// Arguments of `radiosity probe`.
#[derive(Clone, Debug, Args)]
pub struct ProbeArgs {
    /// The solution, or the lightmap.
    pub solution: PathBuf,
    /// The scene: an OBJ file or `cornell`. It is read with the options that it was solved with.
    pub scene: PathBuf,
    /// The points (CSV with the columns px,py,pz in metres and nx,ny,nz; others are ignored).
    #[arg(long, value_name = "FILE")]
    pub points: PathBuf,
    /// How the field is rebuilt between the vertices.
    #[arg(long, value_enum, default_value_t)]
    pub reconstruct: Reconstruction,
    /// Where the points go with their direct and total irradiance [W/m²] (CSV). A point on no surface gets empty
    /// fields.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &ProbeArgs) -> anyhow::Result<Outcome> {
    let table = files::read_bytes(&args.points)?;
    let (field, scene) = solved_scene::open_field(&args.solution, &args.scene)?;
    let tracer = Tracer::new(scene.clone());
    let rebuilt = field.rebuilt(&scene, &tracer, args.reconstruct);
    let irradiance_at = |position: DVec3, normal: Vec3| {
        let normal = Some(mesh::unit_or_zero(normal)).filter(|normal| *normal != Vec3::ZERO)?;
        match locate_point(&tracer, &scene, scene.frame.point_to_local(position), normal)? {
            Located::Enclosed => Some(PointIrradiance::default()),
            Located::On(triangle, place) => {
                let (direct, total) = rebuilt(triangle, place);
                Some(PointIrradiance { direct, total })
            }
        }
    };
    let mut counts = ProbeCounts::default();
    files::write_atomically(&args.output, |writer| {
        counts = probe_table(&table, writer, irradiance_at).with_context(|| args.points.display().to_string())?;
        Ok(())
    })?;
    let ProbeCounts { points, off_surface } = counts;
    if off_surface > 0 {
        eprintln!("warning: {off_surface} of {points} points lie on no surface; their irradiance is left empty");
    }
    eprintln!("{}: {points} points", args.output.display());
    Ok(Outcome::Done)
}

/// What is read, and written again before the irradiance.
const POINT_COLUMNS: [&str; 6] = ["px", "py", "pz", "nx", "ny", "nz"];
/// What is added.
const ANSWER_COLUMNS: [&str; 6] = ["direct_r", "direct_g", "direct_b", "total_r", "total_g", "total_b"];
/// Bytes of a table that one task reads.
const CHUNK_SIZE: usize = 1 << 18;
/// Chunks whose answers are held in memory before they are written.
const CHUNKS_AT_ONCE: usize = 64;

/// How many points were read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProbeCounts {
    /// Rows.
    pub points: usize,
    /// Rows whose point lies on no surface.
    pub off_surface: usize,
}

/// Reads points (CSV, in metres; the columns `px` to `nz` by name in any order, others ignored, and lines that start
/// with `#` too) and writes them with their irradiance, in their order. A point for which `irradiance_at` (position in
/// metres, normal) gives nothing gets empty fields: a 0 would pass for darkness. A quoted field must not hold a line
/// break.
///
/// # Errors
/// A missing column or a field that is not a finite number, with its line.
pub fn probe_table(
    table: &[u8],
    writer: &mut dyn Write,
    irradiance_at: impl Fn(DVec3, Vec3) -> Option<PointIrradiance> + Sync,
) -> anyhow::Result<ProbeCounts> {
    let (columns, body) = read_header(table)?;
    writeln!(writer, "{},{}", POINT_COLUMNS.join(","), ANSWER_COLUMNS.join(","))?;
    let mut counts = ProbeCounts::default();
    for group in chunks_of_lines(table, body).chunks(CHUNKS_AT_ONCE) {
        let answers: Vec<_> =
            group.par_iter().map(|chunk| probe_chunk(&table[chunk.clone()], columns, &irradiance_at)).collect();
        for (answer, chunk) in answers.into_iter().zip(group) {
            let (rows, chunk_counts) = answer.map_err(|problem| {
                let row = skip_unused_lines(table, chunk.start + problem.offset);
                let lines_before = table[..row].iter().filter(|&&byte| byte == b'\n').count();
                anyhow!("line {}: {}", lines_before + 1, problem.reason)
            })?;
            writer.write_all(&rows)?;
            counts.points += chunk_counts.points;
            counts.off_surface += chunk_counts.off_surface;
        }
    }
    Ok(counts)
}

/// Where the line after the one at `start` begins.
fn next_line(table: &[u8], start: usize) -> usize {
    table[start..].iter().position(|&byte| byte == b'\n').map_or(table.len(), |length| start + length + 1)
}

/// The first line from `start` on that is neither blank nor a comment.
fn skip_unused_lines(table: &[u8], mut start: usize) -> usize {
    while start < table.len() && (table[start] == b'#' || table[start..next_line(table, start)].trim_ascii().is_empty())
    {
        start = next_line(table, start);
    }
    start
}

/// The places of [`POINT_COLUMNS`] in a row, and where the rows start.
fn read_header(table: &[u8]) -> anyhow::Result<([usize; 6], usize)> {
    let byte_order_mark = if table.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let start = skip_unused_lines(table, byte_order_mark);
    let body = next_line(table, start);
    let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(&table[start..body]);
    let names = reader.headers()?;
    let mut columns = [0; 6];
    for (column, wanted) in columns.iter_mut().zip(POINT_COLUMNS) {
        *column = names.iter().position(|name| name == wanted).ok_or_else(|| {
            anyhow!("there is no column `{wanted}`; the first line must name {}", POINT_COLUMNS.join(", "))
        })?;
    }
    Ok((columns, body))
}

/// The rows from `body` on, cut between lines.
fn chunks_of_lines(table: &[u8], body: usize) -> Vec<Range<usize>> {
    let mut chunks = Vec::new();
    let mut start = body;
    while start < table.len() {
        let least = (start + CHUNK_SIZE).min(table.len());
        let end = next_line(table, least);
        chunks.push(start..end);
        start = end;
    }
    chunks
}

/// A row that cannot be used.
struct RowProblem {
    /// Where it starts in the chunk, or where the unused lines before it do.
    offset: usize,
    reason: String,
}

/// The rows of a chunk with their irradiance.
fn probe_chunk(
    chunk: &[u8],
    columns: [usize; 6],
    irradiance_at: &impl Fn(DVec3, Vec3) -> Option<PointIrradiance>,
) -> Result<(Vec<u8>, ProbeCounts), RowProblem> {
    let mut reader =
        ReaderBuilder::new().has_headers(false).flexible(true).comment(Some(b'#')).trim(Trim::All).from_reader(chunk);
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::with_capacity(2 * chunk.len()));
    let mut record = ByteRecord::new();
    let mut counts = ProbeCounts::default();
    loop {
        let offset = reader.position().byte() as usize;
        let problem = |reason: String| RowProblem { offset, reason };
        if !reader.read_byte_record(&mut record).map_err(|error| problem(error.to_string()))? {
            break;
        }
        let (texts, values) = point_of(&record, columns).map_err(problem)?;
        let [px, py, pz, nx, ny, nz] = values;
        let answer = irradiance_at(DVec3::new(px, py, pz), DVec3::new(nx, ny, nz).as_vec3());
        counts.points += 1;
        counts.off_surface += usize::from(answer.is_none());
        let answer = answer.map(|PointIrradiance { direct, total }| (direct.to_array(), total.to_array()));
        let written = match answer {
            Some(answer) => writer.serialize((texts, answer)),
            None => writer.serialize((texts, [""; ANSWER_COLUMNS.len()])),
        };
        written.map_err(|error| problem(error.to_string()))?;
    }
    let rows = writer.into_inner().map_err(|error| RowProblem { offset: 0, reason: error.to_string() })?;
    Ok((rows, counts))
}

/// The six fields of a row, as text and as finite numbers.
fn point_of(record: &ByteRecord, columns: [usize; 6]) -> Result<([&str; 6], [f64; 6]), String> {
    let (mut texts, mut values) = ([""; 6], [0.0; 6]);
    for (index, (column, name)) in columns.into_iter().zip(POINT_COLUMNS).enumerate() {
        let field = record.get(column).ok_or_else(|| format!("the row has no `{name}`"))?;
        let text = std::str::from_utf8(field).ok();
        let value = text.and_then(|text| text.parse::<f64>().ok()).filter(|value| value.is_finite());
        let (Some(text), Some(value)) = (text, value) else {
            return Err(format!("`{}` for {name} is not a finite number", String::from_utf8_lossy(field)));
        };
        (texts[index], values[index]) = (text, value);
    }
    Ok((texts, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Direct irradiance is the point, total the normal; there is no surface below z = 0.
    fn echo(position: DVec3, normal: Vec3) -> Option<PointIrradiance> {
        (position.z >= 0.0).then_some(PointIrradiance { direct: position.as_vec3(), total: normal })
    }

    fn probe(table: &str) -> Result<(String, ProbeCounts), String> {
        let mut out = Vec::new();
        let counts = probe_table(table.as_bytes(), &mut out, echo).map_err(|error| format!("{error:#}"))?;
        Ok((String::from_utf8_lossy(&out).into_owned(), counts))
    }

    const HEADER: &str = "px,py,pz,nx,ny,nz,direct_r,direct_g,direct_b,total_r,total_g,total_b\n";

    #[test]
    fn columns_are_found_by_name_and_points_off_the_surface_get_empty_fields() {
        let table =
            "\u{feff}# a comment\n\nnz,name, px,py,pz,nx,ny\r\n1,\"a, b\",0.50,2e0,3,0,0\n# another\n1,c,1,1,-1,0,0";
        let rows = "0.50,2e0,3,0,0,1,0.5,2.0,3.0,0.0,0.0,1.0\n1,1,-1,0,0,1,,,,,,\n";
        assert_eq!(probe(table), Ok((format!("{HEADER}{rows}"), ProbeCounts { points: 2, off_surface: 1 })));
    }

    #[test]
    fn rows_keep_their_order_over_many_chunks() {
        let row_count = 200_000;
        let mut table = String::from("px,py,pz,nx,ny,nz\n");
        for row in 0..row_count {
            table.push_str(&format!("{row},0,0,0,0,1\n"));
        }
        assert!(table.len() > 2 * CHUNK_SIZE);
        let (out, counts) = probe(&table).unwrap_or_default();
        assert_eq!(counts, ProbeCounts { points: row_count, off_surface: 0 });
        for (row, line) in out.lines().skip(1).enumerate() {
            assert_eq!(line, format!("{row},0,0,0,0,1,{row}.0,0.0,0.0,0.0,0.0,1.0"));
        }
    }

    #[test]
    fn bad_tables_are_refused_by_line_or_column() {
        let good = "px,py,pz,nx,ny,nz\n0,0,0,0,0,1\n";
        let line = |table: &str| probe(table).err().unwrap_or_default();
        assert!(line("").contains("`px`"));
        assert!(line("px,py,pz,nx,ny\n").contains("`nz`"));
        assert_eq!(line(&format!("{good}0,0,0,0,0\n")), "line 3: the row has no `nz`");
        assert_eq!(line(&format!("{good}\n0,0,0,0,nan,1\n")), "line 4: `nan` for ny is not a finite number");
        assert_eq!(line(&format!("{good}#\n\n0,0,x y,0,0,1")), "line 5: `x y` for pz is not a finite number");
        let late = format!("{}{}", good, "0,0,0,0,0,1\n".repeat(100_000));
        assert_eq!(line(&format!("{late}0,,0,0,0,1\n")), "line 100003: `` for py is not a finite number");
        assert_eq!(probe(good).map(|(_, counts)| counts.points), Ok(1));
    }
}
