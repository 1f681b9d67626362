//! Imports point one way: a file uses folders before its own in this list, never after.

use std::fs;
use std::path::{Path, PathBuf};

/// The folders (and single files) of `src`, lowest first; those of one entry stand on one level.
const LAYERS: [&[&str]; 11] = [
    &["error", "quantity", "linalg", "watch"],
    &["model"],
    &["modal"],
    &["impact"],
    &["flow"],
    &["contact"],
    &["simulate"],
    &["orbit"],
    &["sweep"],
    &["python"],
    &["lib"],
];

fn level(folder: &str) -> usize {
    LAYERS
        .iter()
        .position(|l| l.contains(&folder))
        .unwrap_or_else(|| panic!("{folder} has no place in LAYERS"))
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("src is there") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The folders that a text names as `crate::folder`, comments and tests at its foot left out.
fn used(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or(text);
    let lines = code.lines().filter(|l| !l.trim_start().starts_with("//"));
    lines
        .flat_map(|line| line.split("crate::").skip(1))
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_ascii_lowercase() || *c == '_')
                .collect::<String>()
        })
        .filter(|folder| !folder.is_empty())
        .collect()
}

#[test]
fn imports_point_down() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    assert!(files.len() > 20);
    let mut upward = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&src).expect("below src");
        let own = inside.iter().next().expect("not empty").to_string_lossy();
        let own = own.trim_end_matches(".rs");
        for folder in used(&fs::read_to_string(&file).expect("readable")) {
            if level(&folder) > level(own) {
                upward.push(format!("{} uses {folder}", inside.display()));
            }
        }
    }
    assert!(upward.is_empty(), "{upward:#?}");
}

#[test]
fn an_upward_import_would_be_seen() {
    let text =
        "use crate::orbit::Pattern;\n// crate::python\nfn f() { crate::model::linearise() }\n";
    assert_eq!(used(text), ["orbit", "model"]);
    assert!(level("orbit") > level("modal"));
}
