//! Marks: many hand-ins, each built and run apart. One that fails costs the others nothing.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

use anyhow::{Context as _, bail};
use glam::DVec3;
use image::RgbaImage;

use super::{
    archive,
    handin::{Notes, png},
    handout::{self, Files},
    judge::{Limits, PICTURE_SOLVES, PictureSolve, Program, Run, Stage, run_limited},
    page,
    tree::{GIVEN_FILES, STUDENT_FOLDER, files_below, find_root},
};
use crate::{
    check::{
        metrics::relative_l2,
        tasks::{TASKS, TaskReport},
    },
    files::write_atomically,
    solver::Solution,
};

/// A build may take so many times the time of a test.
const BUILD_TIMES: u64 = 10;

/// All that hand-ins are marked with.
pub struct Course {
    output: PathBuf,
    limits: Limits,
    /// The files of the hand-out.
    files: Files,
    references: Vec<Reference>,
}

/// The answers' solution of a scene, with its pictures.
struct Reference {
    stage: Stage,
    solution: Solution,
    pictures: Vec<(&'static str, RgbaImage)>,
}

/// A student's picture beside the answers' one.
pub(super) struct Comparison {
    /// Its name.
    pub(super) name: &'static str,
    /// The student's, the answers', and four times their absolute difference; as PNG.
    pub(super) pictures: [Vec<u8>; 3],
    /// Mean absolute difference of the pictures, in levels of 255.
    pub(super) mean_levels: f64,
    /// Difference of irradiance at the vertices, all bounces, relative to its mean in the answers' solution.
    pub(super) field: f64,
}

/// What came of one hand-in.
pub struct Graded {
    /// Its name: that of its file or folder.
    pub hand_in: String,
    /// What the student says.
    pub notes: Notes,
    /// What the tests say; empty if there is no program.
    pub reports: Vec<TaskReport>,
    /// Why something could not be built, run or drawn, one line each.
    pub problems: Vec<String>,
    /// What the compiler said, if the build failed.
    pub(super) build_errors: String,
    pub(super) comparisons: Vec<Comparison>,
}

impl Graded {
    /// Points earned: those of the required tasks, or the extra ones.
    pub fn points(&self, extra: bool) -> f32 {
        let earned = self.reports.iter().filter(|report| report.is_extra == extra).map(|report| report.earned);
        earned.fold(0.0, |sum, points| sum + points) // an empty sum() is -0
    }

    fn failed(hand_in: String, problem: String) -> Self {
        let (notes, reports) = (Notes::default(), Vec::new());
        Self { hand_in, notes, reports, problems: vec![problem], build_errors: String::new(), comparisons: Vec::new() }
    }
}

impl Course {
    /// Builds the hand-out (the given tree, or that of the source around the current folder) and solves and draws the
    /// scenes with the answers.
    ///
    /// # Errors
    /// One line: what cannot be read or written, or that the hand-out does not build.
    pub fn prepare(
        tree: Option<&Path>,
        output: &Path,
        limits: Limits,
        say: &mut dyn FnMut(&str),
    ) -> anyhow::Result<Self> {
        let files = match tree {
            Some(tree) => read_tree(&find_root(Some(tree))?)?,
            None => handout::files(&find_root(None)?)?,
        };
        std::fs::create_dir_all(output).with_context(|| format!("{}: cannot be made", output.display()))?;
        let output = output.canonicalize().with_context(|| format!("{}: cannot be read", output.display()))?;
        let mut course = Self { output, limits, files, references: Vec::new() };
        say("building the hand-out");
        course.fresh_tree()?;
        let run = course.build(u64::MAX / 2)?;
        if run.exit_status != Some(0) {
            bail!("{}: the hand-out does not build:\n{}", course.tree().display(), run.errors);
        }
        say("solving with the answers");
        let reference = |solve| course.reference(solve);
        course.references = PICTURE_SOLVES.iter().map(reference).collect::<anyhow::Result<_>>()?;
        Ok(course)
    }

    /// Where programs are built. Always the same folder, so that what a program has in common with the one before is not
    /// compiled again.
    fn tree(&self) -> PathBuf {
        self.output.join("build").join("tree")
    }

    fn target(&self) -> PathBuf {
        self.output.join("build").join("target")
    }

    /// Writes the tree anew: nothing is left of the student before.
    fn fresh_tree(&self) -> anyhow::Result<()> {
        let tree = self.tree();
        if tree.exists() {
            std::fs::remove_dir_all(&tree).with_context(|| format!("{}: cannot be removed", tree.display()))?;
        }
        handout::write_files(&self.files, &tree).with_context(|| format!("{}: cannot be written", tree.display()))
    }

    fn build(&self, seconds: u64) -> anyhow::Result<Run> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = Command::new(cargo);
        command.args(["build", "--release", "--locked", "--no-default-features", "--quiet", "--color", "never"]);
        command.arg("--target-dir").arg(self.target()).current_dir(self.tree()).env("CARGO_INCREMENTAL", "1");
        run_limited(&mut command, seconds, None)
    }

