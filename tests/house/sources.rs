//! The files that tests of the house read.

use std::fs;
use std::path::{Path, PathBuf};

/// The Rust files of `src`, by their paths in it, with their texts.
pub fn sources() -> Vec<(String, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    assert!(files.len() > 20);
    files.sort();
    let read = |file: PathBuf| {
        let inside = file.strip_prefix(&src).expect("below src");
        let path = inside.to_string_lossy().replace('\\', "/");
        (path, fs::read_to_string(&file).expect("readable"))
    };
    files.into_iter().map(read).collect()
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("src is there") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// A file without the tests at its foot.
pub fn without_tests(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod ").next().unwrap_or(text)
}

/// The code of a file without comments and the tests at its foot.
pub fn code(text: &str) -> String {
    let lines = without_tests(text).lines();
    let lines = lines.filter(|l| !l.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}
