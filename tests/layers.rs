//! The import direction of src/ARCHITECTURE.md: a module uses only what stands to its left.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::path::{Path, PathBuf};

const LAYERS: [&str; 14] = [
    "math",
    "scene",
    "trace",
    "lightmap",
    "student",
    "transport",
    "solver",
    "render",
    "check",
    "files",
    "course",
    "gpu",
    "app",
    "cli",
];

/// All that the passes on the graphics card know of.
const GPU_MAY_USE: [&str; 5] = ["math", "scene", "lightmap", "student", "gpu"];

fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// Modules named after `crate::` in a file: `use crate::math::...`, and each of `use crate::{math::..., scene}`.
fn imported_modules(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (_, rest) in text.match_indices("crate::").map(|(place, word)| (place, &text[place + word.len()..])) {
        let mut depth = 0;
        let mut expects_name = true;
        let mut name = String::new();
        for character in rest.chars() {
            match character {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 1 => expects_name = true,
                'a'..='z' | '_' if expects_name => name.push(character),
                _ if character.is_whitespace() => {}
                _ => {
                    found.extend((!name.is_empty()).then(|| std::mem::take(&mut name)));
                    expects_name = false;
                }
            }
            if depth < 0 || (depth == 0 && (!expects_name || character == ';' || character == '}')) {
                break;
            }
        }
        found.extend((!name.is_empty()).then_some(name));
    }
    found
}

#[test]
fn the_reader_of_imports_sees_single_and_grouped_imports() {
    let text =
        "use crate::math::color;\nuse crate::{\n  scene::{Mesh, Scene},\n  trace,\n};\nlet x = crate::check::y();";
    assert_eq!(imported_modules(text), ["math", "scene", "trace", "check"]);
}

#[test]
fn every_module_uses_only_modules_to_its_left() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut looked_at = 0;
    for (place, layer) in LAYERS.iter().enumerate() {
        let mut files = Vec::new();
        rust_files(&source.join(layer), &mut files);
        for file in files {
            for module in imported_modules(&std::fs::read_to_string(&file).unwrap()) {
                let Some(used) = LAYERS.iter().position(|name| *name == module) else { continue };
                let allowed = used <= place && (*layer != "gpu" || GPU_MAY_USE.contains(&module.as_str()));
                assert!(allowed, "{}: {layer} may not use {module}", file.display());
                looked_at += 1;
            }
        }
    }
    assert!(looked_at > 20, "only {looked_at} imports were found: is the reader broken?");
}

#[test]
fn the_inner_modules_do_no_input_or_output() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for layer in ["math", "trace", "student", "transport", "solver"] {
        let mut files = Vec::new();
        rust_files(&source.join(layer), &mut files);
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap();
            for word in ["std::fs", "std::env::var", "println!", "eprintln!"] {
                assert!(!code.contains(word), "{}: {word}", file.display());
            }
        }
    }
}