    fn program(&self) -> Program {
        let name = format!("radiosity{}", std::env::consts::EXE_SUFFIX);
        Program { executable: self.target().join("release").join(name), root: self.tree(), limits: self.limits }
    }

    fn reference(&self, solve: &'static PictureSolve) -> anyhow::Result<Reference> {
        let own = Program {
            executable: std::env::current_exe().context("the program does not find itself")?,
            ..self.program()
        };
        let named = || format!("{} with the answers", solve.name);
        let solution = own.solve(solve).with_context(named)?.solution;
        let stage = Stage::new(&self.tree(), solve)?;
        let pictures = stage.draw(&solution)?;
        Ok(Reference { stage, solution, pictures })
    }

    /// Marks one hand-in. What goes wrong with it is part of the result.
    ///
    /// # Errors
    /// What has nothing to do with the hand-in: the output folder cannot be written, or cargo not be started.
    fn grade(&self, path: &Path, hand_in: String) -> anyhow::Result<Graded> {
        let read = match archive::read(path) {
            Ok(read) => read,
            Err(problem) => return Ok(Graded::failed(hand_in, format!("{problem:#}"))),
        };
        self.fresh_tree()?;
        let mut graded = Graded { problems: Vec::new(), notes: read.notes, ..Graded::failed(hand_in, String::new()) };
        for file in &read.files {
            let relative = Path::new(STUDENT_FOLDER).join(&file.path);
            let is_given = GIVEN_FILES.contains(&file.path.as_str());
            if is_given && self.files.get(&relative).is_some_and(|given| given != file.text.as_bytes()) {
                graded.problems.push(format!("{} is given, but was changed; the change was not taken", file.path));
            }
            if !is_given {
                let target = self.tree().join(relative);
                std::fs::create_dir_all(target.parent().unwrap_or(&self.output))?;
                std::fs::write(&target, &file.text).with_context(|| target.display().to_string())?;
            }
        }
        let program = self.program();
        // Nothing that was built before may pass for this student's.
        if program.executable.exists() {
            std::fs::remove_file(&program.executable).context("the program before cannot be removed")?;
        }
        let built = self.build(self.limits.time_limit * BUILD_TIMES)?;
        if built.exit_status != Some(0) || !program.executable.exists() {
            let first = built.errors.lines().find(|line| line.starts_with("error")).unwrap_or("no message");
            let why = built.stopped.unwrap_or_else(|| String::from(first));
            graded.problems.push(format!("does not build: {why}"));
            graded.build_errors = built.errors;
            return Ok(graded);
        }
        graded.reports = program.check_all()?;
        for reference in &self.references {
            match reference.compare(&program) {
                Ok((comparisons, problems)) => {
                    graded.comparisons.extend(comparisons);
                    graded.problems.extend(problems);
                }
                Err(problem) => graded.problems.push(format!("{}: {problem:#}", reference.stage.solve().name)),
            }
        }
        Ok(graded)
    }
}

