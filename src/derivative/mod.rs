//! Derivatives of periodic orbits by numbers of their scene, and orbits followed from one set of numbers to another (theory 21).

mod following;
mod loop_rates;
mod measured;
mod multipliers;
mod of_orbit;
mod rates;
mod refusal;
mod stencil;

pub use following::followed;
pub use of_orbit::{derivatives, derivatives_but_multipliers, derivatives_of};
pub use rates::Derivatives;
