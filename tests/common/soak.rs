//! The table of soaks: what each has compared, a line in the file that `VIBROIMPACT_SOAKS` names.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

const HEADER: &str = "compared,seed,count,disagree\n";

/// Adds a line: what was compared, of scenes of which seed, how often, and how often it disagreed.
pub fn note(compared: &str, seed: u64, count: usize, disagree: usize) {
    let Ok(path) = std::env::var("VIBROIMPACT_SOAKS") else {
        return;
    };
    let header = if Path::new(&path).exists() {
        ""
    } else {
        HEADER
    };
    let file = OpenOptions::new().create(true).append(true).open(&path);
    file.expect("a file that can be written to")
        .write_all(format!("{header}{compared},{seed},{count},{disagree}\n").as_bytes())
        .expect("room for a line");
}
