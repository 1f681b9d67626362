//! Referees: slow solvers that share no line with the library, random scenes, and a comparison of the two.

#[path = "../common/extrapolated.rs"]
mod extrapolated;
#[path = "../common/random.rs"]
mod random;
#[path = "../common/roots.rs"]
mod roots;
#[path = "../common/soak.rs"]
mod soak;

mod attractors;
mod branches;
mod flying;
mod orbits;
mod pendulums;
mod runs;
