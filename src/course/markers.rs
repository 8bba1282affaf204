//! What a text of the source tree becomes in the hand-out.

use anyhow::{bail, ensure};

/// Whether a line is an attribute that keeps what it stands on for the program with its own engine: `opening` is `#[cfg(`
/// for an item, `#![cfg(` for a whole file; the feature stands there alone or in `all(...)`.
fn needs_reference(line: &str, opening: &str) -> bool {
    let condition = line.trim().strip_prefix(opening).and_then(|rest| rest.strip_suffix(")]")).unwrap_or_default();
    let condition = condition.strip_prefix("all(").and_then(|rest| rest.strip_suffix(')')).unwrap_or(condition);
    condition.split(", ").any(|part| part == "feature = \"reference\"")
}

const OF_ITEM: &str = "#[cfg(";
const OF_FILE: &str = "#![cfg(";

/// Whether a whole Rust file is left out.
pub(super) fn is_left_out(text: &str) -> bool {
    text.lines().any(|line| needs_reference(line, OF_FILE))
}

/// Modules that a Rust file declares for the program with its own engine alone.
pub(super) fn left_out_modules(text: &str) -> Vec<String> {
    let name = |line: &str| {
        let declared = line.trim().strip_suffix(';')?;
        Some(String::from(declared.rsplit_once("mod ")?.1))
    };
    let lines: Vec<&str> = text.lines().collect();
    let pairs = lines.windows(2).filter(|pair| needs_reference(pair[0], OF_ITEM));
    pairs.filter_map(|pair| name(pair[1])).collect()
}

/// Replaces each answer, from `// <answer>` to `// </answer>` (or with `#`), by what follows on the closing marker's
/// line: the code that stands there in the hand-out, or nothing.
///
/// # Errors
/// A marker without its partner.
pub(super) fn without_answers(text: &str) -> anyhow::Result<String> {
    let mut kept = Vec::new();
    let mut opened_at = None;
    for (number, line) in (1..).zip(text.lines()) {
        let marker = line.trim_start().strip_prefix("//").or_else(|| line.strip_prefix('#')).unwrap_or("").trim_start();
        if marker.trim_end() == "<answer>" {
            ensure!(opened_at.is_none(), "line {number}: an answer begins inside another");
            opened_at = Some(number);
        } else if let Some(placeholder) = marker.strip_prefix("</answer>") {
            ensure!(opened_at.take().is_some(), "line {number}: an answer ends that has not begun");
            let indentation = &line[..line.len() - line.trim_start().len()];
            match placeholder.trim() {
                "" => kept.push(None),
                code => kept.push(Some(format!("{indentation}{code}"))),
            }
        } else if opened_at.is_none() {
            kept.push(Some(String::from(line)));
        }
    }
    if let Some(number) = opened_at {
        bail!("line {number}: an answer begins that does not end");
    }
    Ok(joined(&kept))
}

/// Removes every item of a Rust file that only the program with its own engine has, with its attributes and
/// documentation.
///
/// # Errors
/// An item without an end.
pub(super) fn without_reference(text: &str) -> anyhow::Result<String> {
    let mut kept: Vec<Option<String>> = Vec::new();
    let mut lines = (1..).zip(text.lines());
    while let Some((number, line)) = lines.next() {
        if !needs_reference(line, OF_ITEM) {
            kept.push(Some(String::from(line)));
            continue;
        }
        let belongs = |line: &Option<String>| {
            let text = line.as_deref().unwrap_or_default().trim_start();
            text.starts_with("///") || text.starts_with("#[")
        };
        while kept.last().is_some_and(belongs) {
            kept.pop();
        }
        let mut depth = 0;
        let is_end = |line: &str| {
            depth += line.matches(['{', '(', '[']).count() as i64 - line.matches(['}', ')', ']']).count() as i64;
            let code = line.trim();
            depth == 0 && !code.starts_with('#') && !code.starts_with("//") && code.ends_with([';', ',', '}'])
        };
        ensure!(lines.by_ref().map(|(_, line)| line).any(is_end), "line {number}: no end of what follows it");
        kept.push(None);
    }
    Ok(joined(&kept))
}

