//! The closed-form solve of orbits with one instant of impact in a period, or none (theory 5). It begins in `solve.rs`.

pub(in crate::orbit) mod contact_phases;
pub(in crate::orbit) mod one_stop;
pub(in crate::orbit) mod periodic_conditions;
pub(in crate::orbit) mod phases;
pub(in crate::orbit) mod refine;
pub(in crate::orbit) mod solve;
