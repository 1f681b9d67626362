//! Derivatives of periodic orbits and of runs by numbers of their scene, and orbits followed from one set of numbers to another (theory 21).

mod adaptive_differences;
mod following;
mod itinerary;
mod loop_rates;
mod measured;
mod multipliers;
mod numbers;
mod objective;
mod of_orbit;
mod of_run;
mod rates;
mod refusal;
mod stencil;

pub use following::follow_orbit;
pub use objective::{Objective, ObjectiveValue, OrbitEntry};
pub use of_orbit::{derivatives, derivatives_but_multipliers, derivatives_of};
pub use of_run::{RunDerivatives, derivatives_of_run};
pub use rates::OrbitDerivatives;
