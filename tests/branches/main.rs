//! Branches of periodic motions over a number of their scene.

mod closed_form;
mod ends;
mod motions;
mod scenes;
mod special;
