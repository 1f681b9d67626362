//! Periodic orbits: in closed form, by shooting, and where they exist.

#[path = "../common/random.rs"]
mod random;
#[path = "../common/scenes.rs"]
mod scenes;

mod existence;
mod free_parameter;
mod lasting_contact;
mod many_modes;
mod orbit_digits;
mod orbits;
mod own_time;
mod retraced;
mod shooting;
mod two_instants;