impl Reference {
    fn compare(&self, program: &Program) -> anyhow::Result<(Vec<Comparison>, Vec<String>)> {
        let solved = program.solve(self.stage.solve())?;
        let field = field_difference(&solved.solution, &self.solution);
        let compare = |((name, student), (_, answer)): (_, &(&'static str, RgbaImage))| {
            let (difference, mean_levels) = difference(&student, answer);
            let pictures = [png(&student)?, png(answer)?, png(&difference)?];
            Ok(Comparison { name, pictures, mean_levels, field })
        };
        let drawn = self.stage.draw(&solved.solution)?.into_iter().zip(&self.pictures);
        let comparisons: anyhow::Result<_> = drawn.map(compare).collect();
        let name = self.stage.solve().name;
        Ok((comparisons?, solved.faults.iter().map(|fault| format!("{name}: {fault}")).collect()))
    }
}

fn field_difference(student: &Solution, answer: &Solution) -> f64 {
    let doubles =
        |solution: &Solution| -> Vec<DVec3> { solution.total().iter().map(|value| value.as_dvec3()).collect() };
    relative_l2(&doubles(student), &doubles(answer))
}

/// Four times the absolute difference of two pictures of one size, and its mean before that, in levels of 255.
fn difference(a: &RgbaImage, b: &RgbaImage) -> (RgbaImage, f64) {
    let mut sum = 0.0;
    let picture = RgbaImage::from_fn(a.width(), a.height(), |column, row| {
        let (a, b) = (a.get_pixel(column, row), b.get_pixel(column, row));
        let apart: [u8; 3] = std::array::from_fn(|band| a[band].abs_diff(b[band]));
        sum += apart.iter().map(|&levels| f64::from(levels)).sum::<f64>();
        let [red, green, blue] = apart.map(|levels| levels.saturating_mul(4));
        image::Rgba([red, green, blue, 255])
    });
    (picture, sum / (3.0 * f64::from(a.width()) * f64::from(a.height())).max(1.0))
}

/// All files of a tree that was handed out.
fn read_tree(root: &Path) -> anyhow::Result<Files> {
    let is_source = |path: &PathBuf| !path.starts_with("target") && !path.starts_with(".git");
    let read = |path: PathBuf| {
        let full = root.join(&path);
        Ok((path, std::fs::read(&full).with_context(|| format!("{}: cannot be read", full.display()))?))
    };
    files_below(root)?.into_iter().filter(is_source).map(read).collect()
}

/// Marks hand-ins one after the other. A page is written as soon as a hand-in is done, and marks.csv with all so far.
///
/// # Errors
/// What has nothing to do with the hand-ins: the output folder cannot be written, or cargo not be started.
pub fn grade_all(
    course: &Course,
    hand_ins: &[PathBuf],
    table: fn(&[TaskReport]) -> String,
    say: &mut dyn FnMut(&str),
) -> anyhow::Result<Vec<Graded>> {
    let started = Instant::now();
    let mut all: Vec<Graded> = Vec::new();
    for (index, path) in hand_ins.iter().enumerate() {
        let left = started.elapsed().as_secs_f64() / 60.0 * (hand_ins.len() - index) as f64 / index.max(1) as f64;
        let estimate = if index == 0 { String::new() } else { format!(", about {left:.0} min left") };
        say(&format!("{} of {}: {}{estimate}", index + 1, hand_ins.len(), path.display()));
        let graded = course.grade(path, unique_name(path, &all))?;
        let html = page::html(&graded, &table(&graded.reports))?;
        let page = course.output.join(format!("{}.html", graded.hand_in));
        write_atomically(&page, |writer| Ok(writer.write_all(html.as_bytes())?))?;
        all.push(graded);
        write_atomically(&course.output.join("marks.csv"), |writer| write_marks(&all, writer))?;
    }
    Ok(all)
}

/// The hand-in's name as that of a file: its own without the extension, and a number if another has it.
fn unique_name(path: &Path, others: &[Graded]) -> String {
    let full = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let stem = if full.is_dir() { full.file_name() } else { full.file_stem() };
    let plain =
        |character: char| if character.is_alphanumeric() || "-_.".contains(character) { character } else { '_' };
    let name: String = stem.unwrap_or_default().to_string_lossy().chars().map(plain).collect();
    let is_free = |name: &String| others.iter().all(|other| other.hand_in != *name);
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    std::iter::once(name.clone()).chain(numbered).find(is_free).unwrap_or(name)
}

fn write_marks(graded: &[Graded], writer: &mut dyn std::io::Write) -> anyhow::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    let tasks = TASKS.map(|task| task.name);
    csv.write_record(["hand_in", "name"].iter().chain(&tasks).chain(&["total", "extra", "problems"]))?;
    for student in graded {
        let earned =
            |name: &str| student.reports.iter().find(|report| report.task == name).map_or(0.0, |report| report.earned);
        let mut record = vec![student.hand_in.clone(), student.notes.name.clone().unwrap_or_default()];
        record.extend(tasks.iter().map(|name| earned(name).to_string()));
        record.extend([student.points(false), student.points(true)].map(|points| points.to_string()));
        record.push(student.problems.join("; "));
        csv.write_record(record)?;
    }
    csv.flush()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_of_pictures_is_their_distance_in_levels() {
        let grey = |level| RgbaImage::from_pixel(2, 2, image::Rgba([level, 100, 100, 255]));
        let (picture, mean) = difference(&grey(10), &grey(40));
        assert_eq!(picture.get_pixel(1, 1).0, [120, 0, 0, 255]);
        assert!((mean - 10.0).abs() < 1e-12);
    }

    #[test]
    fn marks_are_a_line_a_student_with_names_that_differ() -> anyhow::Result<()> {
        let mut all = Vec::new();
        for path in ["one/work.zip", "two/work.zip", "a b.zip"] {
            let name = unique_name(Path::new(path), &all);
            all.push(Graded::failed(name, String::from("holds, no Rust file")));
        }
        all[0].reports = TASKS.iter().map(|task| task.report(crate::check::tasks::Status::Done)).collect();
        let mut bytes = Vec::new();
        write_marks(&all, &mut bytes)?;
        let text = String::from_utf8(bytes)?;
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("hand_in,name,basis,disk") && lines[0].ends_with(",total,extra,problems"));
        let total: f32 = TASKS.iter().filter(|task| !task.is_extra).map(|task| task.points).sum();
        assert!(lines[1].starts_with("work,,1,0.5,") && lines[1].contains(&format!(",{total},")), "{text}");
        assert!(lines[2].starts_with("work-2,,0,") && lines[3].starts_with("a_b,,0,"), "{text}");
        assert!(lines[2].ends_with("\"holds, no Rust file\""));
        Ok(())
    }
}
