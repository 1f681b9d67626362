//! Where the next impact is, and where a gap is lowest (theory 8). What a gap is along a motion: `model/contact.rs`,
//! `flow/gap_row.rs`; when a touch is an impact: `touch.rs`.

pub(crate) mod certified;
pub(crate) mod curvature;
pub(crate) mod first_root;
pub(crate) mod gap_bracket;
pub(crate) mod gap_verdict;
pub(crate) mod levels;
pub(crate) mod lowest;
pub(crate) mod next;
pub(crate) mod polynomial;
pub(crate) mod probed;
pub(crate) mod series;
pub(crate) mod step_path;
mod stride;
mod touch;
mod tracked_gap;
pub(crate) mod walk;
