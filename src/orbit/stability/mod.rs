//! Floquet multipliers of an orbit (theory 7).

pub(in crate::orbit) mod multipliers;
