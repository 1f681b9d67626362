//! What is written for maintainers names files and types that are there.

use crate::sources::files_of;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Documents that name parts of the code.
const DOCUMENTS: [&str; 3] = ["CONTRIBUTING.md", "docs/extending.md", "docs/glossary.md"];
/// Folders whose files they name by path.
const FOLDERS: [&str; 6] = [
    "benches/",
    "docs/",
    "examples/",
    "python/",
    "src/",
    "tests/",
];

/// The words of a text that are names of types: a capital and small letters.
fn type_names(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.filter(|word| {
        let mut letters = word.chars();
        let is_capital = letters.next().is_some_and(char::is_uppercase);
        is_capital && letters.next().is_some_and(char::is_lowercase)
    })
}

/// What a document has in code marks, its blocks of code left out.
fn marked(document: &str) -> Vec<&str> {
    let prose = document.split("```").step_by(2);
    prose
        .flat_map(|part| part.split('`').skip(1).step_by(2))
        .collect()
}

/// What of a document is not there: paths of no file, and names that no source has.
fn stale(document: &str, known: &BTreeSet<&str>, is_file: impl Fn(&str) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    for mark in marked(document) {
        if FOLDERS.iter().any(|folder| mark.starts_with(folder)) {
            // Of a path with a name to be filled in, the folder.
            let path = mark.split([' ', ':', '<']).next().unwrap_or(mark);
            if !is_file(path) {
                found.push(path.to_owned());
            }
        } else if !mark.contains('.') {
            let unknown = type_names(mark).filter(|word| !known.contains(word));
            found.extend(unknown.map(str::to_owned));
        }
    }
    found
}

#[test]
fn documents_name_what_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = [files_of("src", "rs"), files_of("python", "py")].concat();
    let names = sources.iter().flat_map(|(_, text)| type_names(text));
    let known: BTreeSet<&str> = names.collect();
    let is_file = |path: &str| root.join(path).exists();
    for name in DOCUMENTS {
        let text = fs::read_to_string(root.join(name)).expect("it is there");
        let stale = stale(&text, &known, is_file);
        assert!(stale.is_empty(), "{name} names {stale:?}");
    }
}

#[test]
fn what_is_gone_would_be_seen() {
    let document =
        "`Place`, `Stop::new` and `Tangent`, in `src/a.rs` and `src/b.rs`.\n```\n`Gone`\n```\n";
    let known = BTreeSet::from(["Stop", "Tangent"]);
    let found = stale(document, &known, |path| path == "src/a.rs");
    assert_eq!(found, ["Place", "src/b.rs"]);
}
