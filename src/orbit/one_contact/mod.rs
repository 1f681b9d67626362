//! Orbits with one contact in the period with a stop that gives way: the search for its duration (theory 22).

pub(in crate::orbit) mod conditions;
pub(in crate::orbit) mod kernel;
pub(in crate::orbit) mod search;
pub(in crate::orbit) mod solve;