/// The lines as a text; where a part was removed (None), of the empty lines around it only one stays.
fn joined(lines: &[Option<String>]) -> String {
    let mut text = String::new();
    let mut removed = false;
    for line in lines {
        let Some(line) = line else {
            removed = true;
            continue;
        };
        let follows_space = text.is_empty() || text.ends_with("\n\n") || text.ends_with("{\n");
        if removed && line.trim_start().starts_with('}') && text.ends_with("\n\n") {
            text.pop();
        }
        if !(removed && line.is_empty() && follows_space) {
            text += line;
            text.push('\n');
        }
        removed &= line.is_empty();
    }
    if removed || text.ends_with("\n\n") {
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    #[test]
    fn an_answer_becomes_its_placeholder_and_leaves_no_gap() {
        let text = "//! A file.\n\n// <answer>\nuse std::f32;\n// </answer>\n\nfn half() -> f32 {\n    // <answer>\n    \
                    let x = 1.0;\n    x / 2.0\n    // </answer> 0.0\n}\n\n// <answer>\nfn helper() {}\n// </answer>\n";
        assert_eq!(without_answers(text).unwrap(), "//! A file.\n\nfn half() -> f32 {\n    0.0\n}\n");
        let manifest = "[features]\n# <answer>\ndefault = [\"a\", \"b\"]\n# </answer> default = [\"a\"]\nb = []\n";
        assert_eq!(without_answers(manifest).unwrap(), "[features]\ndefault = [\"a\"]\nb = []\n");
        let plain = "# [features]\n\n\nx = 1\n";
        assert_eq!(without_answers(plain).unwrap(), plain);
    }

    #[test]
    fn markers_without_a_partner_are_refused_with_their_line() {
        for (text, words) in [
            ("// <answer>\nlet x = 1;\n", "line 1: an answer begins that does not end"),
            ("let x = 1;\n// </answer> 0\n", "line 2: an answer ends that has not begun"),
            ("// <answer>\n// <answer>\n// </answer>\n", "line 2: an answer begins inside another"),
        ] {
            assert_eq!(without_answers(text).unwrap_err().to_string(), words);
        }
    }

    #[test]
    fn what_only_the_programs_own_engine_needs_goes_with_its_documentation_and_attributes() {
        let gone = [
            "#[cfg(feature = \"reference\")]\nmod gather;\n",
            "/// Paths.\n/// Two lines.\n#[cfg(feature = \"reference\")]\npub mod paths;\n",
            "#[cfg(feature = \"reference\")]\nuse a::{\n    b,\n    c::{d},\n};\n",
            "#[cfg(feature = \"reference\")]\n#[test]\nfn both_agree() {\n    if true {\n        f(1);\n    }\n}\n",
        ];
        for item in gone {
            let text = format!("use x;\n{item}use y;\n");
            assert_eq!(without_reference(&text).unwrap(), "use x;\nuse y;\n", "{item}");
        }
        let arms = "match x {\n    A => 1,\n    /// B.\n    #[cfg(feature = \"reference\")]\n    B(b) => {\n        b\n    }\n    C => 2,\n}\n";
        assert_eq!(without_reference(arms).unwrap(), "match x {\n    A => 1,\n    C => 2,\n}\n");
        assert!(without_reference("#[cfg(feature = \"reference\")]\nfn f() {\n").is_err());
        let last = "impl A {\n    fn a() {}\n\n    #[cfg(feature = \"reference\")]\n    fn b() {}\n}\n";
        assert_eq!(without_reference(last).unwrap(), "impl A {\n    fn a() {}\n}\n");
        let other = "#[cfg(feature = \"app\")]\nmod app;\n";
        assert_eq!(without_reference(other).unwrap(), other);
    }

    #[test]
    fn left_out_files_and_modules_are_found() {
        let text = "#[cfg(feature = \"reference\")]\npub mod truth;\n#[cfg(feature = \"app\")]\nmod window;\n\
                    #[cfg(feature = \"reference\")]\npub(crate) mod gather;\n#[cfg(feature = \"reference\")]\nuse a;\n";
        assert_eq!(left_out_modules(text), ["truth", "gather"]);
        let gpu = "//! Tests.\n#![cfg(all(feature = \"gpu\", feature = \"reference\"))]\n";
        assert!(is_left_out("//! Tests.\n#![cfg(feature = \"reference\")]\n") && is_left_out(gpu));
        assert!(!is_left_out(text) && !is_left_out("#![cfg(not(feature = \"reference\"))]\n"));
    }
}
