//! Derivatives of periodic orbits by numbers of their scene.

mod closed_form;
mod differences;
mod exceptions;
mod following;
mod linear_scenes;
mod motions;
#[path = "../common/random.rs"]
mod random;
#[path = "../common/scenes.rs"]
mod scenes;
