//! Derivatives of periodic orbits and of runs by numbers of their scene.

mod closed_form;
mod differences;
mod exceptions;
mod following;
mod linear_scenes;
mod motions;
#[path = "../common/random.rs"]
mod random;
mod runs;
#[path = "../common/scenes.rs"]
mod scenes;
