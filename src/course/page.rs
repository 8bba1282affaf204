//! The page of one student: self-contained HTML, with everything that they wrote escaped.

use anyhow::Context as _;
use base64::{Engine as _, engine::general_purpose::STANDARD};
use minijinja::{Environment, value::Serde};
use serde::Serialize;

use super::grade::{Comparison, Graded};

/// A picture beside the answers' one, as the template wants it.
#[derive(Serialize)]
struct Row {
    name: &'static str,
    student: String,
    answer: String,
    difference: String,
    mean_levels: String,
    field: String,
}

/// What the template fills in.
#[derive(Serialize)]
struct Page<'a> {
    hand_in: &'a str,
    name: Option<&'a str>,
    total: String,
    extra: String,
    problems: &'a [String],
    build_errors: &'a str,
    table: &'a str,
    rows: Vec<Row>,
    said: [(&'static str, &'a str); 6],
}

/// The page; `table` is what the tests say, as text.
pub(super) fn html(graded: &Graded, table: &str) -> anyhow::Result<String> {
    let mut templates = Environment::new();
    // The name's end turns escaping on.
    templates.add_template("page.html", include_str!("page.html")).context("the page's template")?;
    let template = templates.get_template("page.html").context("the page's template")?;
    let page = Page {
        hand_in: &graded.hand_in,
        name: graded.notes.name.as_deref(),
        total: graded.points(false).to_string(),
        extra: graded.points(true).to_string(),
        problems: &graded.problems,
        build_errors: &graded.build_errors,
        table: if graded.reports.is_empty() { "" } else { table },
        rows: graded.comparisons.iter().map(row).collect(),
        said: graded.notes.sections(),
    };
    template.render(Serde(page)).with_context(|| format!("the page of {}", graded.hand_in))
}

fn row(comparison: &Comparison) -> Row {
    let [student, answer, difference] =
        comparison.pictures.each_ref().map(|png| format!("data:image/png;base64,{}", STANDARD.encode(png)));
    let mean_levels = format!("{:.2}", comparison.mean_levels);
    let field = format!("{:.2}", 100.0 * comparison.field);
    Row { name: comparison.name, student, answer, difference, mean_levels, field }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::handin::Notes;

    #[test]
    fn what_a_student_writes_is_text_on_the_page_and_no_markup() -> anyhow::Result<()> {
        let notes = Notes { name: Some(String::from("<script>alert(1)</script>")), ..Notes::default() };
        let problems = vec![String::from("does not build: expected `<T>`")];
        let comparison =
            Comparison { name: "cornell", pictures: [vec![1], vec![2], vec![3]], mean_levels: 1.5, field: 0.02 };
        let graded = Graded {
            hand_in: String::from("a"),
            notes,
            reports: Vec::new(),
            problems,
            build_errors: String::from("</pre>"),
            comparisons: vec![comparison],
        };
        let page = html(&graded, "")?;
        assert!(!page.contains("<script>") && page.contains("&lt;script&gt;"), "{page}");
        assert!(page.contains("&lt;T&gt;") && page.matches("</pre>").count() == 1);
        assert!(page.contains("1.50 of 255 levels") && page.contains("2.00 % apart"));
        assert!(page.contains("base64,AQ==") && !page.contains("http"), "self-contained");
        Ok(())
    }
}
