//! A referee of periodic orbits that shares no line with the library: plain matrices, an exponential and a solver of its own.

mod causes;
mod closing;
#[allow(dead_code, reason = "random plants are for the tests to come")]
mod plant;
#[path = "../common/random.rs"]
mod random;
