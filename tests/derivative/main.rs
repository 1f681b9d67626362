//! Derivatives of periodic orbits and of runs by numbers of their scene.

mod closed_form;
mod differences;
mod draw;
mod exceptions;
mod following;
mod laws;
mod linear_scenes;
mod motions;
mod objective;
mod own;
#[path = "../common/random.rs"]
mod random;
mod random_orbits;
mod referee;
mod runs;
#[path = "../common/scenes.rs"]
mod scenes;
#[path = "../common/soak.rs"]
mod soak;
mod twin;
