//! Runs: flights, impacts, chatter and lasting contact, methods of integration, what is kept and what is counted.

#[path = "../common/random.rs"]
mod random;
#[path = "../common/scenes.rs"]
mod scenes;

mod chatter_stick;
mod contacts;
mod dependent_stops;
mod energy;
mod flights;
mod impacts;
mod late_releases;
mod margins;
mod outputs;
mod pendulum;
mod ramps;
mod scene_cost;
mod sides;
mod springs;
mod stepping;
mod taylor;
