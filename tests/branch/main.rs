//! Branches of periodic motions over a number of their scene.

mod accumulation;
mod beyond;
mod closed_form;
mod curves;
mod ends;
mod energy;
mod landing;
mod many_modes;
mod monitors;
mod motions;
#[path = "../common/random.rs"]
mod random;
mod scenes;
mod special;
mod switching;
mod symmetry;
mod tips;
mod touches;
mod tree;
mod two_at_once;
mod verdicts;
