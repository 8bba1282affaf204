//! The hand-in: a student's files with what they say, what the tests say, and pictures.

use std::{collections::BTreeMap, io::Cursor, path::Path};

use anyhow::{Context as _, bail};
use clap::Args;
use image::{ExtendedColorType, ImageEncoder as _, RgbaImage, codecs::png::PngEncoder};
use serde::{Deserialize, Serialize};

use super::{
    archive,
    judge::{PICTURE_SOLVES, Program, Stage},
    tree::{STUDENT_FOLDER, student_files},
};
use crate::{check::tasks::TaskReport, files::write_atomically};

/// What a student says with a hand-in: the fields of handin.toml, and flags that win over them.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Notes {
    /// Your name.
    #[arg(long, value_name = "TEXT")]
    pub name: Option<String>,
    /// With whom you worked, and on what.
    #[arg(long, value_name = "TEXT")]
    pub collaborators: Option<String>,
    /// Books, papers, pages that you used.
    #[arg(long, value_name = "TEXT")]
    pub references: Option<String>,
    /// What does not work, as far as you know.
    #[arg(long, value_name = "TEXT")]
    pub known_problems: Option<String>,
    /// What you did beyond the tasks that `check` tests.
    #[arg(long, value_name = "TEXT")]
    pub extra_credit: Option<String>,
    /// What was hard, what was good, how long it took.
    #[arg(long, value_name = "TEXT")]
    pub comments: Option<String>,
}

impl Notes {
    /// Reads the text of a handin.toml.
    ///
    /// # Errors
    /// One line: what is wrong with it, and where.
    pub fn from_toml(text: &str) -> anyhow::Result<Self> {
        toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            anyhow::anyhow!("line {line}: {}", error.message().replace('\n', "; "))
        })
    }

    /// These notes, and where one is missing that of `saved`.
    pub fn over(self, saved: Self) -> Self {
        let one = |flag: Option<String>, saved: Option<String>| flag.or(saved).filter(|text| !text.trim().is_empty());
        Self {
            name: one(self.name, saved.name),
            collaborators: one(self.collaborators, saved.collaborators),
            references: one(self.references, saved.references),
            known_problems: one(self.known_problems, saved.known_problems),
            extra_credit: one(self.extra_credit, saved.extra_credit),
            comments: one(self.comments, saved.comments),
        }
    }

    /// Headings and texts, in the order of README.txt.
    pub fn sections(&self) -> [(&'static str, &str); 6] {
        [
            ("NAME", said(&self.name)),
            ("COLLABORATORS", said(&self.collaborators)),
            ("REFERENCES", said(&self.references)),
            ("KNOWN PROBLEMS", said(&self.known_problems)),
            ("EXTRA CREDIT", said(&self.extra_credit)),
            ("COMMENTS", said(&self.comments)),
        ]
    }
}

fn said(note: &Option<String>) -> &str {
    note.as_deref().map(str::trim).filter(|text| !text.is_empty()).unwrap_or("none")
}

/// The README.txt of a hand-in.
fn readme(notes: &Notes, table: &str, problems: &[String]) -> String {
    let indented = |text: &str| text.lines().map(|line| format!("    {line}\n")).collect::<String>();
    let mut text = String::from("HAND-IN OF THE RADIOSITY ASSIGNMENT\n");
    for (heading, said) in notes.sections() {
        text += &format!("\n{heading}\n\n{}", indented(said));
    }
    text += &format!("\nTASKS, as `radiosity check` found them\n\n{}", indented(table));
    text += "\nPICTURES, computed with these functions: in pictures/\n";
    if !problems.is_empty() {
        text += &format!("\n{}", indented(&problems.join("\n")));
    }
    text
}

/// A picture as the bytes of a PNG file.
///
/// # Errors
/// The encoder's.
pub fn png(picture: &RgbaImage) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(picture, picture.width(), picture.height(), ExtendedColorType::Rgba8)?;
    Ok(bytes)
}

/// What went into a hand-in.
#[derive(Debug)]
pub struct Written {
    /// What the tests said.
    pub reports: Vec<TaskReport>,
    /// What kept a picture from being made, or a function from being used.
    pub problems: Vec<String>,
}

/// Tests and runs `program` and writes the archive of its tree. `table` makes a text of the tests' reports; `say` hears
/// what is being done.
///
/// # Errors
/// One line: there is no name in the notes, the program is older than the student's files, or a file cannot be read or
/// written.
pub fn write(
    program: &Program,
    notes: &Notes,
    target: &Path,
    table: fn(&[TaskReport]) -> String,
    say: &mut dyn FnMut(&str),
) -> anyhow::Result<Written> {
    if notes.name.is_none() {
        bail!("whose work is it? Fill in handin.toml, or give --name");
    }
    refuse_outdated(program)?;
    crate::files::check_writable(target)?;
    say("testing the functions");
    let reports = program.check_all()?;
    let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    let mut problems = Vec::new();
    for solve in &PICTURE_SOLVES {
        say(&format!("solving {}", solve.name));
        match program.solve(solve) {
            Err(problem) => problems.push(format!("{}: no picture: {problem:#}", solve.name)),
            Ok(solved) => {
                problems.extend(solved.faults.iter().map(|fault| format!("{}: {fault}", solve.name)));
                for (name, picture) in Stage::new(&program.root, solve)?.draw(&solved.solution)? {
                    files.insert(format!("pictures/{name}.png"), png(&picture)?);
                }
            }
        }
    }
    let table = table(&reports);
    files.insert(String::from("README.txt"), readme(notes, &table, &problems).into_bytes());
    files.insert(String::from("handin.toml"), toml::to_string(notes).context("the notes")?.into_bytes());
    files.insert(String::from("check.txt"), table.into_bytes());
    files.insert(String::from("check.json"), serde_json::to_vec_pretty(&reports).context("the report")?);
    for file in student_files(&program.root)? {
        files.insert(format!("{STUDENT_FOLDER}/{}", file.path), file.text.into_bytes());
    }
    let mut bytes = Cursor::new(Vec::new());
    archive::write(&mut bytes, files.iter().map(|(name, bytes)| (name.clone(), bytes.as_slice())))?;
    write_atomically(target, |writer| Ok(writer.write_all(bytes.get_ref())?))?;
    Ok(Written { reports, problems })
}

/// A program that was built before the last change would test and draw something else than what is handed in.
fn refuse_outdated(program: &Program) -> anyhow::Result<()> {
    let changed = |path: &Path| std::fs::metadata(path).and_then(|file| file.modified());
    let built = changed(&program.executable).context("the program's own file cannot be read")?;
    for file in student_files(&program.root)? {
        let path = program.root.join(STUDENT_FOLDER).join(&file.path);
        if changed(&path).is_ok_and(|changed| changed > built) {
            bail!("{}: is newer than this program; type `cargo run --release -- handin ...`", path.display());
        }
    }
    Ok(())
}
