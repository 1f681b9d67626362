//! What the rules of contact say of an orbit (theory 6), and whether it closes.

pub(in crate::orbit) mod admissibility;
pub(in crate::orbit) mod another_route;
mod bounded;
pub(in crate::orbit) mod closing;
pub(in crate::orbit) mod integrated;
pub(in crate::orbit) mod judge;
pub(in crate::orbit) mod lasting;
pub(in crate::orbit) mod thrown;
