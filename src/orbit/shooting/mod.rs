//! Orbits of any pattern near a guess, by shooting on the times of their instants (theory 5).

pub(in crate::orbit) mod closure;
pub(in crate::orbit) mod find;
pub(in crate::orbit) mod guess;
pub(in crate::orbit) mod guess_by_signature;
pub(in crate::orbit) mod guess_in_order;
pub(in crate::orbit) mod memory;
pub(in crate::orbit) mod mirror;
pub(in crate::orbit) mod newton;
pub(in crate::orbit) mod own_time;
pub(in crate::orbit) mod signature;
pub(in crate::orbit) mod transported_flight;
