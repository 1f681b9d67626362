//! Patterns of one instant, and of none, in closed form (theory 5).

pub(in crate::orbit) mod one_stop;
pub(in crate::orbit) mod periodic_conditions;
pub(in crate::orbit) mod phases;
pub(in crate::orbit) mod refine;
pub(in crate::orbit) mod solve;
