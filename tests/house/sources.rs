//! The files that tests of the house read.

use std::fs;
use std::path::{Path, PathBuf};

/// The Rust files of `src`, by their paths in it, with their texts.
pub fn sources() -> Vec<(String, String)> {
    files_of("src", "rs")
}

/// The files of a folder of the repository and of the folders in it that have an ending, by their paths in it, with their texts.
pub fn files_of(folder: &str, ending: &str) -> Vec<(String, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut files = Vec::new();
    collect(&src, &[ending], &mut files);
    assert!(files.len() > 20);
    files.sort();
    let read = |file: PathBuf| {
        let inside = file.strip_prefix(&src).expect("below the folder");
        let path = inside.to_string_lossy().replace('\\', "/");
        (path, fs::read_to_string(&file).expect("readable"))
    };
    files.into_iter().map(read).collect()
}

/// Adds the files of a folder and of the folders in it that have one of some endings.
pub fn collect(folder: &Path, endings: &[&str], found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of the repository") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            collect(&path, endings, found);
        } else if path
            .extension()
            .is_some_and(|e| endings.iter().any(|own| e == *own))
        {
            found.push(path);
        }
    }
}

/// A file without the tests at its foot; nothing of a file that is all tests.
pub fn without_tests(text: &str) -> &str {
    let begins = [
        "#![cfg(test)]",
        "#[cfg(test)]\nmod ",
        "#[cfg(test)]\npub(crate) mod ",
    ];
    let end = begins.iter().filter_map(|mark| text.find(mark)).min();
    &text[..end.unwrap_or(text.len())]
}

/// The code of a file without comments and the tests at its foot.
pub fn code(text: &str) -> String {
    let lines = without_tests(text).lines();
    let lines = lines.filter(|l| !l.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}
